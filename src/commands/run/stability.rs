//! What may run on real drives: a loop that is stable along its task.

use anyhow::bail;
use hinf_control::Law;
use uarm_loop::dimensions;
use uarm_loop::stability::survey::Worst;

use super::place::Place;
use crate::robot::Robot;
use crate::stability::{Analysis, StabilityError};
use crate::words::in_words;

/// What is to be said before a run of `law` at `place`. On the simulated robot a loop that would be refused is a warning.
///
/// Along the task, since the run goes there. The rest of the workspace is not looked at here, since that takes seconds on a slow
/// machine: another command does.
///
/// # Errors
/// If the loop is not stable along the task, and the drives are real.
pub fn admit<const J: usize, const N: usize>(
    robot: &Robot<J, N>,
    law: Law,
    place: &Place,
) -> anyhow::Result<Vec<String>> {
    let drives = matches!(place, Place::Interface(_));
    let mut analysis = match Analysis::new(robot, law, None) {
        Ok(analysis) => analysis,
        Err(StabilityError::NotLinear(error)) => return Ok(vec![format!("stability: not judged: {error}")]),
        Err(error) if drives => return Err(error.into()),
        Err(error) => return Ok(vec![format!("stability: on real drives this would be refused: {error}")]),
    };
    let task = analysis.along_the_task();
    if task.is_unstable() {
        let message = refusal(robot, law, &analysis, &task);
        if drives {
            bail!("{message}");
        }
        return Ok(vec![format!("stability: on real drives this would be refused: {message}")]);
    }
    Ok(Vec::new())
}

fn radius<const J: usize, const N: usize>(worst: &Worst<N>) -> String {
    let numbers = (0..N).map(dimensions::number_of_active::<J, N>);
    let angles = worst.configuration.iter().map(|angle| format!("{:.1}", angle.to_degrees()));
    format!("spectral radius {:.4} with joints {} at {} deg", worst.radius, in_words(numbers), in_words(angles))
}

fn refusal<const J: usize, const N: usize>(
    robot: &Robot<J, N>,
    law: Law,
    analysis: &Analysis<'_, J, N>,
    task: &Worst<N>,
) -> String {
    let delays = in_words(analysis.delays().iter().map(|delay| format!("{:.2}", delay.get())));
    format!(
        "the loop would swing up along the task: {}, expected below 1, with controller {}, a period of {:?}, the estimator {}, \
         and torques that act {delays} cycles after their counts. What helps: a shorter period, an estimator \
         with less delay (robots/uarm-hardware.toml has both), drives that apply the torque on reception; `uarm stability` \
         tells how much",
        radius::<J, N>(task),
        law.name(),
        robot.description.period.duration(),
        robot.file.estimator,
    )
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use hinf_control::BaseAcceleration;

    use super::*;
    use crate::robot::BUILT_IN;
    use crate::robot::overrides::Overrides;
    use crate::simulated_plant::PlantChoice;

    const HARDWARE: Place = Place::Interface(String::new());
    const SIMULATED: Place = Place::SimulatedVirtualTime(PlantChoice::Uarm);

    fn robot(changes: &[(&str, &str)]) -> Robot {
        let text = changes.iter().fold(BUILT_IN.to_owned(), |text, (from, to)| {
            assert!(text.contains(from), "{from}");
            text.replace(from, to)
        });
        let mode = Some((Law::Nonlinear, BaseAcceleration::Reduced));
        let overrides = Overrides { base_acceleration: mode, ..Overrides::default() };
        Robot::parse(Path::new("test.toml"), &text, &overrides).unwrap()
    }

    const LATE: (&str, &str) = ("rated_torque_nm = 0.2,", "rated_torque_nm = 0.2, torque_applies = \"at-sync\",");

    #[test]
    fn real_drives_are_refused_a_loop_that_swings_up() {
        assert_eq!(admit(&robot(&[]), Law::Nonlinear, &HARDWARE).unwrap(), [""; 0]);
        let message = admit(&robot(&[LATE]), Law::Nonlinear, &HARDWARE).unwrap_err().to_string();
        for part in
            ["1.00", "expected below 1", "3ms", "low-pass, 27.81882 rad/s", "1.00 and 1.00 cycles", "uarm-hardware"]
        {
            assert!(message.contains(part), "{part}: {message}");
        }
        let [warning] = admit(&robot(&[LATE]), Law::Nonlinear, &SIMULATED).unwrap().try_into().unwrap();
        assert!(warning.contains("would be refused") && warning.contains(&message), "{warning}");
    }

    /// With half a cycle the paper's task is stable, and the stretched arm is not.
    #[test]
    fn outside_the_task_nothing_is_looked_at() {
        let robot = robot(&[("rated_torque_nm = 0.2,", "rated_torque_nm = 0.2, torque_delay_us = 1200,")]);
        assert_eq!(admit(&robot, Law::Nonlinear, &HARDWARE).unwrap(), [""; 0]);
        assert!(Analysis::new(&robot, Law::Nonlinear, None).unwrap().in_the_workspace().is_unstable());
    }

    #[test]
    fn what_is_not_judged_is_said() {
        let levant =
            ("kind = \"low-pass\"\ncutoff_rad_per_s = 27.81882", "kind = \"levant\"\njerk_bound_rad_per_s3 = 20.0");
        let [warning] = admit(&robot(&[levant]), Law::Nonlinear, &HARDWARE).unwrap().try_into().unwrap();
        assert!(warning.contains("not judged"), "{warning}");
    }
}
