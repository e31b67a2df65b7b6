//! One type for whichever estimator a robot file names.

use super::{
    Estimate, EstimatorError, EstimatorState, KalmanFilter, KalmanSettings, LowPassDerivative, RateEstimator,
    RobustDifferentiator, TrackingLoop,
};
use crate::real::Real;

/// Which estimator, and its settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EstimatorConfiguration {
    /// [`LowPassDerivative`].
    LowPass {
        /// ω_c, rad/s.
        corner: f64,
    },
    /// [`TrackingLoop`].
    Tracking {
        /// ω, rad/s.
        bandwidth: f64,
    },
    /// [`KalmanFilter`].
    Kalman(KalmanSettings),
    /// [`RobustDifferentiator`].
    Robust {
        /// L, rad/s³.
        jerk_bound: f64,
    },
}

/// Any of the four estimators, without a heap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AnyEstimator<T: Real> {
    /// The paper's.
    LowPass(LowPassDerivative<T>),
    /// α-β-γ.
    Tracking(TrackingLoop<T>),
    /// Kalman.
    Kalman(KalmanFilter<T>),
    /// Levant.
    Robust(RobustDifferentiator<T>),
}

impl<T: Real> AnyEstimator<T> {
    /// The estimator of a configuration.
    ///
    /// # Errors
    /// As the constructor of the estimator in question.
    pub fn new(configuration: &EstimatorConfiguration) -> Result<Self, EstimatorError> {
        Ok(match configuration {
            EstimatorConfiguration::LowPass { corner } => Self::LowPass(LowPassDerivative::new(*corner)?),
            EstimatorConfiguration::Tracking { bandwidth } => Self::Tracking(TrackingLoop::new(*bandwidth)?),
            EstimatorConfiguration::Kalman(settings) => Self::Kalman(KalmanFilter::new(settings)?),
            EstimatorConfiguration::Robust { jerk_bound } => Self::Robust(RobustDifferentiator::new(*jerk_bound)?),
        })
    }
}

impl<T: Real> RateEstimator<T> for AnyEstimator<T> {
    fn update(&mut self, position: T, period: T) -> Estimate<T> {
        match self {
            Self::LowPass(estimator) => estimator.update(position, period),
            Self::Tracking(estimator) => estimator.update(position, period),
            Self::Kalman(estimator) => estimator.update(position, period),
            Self::Robust(estimator) => estimator.update(position, period),
        }
    }

    fn freeze(&self) -> EstimatorState<T> {
        match self {
            Self::LowPass(estimator) => estimator.freeze(),
            Self::Tracking(estimator) => estimator.freeze(),
            Self::Kalman(estimator) => estimator.freeze(),
            Self::Robust(estimator) => estimator.freeze(),
        }
    }

    fn thaw(&mut self, state: EstimatorState<T>) {
        match self {
            Self::LowPass(estimator) => estimator.thaw(state),
            Self::Tracking(estimator) => estimator.thaw(state),
            Self::Kalman(estimator) => estimator.thaw(state),
            Self::Robust(estimator) => estimator.thaw(state),
        }
    }
}
