//! Why a set of parameters is refused.

use core::fmt;

use crate::scalar::Scalar;

/// The body that a parameter belongs to, numbered as in the paper: the spacecraft (or base) is link 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Body {
    /// The spacecraft of a space manipulator: link 1.
    Spacecraft,
    /// The first link of a DEM, which turns about the passive joint: link 1.
    Base,
    /// A link of the arm; the first one has number 2.
    Link(usize),
}

impl Body {
    /// The arm's link at `index` of an array of arm links, which counts from 0.
    pub(crate) const fn arm_link(index: usize) -> Self {
        Self::Link(index + 2)
    }
}

impl fmt::Display for Body {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Spacecraft => formatter.write_str("spacecraft (link 1)"),
            Self::Base => formatter.write_str("base (link 1)"),
            Self::Link(number) => write!(formatter, "link {number}"),
        }
    }
}

/// What a parameter has to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Requirement {
    /// Finite and greater than zero.
    Positive,
    /// Finite and not less than zero.
    NotNegative,
    /// A finite number.
    Finite,
}

impl Requirement {
    fn is_met_by<T: Scalar>(self, value: T) -> bool {
        value.is_finite()
            && match self {
                Self::Positive => value > T::zero(),
                Self::NotNegative => value >= T::zero(),
                Self::Finite => true,
            }
    }
}

impl fmt::Display for Requirement {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Positive => "a finite value > 0",
            Self::NotNegative => "a finite value >= 0",
            Self::Finite => "a finite value",
        })
    }
}

/// A parameter, or a set of parameters, that no physical manipulator can have.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ParameterError {
    /// One value is out of its range.
    #[error("{body}: {field} is {found}, expected {expected}")]
    OutOfRange {
        /// The body that the value belongs to.
        body: Body,
        /// The field's name, as in the struct that holds it.
        field: &'static str,
        /// The value found.
        found: f64,
        /// The range it has to be in.
        expected: Requirement,
    },
    /// The inertia matrix of a body in space is not symmetric and positive definite.
    #[error("{body}: inertia is not a symmetric positive definite matrix")]
    InertiaNotPositiveDefinite {
        /// The body that the matrix belongs to.
        body: Body,
    },
    /// The axis of a body's inboard joint is not finite, or has no direction.
    #[error("{body}: joint axis has no direction, expected a finite vector other than zero")]
    NoAxis {
        /// The body outboard of the joint.
        body: Body,
    },
    /// A DEM of given parameters has a prismatic joint.
    #[error(
        "{body}: prismatic joint in a DEM, expected a space manipulator, from which follows how far it moves the link"
    )]
    PrismaticDem {
        /// The body outboard of the joint.
        body: Body,
    },
    /// A body's inertia is so small beside that of what its joint moves that M could not be factorised in this number type.
    #[error(
        "{body}: inertia is {found} kg m^2, expected at least {least} kg m^2: \
         less is lost in rounding beside what its joint moves"
    )]
    InertiaLostInRounding {
        /// The body that the inertia belongs to.
        body: Body,
        /// The inertia found, in kg·m².
        found: f64,
        /// The least inertia that can be told apart, in kg·m².
        least: f64,
    },
}

/// Refuses a `value` that does not meet `expected`.
pub(crate) fn require<T: Scalar>(
    body: Body,
    field: &'static str,
    value: T,
    expected: Requirement,
) -> Result<(), ParameterError> {
    if expected.is_met_by(value) {
        Ok(())
    } else {
        Err(ParameterError::OutOfRange { body, field, found: value.to_f64(), expected })
    }
}
