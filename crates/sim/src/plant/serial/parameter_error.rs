//! Arms that weigh other than their model says.

use core::ops::Mul;

use dem_model::{Dem, DemBase, DemLink, Distance, ParameterError, SpaceLink, SpacecraftBody, SpatialSpaceManipulator};

/// By which factors masses and inertias differ from the nominal ones; > 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterScale {
    /// Of the spacecraft, or of the inertia of a DEM's base.
    pub base: f64,
    /// Of each link of the arm.
    pub links: f64,
}

impl ParameterScale {
    /// The space manipulator with other masses and inertias. All lengths stay, so that those of its equivalent change.
    ///
    /// # Errors
    /// [`ParameterError`] names the first body that a factor leaves without mass.
    pub fn space_manipulator<const N: usize>(
        &self,
        nominal: &SpatialSpaceManipulator<f64, N>,
    ) -> Result<SpatialSpaceManipulator<f64, N>, ParameterError> {
        let spacecraft = *nominal.spacecraft();
        let spacecraft =
            SpacecraftBody { mass: spacecraft.mass * self.base, inertia: spacecraft.inertia * self.base, ..spacecraft };
        let links = nominal.links().map(|link| SpaceLink {
            mass: link.mass * self.links,
            inertia: link.inertia * self.links,
            ..link
        });
        SpatialSpaceManipulator::new(spacecraft, links)
    }

    /// The equivalent manipulator, in the plane or in space, with other masses and inertias on the same lengths: one that was built.
    ///
    /// # Errors
    /// [`ParameterError`] names the first body that a factor leaves without mass.
    pub fn dem<const N: usize, D: Distance<f64, Inertia: Mul<f64, Output = D::Inertia>>>(
        &self,
        nominal: &Dem<f64, N, D, D::Inertia>,
    ) -> Result<Dem<f64, N, D, D::Inertia>, ParameterError> {
        let base = *nominal.base();
        let base = DemBase { inertia: base.inertia * self.base, ..base };
        let links = nominal.links().map(|link| DemLink {
            mass: link.mass * self.links,
            inertia: link.inertia * self.links,
            ..link
        });
        Dem::new(base, links)
    }
}
