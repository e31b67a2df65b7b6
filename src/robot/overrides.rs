//! What a command line changes of a robot file, before it is checked.

use std::time::Duration;

use hinf_control::{BaseAcceleration, ControllerSettings, Law};

use super::error::{Checker, RobotError};
use super::file::{Control, Task};
use crate::usage::UsageError;

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
    pub(super) fn apply(&self, control: &mut Control, task: &mut Task, check: &Checker<'_>) -> Result<(), RobotError> {
        if let Some(period) = self.period {
            control.period_us = whole_microseconds(period)
                .ok_or_else(|| check.refuse("--period", format!("{period:?}"), "a whole number of microseconds"))?;
        }
        if let Some(hold) = self.hold {
            task.hold_s = hold.as_secs_f64();
        }
        Ok(())
    }

    pub(super) fn apply_to_laws<const N: usize>(
        &self,
        controllers: &mut ControllerSettings<N>,
    ) -> Result<(), RobotError> {
        if let Some((law, mode)) = self.base_acceleration {
            controllers.set_base_acceleration(law, mode).map_err(|error| {
                let (law, mode) = (law.name(), error.found.name());
                RobotError::Override(UsageError::new(format!(
                    "--base-acceleration {mode} with --controller {law}: expected {}",
                    error.expected
                )))
            })?;
        }
        Ok(())
    }
}

fn whole_microseconds(duration: Duration) -> Option<u32> {
    if duration.as_nanos().is_multiple_of(1_000) { u32::try_from(duration.as_micros()).ok() } else { None }
}
