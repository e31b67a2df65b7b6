//! A joint of a serial arm: its axis, and whether it turns or slides.

use nalgebra::{Unit, Vector3};

use crate::error::{Body, ParameterError};
use crate::scalar::Scalar;

/// How a joint moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointMotion {
    /// It turns about its axis; its coordinate is in rad, its torque in N·m.
    Revolute,
    /// It slides along its axis; its coordinate is in m, its force in N.
    Prismatic,
}

/// A joint between a link and the link before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Joint<T: Scalar> {
    motion: JointMotion,
    axis: Unit<Vector3<T>>,
}

impl<T: Scalar> Joint<T> {
    /// A joint whose `axis` is given in the frame of the link before, of any length but zero. The frame of the link after
    /// is parallel to it while the joint's coordinate is zero.
    ///
    /// # Errors
    /// [`ParameterError::NoAxis`] if the axis is not finite or has no direction; `body` is the link after.
    pub fn new(motion: JointMotion, axis: Vector3<T>, body: Body) -> Result<Self, ParameterError> {
        // By its largest entry first, so that no square overflows or vanishes.
        let largest = axis.amax();
        let direction = if largest.is_finite() && largest > T::zero() { axis / largest } else { Vector3::zeros() };
        match Unit::try_new(direction, T::constant(0.5)) {
            Some(axis) if axis.iter().all(|entry| entry.is_finite()) => Ok(Self { motion, axis }),
            _ => Err(ParameterError::NoAxis { body }),
        }
    }

    /// A revolute joint of an arm in the plane.
    pub fn about_z() -> Self {
        Self { motion: JointMotion::Revolute, axis: Vector3::z_axis() }
    }

    /// Whether it turns or slides.
    pub fn motion(&self) -> JointMotion {
        self.motion
    }

    /// The unit vector of its axis, in the frame of the link before.
    pub fn axis(&self) -> Unit<Vector3<T>> {
        self.axis
    }
}
