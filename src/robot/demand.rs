//! What a motion asks of the active joints, held against what the robot file allows them: before anything moves.

use nalgebra::SVector;
use serde::Serialize;
use uarm_loop::barrier::Times;
use uarm_loop::dimensions;
use uarm_loop::guard::Quantity;
use uarm_loop::reference::TaskReference;

use super::arm::Arm;
use super::error::{Checker, RobotError};
use crate::dimensions::LoopRobot;

/// In how many equal parts the motion is looked at, at least: velocity and torque of a quintic change by less than a per cent from
/// one to the next.
const SAMPLES: f64 = 1000.0;
/// In how many the shortest part of a motion of several is.
const SAMPLES_OF_A_PART: f64 = 100.0;
/// The most parts that are looked at.
const MOST_SAMPLES: f64 = 200_000.0;

/// The most that a motion asks of one active joint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Demand {
    /// Least and greatest angle, rad.
    pub position: [f64; 2],
    /// Largest velocity either way, rad/s.
    pub velocity: f64,
    /// Largest acceleration either way, rad/s².
    pub acceleration: f64,
    /// Largest torque either way, N·m: F̄ of the nominal model on a base without momentum, so without friction and disturbance.
    pub torque: f64,
    /// Largest change of that torque, N·m/s.
    pub torque_rate: f64,
}

/// The times at which a motion is looked at, from 0 to its end, and the step between them, s.
fn times<const N: usize>(motion: &TaskReference<N>) -> (impl Iterator<Item = f64>, f64) {
    let samples = (SAMPLES_OF_A_PART * motion.duration() / motion.finest()).clamp(SAMPLES, MOST_SAMPLES).ceil();
    let step = motion.duration() / samples;
    let times = (0_u32..).map(f64::from).take_while(move |sample| *sample <= samples).map(move |sample| sample * step);
    (times, step)
}

/// What `motion` asks of each active joint of the nominal `arm`.
pub fn demand<const J: usize, const N: usize>(arm: &dyn Arm<J, N>, motion: &TaskReference<N>) -> [Demand; N] {
    let (times, step) = times(motion);
    let mut most = [Demand::default(); N];
    for (joint, most) in most.iter_mut().enumerate() {
        let (start, end) = (motion.start()[joint], motion.end()[joint]);
        most.position = [start.min(end), start.max(end)];
    }
    let mut torque_before = None;
    for time in times {
        let reference = motion.at(time);
        let torque = arm.torque_from_rest(&reference);
        let change = torque_before.map_or(SVector::zeros(), |before| torque - before);
        torque_before = Some(torque);
        for (joint, most) in most.iter_mut().enumerate() {
            // A quintic never leaves the range between its ends.
            if motion.as_quintic().is_none() {
                let [least, greatest] = most.position;
                most.position = [least.min(reference.position[joint]), greatest.max(reference.position[joint])];
            }
            *most = Demand {
                position: most.position,
                velocity: most.velocity.max(reference.velocity[joint].abs()),
                acceleration: most.acceleration.max(reference.acceleration[joint].abs()),
                torque: most.torque.max(torque[joint].abs()),
                torque_rate: most.torque_rate.max((change[joint] / step).abs()),
            };
        }
    }
    most
}

/// Refuses a task that the limits of the active joints forbid: its postures, its velocity, the torque that the nominal model needs
/// for it, how fast that torque changes, and braking from it.
///
/// # Errors
/// [`RobotError::Field`] names what sets the motion, the joint, and the limit.
pub fn check<const J: usize, const N: usize>(
    robot: &LoopRobot<J, N>,
    arm: &dyn Arm<J, N>,
    motion: &TaskReference<N>,
    check: &Checker<'_>,
) -> Result<[Demand; N], RobotError> {
    let demands = demand(arm, motion);
    let passive = dimensions::passive::<J, N>();
    for (active, (joint, demand)) in robot.joints.iter().skip(passive).zip(&demands).enumerate() {
        let limits = format!("joints[{}].limits", active + passive);
        let [least, most] = joint.limits.position;
        let within = format!(
            "{:.1} to {:.1}: {limits}.minimum_deg and .maximum_deg of {}",
            least.to_degrees(),
            most.to_degrees(),
            joint.name
        );
        for (field, posture) in [(START, motion.start()), (END, motion.end())] {
            let angle = posture[active];
            if !(least..=most).contains(&angle) {
                return Err(check.refuse(format!("{field}[{active}]"), degrees(angle), within));
            }
        }
        if let Some(angle) = demand.position.into_iter().find(|angle| !(least..=most).contains(angle)) {
            let found = format!("a motion by {} deg", degrees(angle));
            return Err(check.refuse("task", found, within));
        }
        let asked = [
            (
                "velocity",
                demand.velocity.to_degrees(),
                joint.limits.velocity.to_degrees(),
                "velocity_deg_per_s",
                "deg/s",
            ),
            ("torque", demand.torque, joint.torque_limit, "torque_nm", "N m"),
            ("torque rate", demand.torque_rate, joint.torque_rate_limit, "torque_rate_nm_per_s", "N m/s"),
        ];
        for (what, asked, allowed, field, unit) in asked {
            if asked > allowed {
                let expected = format!(
                    "a motion within {limits}.{field} = {allowed}: {} would need a {what} of {} {unit}",
                    joint.name,
                    rounded(asked)
                );
                return Err(check.refuse(DURATION, motion.duration(), expected));
            }
        }
    }
    check_braking(robot, motion, check)?;
    Ok(demands)
}

const START: &str = "task.start_deg";
const END: &str = "task.end_deg";
const DURATION: &str = "task.duration_s";

/// Refuses a motion from which a joint could not be braked within its limits: the loop would end the run there. The base is taken
/// to stand at zero.
fn check_braking<const J: usize, const N: usize>(
    robot: &LoopRobot<J, N>,
    motion: &TaskReference<N>,
    check: &Checker<'_>,
) -> Result<(), RobotError> {
    let guard = robot.guard();
    let period = robot.period.seconds(1);
    let angles = |time: f64| dimensions::of_all(&motion.at(time).position);
    for time in times(motion).0 {
        let times = Times { time, elapsed: period, period };
        let before = angles((time - period).max(0.0)).map(Some);
        if let Err(violation) = guard.check_stopping(&times, &before, &angles(time)) {
            let expected = format!("a motion in which every joint can be braked within its limits: {violation}");
            if violation.quantity != Quantity::StoppingAngle {
                return Err(check.refuse(DURATION, motion.duration(), expected));
            }
            let active = violation.joint.saturating_sub(1 + dimensions::passive::<J, N>());
            if motion.as_quintic().is_none() {
                return Err(check.refuse(
                    "task",
                    format!("{} deg", degrees(motion.at(time).position[active])),
                    expected,
                ));
            }
            let is_early = time * 2.0 < motion.duration();
            let (field, posture) = if is_early { (START, motion.start()) } else { (END, motion.end()) };
            return Err(check.refuse(format!("{field}[{active}]"), degrees(posture[active]), expected));
        }
    }
    Ok(())
}

fn degrees(angle: f64) -> f64 {
    rounded(angle.to_degrees())
}

/// To three digits behind the point, without zeros at the end.
fn rounded(value: f64) -> f64 {
    (value * 1e3).round() / 1e3
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use dem_model::ThreeLinkDem;
    use nalgebra::Vector3;

    use super::*;
    use crate::robot::overrides::Overrides;
    use crate::robot::{BUILT_IN, Robot};

    fn with(from: &str, to: &str) -> Result<Robot, String> {
        assert!(BUILT_IN.contains(from), "{from}");
        // What may be unmodelled must be less than the smallest torque that is tried here.
        let text = BUILT_IN.replace("unmodelled_torque_nm = [0.15, 0.075]", "unmodelled_torque_nm = [0.002, 0.002]");
        let text = text.replace(from, to);
        Robot::parse(Path::new("test.toml"), &text, &Overrides::default()).map_err(|error| error.to_string())
    }

    #[test]
    fn a_posture_outside_the_limits_is_refused_with_joint_and_limit() {
        let message = with("end_deg = [80.0, 60.0]", "end_deg = [80.0, 171.0]").unwrap_err();
        assert!(message.starts_with("test.toml: task.end_deg[1] = 171: expected -170.0 to 170.0: "), "{message}");
        assert!(message.contains("joints[2].limits") && message.ends_with("of joint 3"), "{message}");
        let message = with("start_deg = [20.0, 20.0]", "start_deg = [-170.5, 20.0]").unwrap_err();
        assert!(message.contains("task.start_deg[0] = -170.5") && message.contains("joints[1].limits"), "{message}");
        assert!(with("end_deg = [80.0, 60.0]", "end_deg = [80.0, 169.0]").is_ok());
    }

    /// Two periods of 3 ms at the largest acceleration, and a brake that takes 100 ms more, lead beyond a limit from where a task may well end.
    #[test]
    fn a_task_from_which_a_joint_cannot_be_braked_within_its_limits_is_refused() {
        let message = with("end_deg = [80.0, 60.0]", "end_deg = [80.0, 170.0]").unwrap_err();
        assert!(message.starts_with("test.toml: task.end_deg[1] = 170: expected a motion in which every"), "{message}");
        assert!(message.contains("joint 3 at ") && message.contains("stopped a cycle later is 170."), "{message}");
        let message = with("start_deg = [20.0, 20.0]", "start_deg = [-170.0, 20.0]").unwrap_err();
        assert!(message.contains("task.start_deg[0] = -170: ") && message.contains("joint 2 at 0.000 s"), "{message}");
        let near = |brake: u32| {
            let text = BUILT_IN.replace("end_deg = [80.0, 60.0]", "end_deg = [80.0, 168.0]");
            let text = text.replace("brake_ms = 0", &format!("brake_ms = {brake}"));
            Robot::parse(Path::new("test.toml"), &text, &Overrides::default()).map_err(|error| error.to_string())
        };
        assert!(near(0).is_ok());
        let message = near(100).unwrap_err();
        assert!(message.contains("task.end_deg[1] = 168: "), "{message}");
    }

    /// A quintic's peak velocity is 15/8 of its mean: 60 deg in 3 s are 37.5 deg/s.
    #[test]
    fn a_task_that_is_too_fast_is_refused() {
        let limits = |velocity: f64| {
            let text = BUILT_IN.replace("velocity_deg_per_s = 360.0", &format!("velocity_deg_per_s = {velocity}"));
            Robot::parse(Path::new("test.toml"), &text, &Overrides::default()).map_err(|error| error.to_string())
        };
        assert!(limits(120.0).is_ok(), "{:?}", limits(60.0).err());
        let message = limits(37.6).unwrap_err();
        assert!(
            message.contains("task.duration_s = 3: expected a motion in which every joint can be braked"),
            "{message}"
        );
        let message = limits(37.4).unwrap_err();
        assert!(message.contains("task.duration_s = 3: expected a motion within"), "{message}");
        assert!(
            message.contains("velocity_deg_per_s = 37.4: joint 2 would need a velocity of 37.5 deg/s"),
            "{message}"
        );
    }

    /// The peak velocity of a quintic is 15/8 of travel over duration, its peak acceleration 10/√3 of travel over duration squared.
    #[test]
    fn the_demand_of_the_papers_task_is_that_of_its_equations() {
        let robot = Robot::load(None).unwrap();
        let [joint_2, joint_3] = demand(robot.arm.as_ref(), &robot.description.task.reference);
        let peak = |travel: f64| 10.0 / 3.0_f64.sqrt() * travel.to_radians() / 9.0;
        for (found, expected) in [
            (joint_2.velocity, (15.0 / 8.0 * 60.0 / 3.0_f64).to_radians()),
            (joint_3.velocity, (15.0 / 8.0 * 40.0 / 3.0_f64).to_radians()),
            (joint_2.acceleration, peak(60.0)),
            (joint_3.acceleration, peak(40.0)),
        ] {
            assert!((found / expected - 1.0).abs() < 1e-5, "{found} for {expected}");
        }
        // The same by the full dynamics, of which nothing is reduced: the base's acceleration is the one at which the base
        // needs no torque, and its velocity the one at which there is no momentum.
        let model = ThreeLinkDem::<f64>::table_2();
        let mut most = [0.0_f64; 2];
        for step in 0..=3000 {
            let motion = robot.description.task.reference.at(f64::from(step) * 1e-3);
            let q = Vector3::new(0.0, motion.position.x, motion.position.y);
            let with_base = |base: f64, joints: nalgebra::Vector2<f64>| Vector3::new(base, joints.x, joints.y);
            let momentum = |base| model.angular_momentum(&q, &with_base(base, motion.velocity));
            let velocity = with_base(-momentum(0.0) / (momentum(1.0) - momentum(0.0)), motion.velocity);
            let torque = |base| model.inverse_dynamics(&q, &velocity, &with_base(base, motion.acceleration));
            let base = -torque(0.0).x / (torque(1.0).x - torque(0.0).x);
            let needed = torque(base);
            assert!(needed.x.abs() < 1e-12);
            most = [most[0].max(needed.y.abs()), most[1].max(needed.z.abs())];
        }
        assert!((joint_2.torque / most[0] - 1.0).abs() < 1e-4, "{} for {}", joint_2.torque, most[0]);
        assert!((joint_3.torque / most[1] - 1.0).abs() < 1e-4, "{} for {}", joint_3.torque, most[1]);
    }

    #[test]
    fn a_torque_that_the_joint_has_not_is_refused() {
        let message = with("limits = { torque_nm = 0.2, ", "limits = { torque_nm = 0.003, ").unwrap_err();
        assert!(message.contains("torque_nm = 0.003: joint 2 would need a torque of"), "{message}");
        let message = with("torque_rate_nm_per_s = 100.0", "torque_rate_nm_per_s = 0.01").unwrap_err();
        assert!(message.contains("torque_rate_nm_per_s = 0.01: joint 2 would need a torque rate of"), "{message}");
    }
}
