//! A planar dynamically equivalent manipulator of any number of links.

use crate::error::{Body, ParameterError};
use crate::link::{DemBase, DemLink};
use crate::{Scalar, ThreeLinkDem};

/// A dynamically equivalent manipulator in the plane: a base that turns about the fixed, passive joint 1, and an arm
/// of `LINKS` links.
///
/// Its inertia and Coriolis matrices are sums over Jacobians, for any number of links; they share no code with the
/// closed form of [`ThreeLinkDem`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanarDem<T, const LINKS: usize> {
    base: DemBase<T>,
    links: [DemLink<T>; LINKS],
}

impl<T: Scalar, const LINKS: usize> PlanarDem<T, LINKS> {
    /// Checks and takes the parameters of the base and of the arm's links, from the base outwards.
    ///
    /// # Errors
    /// [`ParameterError::OutOfRange`] names the first value that is not finite or out of the range its field states.
    pub fn new(base: DemBase<T>, links: [DemLink<T>; LINKS]) -> Result<Self, ParameterError> {
        base.validate()?;
        for (index, link) in links.iter().enumerate() {
            link.validate(Body::arm_link(index))?;
        }
        Ok(Self { base, links })
    }

    /// What the map makes of a checked space manipulator.
    pub(crate) fn from_map(base: DemBase<T>, links: [DemLink<T>; LINKS]) -> Self {
        Self { base, links }
    }

    /// The base.
    pub fn base(&self) -> &DemBase<T> {
        &self.base
    }

    /// The arm's links, from the base outwards.
    pub fn links(&self) -> &[DemLink<T>; LINKS] {
        &self.links
    }
}

impl<T: Scalar> PlanarDem<T, 2> {
    /// The same manipulator in closed form.
    ///
    /// # Errors
    /// As [`ThreeLinkDem::new`].
    pub fn closed_form(&self) -> Result<ThreeLinkDem<T>, ParameterError> {
        ThreeLinkDem::new(self.base, self.links)
    }
}
