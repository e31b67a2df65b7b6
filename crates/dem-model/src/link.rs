//! The links of a planar dynamically equivalent manipulator.

use crate::Scalar;
use crate::error::{Body, ParameterError, Requirement, require};

/// The base of a planar DEM: its first link, which turns about the passive joint 1.
///
/// It has no mass: its centre of mass lies in joint 1 (l_c1 = 0, eq. 1), so that m_1 neither follows from the map nor
/// has any effect on the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DemBase<T> {
    /// Moment of inertia I_1 about the centre of mass, which is joint 1, in kg·m²; > 0.
    pub inertia: T,
    /// Length W_1 from joint 1 to joint 2, in m; ≥ 0.
    pub length: T,
}

/// A link i ≥ 2 of a planar DEM. Lengths are measured along the link, from its own joint outwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DemLink<T> {
    /// Mass m_i in kg; > 0.
    pub mass: T,
    /// Moment of inertia I_i about the centre of mass, in kg·m²; > 0.
    pub inertia: T,
    /// Length W_i from joint i to joint i+1, or to the end effector, in m; ≥ 0.
    pub length: T,
    /// Distance l_ci from joint i to the centre of mass, in m; ≥ 0.
    pub centre_of_mass: T,
}

impl<T: Scalar> DemBase<T> {
    pub(crate) fn validate(&self) -> Result<(), ParameterError> {
        require(Body::Base, "inertia", self.inertia, Requirement::Positive)?;
        require(Body::Base, "length", self.length, Requirement::NotNegative)
    }
}

impl<T: Scalar> DemLink<T> {
    pub(crate) fn validate(&self, body: Body) -> Result<(), ParameterError> {
        require(body, "mass", self.mass, Requirement::Positive)?;
        require(body, "inertia", self.inertia, Requirement::Positive)?;
        require(body, "length", self.length, Requirement::NotNegative)?;
        require(body, "centre_of_mass", self.centre_of_mass, Requirement::NotNegative)
    }
}
