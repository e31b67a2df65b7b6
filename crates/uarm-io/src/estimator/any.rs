//! One type for whichever method a configuration names.

use super::estimate::{Estimate, EstimationMethod, EstimatorError, Real};
use super::kalman::{KalmanFilter, KalmanSettings};
use super::levant::LevantDifferentiator;
use super::low_pass::LowPassDerivative;
use super::tracking::TrackingLoop;
use super::velocity::VelocityEstimator;

/// Which method, and its settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EstimatorConfiguration {
    /// [`LowPassDerivative`].
    LowPass {
        /// Cutoff ω_c, rad/s, finite and above zero.
        cutoff: f64,
    },
    /// [`TrackingLoop`].
    Tracking {
        /// Bandwidth ω, rad/s, finite and above zero.
        bandwidth: f64,
    },
    /// [`KalmanFilter`].
    Kalman(KalmanSettings),
    /// [`LevantDifferentiator`].
    Levant {
        /// Jerk bound L, rad/s³, finite and above zero.
        jerk_bound: f64,
    },
}

/// Any of the four methods, without a heap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AnyMethod<T: Real> {
    /// Low-pass derivative: the paper's.
    LowPass(LowPassDerivative<T>),
    /// α-β-γ tracking loop.
    Tracking(TrackingLoop<T>),
    /// Steady-state Kalman filter.
    Kalman(KalmanFilter<T>),
    /// Levant's differentiator.
    Levant(LevantDifferentiator<T>),
}

impl<T: Real> AnyMethod<T> {
    /// The method of a configuration.
    ///
    /// # Errors
    /// As the constructor of the method in question.
    pub fn new(configuration: &EstimatorConfiguration) -> Result<Self, EstimatorError> {
        Ok(match configuration {
            EstimatorConfiguration::LowPass { cutoff } => Self::LowPass(LowPassDerivative::new(*cutoff)?),
            EstimatorConfiguration::Tracking { bandwidth } => Self::Tracking(TrackingLoop::new(*bandwidth)?),
            EstimatorConfiguration::Kalman(settings) => Self::Kalman(KalmanFilter::new(settings)?),
            EstimatorConfiguration::Levant { jerk_bound } => Self::Levant(LevantDifferentiator::new(*jerk_bound)?),
        })
    }
}

impl<T: Real> EstimationMethod<T> for AnyMethod<T> {
    fn step(&self, last: &Estimate<T>, position: T, period: T) -> Estimate<T> {
        match self {
            Self::LowPass(method) => method.step(last, position, period),
            Self::Tracking(method) => method.step(last, position, period),
            Self::Kalman(method) => method.step(last, position, period),
            Self::Levant(method) => method.step(last, position, period),
        }
    }
}

/// An estimator of any of the four methods.
pub type AnyEstimator<T> = VelocityEstimator<T, AnyMethod<T>>;

impl EstimatorConfiguration {
    /// The estimator of this configuration.
    ///
    /// # Errors
    /// [`EstimatorError`] if a setting is out of its range.
    pub fn build<T: Real>(&self) -> Result<AnyEstimator<T>, EstimatorError> {
        AnyMethod::new(self).map(VelocityEstimator::new)
    }
}
