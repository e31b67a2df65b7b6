//! What must be true of any run, whatever happened in it.

use std::fmt;
use std::time::Duration;

use uarm_io::torque::TorqueScale;
use uarm_loop::robot::Joint;
use uarm_sim::Brake;

use super::expectation::Expectation;
use super::fault::Fault;
use super::observation::{End, Observation};
use super::scenario::Scenario;
use crate::robot::Robot;

/// What is not as it must be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Violation {
    /// A run with this fault may not end so.
    End(End),
    /// The brakes closed too late.
    Late {
        /// From the fault to the last brake that closed.
        took: Duration,
        /// The fault's bound.
        allowed: Duration,
    },
    /// A joint did what it must not.
    Joint {
        /// The joint, counted from 1.
        joint: usize,
        /// What it did.
        what: JointViolation,
    },
    /// Cycles are missing in the record of the run.
    Record {
        /// Cycles recorded.
        cycles: u64,
        /// Cycles that began.
        syncs: u64,
    },
}

/// What is not as it must be at a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointViolation {
    /// A torque beyond its limit was sent, per mille.
    Torque {
        /// What was sent.
        sent: u16,
        /// Its limit.
        allowed: u16,
    },
    /// Its torque rose faster than its limit allows, per mille in a period.
    TorqueStep {
        /// What was sent.
        sent: u16,
        /// Its limit.
        allowed: u16,
    },
    /// It was beyond its angles.
    Angle {
        /// Where it was, rad.
        found: f64,
    },
    /// It had all of its torque for longer after the fault than it may.
    FullTorque {
        /// For how long.
        lasted: Duration,
        /// For how long it may.
        allowed: Duration,
    },
    /// Its brake is open in the end.
    BrakeOpen,
}

impl fmt::Display for Violation {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::End(end) => write!(formatter, "ended with {end}, which this fault does not explain"),
            Self::Late { took, allowed } => write!(formatter, "brakes closed after {took:?}, allowed {allowed:?}"),
            Self::Joint { joint, what } => write!(formatter, "joint {joint}: {what}"),
            Self::Record { cycles, syncs } => write!(formatter, "{cycles} cycles are recorded of {syncs} that began"),
        }
    }
}

impl fmt::Display for JointViolation {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Torque { sent, allowed } => write!(formatter, "torque {sent} per mille, allowed {allowed}"),
            Self::TorqueStep { sent, allowed } => {
                write!(formatter, "torque changed by {sent} per mille in a cycle, allowed {allowed}")
            }
            Self::Angle { found } => write!(formatter, "angle {:.2} deg, beyond its limits", found.to_degrees()),
            Self::FullTorque { lasted, allowed } => {
                write!(formatter, "full torque for {lasted:?} after the fault, allowed {allowed:?}")
            }
            Self::BrakeOpen => formatter.write_str("the brake is open in the end"),
        }
    }
}

/// Everything that is not as it must be.
pub fn judge(
    robot: &Robot,
    scenario: &Scenario,
    expectation: &Expectation,
    observation: &Observation,
) -> Vec<Violation> {
    let mut violations: Vec<_> = how_it_ended(scenario, expectation, observation).into_iter().collect();
    violations.extend(too_late(expectation, observation));
    for (index, joint) in robot.description.joints.iter().enumerate() {
        let is_excused = expectation.brake_may_fail && scenario.joint.index() == index;
        let rise = joint.torque_rate_limit * robot.description.period.seconds(1);
        // After a standstill a torque has had longer to rise in.
        let rise = if matches!(scenario.fault, Fault::Suspended { .. }) { f64::INFINITY } else { rise };
        let found = torques(joint, rise, observation, index).into_iter();
        let is_driven = joint.torque_limit > 0.0;
        let is_judged = is_driven && scenario.joint.index() == index;
        let allowed = expectation.full_torque_for.filter(|_| is_judged);
        let lasted = observation.seen.full_torque[index];
        let unnoticed = allowed.filter(|allowed| lasted > *allowed);
        let found = found.chain(unnoticed.map(|allowed| JointViolation::FullTorque { lasted, allowed }));
        let found = found.chain(mechanics(joint, observation, index).into_iter().filter(|_| !is_excused));
        violations.extend(found.map(|what| Violation::Joint { joint: index + 1, what }));
    }
    violations.extend(incomplete_record(observation));
    violations
}

fn how_it_ended(scenario: &Scenario, expectation: &Expectation, observation: &Observation) -> Option<Violation> {
    let is_expected = match observation.end {
        End::Completed => expectation.may_complete,
        End::Interrupted => scenario.fault == Fault::StopRequest,
        End::Fault(code) => expectation.faults.contains(&code),
    };
    (!is_expected).then_some(Violation::End(observation.end))
}

fn too_late(expectation: &Expectation, observation: &Observation) -> Option<Violation> {
    let (allowed, took) = (expectation.within?, observation.reaction()?);
    (took > allowed).then_some(Violation::Late { took, allowed })
}

fn torques(joint: &Joint, rise: f64, observation: &Observation, index: usize) -> Vec<JointViolation> {
    let seen = &observation.seen;
    let mut found = Vec::new();
    let (sent, allowed) = (seen.largest_torque[index], per_mille(&joint.torque_scale, joint.torque_limit));
    if sent > allowed {
        found.push(JointViolation::Torque { sent, allowed });
    }
    let (sent, allowed) = (seen.largest_step[index], per_mille(&joint.torque_scale, rise));
    if sent > allowed && rise.is_finite() {
        found.push(JointViolation::TorqueStep { sent, allowed });
    }
    found
}

fn mechanics(joint: &Joint, observation: &Observation, index: usize) -> Vec<JointViolation> {
    let [least, most] = joint.limits.position;
    let beyond = observation.seen.angles[index].into_iter().find(|angle| *angle < least || *angle > most);
    let mut found: Vec<_> = beyond.map(|found| JointViolation::Angle { found }).into_iter().collect();
    if observation.brakes[index] != Brake::Engaged {
        found.push(JointViolation::BrakeOpen);
    }
    found
}

/// The cycle that fails leaves no record.
fn incomplete_record(observation: &Observation) -> Option<Violation> {
    let failed = u64::from(matches!(observation.end, End::Fault(_)));
    let (cycles, syncs) = (observation.recorded, observation.seen.syncs);
    (cycles + failed < syncs).then_some(Violation::Record { cycles, syncs })
}

/// A torque in N·m as the wire has it, rounded up, per mille.
pub fn per_mille(scale: &TorqueScale, torque: f64) -> u16 {
    let sent = scale.to_drive(torque).map(|torque| torque.per_mille.unsigned_abs());
    sent.map_or(0, |sent| sent.saturating_add(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::injection::Seen;
    use uarm_io::time::Instant;
    use uarm_loop::fault_code::FaultCode;
    use uarm_sim::DriveFault;

    fn scenario(fault: Fault) -> (Robot, Scenario) {
        let robot = Robot::load(None).unwrap();
        let scenario = Scenario { fault, joint: uarm_sim::Joint::TWO, ..Scenario::draw(&robot, 1).unwrap() };
        (robot, scenario)
    }

    /// A run of 100 cycles that nothing is wrong with, of which the last failed with `end`.
    fn observation(end: End) -> Observation {
        let at = Instant::from_nanoseconds;
        let seen =
            Seen { syncs: 100, fault_at: Some(at(300_000_000)), braked_at: Some(at(302_000_000)), ..Seen::default() };
        Observation { end, seen, brakes: [Brake::Engaged; 3], recorded: 99 }
    }

    fn words(fault: Fault, change: impl FnOnce(&mut Observation)) -> Vec<String> {
        let (mut robot, scenario) = scenario(fault);
        // 0.03 N m in a period of 3 ms, of 0.2 N m rated.
        robot.description.joints[1].torque_rate_limit = 10.0;
        let mut observation = observation(End::Fault(FaultCode::DriveEmergency));
        change(&mut observation);
        let expectation = Expectation::of(fault, &robot);
        judge(&robot, &scenario, &expectation, &observation).iter().map(ToString::to_string).collect()
    }

    const EMERGENCY: Fault = Fault::Emergency { bytes: 3 };

    #[test]
    fn a_run_that_is_as_it_must_be_has_no_violation() {
        assert_eq!(words(EMERGENCY, |_| {}), [""; 0]);
    }

    /// The paper's robot: 0.2 N m of 0.2 N m rated at joints 2 and 3, angles within 180 deg, a period of 3 ms.
    #[test]
    fn each_rule_is_checked() {
        let one = |change: fn(&mut Observation)| words(EMERGENCY, change).join("; ");
        assert_eq!(
            one(|run| run.end = End::Completed),
            "ended with completed, which this fault does not explain; 99 cycles are recorded of 100 that began"
        );
        assert_eq!(
            one(|run| run.end = End::Fault(FaultCode::TrackingError)),
            "ended with tracking-error, which this fault does not explain"
        );
        let late = one(|run| run.seen.braked_at = Some(Instant::from_nanoseconds(306_000_001)));
        assert_eq!(late, "brakes closed after 6.000001ms, allowed 6ms");
        assert_eq!(
            one(|run| run.seen.largest_torque = [0, 1001, 1002]),
            "joint 3: torque 1002 per mille, allowed 1001"
        );
        assert_eq!(one(|run| run.seen.largest_torque = [2, 0, 0]), "joint 1: torque 2 per mille, allowed 1");
        let step = one(|run| run.seen.largest_step[1] = 152);
        assert_eq!(step, "joint 2: torque changed by 152 per mille in a cycle, allowed 151");
        assert_eq!(one(|run| run.seen.angles[2] = [-4.0, 0.0]), "joint 3: angle -229.18 deg, beyond its limits");
        assert_eq!(one(|run| run.seen.angles[2] = [0.0, 4.0]), "joint 3: angle 229.18 deg, beyond its limits");
        assert_eq!(one(|run| run.brakes[0] = Brake::Released), "joint 1: the brake is open in the end");
        assert_eq!(one(|run| run.recorded = 98), "98 cycles are recorded of 100 that began");
    }

    #[test]
    fn only_the_drive_whose_brake_fails_is_excused() {
        let fault = Fault::Drive(DriveFault::BrakeStuckReleased);
        let complete = |run: &mut Observation| {
            (run.end, run.recorded) = (End::Completed, 100);
            run.brakes = [Brake::Released; 3];
        };
        assert_eq!(
            words(fault, complete),
            ["joint 1: the brake is open in the end", "joint 3: the brake is open in the end"]
        );
    }

    #[test]
    fn a_fault_that_shows_at_full_torque_must_be_noticed_there() {
        let fault = Fault::Drive(DriveFault::EncoderStuck);
        let lasting = |milliseconds: u64| {
            words(fault, |run| {
                run.end = End::Fault(FaultCode::EncoderStuck);
                run.seen.full_torque[1] = Duration::from_millis(milliseconds);
            })
        };
        assert_eq!(lasting(250), [""; 0]);
        assert_eq!(lasting(251), ["joint 2: full torque for 251ms after the fault, allowed 250ms"]);
    }

    #[test]
    fn after_a_standstill_a_torque_may_have_risen_further() {
        let fault = Fault::Suspended { duration: Duration::from_millis(100) };
        assert_eq!(words(fault, |run| run.seen.largest_step[1] = 1000), [""; 0]);
    }
}
