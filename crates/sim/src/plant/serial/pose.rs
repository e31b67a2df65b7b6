//! Where a base is and how it is turned.

use crate::plant::integrator::Integrable;
use core::fmt::Debug;
use core::ops::{Add, Mul};
use dem_model::{BaseFreedom, BaseMotion};
use nalgebra::{Quaternion, SVector, UnitQuaternion, Vector1, Vector3, Vector6};

/// The bases of [`BaseMotion`], each with the pose that its velocity moves:
///
/// | B | pose |
/// |---|---|
/// | 1 | `f64`: the angle about z in rad, counted through whole turns |
/// | 3 | `UnitQuaternion<f64>`: from base axes to inertial axes |
/// | 6 | [`FloatingPose`]: the same, and the place of the spacecraft's centre of mass |
pub trait PosedBase<const B: usize>: BaseMotion<f64, B> {
    /// The pose.
    type Pose: BasePose<B>;
}

/// The pose of a base of `B` degrees of freedom.
pub trait BasePose<const B: usize>: Integrable + Debug + PartialEq {
    /// Base axes and inertial axes are the same.
    fn upright() -> Self;

    /// Its rate while the base moves at `velocity` v_b, in rad/s and m/s, base axes.
    fn rate(&self, velocity: &SVector<f64, B>) -> Self::Rate;

    /// The same pose after an integrator's step: a quaternion is divided by its norm, which the step keeps to its own
    /// error only.
    #[must_use]
    fn normalised(self) -> Self;

    /// From base axes to inertial axes.
    fn attitude(&self) -> UnitQuaternion<f64>;

    /// The angular momentum about the inertial origin in inertial axes, N·m·s, of the base's `momentum`
    /// M_bb v_b + M_bm q̇_m.
    fn angular_momentum(&self, momentum: &SVector<f64, B>) -> Vector3<f64>;
}

/// Attitude and place of a spacecraft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FloatingPose {
    /// From the spacecraft's axes to inertial axes.
    pub attitude: UnitQuaternion<f64>,
    /// The spacecraft's centre of mass in m, inertial axes.
    pub place: Vector3<f64>,
}

/// The rate of a [`FloatingPose`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FloatingRate {
    /// Of the quaternion, 1/s.
    pub attitude: Quaternion<f64>,
    /// Of the place, m/s.
    pub place: Vector3<f64>,
}

impl Add for FloatingRate {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { attitude: self.attitude + other.attitude, place: self.place + other.place }
    }
}

impl Mul<f64> for FloatingRate {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self { attitude: self.attitude * factor, place: self.place * factor }
    }
}

impl PosedBase<1> for BaseFreedom<1> {
    type Pose = f64;
}

impl PosedBase<3> for BaseFreedom<3> {
    type Pose = UnitQuaternion<f64>;
}

impl PosedBase<6> for BaseFreedom<6> {
    type Pose = FloatingPose;
}

impl Integrable for f64 {
    type Rate = Self;

    fn moved(&self, rate: &Self, seconds: f64) -> Self {
        self + rate * seconds
    }
}

impl BasePose<1> for f64 {
    fn upright() -> Self {
        0.0
    }

    fn rate(&self, velocity: &Vector1<f64>) -> Self {
        velocity.x
    }

    fn normalised(self) -> Self {
        self
    }

    fn attitude(&self) -> UnitQuaternion<f64> {
        UnitQuaternion::from_axis_angle(&Vector3::z_axis(), *self)
    }

    fn angular_momentum(&self, momentum: &Vector1<f64>) -> Vector3<f64> {
        Vector3::z() * momentum.x
    }
}

/// Off the unit sphere between the stages of a step.
impl Integrable for UnitQuaternion<f64> {
    type Rate = Quaternion<f64>;

    fn moved(&self, rate: &Quaternion<f64>, seconds: f64) -> Self {
        Self::new_unchecked(**self + *rate * seconds)
    }
}

impl BasePose<3> for UnitQuaternion<f64> {
    fn upright() -> Self {
        Self::identity()
    }

    fn rate(&self, velocity: &Vector3<f64>) -> Quaternion<f64> {
        **self * Quaternion::from_imag(velocity * 0.5)
    }

    fn normalised(self) -> Self {
        Self::new_normalize(self.into_inner())
    }

    fn attitude(&self) -> UnitQuaternion<f64> {
        *self
    }

    fn angular_momentum(&self, momentum: &Vector3<f64>) -> Vector3<f64> {
        self * momentum
    }
}

impl Integrable for FloatingPose {
    type Rate = FloatingRate;

    fn moved(&self, rate: &FloatingRate, seconds: f64) -> Self {
        Self { attitude: self.attitude.moved(&rate.attitude, seconds), place: self.place + rate.place * seconds }
    }
}

impl BasePose<6> for FloatingPose {
    fn upright() -> Self {
        Self { attitude: UnitQuaternion::identity(), place: Vector3::zeros() }
    }

    fn rate(&self, velocity: &Vector6<f64>) -> FloatingRate {
        let (angular, linear) = halves(velocity);
        FloatingRate { attitude: BasePose::rate(&self.attitude, &angular), place: self.attitude * linear }
    }

    fn normalised(self) -> Self {
        Self { attitude: self.attitude.normalised(), ..self }
    }

    fn attitude(&self) -> UnitQuaternion<f64> {
        self.attitude
    }

    fn angular_momentum(&self, momentum: &Vector6<f64>) -> Vector3<f64> {
        let (angular, linear) = halves(momentum);
        self.attitude * angular + self.place.cross(&(self.attitude * linear))
    }
}

/// The angular and the linear part.
pub(super) fn halves(vector: &Vector6<f64>) -> (Vector3<f64>, Vector3<f64>) {
    (vector.fixed_rows::<3>(0).into_owned(), vector.fixed_rows::<3>(3).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::integrator::runge_kutta_step;

    /// A constant rate turns by exp of the angle; 10 000 steps leave the norm at one.
    #[test]
    fn a_constant_rate_turns_about_its_axis_and_keeps_the_norm() {
        let (rate, step) = (Vector3::new(0.4, -1.2, 0.9), 1e-3);
        let mut attitude = UnitQuaternion::from_euler_angles(0.3, -0.2, 0.8);
        let expected = attitude * UnitQuaternion::from_scaled_axis(rate * 10.0);
        for _ in 0..10_000 {
            attitude = runge_kutta_step(&attitude, step, |_, attitude| attitude.rate(&rate)).normalised();
        }
        assert!((attitude.norm() - 1.0).abs() < 4e-16, "{}", attitude.norm());
        // RK4: (|ω|·h)⁴/120 of a turn for each rad.
        assert!(attitude.angle_to(&expected) < 1e-12, "{}", attitude.angle_to(&expected));
    }

    #[test]
    fn a_planar_base_counts_whole_turns() {
        let angle = runge_kutta_step(&6.0, 1.0, |_, angle: &f64| BasePose::<1>::rate(angle, &Vector1::new(2.0)));
        approx::assert_relative_eq!(angle, 8.0, max_relative = 1e-15);
    }
}
