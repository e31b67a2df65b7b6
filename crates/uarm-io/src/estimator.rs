//! Joint velocities and accelerations from quantised angles.
//!
//! Four methods, each of which says how an estimate moves on by one measurement; a [`VelocityEstimator`] keeps the estimate
//! and applies one of them. All take the period of each step and hold their gains to it, so that a late cycle is a longer
//! step and not an error.
//!
//! | method | velocity | angle |
//! |---|---|---|
//! | [`LowPassDerivative`] | backward difference through a first-order low-pass: the paper's | as measured |
//! | [`TrackingLoop`] | α-β-γ loop with a triple pole | tracked |
//! | [`KalmanFilter`] | constant acceleration, white jerk, steady-state gain | filtered |
//! | [`LevantDifferentiator`] | second order, homogeneous discretisation | tracked |
//! | [`AnyMethod`] | whichever of the four an [`EstimatorConfiguration`] names | |

mod any;
mod estimate;
mod kalman;
mod levant;
mod low_pass;
mod tracking;
mod velocity;

pub use any::{AnyEstimator, AnyMethod, EstimatorConfiguration};
pub use estimate::{Estimate, EstimationMethod, EstimatorError, Real};
pub use kalman::{KalmanFilter, KalmanSettings};
pub use levant::LevantDifferentiator;
pub use low_pass::LowPassDerivative;
pub use tracking::TrackingLoop;
pub use velocity::{EstimatorState, VelocityEstimator};

#[cfg(test)]
mod tests;
