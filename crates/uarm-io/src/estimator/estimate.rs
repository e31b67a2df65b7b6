//! What the estimation methods share: the number type, the estimate, the step, and what is wrong with a setting.

use nalgebra::RealField;

/// The number type of the estimators, `f32` or `f64`; transcendentals come from `libm` on every target.
pub trait Real: RealField + Copy {
    /// The number nearest to `value`, for constants and settings written in `f64`.
    fn constant(value: f64) -> Self {
        nalgebra::convert(value)
    }

    /// True for finite numbers above zero.
    fn is_positive_finite(self) -> bool {
        self.is_finite() && self > Self::zero()
    }
}

impl<T: RealField + Copy> Real for T {}

/// What an estimator makes of a joint's angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate<T> {
    /// Angle, rad.
    pub position: T,
    /// Velocity, rad/s.
    pub velocity: T,
    /// Acceleration, rad/s².
    pub acceleration: T,
}

impl<T: Real> Estimate<T> {
    /// At `position`, not moving.
    pub fn at_rest(position: T) -> Self {
        Self { position, velocity: T::zero(), acceleration: T::zero() }
    }

    /// Moved on by `period` under constant acceleration.
    pub(super) fn predict(&self, period: T) -> Self {
        let half = T::constant(0.5);
        Self {
            position: self.position + (self.velocity + self.acceleration * period * half) * period,
            velocity: self.velocity + self.acceleration * period,
            acceleration: self.acceleration,
        }
    }
}

/// How an estimate moves on by one measurement.
pub trait EstimationMethod<T: Real> {
    /// The estimate after measuring `position` rad, `period` s after the estimate `last`. `period` is finite and above zero.
    fn step(&self, last: &Estimate<T>, position: T, period: T) -> Estimate<T>;
}

/// A setting that no estimator can be built with.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum EstimatorError {
    /// A setting that must be positive.
    #[error("{setting} of {found}, expected a finite number above zero")]
    NotPositive {
        /// Which setting, with its unit.
        setting: &'static str,
        /// The value that was refused.
        found: f64,
    },
    /// The Riccati equation has no solution within the numbers' precision.
    #[error("the Riccati equation did not settle for a tracking index of {tracking_index}")]
    Riccati {
        /// √(jerk density · period⁵ / measurement variance), no unit.
        tracking_index: f64,
    },
}

/// `value` as a `T`.
///
/// # Errors
/// [`EstimatorError::NotPositive`] unless it is finite and above zero.
pub(super) fn positive<T: Real>(setting: &'static str, value: f64) -> Result<T, EstimatorError> {
    if value.is_positive_finite() {
        Ok(T::constant(value))
    } else {
        Err(EstimatorError::NotPositive { setting, found: value })
    }
}
