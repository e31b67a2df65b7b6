//! Random arms in space, and their states.

use dem_model::{
    Body, Joint, JointMotion, SpaceLink, SpacecraftBody, SpatialSpaceManipulator, SphericalBaseManipulator,
};
use hinf_control::{BaseMeasurement, Measurement, Reference};
use nalgebra::{Matrix3, SVector, Vector3};
use proptest::prelude::*;

/// Numbers within ±1 that are drawn one after another.
pub struct Draws(std::vec::IntoIter<f64>);

pub fn draws() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(-1.0..1.0_f64, 600).no_shrink()
}

impl Draws {
    pub fn new(numbers: Vec<f64>) -> Self {
        Self(numbers.into_iter())
    }

    pub fn next(&mut self) -> f64 {
        self.0.next().expect("enough numbers")
    }

    pub fn vector<const ROWS: usize>(&mut self) -> SVector<f64, ROWS> {
        SVector::from_fn(|_, _| self.next())
    }

    /// An inertia that a body can have: that of eight point masses.
    fn inertia(&mut self) -> Matrix3<f64> {
        let points = (0..8).map(|_| self.vector::<3>() * 0.2);
        points.map(|r| Matrix3::identity() * r.norm_squared() - r * r.transpose()).sum()
    }

    /// The equivalent of a space manipulator with revolute joints of any axes.
    pub fn arm<const N: usize>(&mut self) -> SphericalBaseManipulator<f64, N> {
        let spacecraft = SpacecraftBody {
            mass: 6.0 + self.next(),
            inertia: self.inertia() * 3.0,
            centre_of_mass_to_joint: self.vector::<3>() * 0.3,
        };
        let links = core::array::from_fn(|_| SpaceLink {
            mass: 2.0 + self.next(),
            inertia: self.inertia(),
            joint_to_centre_of_mass: self.vector::<3>() * 0.3,
            centre_of_mass_to_joint: self.vector::<3>() * 0.3,
        });
        let joints = core::array::from_fn(|index| {
            let axis = self.vector::<3>() + Vector3::new(0.0, 0.0, 0.1);
            Joint::new(JointMotion::Revolute, axis, Body::Link(index + 2)).unwrap()
        });
        let manipulator = SpatialSpaceManipulator::new(spacecraft, links).unwrap();
        SphericalBaseManipulator::dynamically_equivalent(&manipulator, joints)
    }

    pub fn measurement<const N: usize, const B: usize>(&mut self) -> Measurement<f64, N, B> {
        Measurement {
            position: self.vector::<N>() * 2.0,
            velocity: self.vector(),
            base: BaseMeasurement { velocity: self.vector(), acceleration: self.vector() },
        }
    }

    /// A motion some degrees from what is measured.
    pub fn near<const N: usize, const B: usize>(&mut self, measurement: &Measurement<f64, N, B>) -> Reference<f64, N> {
        Reference {
            position: measurement.position + self.vector::<N>() * 0.1,
            velocity: measurement.velocity + self.vector::<N>() * 0.5,
            acceleration: self.vector::<N>() * 3.0,
        }
    }
}
