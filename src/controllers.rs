//! From names and robot files to laws: what the file chooses, for the register of laws in `hinf-control`.

use anyhow::Context;
use hinf_control::adaptation::AntiWindup;
use hinf_control::{
    AdaptationWeights, AnyController, BaseAcceleration, ControllerOptions, FUZZY_PARAMETERS, Firing, FuzzySets,
    FuzzySystem, Law, NETWORK_PARAMETERS, NominalForm, ParameterLimits,
};

use uarm_loop::settings::AdaptationGuard;

use crate::robot::Robot;
use crate::robot::control::{adaptation_bound, adaptation_weight, weights};
use crate::robot::file::{self, BaseAccelerationMode, Controllers, ModelForm};

/// The law with the robot file's weights and choices.
///
/// # Errors
/// If they allow no design; a checked robot file has only such that do.
pub fn build(law: Law, robot: &Robot, guard: AdaptationGuard) -> anyhow::Result<AnyController<f64>> {
    let controllers = &robot.file.controllers;
    let mut options = ControllerOptions::paper(law);
    options.base_acceleration = base_acceleration(controllers, law);
    options.nominal_form = nominal_form(controllers, law);
    if let Some(z) = adaptation_weight(controllers, law) {
        options.adaptation_weights = AdaptationWeights::Scalar(z);
    }
    options.fuzzy_system =
        FuzzySystem::new(robot.fuzzy_sets.unwrap_or_else(FuzzySets::untrained), firing(controllers, law));
    // A box, not a ball: clamping keeps inequality 12 for every diagonal Z and design (docs/theory.md, projection).
    let (lower, upper) = parameter_box(robot, law);
    if guard == AdaptationGuard::Bounded && !lower.is_empty() {
        options.parameter_limits = ParameterLimits::Box { lower: &lower, upper: &upper };
        options.anti_windup = AntiWindup::FreezeWhileLimited;
    }
    AnyController::new(law, robot.model, &weights(controllers, law), &options)
        .with_context(|| format!("controllers.{}", law.name()))
}

fn base_acceleration(controllers: &Controllers, law: Law) -> BaseAcceleration {
    let mode = match law {
        Law::Adaptive => controllers.adaptive.base_acceleration,
        _ => controllers.nonlinear.base_acceleration,
    };
    match mode {
        BaseAccelerationMode::Measured => BaseAcceleration::Measured,
        BaseAccelerationMode::Eliminated => BaseAcceleration::Eliminated,
        BaseAccelerationMode::Omitted => BaseAcceleration::Omitted,
        BaseAccelerationMode::Reduced => BaseAcceleration::Reduced,
        BaseAccelerationMode::ReducedMomentum => BaseAcceleration::ReducedMomentum,
    }
}

fn nominal_form(controllers: &Controllers, law: Law) -> NominalForm {
    let form = match law {
        Law::NeuralModel => controllers.neural_model.model_form,
        Law::FuzzyModel => controllers.fuzzy_model.model_form,
        _ => controllers.computed_torque.model_form,
    };
    match form {
        ModelForm::Paper => NominalForm::ActiveJoints,
        ModelForm::Reduced => NominalForm::Reduced,
    }
}

/// How the rules of a fuzzy law fire; of any other law, as those of `fuzzy`.
pub fn firing(controllers: &Controllers, law: Law) -> Firing {
    let firing = match law {
        Law::FuzzyModel => controllers.fuzzy_model.firing,
        _ => controllers.fuzzy.firing,
    };
    match firing {
        file::Firing::Minimum => Firing::Minimum,
        file::Firing::Product => Firing::Product,
    }
}

/// The corners of the box that the guard keeps Φ in, around where it starts; empty for a law that does not adapt.
fn parameter_box(robot: &Robot, law: Law) -> (Vec<f64>, Vec<f64>) {
    let start = match law {
        Law::Nonlinear | Law::ComputedTorque => Vec::new(),
        Law::Adaptive => robot.model.regressor_parameters().as_slice().to_vec(),
        Law::Neural | Law::NeuralModel => vec![0.0; NETWORK_PARAMETERS],
        Law::Fuzzy | Law::FuzzyModel => vec![0.0; FUZZY_PARAMETERS],
    };
    let bound = adaptation_bound(&robot.file.controllers, law).unwrap_or_default();
    let corner = |distance: f64| start.iter().map(|value| value + distance).collect();
    (corner(-bound), corner(bound))
}
