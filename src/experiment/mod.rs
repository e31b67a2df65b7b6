//! One experiment: a robot, a link to it, the loop, and the end that brakes whatever happened.
//!
//! | module | subject |
//! |---|---|
//! | [`embedded`] | the embedded robot, in real or virtual time |
//! | [`hardware`] | drives on a CAN interface |
//! | [`session`] | experiments as the command line asks for them |
//! | [`place`], [`realtime`], [`tape`], [`watch`] | where they run, how the loop is scheduled, what they are recorded in, how they are watched |
//! | [`loop_thread`] | what happens on the loop's thread |
//! | [`statistics`] | what the report tells of the motion |
//! | [`report`] | the report |

pub mod embedded;
pub mod hardware;
pub mod loop_thread;
pub mod place;
pub mod realtime;
pub mod report;
pub mod session;
pub mod statistics;
pub mod tape;
pub mod watch;

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

use anyhow::Context;
use hinf_control::Disturbance;
use hinf_control::{Controller, Law, PerformanceIndices, QuinticReference, TorqueLimiter, TorqueLimits};
use nalgebra::Vector2;
use uarm_io::drive::network::{Confirmation, DriveNetwork, StopReport};
use uarm_io::encoder::Encoder;
use uarm_io::link::Link;
use uarm_io::realtime::PageFaults;
use uarm_io::time::{Clock, Duration};

use crate::control_loop::estimation::Estimation;
use crate::control_loop::guard::Guard;
use crate::control_loop::motion::Motion;
use crate::control_loop::progress::Progress;
use crate::control_loop::record::Recorder;
use crate::control_loop::schedule::{OverrunPolicy, Schedule};
use crate::control_loop::signal_path::SignalPath;
use crate::control_loop::task_clock::{PeriodSource, TaskClock};
use crate::control_loop::timing::{TimingRecorder, TimingSummary};
use crate::control_loop::torque::{DisturbanceSite, TorqueStage};
use crate::control_loop::{ControlLoop, JOINTS, LoopEnd};
use crate::controllers::AdaptationGuard;
use crate::robot::Robot;
use crate::signals::StopRequest;
use report::Indices;
use statistics::Statistics;

/// What one experiment does, beyond what the robot file says.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// The law.
    pub law: Law,
    /// What keeps Φ from drifting.
    pub guard: AdaptationGuard,
    /// What to do about late cycles.
    pub overrun: OverrunPolicy,
    /// Where the laws' period comes from.
    pub period_source: PeriodSource,
    /// How long the way to the start of the task may take; without it, the joints must be there.
    pub approach: Option<Duration>,
    /// The disturbance.
    pub disturbance: Disturbance,
    /// Where it acts.
    pub disturbance_site: DisturbanceSite,
}

impl Settings {
    /// The paper's experiment: nothing guards the adaptation, and eq. 48 disturbs the joints.
    pub fn paper(law: Law) -> Self {
        Self {
            law,
            guard: AdaptationGuard::None,
            overrun: OverrunPolicy::default(),
            period_source: PeriodSource::default(),
            approach: None,
            disturbance: Disturbance::Paper,
            disturbance_site: DisturbanceSite::Plant,
        }
    }
}

/// What came of one experiment.
#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    /// L2 and E.
    pub indices: Indices,
    /// Tracking error of joints 2 and 3 in the last cycle, rad.
    pub final_error: [f64; 2],
    /// Largest torques applied, N·m.
    pub peak_torque: [f64; 2],
    /// How far the base turned, rad.
    pub base_drift: f64,
    /// Cycles in which the limiter cut a torque.
    pub limited_cycles: u64,
    /// Timing.
    pub timing: TimingSummary,
    /// Page faults of the loop's thread between its first cycle and its last.
    pub page_faults: PageFaults,
}

/// How an experiment ended, and what came of it until then.
#[derive(Debug)]
pub struct Finished {
    /// The end, or the first cause of an early one.
    pub end: anyhow::Result<LoopEnd>,
    /// What came of it.
    pub outcome: Outcome,
    /// What braking at the end met.
    pub stop: String,
}

/// Runs one experiment over `link`: starts the drives, runs the loop, and brakes, whatever happens in between.
///
/// # Errors
/// If the experiment cannot be begun; nothing has moved then.
pub fn run<L: Link, C: Clock, R: Recorder>(
    robot: &Robot,
    settings: &Settings,
    link: L,
    clock: &mut C,
    recorder: R,
    progress: &Progress,
    stop: &StopRequest,
) -> anyhow::Result<(Finished, R)>
where
    L::Error: Send + Sync + 'static,
{
    let mut controller = crate::controllers::build(settings.law, robot, settings.guard)?;
    let mut control_loop = ControlLoop {
        path: signal_path(robot, settings, &mut controller)?,
        timing: TimingRecorder::new(robot.period.duration()),
        progress,
        stop,
    };
    let mut statistics = Statistics::new(recorder);
    let mut drives = DriveNetwork::new(link, robot.network_configuration()?);

    let started = drives.start(clock).map_err(anyhow::Error::new).context("the drives could not be started");
    let motion = started.and_then(|started| motion(robot, settings, started.drives.map(|drive| drive.position)));
    let mut page_faults = PageFaults::default();
    let end = match motion {
        Ok(motion) => {
            control_loop.path.motion = motion;
            control_loop.path.task_clock = TaskClock::new(settings.period_source, motion.start());
            let mut schedule = Schedule::new(clock.now() + robot.period.duration(), robot.period, settings.overrun);
            let faults_before = PageFaults::of_this_thread();
            let end =
                catch_unwind(AssertUnwindSafe(|| control_loop.run(&mut drives, clock, &mut schedule, &mut statistics)));
            page_faults = PageFaults::of_this_thread().since(faults_before);
            end.map(|end| end.map_err(anyhow::Error::new))
        }
        Err(error) => Ok(Err(error)),
    };
    let stop_report = drives.stop(clock);
    // A bug in the loop must not leave the motors on, so its panic goes on only now.
    let end = end.unwrap_or_else(|panic| resume_unwind(panic));
    let outcome = Outcome {
        indices: Indices { l2: control_loop.path.indices.tracking(), e: control_loop.path.indices.torque() },
        final_error: statistics.final_error,
        peak_torque: statistics.peak_torque,
        base_drift: statistics.base_drift(),
        limited_cycles: statistics.limited_cycles,
        timing: control_loop.timing.summary(),
        page_faults,
    };
    Ok((Finished { end, outcome, stop: describe(&stop_report) }, statistics.into_next()))
}

/// The way from counts to torques of an experiment without an approach, in its initial state.
///
/// # Errors
/// If the robot file's torque limits are none.
pub fn signal_path<'a>(
    robot: &Robot,
    settings: &Settings,
    controller: &'a mut dyn Controller<f64>,
) -> anyhow::Result<SignalPath<'a>> {
    Ok(SignalPath {
        estimation: Estimation::new(robot.joints.each_ref().map(|joint| (joint.encoder, joint.estimator))),
        motion: robot.task.motion(),
        controller,
        torque: torque_stage(robot, settings)?,
        guard: Guard {
            joints: robot.joints.each_ref().map(|joint| joint.limits),
            tracking_error: robot.tracking_error_limit,
            start_tolerance: robot.task.start_tolerance,
        },
        task_clock: TaskClock::new(settings.period_source, 0.0),
        indices: PerformanceIndices::new(),
    })
}

/// The motion from where the encoders say that the joints are.
fn motion(robot: &Robot, settings: &Settings, counts: [i32; JOINTS]) -> anyhow::Result<Motion> {
    let task = robot.task.motion();
    let Some(duration) = settings.approach else { return Ok(task) };
    let mut angles = [0.0; JOINTS];
    for ((angle, joint), counts) in angles.iter_mut().zip(&robot.joints).zip(counts) {
        let mut encoder = Encoder::new(joint.encoder);
        let count = encoder.update(counts, Duration::ZERO).with_context(|| joint.name.clone())?;
        *angle = encoder.angle_of(count);
    }
    let [_, second, third] = angles;
    let approach =
        QuinticReference::new(Vector2::new(second, third), *robot.task.reference.start(), duration.as_secs_f64())
            .context("--approach")?;
    Ok(task.after(approach))
}

fn torque_stage(robot: &Robot, settings: &Settings) -> anyhow::Result<TorqueStage> {
    let [_, second, third] = &robot.joints;
    let limits = TorqueLimits::new(Vector2::new(second.torque_limit, third.torque_limit))
        .and_then(|limits| limits.with_rate(Vector2::new(second.torque_rate_limit, third.torque_rate_limit)))
        .context("joints: limits")?;
    Ok(TorqueStage {
        limiter: TorqueLimiter::new(limits),
        scales: robot.joints.each_ref().map(|joint| joint.torque_scale),
        disturbance: settings.disturbance,
        site: settings.disturbance_site,
    })
}

fn describe(stop: &StopReport<JOINTS>) -> String {
    let doubtful: Vec<_> = stop.drives.iter().filter(|drive| drive.power_off != Confirmation::Confirmed).collect();
    if doubtful.is_empty() {
        return "all drives confirmed power off, brakes closed".to_owned();
    }
    let nodes: Vec<_> = doubtful.iter().map(|drive| drive.node.to_string()).collect();
    format!("NOT CONFIRMED by node {}: power off and brakes (its own heartbeat watchdog brakes it)", nodes.join(", "))
}
