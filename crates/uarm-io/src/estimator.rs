//! Joint rates and accelerations from quantised angles.
//!
//! Four estimators behind one trait. All take the period of each step and hold their gains to it, so that a late cycle
//! is a longer step and not an error; a period of zero, or one that is no number, changes nothing but what the
//! measurement itself says.
//!
//! | estimator | rate | angle |
//! |---|---|---|
//! | [`LowPassDerivative`] | backward difference through a first-order low-pass: the paper's | as measured |
//! | [`TrackingLoop`] | α-β-γ loop with a triple pole | tracked |
//! | [`KalmanFilter`] | constant acceleration, white jerk, steady-state gain | filtered |
//! | [`RobustDifferentiator`] | Levant's, second order, homogeneous discretisation | tracked |

mod any;
mod kalman;
mod levant;
mod low_pass;
mod tracking;

pub use any::{AnyEstimator, EstimatorConfiguration};
pub use kalman::{KalmanFilter, KalmanSettings};
pub use levant::RobustDifferentiator;
pub use low_pass::LowPassDerivative;
pub use tracking::TrackingLoop;

use crate::real::Real;

/// What an estimator makes of a joint's angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate<T> {
    /// Angle, rad.
    pub position: T,
    /// Rate, rad/s.
    pub rate: T,
    /// Acceleration, rad/s².
    pub acceleration: T,
}

impl<T: Real> Estimate<T> {
    /// At `position`, not moving.
    pub fn at_rest(position: T) -> Self {
        Self { position, rate: T::zero(), acceleration: T::zero() }
    }

    /// Moved on by `period` under constant acceleration.
    fn predict(&self, period: T) -> Self {
        let half = T::constant(0.5);
        Self {
            position: self.position + (self.rate + self.acceleration * period * half) * period,
            rate: self.rate + self.acceleration * period,
            acceleration: self.acceleration,
        }
    }
}

/// An estimator's whole state: its last estimate, none before the first measurement.
pub type EstimatorState<T> = Option<Estimate<T>>;

/// Something that makes rates of angles.
///
/// The first measurement, after construction or [`RateEstimator::reset_unknown`], is taken as a joint at rest.
pub trait RateEstimator<T: Real> {
    /// The estimate after measuring `position` rad, `period` s after the previous measurement; the period of the first
    /// call does not matter.
    fn update(&mut self, position: T, period: T) -> Estimate<T>;

    /// The whole state, to be put back with [`RateEstimator::thaw`].
    fn freeze(&self) -> EstimatorState<T>;

    /// Goes on from a frozen state.
    fn thaw(&mut self, state: EstimatorState<T>);

    /// Starts again, at rest at `position` rad.
    fn reset(&mut self, position: T) {
        self.thaw(Some(Estimate::at_rest(position)));
    }

    /// Starts again, at rest where the next measurement will be.
    fn reset_unknown(&mut self) {
        self.thaw(None);
    }
}

/// A setting that no estimator can be built with.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum EstimatorError {
    /// A setting that must be positive.
    #[error("{setting} of {found}, expected a finite number above zero")]
    NotPositive {
        /// Which setting, with its unit.
        setting: &'static str,
        /// Its value.
        found: f64,
    },
    /// The Riccati equation has no solution within the numbers' precision.
    #[error("the Riccati equation did not settle for a tracking index of {tracking_index}")]
    Riccati {
        /// √(jerk density · period⁵ / measurement variance), no unit.
        tracking_index: f64,
    },
}

fn positive<T: Real>(setting: &'static str, value: f64) -> Result<T, EstimatorError> {
    if value.is_finite() && value > 0.0 {
        Ok(T::constant(value))
    } else {
        Err(EstimatorError::NotPositive { setting, found: value })
    }
}

#[cfg(test)]
mod tests;
