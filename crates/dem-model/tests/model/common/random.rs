//! Random manipulators and states for property tests.

use core::ops::Range;

use dem_model::{DemBase, DemLink, PlanarDem, PlanarSpaceManipulator, SpaceLink, SpacecraftBody, ThreeLinkDem};
use nalgebra::SVector;
use proptest::prelude::*;

const INERTIAS: Range<f64> = 1e-3..0.1;
const MASSES: Range<f64> = 0.1..5.0;
const LENGTHS: Range<f64> = 0.0..0.6;
const ANGLES: Range<f64> = -3.2..3.2;
/// Velocities in rad/s, accelerations in rad/s² and torques in N·m alike.
const SIGNALS: Range<f64> = -3.0..3.0;

prop_compose! {
    fn dem_link()(mass in MASSES, inertia in INERTIAS, length in LENGTHS, centre_of_mass in LENGTHS) -> DemLink<f64> {
        DemLink { mass, inertia, length, centre_of_mass }
    }
}

prop_compose! {
    /// The parameters of a planar DEM with two links in its arm.
    pub fn planar_dem()(inertia in INERTIAS, length in LENGTHS, links in [dem_link(), dem_link()]) -> PlanarDem<f64, 2> {
        PlanarDem::new(DemBase { inertia, length }, links).unwrap()
    }
}

/// A three-link DEM in closed form.
pub fn three_link_dem() -> impl Strategy<Value = ThreeLinkDem<f64>> {
    planar_dem().prop_map(|dem| dem.closed_form().unwrap())
}

prop_compose! {
    fn space_link()(mass in MASSES, inertia in INERTIAS, left in LENGTHS, right in LENGTHS) -> SpaceLink<f64> {
        SpaceLink { mass, inertia, joint_to_centre_of_mass: left, centre_of_mass_to_joint: right }
    }
}

prop_compose! {
    /// A planar space manipulator with three links in its arm.
    pub fn space_manipulator()(
        (mass, inertia, right) in (MASSES, INERTIAS, LENGTHS),
        links in [space_link(), space_link(), space_link()],
    ) -> PlanarSpaceManipulator<f64, 3> {
        PlanarSpaceManipulator::new(SpacecraftBody { mass, inertia, centre_of_mass_to_joint: right }, links).unwrap()
    }
}

/// Angles in rad.
pub fn angles<const JOINTS: usize>() -> impl Strategy<Value = SVector<f64, JOINTS>> {
    proptest::array::uniform::<_, JOINTS>(ANGLES).prop_map(SVector::from)
}

/// Velocities, accelerations or torques.
pub fn signals<const JOINTS: usize>() -> impl Strategy<Value = SVector<f64, JOINTS>> {
    proptest::array::uniform::<_, JOINTS>(SIGNALS).prop_map(SVector::from)
}
