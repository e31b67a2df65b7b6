//! The newest that a log has told, as numbers with units.

use std::borrow::Cow;

use serde::Serialize;

use super::state::{Life, State};
use crate::dimensions::CycleRecord;
use uarm_log::cycle::state_in_words;
use uarm_log::description::ClockKind;
use uarm_log::proto;
use uarm_loop::dimensions;
use uarm_loop::timing::{CycleInstants, TimingSummary};

/// What is known now.
#[derive(Clone, Debug, Serialize)]
pub struct Snapshot<'a> {
    /// The log.
    pub file: Cow<'a, str>,
    /// What is run; nothing before the log tells.
    pub run: Option<Subject<'a>>,
    /// How it is: beginning, running, silent, failed, ended or unreadable.
    pub life: &'static str,
    /// The same in words.
    pub told: String,
    /// The last cycle; nothing before the first.
    pub cycle: Option<Cycle<'a>>,
    /// Cycles in which the limiter cut a torque.
    pub limited_cycles: u64,
    /// Timing since the start of the run.
    pub timing: Option<TimingSummary>,
    /// Bus and drives.
    pub health: Option<&'a proto::CanHealth>,
    /// What is missing or could not be read.
    pub damage: &'a [String],
}

/// What is run.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Subject<'a> {
    /// The robot's name.
    pub robot: &'a str,
    /// The interface, or the simulated plant.
    pub place: &'a str,
    /// The name of the control law.
    pub controller: &'a str,
    /// The loop's clock.
    pub clock: ClockKind,
}

/// One cycle.
#[derive(Clone, Debug, Serialize)]
pub struct Cycle<'a> {
    /// Its tick.
    pub tick: u64,
    /// Task time, s.
    pub time_s: f64,
    /// The joints.
    pub joints: Vec<JointRow<'a>>,
    /// Its latencies.
    pub latencies: Latencies,
}

/// One joint in one cycle.
#[derive(Clone, Debug, Serialize)]
pub struct JointRow<'a> {
    /// Its name in the robot file.
    pub name: &'a str,
    /// Estimated angle.
    pub angle_deg: f64,
    /// Estimated velocity.
    pub velocity_deg_per_s: f64,
    /// What is wanted of it; nothing of the base.
    pub active: Option<ActiveJoint>,
    /// Target torque as sent, per mille of the rated torque.
    pub torque_sent_per_mille: i16,
    /// State of its drive.
    pub drive: String,
}

/// An active joint in one cycle.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ActiveJoint {
    /// Desired angle.
    pub reference_deg: f64,
    /// Estimated less desired angle.
    pub error_deg: f64,
    /// What the law asked for.
    pub torque_requested_nm: f64,
    /// What the limiter left of it.
    pub torque_applied_nm: f64,
    /// Whether that is less.
    pub limited: bool,
}

/// Latencies of one cycle, us.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Latencies {
    /// From the scheduled start to the wake-up.
    pub wake_up_us: f64,
    /// From SYNC to the last count.
    pub feedback_latency_us: f64,
    /// From the scheduled start to the last torque on the link.
    pub total_us: f64,
}

impl<'a> Snapshot<'a> {
    /// The snapshot of a state.
    pub fn of<const J: usize, const N: usize>(state: &'a State<J, N>) -> Self {
        let (life, told) = words(&state.life());
        let run = state.run.as_ref();
        Self {
            file: state.file.to_string_lossy(),
            run: run.map(|run| Subject {
                robot: &run.robot.name,
                place: &run.place,
                controller: &run.controller,
                clock: run.clock(),
            }),
            life,
            told,
            cycle: run.and(state.last()).map(|record| Cycle::of(&state.joint_names, record)),
            limited_cycles: state.limited_cycles,
            timing: state.timing(),
            health: state.health.as_deref(),
            damage: &state.damage,
        }
    }
}

fn words(life: &Life) -> (&'static str, String) {
    match life {
        Life::Beginning => ("beginning", "has not begun".to_owned()),
        Life::Running => ("running", "running".to_owned()),
        Life::Silent(silence) => {
            let seconds = silence.as_secs_f64();
            ("silent", format!("nothing new for {seconds:.1} s: killed or stopped, or the disk stands still"))
        }
        Life::Failed(cause) => ("failed", format!("FAULT: {cause}")),
        Life::Ended(end) => ("ended", end.clone()),
        Life::Unreadable => ("unreadable", "the log is damaged: nothing more can be read".to_owned()),
    }
}

impl<'a> Cycle<'a> {
    fn of<const J: usize, const N: usize>(names: &'a [String], record: &CycleRecord<J, N>) -> Self {
        let joints = names.iter().enumerate();
        Self {
            tick: record.tick,
            time_s: record.time,
            joints: joints.map(|(joint, name)| JointRow::of(name, record, joint)).collect(),
            latencies: Latencies::of(&record.instants),
        }
    }
}

impl<'a> JointRow<'a> {
    fn of<const J: usize, const N: usize>(name: &'a str, record: &CycleRecord<J, N>, joint: usize) -> Self {
        let error = record.tracking_error().position;
        // A base with an encoder has neither a reference nor a torque.
        let active = joint.checked_sub(dimensions::passive::<J, N>()).map(|active| ActiveJoint {
            reference_deg: record.reference_position[active].to_degrees(),
            error_deg: error[active].to_degrees(),
            torque_requested_nm: record.torque_requested[active],
            torque_applied_nm: record.torque_applied[active],
            limited: record.flags.limited[active],
        });
        Self {
            name,
            angle_deg: record.position[joint].to_degrees(),
            velocity_deg_per_s: record.velocity[joint].to_degrees(),
            active,
            torque_sent_per_mille: record.torque_sent[joint],
            drive: state_in_words(record.statuswords[joint]),
        }
    }
}

impl Latencies {
    fn of(instants: &CycleInstants) -> Self {
        let [wake_up_us, feedback_latency_us, total_us] =
            [instants.wake_up(), instants.feedback_latency(), instants.total()]
                .map(|latency| latency.as_secs_f64() * 1e6);
        Self { wake_up_us, feedback_latency_us, total_us }
    }
}
