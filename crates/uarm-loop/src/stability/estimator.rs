//! A velocity estimator as a linear difference equation.

use nalgebra::{Matrix3, Vector3};
use uarm_io::estimator::{AnyEstimator, AnyMethod, Estimate, EstimationMethod};

use crate::period::Period;

/// ê_k = A ê_{k−1} + b q_k for the estimate ê = [angle, velocity, acceleration] and the measured angle q, at one period.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinearEstimator {
    /// A.
    pub transition: Matrix3<f64>,
    /// b.
    pub input: Vector3<f64>,
}

/// An estimator that is no linear difference equation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("Levant's differentiator is not linear, so that this analysis says nothing about a loop with it")]
pub struct NotLinear;

impl LinearEstimator {
    /// The equation of `estimator`, from its own code: what a step makes of each unit vector is a column.
    ///
    /// # Errors
    /// [`NotLinear`] for Levant's differentiator, which takes roots of the innovation.
    pub fn of(estimator: &AnyEstimator<f64>, period: Period) -> Result<Self, NotLinear> {
        let method = estimator.method();
        if matches!(method, AnyMethod::Levant(_)) {
            return Err(NotLinear);
        }
        let step = |last: [f64; 3], position: f64| {
            let [last_position, velocity, acceleration] = last;
            let last = Estimate { position: last_position, velocity, acceleration };
            let next = method.step(&last, position, period.seconds(1));
            Vector3::new(next.position, next.velocity, next.acceleration)
        };
        let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|unit| step(unit, 0.0));
        Ok(Self { transition: Matrix3::from_columns(&columns), input: step([0.0; 3], 1.0) })
    }
}
