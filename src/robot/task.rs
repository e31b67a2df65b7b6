//! The experiment's motion: checked.

use hinf_control::QuinticReference;
use nalgebra::Vector2;

use uarm_loop::robot::Task;

use crate::dimensions::ACTIVE;

use super::error::{Checker, RobotError};
use super::file;

/// The longest motion, s.
const LONGEST_MOTION: f64 = 3600.0;
/// The longest hold, s: a day keeps every counter of a run far from its end.
const LONGEST_HOLD: f64 = 24.0 * 3600.0;

pub(super) fn check(task: &file::Task, check: &Checker<'_>) -> Result<Task<ACTIVE>, RobotError> {
    let radians = |field: &str, [joint_2, joint_3]: [f64; 2]| -> Result<Vector2<f64>, RobotError> {
        Ok(Vector2::new(
            check.within(&format!("task.{field}[0]"), joint_2, -360.0, 360.0)?.to_radians(),
            check.within(&format!("task.{field}[1]"), joint_3, -360.0, 360.0)?.to_radians(),
        ))
    };
    let start = radians("start_deg", task.start_deg)?;
    let end = radians("end_deg", task.end_deg)?;
    let duration = check.within("task.duration_s", task.duration_s, 0.1, LONGEST_MOTION)?;
    let reference = QuinticReference::new(start, end, duration)
        .map_err(|error| check.refuse("task", format!("{start:?} to {end:?}"), error.to_string()))?;
    Ok(Task {
        reference,
        hold: check.within("task.hold_s", task.hold_s, 0.0, LONGEST_HOLD)?,
        start_tolerance: check.within("task.start_tolerance_deg", task.start_tolerance_deg, 0.0, 90.0)?.to_radians(),
    })
}
