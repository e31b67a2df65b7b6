//! From names and robot files to laws. A new law is registered in [`Law`] and built in [`build`], nowhere else.

use anyhow::Context;
use dem_model::REGRESSOR_PARAMETERS;
use hinf_control::adaptation::{Adaptation, AntiWindup, Ball, ScalarWeight};
use hinf_control::{
    Adaptive, AdaptiveBaseAcceleration, BaseAcceleration, Controller, FUZZY_PARAMETERS, Firing, Fuzzy, FuzzyModel,
    FuzzySets, FuzzySystem, Law, NETWORK_PARAMETERS, Neural, NeuralModel, NominalForm, NominalModel,
    NonlinearHInfinity, PdComputedTorque, PdGains, Synthesis, TanhNetworks,
};
use nalgebra::{Matrix2, SVector, Vector2};

use crate::robot::Robot;
use crate::robot::control::weights;
use crate::robot::file::{self, BaseAccelerationMode, ModelForm};

/// A law, whichever it is.
pub type BoxedController = Box<dyn Controller<f64> + Send>;

/// What keeps Φ from drifting. The laws as printed are pure integrators.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum AdaptationGuard {
    /// As printed in the paper: nothing
    None,
    /// Φ is projected onto a ball and stands still while the torque is limited: the default on hardware
    Bounded,
}

/// The law named `law` with the robot file's weights.
///
/// # Errors
/// If the weights allow no design; a checked robot file has only weights that do.
pub fn build(law: Law, robot: &Robot, guard: AdaptationGuard) -> anyhow::Result<BoxedController> {
    let controllers = &robot.file.controllers;
    let name = law.name();
    let synthesis = Synthesis::new(&weights(controllers, law)).with_context(|| format!("controllers.{name}"))?;
    let nominal = |form| NominalModel::new(robot.model, nominal_form(form));
    Ok(match law {
        Law::Nonlinear => {
            let mode = base_acceleration(controllers.nonlinear.base_acceleration);
            Box::new(NonlinearHInfinity::new(robot.model, synthesis, mode))
        }
        Law::Adaptive => {
            let settings = &controllers.adaptive;
            let initial: SVector<f64, REGRESSOR_PARAMETERS> = robot.model.regressor_parameters();
            let adaptation = adaptation(initial, settings.z, settings.bound_radius, guard)?;
            let mode = adaptive_base_acceleration(settings.base_acceleration)?;
            Box::new(Adaptive::new(robot.model, synthesis, mode, adaptation))
        }
        Law::Neural => {
            let settings = &controllers.neural;
            let adaptation =
                adaptation(SVector::<f64, NETWORK_PARAMETERS>::zeros(), settings.z, settings.bound_radius, guard)?;
            Box::new(Neural::new(synthesis, TanhNetworks::paper(), adaptation))
        }
        Law::NeuralModel => {
            let settings = &controllers.neural_model;
            let adaptation =
                adaptation(SVector::<f64, NETWORK_PARAMETERS>::zeros(), settings.z, settings.bound_radius, guard)?;
            Box::new(NeuralModel::new(nominal(settings.model_form), synthesis, TanhNetworks::paper(), adaptation))
        }
        Law::Fuzzy => {
            let settings = &controllers.fuzzy;
            let adaptation =
                adaptation(SVector::<f64, FUZZY_PARAMETERS>::zeros(), settings.z, settings.bound_radius, guard)?;
            Box::new(Fuzzy::new(synthesis, fuzzy_system(robot, settings.firing), adaptation))
        }
        Law::FuzzyModel => {
            let settings = &controllers.fuzzy_model;
            let adaptation =
                adaptation(SVector::<f64, FUZZY_PARAMETERS>::zeros(), settings.z, settings.bound_radius, guard)?;
            let system = fuzzy_system(robot, settings.firing);
            Box::new(FuzzyModel::new(nominal(settings.model_form), synthesis, system, adaptation))
        }
        Law::ComputedTorque => {
            let settings = &controllers.computed_torque;
            let diagonal = |[first, second]: [f64; 2]| Matrix2::from_diagonal(&Vector2::new(first, second));
            let gains =
                PdGains::new(diagonal(settings.proportional_nm_per_rad), diagonal(settings.derivative_nm_s_per_rad))
                    .context("controllers.computed-torque")?;
            Box::new(PdComputedTorque::new(nominal(settings.model_form), gains))
        }
    })
}

/// Adaptation from Φ(0) = `initial` with Z = zI. The guard's ball is centred there.
fn adaptation<const P: usize>(
    initial: SVector<f64, P>,
    z: f64,
    bound_radius: f64,
    guard: AdaptationGuard,
) -> anyhow::Result<Adaptation<f64, P>> {
    let adaptation = Adaptation::new(initial, ScalarWeight::new(z)?)?;
    Ok(match guard {
        AdaptationGuard::None => adaptation,
        AdaptationGuard::Bounded => adaptation
            .projected_onto_ball(Ball::new(initial, bound_radius)?)?
            .with_anti_windup(AntiWindup::FreezeWhileLimited),
    })
}

fn fuzzy_system(robot: &Robot, firing: file::Firing) -> FuzzySystem<f64> {
    let firing = match firing {
        file::Firing::Minimum => Firing::Minimum,
        file::Firing::Product => Firing::Product,
    };
    FuzzySystem::new(robot.fuzzy_sets.unwrap_or_else(FuzzySets::untrained), firing)
}

const fn nominal_form(form: ModelForm) -> NominalForm {
    match form {
        ModelForm::Paper => NominalForm::ActiveJoints,
        ModelForm::Reduced => NominalForm::Reduced,
    }
}

const fn base_acceleration(mode: BaseAccelerationMode) -> BaseAcceleration {
    match mode {
        BaseAccelerationMode::Measured => BaseAcceleration::Measured,
        BaseAccelerationMode::Eliminated => BaseAcceleration::Eliminated,
        BaseAccelerationMode::Omitted => BaseAcceleration::Omitted,
        BaseAccelerationMode::Reduced => BaseAcceleration::Reduced,
        BaseAccelerationMode::ReducedMomentum => BaseAcceleration::ReducedMomentum,
    }
}

fn adaptive_base_acceleration(mode: BaseAccelerationMode) -> anyhow::Result<AdaptiveBaseAcceleration> {
    Ok(match mode {
        BaseAccelerationMode::Measured => AdaptiveBaseAcceleration::Measured,
        BaseAccelerationMode::Eliminated => AdaptiveBaseAcceleration::Eliminated,
        BaseAccelerationMode::Omitted => AdaptiveBaseAcceleration::Omitted,
        BaseAccelerationMode::Reduced | BaseAccelerationMode::ReducedMomentum => {
            anyhow::bail!("controllers.adaptive.base_acceleration: {mode:?}, expected measured, eliminated or omitted")
        }
    })
}
