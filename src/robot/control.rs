//! The controllers' weights and the estimator: checked.

use hinf_control::{Law, Synthesis, WeightReading, Weights};
use nalgebra::{Matrix2, Vector2};

use uarm_io::encoder::CountsPerRevolution;
use uarm_io::estimator::{AnyEstimator, EstimatorConfiguration, KalmanSettings};

use super::error::{Checker, RobotError};
use super::file::{self, Controllers, RobotFile, Weight};

/// Checks that every law of the file can be built.
pub(super) fn check(file: &RobotFile, check: &Checker<'_>) -> Result<(), RobotError> {
    let controllers = &file.controllers;
    for law in Law::PAPER {
        let name = law.name();
        Synthesis::new(&weights(controllers, law)).map_err(|error| {
            check.refuse(
                format!("controllers.{name}"),
                error,
                "weights for which the H-infinity problem has a solution",
            )
        })?;
        if let Some(z) = adaptation_weight(controllers, law) {
            check.positive(&format!("controllers.{name}.z"), z)?;
        }
        if let Some(bound) = adaptation_bound(controllers, law) {
            check.positive(&format!("controllers.{name}.bound"), bound)?;
        }
    }
    if matches!(
        controllers.adaptive.base_acceleration,
        file::BaseAccelerationMode::Reduced | file::BaseAccelerationMode::ReducedMomentum
    ) {
        return Err(check.refuse(
            "controllers.adaptive.base_acceleration",
            "a reduced form",
            "measured, eliminated or omitted: the reduced inertia is not linear in the adapted parameters",
        ));
    }
    Ok(())
}

/// The H∞ weights of a law. The baseline has none of its own and is given those of controller 1.
pub fn weights(controllers: &Controllers, law: Law) -> Weights<f64> {
    let (velocity, position) = match law {
        Law::Nonlinear | Law::ComputedTorque => (controllers.nonlinear.q1, controllers.nonlinear.q2),
        Law::Adaptive => (controllers.adaptive.q1, controllers.adaptive.q2),
        Law::Neural => (controllers.neural.q1, controllers.neural.q2),
        Law::NeuralModel => (controllers.neural_model.q1, controllers.neural_model.q2),
        Law::Fuzzy => (controllers.fuzzy.q1, controllers.fuzzy.q2),
        Law::FuzzyModel => (controllers.fuzzy_model.q1, controllers.fuzzy_model.q2),
    };
    Weights {
        velocity: matrix(velocity),
        position: matrix(position),
        cross: Matrix2::zeros(),
        control: matrix(controllers.r),
        attenuation_level: controllers.attenuation_level,
        reading: match controllers.reading {
            file::Reading::Factors => WeightReading::Factors,
            file::Reading::Blocks => WeightReading::Blocks,
        },
    }
}

/// The scalar z of the adaptation weight Z = zI; `None` for a law that does not adapt.
pub const fn adaptation_weight(controllers: &Controllers, law: Law) -> Option<f64> {
    match law {
        Law::Nonlinear | Law::ComputedTorque => None,
        Law::Adaptive => Some(controllers.adaptive.z),
        Law::Neural => Some(controllers.neural.z),
        Law::NeuralModel => Some(controllers.neural_model.z),
        Law::Fuzzy => Some(controllers.fuzzy.z),
        Law::FuzzyModel => Some(controllers.fuzzy_model.z),
    }
}

/// How far each adapted parameter may go from its start when the adaptation is bounded; `None` for a law that does not
/// adapt.
pub const fn adaptation_bound(controllers: &Controllers, law: Law) -> Option<f64> {
    match law {
        Law::Nonlinear | Law::ComputedTorque => None,
        Law::Adaptive => Some(controllers.adaptive.bound),
        Law::Neural => Some(controllers.neural.bound),
        Law::NeuralModel => Some(controllers.neural_model.bound),
        Law::Fuzzy => Some(controllers.fuzzy.bound),
        Law::FuzzyModel => Some(controllers.fuzzy_model.bound),
    }
}

fn matrix(weight: Weight) -> Matrix2<f64> {
    match weight {
        Weight::Diagonal([first, second]) => Matrix2::from_diagonal(&Vector2::new(first, second)),
        Weight::Full([[a, b], [c, d]]) => Matrix2::new(a, b, c, d),
    }
}

/// The estimator of one joint, whose encoder has this many counts.
pub(super) fn estimator(
    file: &RobotFile,
    counts: CountsPerRevolution,
    check: &Checker<'_>,
) -> Result<AnyEstimator<f64>, RobotError> {
    let configuration = match file.estimator {
        file::Estimator::LowPass { cutoff_rad_per_s } => EstimatorConfiguration::LowPass { cutoff: cutoff_rad_per_s },
        file::Estimator::TrackingLoop { bandwidth_rad_per_s } => {
            EstimatorConfiguration::Tracking { bandwidth: bandwidth_rad_per_s }
        }
        file::Estimator::Kalman { jerk_density_rad2_per_s5 } => EstimatorConfiguration::Kalman(KalmanSettings {
            jerk_density: jerk_density_rad2_per_s5,
            // A value rounded to steps of D has the standard deviation D/sqrt(12).
            measurement_deviation: counts.resolution() / 12.0_f64.sqrt(),
            nominal_period: f64::from(file.control.period_us) * 1e-6,
        }),
        file::Estimator::Levant { jerk_bound_rad_per_s3 } => {
            EstimatorConfiguration::Levant { jerk_bound: jerk_bound_rad_per_s3 }
        }
    };
    configuration
        .build()
        .map_err(|error| check.refuse("estimator", error, "settings with which the estimator can be built"))
}
