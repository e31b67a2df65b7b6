//! The experiment's motion: checked.

use nalgebra::SVector;
use uarm_loop::period::Period;
use uarm_loop::reference::{Oscillation, Oscillations, Path, PathError, TaskReference, ViaPoint};
use uarm_loop::robot::Task;

use super::error::{Checker, RobotError};
use super::file;

/// The longest motion, s.
const LONGEST_MOTION: f64 = 3600.0;
/// The longest hold, s: a day keeps every counter of a run far from its end.
const LONGEST_HOLD: f64 = 24.0 * 3600.0;
/// The cycles of the loop that an oscillation takes at least: with fewer, its samples are another one's.
const CYCLES_OF_AN_OSCILLATION: f64 = 10.0;
/// The time in which oscillations swell and die away where the file does not say, s.
const USUAL_RAMP: f64 = 1.0;

pub(super) fn check<const N: usize>(
    task: &file::Task,
    joints: &[file::Joint],
    period: Period,
    check: &Checker<'_>,
) -> Result<Task<N>, RobotError> {
    Ok(Task {
        reference: TaskReference::new(path(task, check)?, oscillations(task, joints, period, check)?),
        hold: check.within("task.hold_s", task.hold_s, 0.0, LONGEST_HOLD)?,
        start_tolerance: check.within("task.start_tolerance_deg", task.start_tolerance_deg, 0.0, 90.0)?.to_radians(),
    })
}

/// Angles of all active joints, rad.
fn radians<const N: usize>(field: &str, degrees: &[f64], check: &Checker<'_>) -> Result<SVector<f64, N>, RobotError> {
    if degrees.len() != N {
        let expected = format!("{N}, one for each active joint");
        return Err(check.refuse(field, format!("{} values", degrees.len()), expected));
    }
    let mut angles = SVector::<f64, N>::zeros();
    for ((index, angle), degrees) in angles.iter_mut().enumerate().zip(degrees) {
        *angle = check.within(&format!("{field}[{index}]"), *degrees, -360.0, 360.0)?.to_radians();
    }
    Ok(angles)
}

fn path<const N: usize>(task: &file::Task, check: &Checker<'_>) -> Result<Path<N>, RobotError> {
    let start = radians("task.start_deg", &task.start_deg, check)?;
    let end = radians("task.end_deg", &task.end_deg, check)?;
    let duration = check.within("task.duration_s", task.duration_s, 0.1, LONGEST_MOTION)?;
    let via = task.via.iter().enumerate().map(|(index, point)| {
        let position = radians(&format!("task.via[{index}].angles_deg"), &point.angles_deg, check)?;
        Ok(ViaPoint { time: point.at_s, position, passing: point.passing })
    });
    let via = via.collect::<Result<Vec<_>, RobotError>>()?;
    Path::new(start, &via, end, duration).map_err(|error| match error {
        PathError::Time { index, found, least, most } => {
            let expected = format!("{least} to {most}: after the one before it, and before task.duration_s");
            check.refuse(format!("task.via[{index}].at_s"), found, expected)
        }
        error => check.refuse("task", format!("{:?} to {:?}", task.start_deg, task.end_deg), error.to_string()),
    })
}

fn oscillations<const N: usize>(
    task: &file::Task,
    joints: &[file::Joint],
    period: Period,
    check: &Checker<'_>,
) -> Result<Option<Oscillations<N>>, RobotError> {
    let fastest = 1.0 / (CYCLES_OF_AN_OSCILLATION * period.seconds(1));
    if task.oscillations.is_empty() {
        return match task.oscillation_ramp_s {
            Some(ramp) => Err(check.refuse("task.oscillation_ramp_s", ramp, "task.oscillations beside it")),
            None => Ok(None),
        };
    }
    let ramp = task.oscillation_ramp_s.unwrap_or(USUAL_RAMP.min(0.5 * task.duration_s));
    let ramp = check.within("task.oscillation_ramp_s", ramp, 0.01, 0.5 * task.duration_s)?;
    let active: Vec<&str> =
        joints.iter().filter(|joint| joint.role == file::Role::Active).map(|joint| joint.name.as_str()).collect();
    let each = task.oscillations.iter().enumerate().map(|(index, oscillation)| {
        let field = |name: &str| format!("task.oscillations[{index}].{name}");
        let joint = active.iter().position(|name| *name == oscillation.joint).ok_or_else(|| {
            check.refuse(field("joint"), format!("{:?}", oscillation.joint), format!("an active joint, of {active:?}"))
        })?;
        Ok(Oscillation {
            joint,
            amplitude: check.within(&field("amplitude_deg"), oscillation.amplitude_deg, 0.0, 360.0)?.to_radians(),
            frequency: check.within(
                &field("frequency_hz"),
                check.positive(&field("frequency_hz"), oscillation.frequency_hz)?,
                0.0,
                fastest,
            )?,
            phase: check.within(&field("phase_deg"), oscillation.phase_deg, -360.0, 360.0)?.to_radians(),
        })
    });
    let each = each.collect::<Result<Vec<_>, RobotError>>()?;
    let checked = Oscillations::new(each, ramp);
    checked.map(Some).map_err(|error| check.refuse("task.oscillations", "a list", error.to_string()))
}
