//! The experiment's motion: checked.

use hinf_control::QuinticReference;
use nalgebra::SVector;

use uarm_loop::robot::Task;

use super::error::{Checker, RobotError};
use super::file;

/// The longest motion, s.
const LONGEST_MOTION: f64 = 3600.0;
/// The longest hold, s: a day keeps every counter of a run far from its end.
const LONGEST_HOLD: f64 = 24.0 * 3600.0;

pub(super) fn check<const N: usize>(task: &file::Task, check: &Checker<'_>) -> Result<Task<N>, RobotError> {
    let radians = |field: &str, degrees: &[f64]| -> Result<SVector<f64, N>, RobotError> {
        if degrees.len() != N {
            let expected = format!("{N}, one for each active joint");
            return Err(check.refuse(format!("task.{field}"), format!("{} values", degrees.len()), expected));
        }
        let mut angles = SVector::<f64, N>::zeros();
        for ((index, angle), degrees) in angles.iter_mut().enumerate().zip(degrees) {
            *angle = check.within(&format!("task.{field}[{index}]"), *degrees, -360.0, 360.0)?.to_radians();
        }
        Ok(angles)
    };
    let start = radians("start_deg", &task.start_deg)?;
    let end = radians("end_deg", &task.end_deg)?;
    let duration = check.within("task.duration_s", task.duration_s, 0.1, LONGEST_MOTION)?;
    let reference = QuinticReference::new(start, end, duration).map_err(|error| {
        check.refuse("task", format!("{:?} to {:?}", task.start_deg, task.end_deg), error.to_string())
    })?;
    Ok(Task {
        reference,
        hold: check.within("task.hold_s", task.hold_s, 0.0, LONGEST_HOLD)?,
        start_tolerance: check.within("task.start_tolerance_deg", task.start_tolerance_deg, 0.0, 90.0)?.to_radians(),
    })
}
