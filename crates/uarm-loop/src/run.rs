//! One run: the drives are started, the loop runs, and the drives are stopped and braked whatever happened, step by step as
//! the supervisor's states go.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

use hinf_control::{Controller, PerformanceIndices, QuinticReference, ReferenceError, TorqueLimitError};
use uarm_io::drive::network::{Confirmation, DriveStop, StopReport};
use uarm_io::drive::robot_drives::RobotDrives;
use uarm_io::encoder::Encoder;
use uarm_io::realtime::PageFaults;
use uarm_io::time::{Clock, Duration};

use crate::control_loop::{ControlLoop, LoopEnd, LoopFault};
use crate::dimensions;
use crate::estimation::{Estimation, EstimationError};
use crate::fade::Fade;
use crate::guard::LimitViolation;
use crate::motion::Motion;
use crate::outcome::{Indices, Outcome};
use crate::progress::Progress;
use crate::record::Recorder;
use crate::rest::{self, NotAtRest};
use crate::robot::Robot;
use crate::saturation::SaturationWatch;
use crate::schedule::Schedule;
use crate::settings::Settings;
use crate::signal_path::SignalPath;
use crate::statistics::Statistics;
use crate::stop_request::StopRequest;
use crate::supervisor::{Ordinary, State, Supervisor};
use crate::task_clock::TaskClock;
use crate::timing::TimingRecorder;
use crate::torque::TorqueStage;

/// What others see of a run while it goes on, and how they end it.
#[derive(Clone, Copy, Debug)]
pub struct Observer<'a, const N: usize> {
    /// The latest numbers of the loop.
    pub progress: &'a Progress<N>,
    /// Asks the loop to end.
    pub stop: &'a StopRequest,
}

/// Why a run could not be prepared. Nothing was sent to the drives.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SetupError {
    /// A torque limit of a joint cannot be used.
    #[error("joints: limits: {0}")]
    Limits(#[from] TorqueLimitError),
}

/// Why a run that was prepared did not end as planned. The drives were stopped. `S` and `C` are the drives' errors at start
/// and in a cycle.
#[derive(Debug, thiserror::Error)]
pub enum RunError<S, C> {
    /// The drives did not start.
    #[error("the drives could not be started: {0}")]
    Start(#[source] S),
    /// The encoders do not say where the joints are.
    #[error(transparent)]
    Encoder(#[from] EstimationError),
    /// There is no way from where the joints are to the start of the task.
    #[error("the approach: {0}")]
    Approach(#[from] ReferenceError),
    /// The motion from where the joints are would pass a limit; the brakes stayed closed.
    #[error(transparent)]
    Forbidden(#[from] LimitViolation),
    /// A joint turns before the brakes opened; they stayed closed.
    #[error(transparent)]
    Turning(#[from] NotAtRest),
    /// The loop ended with a fault.
    #[error(transparent)]
    Loop(#[from] LoopFault<C>),
    /// All went well until a drive did not confirm at the end that its power is off.
    #[error("the drive of node {} did not confirm at the end that its power is off", .0.node)]
    NotOff(DriveStop),
}

/// How a run ended, and what came of it until then.
#[derive(Debug)]
pub struct Finished<S, C, R, const J: usize, const N: usize> {
    /// The end, or the first cause of an early one.
    pub end: Result<LoopEnd, RunError<S, C>>,
    /// Faults that came after the first cause, such as drives that did not confirm the stop.
    pub later_faults: u64,
    /// What came of the run.
    pub outcome: Outcome<N>,
    /// What the drives said when they were stopped.
    pub stop: StopReport<J>,
    /// The recorder that the run was given.
    pub recorder: R,
}

/// Runs one experiment on `drives`: starts the drives, runs the loop, and brakes, whatever happens in between.
///
/// # Errors
/// [`SetupError`] if the run cannot be prepared; nothing has moved then.
pub fn run<D: RobotDrives<J>, C: Clock, R: Recorder<J, N>, const J: usize, const N: usize>(
    robot: &Robot<J, N>,
    settings: &Settings,
    controller: &mut dyn Controller<f64, N>,
    mut drives: D,
    clock: &mut C,
    recorder: R,
    observer: Observer<'_, N>,
) -> Result<Finished<D::StartError, D::CycleError, R, J, N>, SetupError> {
    let mut control_loop = ControlLoop {
        path: signal_path(robot, settings, controller)?,
        feedback_timeout: robot.feedback_timeout,
        timing: TimingRecorder::new(robot.period.duration()),
        progress: observer.progress,
        stop: observer.stop,
    };
    let mut statistics = Statistics::new(recorder);
    let mut supervisor = Supervisor::default();

    let motion = start(robot, settings, &mut drives, clock, &mut statistics, &mut supervisor, observer.stop);
    let mut page_faults = PageFaults::default();
    let end = match motion {
        Ok(Some(motion)) => {
            control_loop.path.task_clock = TaskClock::new(settings.period_source, motion.start());
            control_loop.path.motion = motion;
            let mut schedule = Schedule::new(clock.now() + robot.period.duration(), robot.period, settings.overrun)
                .with_overruns_in_a_row(robot.overruns_in_a_row);
            let faults_before = PageFaults::of_this_thread();
            let end = catch_unwind(AssertUnwindSafe(|| {
                control_loop.run(&mut drives, clock, &mut schedule, &mut statistics, &mut supervisor)
            }));
            page_faults = PageFaults::of_this_thread().since(faults_before);
            end.map(|end| end.map_err(RunError::from))
        }
        Ok(None) => Ok(Ok(LoopEnd::Interrupted)),
        Err(error) => Ok(Err(error)),
    };
    let stop = drives.stop(clock);
    // A bug in the loop must not leave the motors on, so its panic goes on only now.
    let end = end.unwrap_or_else(|panic| resume_unwind(panic));
    let (end, later_faults) = conclude(supervisor, end, &stop);
    let indices = Indices::from(&control_loop.path.indices);
    let outcome = Outcome::new(indices, &statistics, control_loop.timing.summary(), page_faults);
    Ok(Finished { end, later_faults, outcome, stop, recorder: statistics.into_next() })
}

/// What a run is told to have come to: its end, or the first cause of a fault, and how many faults followed.
fn conclude<S, C, const J: usize>(
    mut supervisor: Supervisor<RunError<S, C>>,
    end: Result<LoopEnd, RunError<S, C>>,
    stop: &StopReport<J>,
) -> (Result<LoopEnd, RunError<S, C>>, u64) {
    let end = end.map_err(|fault| supervisor.fault(fault));
    for drive in stop.drives.iter().filter(|drive| !is_off(drive)) {
        supervisor.fault(RunError::NotOff(*drive));
    }
    let later_faults = supervisor.later_faults();
    match (supervisor.into_first_cause(), end) {
        (None, Ok(end)) => (Ok(end), later_faults),
        (Some(cause), _) => (Err(cause), later_faults),
        (None, Err(())) => (Ok(LoopEnd::Interrupted), later_faults),
    }
}

/// Whether a drive's power is off, or was never ours to switch.
fn is_off(drive: &DriveStop) -> bool {
    matches!(drive.power_off, Confirmation::Confirmed | Confirmation::Withheld)
}

/// The way from counts to torques of a run without an approach, in its initial state.
///
/// # Errors
/// [`SetupError::Limits`] if a torque limit cannot be used.
pub fn signal_path<'a, const J: usize, const N: usize>(
    robot: &Robot<J, N>,
    settings: &Settings,
    controller: &'a mut dyn Controller<f64, N>,
) -> Result<SignalPath<'a, J, N>, SetupError> {
    Ok(SignalPath {
        estimation: Estimation::new(robot.joints.each_ref().map(|joint| (joint.encoder, joint.estimator)))
            .within(robot.acceleration_bounds),
        motion: robot.task.motion(),
        controller,
        torque: TorqueStage {
            limiter: robot.torque_limiter()?,
            output_limiter: robot.torque_limiter()?,
            fade: Fade::new(robot.stop_ramp),
            scales: robot.joints.each_ref().map(|joint| joint.torque_scale),
            disturbance: settings.disturbance,
            site: settings.disturbance_site,
        },
        saturation: SaturationWatch::new(robot.saturation_limit),
        supervision: robot.supervision(),
        guard: robot.guard(),
        task_clock: TaskClock::new(settings.period_source, 0.0),
        indices: PerformanceIndices::new(),
    })
}

/// Sets the drives up and, if the motion from where the joints stand is within their limits, opens the brakes. Nothing if somebody
/// asked for the end meanwhile.
fn start<D: RobotDrives<J>, C: Clock, const J: usize, const N: usize>(
    robot: &Robot<J, N>,
    settings: &Settings,
    drives: &mut D,
    clock: &C,
    recorder: &mut impl Recorder<J, N>,
    supervisor: &mut Supervisor<RunError<D::StartError, D::CycleError>>,
    stop: &StopRequest,
) -> Result<Option<Motion<N>>, RunError<D::StartError, D::CycleError>> {
    supervisor.take(Ordinary::Begin);
    drives.configure(clock).map_err(RunError::Start)?;
    recorder.identities(&drives.identities(), clock.now());
    let counts = where_they_stand(robot, drives, clock)?;
    let angles = angles(robot, counts)?;
    let motion = motion(robot, settings, &angles)?;
    robot.guard().check_start(&angles, &motion)?;
    supervisor.take(if stop.is_made() { Ordinary::StopRequested } else { Ordinary::Prepared });
    if supervisor.state() != State::Armed {
        return Ok(None);
    }
    drives.enable(clock).map_err(RunError::Start)?;
    supervisor.take(Ordinary::Enabled);
    Ok(Some(motion))
}

/// The counts of joints that stand still, as they must when brakes open: one that turns is not held, or moved by somebody.
fn where_they_stand<D: RobotDrives<J>, C: Clock, const J: usize, const N: usize>(
    robot: &Robot<J, N>,
    drives: &mut D,
    clock: &C,
) -> Result<[i32; J], RunError<D::StartError, D::CycleError>> {
    let before = drives.positions_after(Duration::ZERO, clock).map_err(RunError::Start)?;
    let now = drives.positions_after(rest::BETWEEN_READINGS, clock).map_err(RunError::Start)?;
    rest::check(robot.joints.each_ref().map(|joint| joint.encoder), robot.rest_velocity, before, now)?;
    Ok(now)
}

/// Where the encoders say that the joints are, rad.
fn angles<const J: usize, const N: usize>(robot: &Robot<J, N>, counts: [i32; J]) -> Result<[f64; J], EstimationError> {
    let mut angles = [0.0; J];
    for (((angle, joint), raw), number) in angles.iter_mut().zip(&robot.joints).zip(counts).zip(1..) {
        let mut encoder = Encoder::new(joint.encoder);
        let count = encoder
            .update(raw, Duration::ZERO)
            .map_err(|source| EstimationError { joint: number, source: source.into() })?;
        *angle = encoder.angle_of(count);
    }
    Ok(angles)
}

/// The motion of a run that begins at `angles`, rad.
fn motion<const J: usize, const N: usize>(
    robot: &Robot<J, N>,
    settings: &Settings,
    angles: &[f64; J],
) -> Result<Motion<N>, ReferenceError> {
    let task = robot.task.motion();
    let Some(duration) = settings.approach else { return Ok(task) };
    let start = *robot.task.reference.start();
    let approach = QuinticReference::new(dimensions::active(angles), start, duration.as_secs_f64())?;
    Ok(task.after(approach))
}
