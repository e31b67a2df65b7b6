//! How distances and inertias are written: as numbers in the plane, as vectors and tensors in space.

use core::ops::{Add, Mul};

use nalgebra::{Matrix3, Vector3};

use crate::error::{Body, ParameterError, Requirement, require};
use crate::scalar::Scalar;

/// A distance between two points of a link, from which follows whether the link moves in the plane or in space:
///
/// - `T` for a link in the plane, whose joints and centre of mass all lie on one line; in m, finite and ≥ 0;
/// - `Vector3<T>` for a link in space; in m, in the frame of the link, finite.
///
/// The trait is sealed: there are no others.
pub trait Distance<T: Scalar>: Copy + Add<Output = Self> + Mul<T, Output = Self> + CheckedDistance {
    /// How the inertia of a link about its centre of mass is written, in kg·m²: `T`, finite and > 0, in the plane;
    /// `Matrix3<T>` in the frame of the link, symmetric and positive definite, in space.
    type Inertia: Copy + CheckedInertia;
}

/// Checks distances. Private to the crate, so that [`Distance`] is sealed.
pub trait CheckedDistance {
    /// Refuses the value of a `field` of `body` that is no distance.
    fn require_distance(&self, body: Body, field: &'static str) -> Result<(), ParameterError>;
}

/// Checks inertias. Private to the crate, so that [`Distance::Inertia`] is sealed.
pub trait CheckedInertia {
    /// Refuses an `inertia` that `body` cannot have.
    fn require_inertia(&self, body: Body) -> Result<(), ParameterError>;
}

impl<T: Scalar> Distance<T> for T {
    type Inertia = T;
}

impl<T: Scalar> Distance<T> for Vector3<T> {
    type Inertia = Matrix3<T>;
}

impl<T: Scalar> CheckedDistance for T {
    fn require_distance(&self, body: Body, field: &'static str) -> Result<(), ParameterError> {
        require(body, field, *self, Requirement::NotNegative)
    }
}

impl<T: Scalar> CheckedInertia for T {
    fn require_inertia(&self, body: Body) -> Result<(), ParameterError> {
        require(body, "inertia", *self, Requirement::Positive)
    }
}

impl<T: Scalar> CheckedDistance for Vector3<T> {
    fn require_distance(&self, body: Body, field: &'static str) -> Result<(), ParameterError> {
        self.iter().try_for_each(|entry| require(body, field, *entry, Requirement::Finite))
    }
}

impl<T: Scalar> CheckedInertia for Matrix3<T> {
    fn require_inertia(&self, body: Body) -> Result<(), ParameterError> {
        self.iter().try_for_each(|entry| require(body, "inertia", *entry, Requirement::Finite))?;
        // Tensors that were rotated into the link's frame are symmetric but for rounding.
        let rounding = T::default_epsilon().sqrt() * self.amax();
        let symmetric = (self - self.transpose()).amax() <= rounding;
        if symmetric && self.cholesky().is_some() {
            Ok(())
        } else {
            Err(ParameterError::InertiaNotPositiveDefinite { body })
        }
    }
}
