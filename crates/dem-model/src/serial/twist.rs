//! Twists and wrenches about the base's origin, in base axes.

use core::ops::{Add, Mul};

use nalgebra::Vector3;

use crate::scalar::Scalar;

/// The motion of a body: its angular velocity, and the velocity of its point at the base's origin. Also a rate of such a
/// motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Twist<T: Scalar> {
    /// Angular part, in rad/s.
    pub angular: Vector3<T>,
    /// Linear part, in m/s.
    pub linear: Vector3<T>,
}

/// Moment about the base's origin and force; also angular and linear momentum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Wrench<T: Scalar> {
    /// In N·m, or N·m·s.
    pub moment: Vector3<T>,
    /// In N, or N·s.
    pub force: Vector3<T>,
}

impl<T: Scalar> Twist<T> {
    /// Rest.
    pub(super) fn zero() -> Self {
        Self { angular: Vector3::zeros(), linear: Vector3::zeros() }
    }

    /// About an axis through the origin.
    pub(super) fn turning(axis: Vector3<T>) -> Self {
        Self { angular: axis, linear: Vector3::zeros() }
    }

    /// Along an axis.
    pub(super) fn sliding(axis: Vector3<T>) -> Self {
        Self { angular: Vector3::zeros(), linear: axis }
    }

    /// The power of a wrench on a body that moves so.
    pub(super) fn power(&self, wrench: &Wrench<T>) -> T {
        self.angular.dot(&wrench.moment) + self.linear.dot(&wrench.force)
    }
}

impl<T: Scalar> Add for Twist<T> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { angular: self.angular + other.angular, linear: self.linear + other.linear }
    }
}

impl<T: Scalar> Mul<T> for Twist<T> {
    type Output = Self;

    fn mul(self, factor: T) -> Self {
        Self { angular: self.angular * factor, linear: self.linear * factor }
    }
}

impl<T: Scalar> Add for Wrench<T> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { moment: self.moment + other.moment, force: self.force + other.force }
    }
}
