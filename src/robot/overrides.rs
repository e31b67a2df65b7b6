//! What a command line changes of a robot file, before it is checked.

use std::time::Duration;

use hinf_control::{BaseAcceleration, Law};

use super::error::{Checker, RobotError};
use super::file::{BaseAccelerationMode, ModelForm, RobotFile};

/// Changes to a robot file.
#[derive(Clone, Copy, Debug, Default)]
pub struct Overrides {
    /// Another period.
    pub period: Option<Duration>,
    /// Another time for which the end of the motion is held.
    pub hold: Option<Duration>,
    /// Another way for one law to have the base acceleration.
    pub base_acceleration: Option<(Law, BaseAcceleration)>,
}

impl Overrides {
    pub(super) fn apply(&self, file: &mut RobotFile, check: &Checker<'_>) -> Result<(), RobotError> {
        if let Some(period) = self.period {
            file.control.period_us = whole_microseconds(period)
                .ok_or_else(|| check.refuse("--period", format!("{period:?}"), "a whole number of microseconds"))?;
        }
        if let Some(hold) = self.hold {
            file.task.hold_s = hold.as_secs_f64();
        }
        if let Some((law, mode)) = self.base_acceleration {
            set_base_acceleration(file, law, mode, check)?;
        }
        Ok(())
    }
}

fn whole_microseconds(duration: Duration) -> Option<u32> {
    if duration.as_nanos().is_multiple_of(1_000) { u32::try_from(duration.as_micros()).ok() } else { None }
}

fn set_base_acceleration(
    file: &mut RobotFile,
    law: Law,
    mode: BaseAcceleration,
    check: &Checker<'_>,
) -> Result<(), RobotError> {
    let mode = BaseAccelerationMode::from(mode);
    let controllers = &mut file.controllers;
    let form = match law {
        Law::Nonlinear => {
            controllers.nonlinear.base_acceleration = mode;
            return Ok(());
        }
        Law::Adaptive => {
            controllers.adaptive.base_acceleration = mode;
            return Ok(());
        }
        Law::NeuralModel => &mut controllers.neural_model.model_form,
        Law::FuzzyModel => &mut controllers.fuzzy_model.model_form,
        Law::Neural | Law::Fuzzy | Law::ComputedTorque => {
            let expected = "nonlinear, adaptive, neural-model or fuzzy-model: no other law models the base";
            return Err(check.refuse("--base-acceleration with --controller", law.name(), expected));
        }
    };
    *form = match mode {
        BaseAccelerationMode::Omitted => ModelForm::Paper,
        BaseAccelerationMode::Reduced => ModelForm::Reduced,
        other => {
            let expected = format!("omitted or reduced for {}, which reads no base data", law.name());
            return Err(check.refuse("--base-acceleration", format!("{other:?}"), expected));
        }
    };
    Ok(())
}
