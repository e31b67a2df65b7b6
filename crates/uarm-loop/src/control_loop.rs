//! The hard loop: wait, read, estimate, control, limit, write, record, for as long as the supervisor lets torque flow.
//!
//! One source for every robot: it sees [`RobotDrives`] and a [`Clock`], so that real drives on SocketCAN in real time and the
//! simulated robot in virtual time run the same code, and the latter bit for bit the same each time. Nothing in here
//! allocates, locks, logs, reads a file or panics.

use uarm_io::drive::cia402::Statusword;
use uarm_io::drive::robot_drives::RobotDrives;
use uarm_io::time::{Clock, Duration, Instant};

use crate::progress::Progress;
use crate::record::{CycleRecord, HealthRecord, Recorder};
use crate::schedule::{Overrun, Schedule, Tick};
use crate::signal_path::{SignalFault, SignalPath};
use crate::stop_request::StopRequest;
use crate::supervisor::{Authority, Ordinary, State, Supervisor, TorquePermission};
use crate::timing::{CycleInstants, TimingRecorder};

/// How often the whole inner state is recorded: what a replay from the middle of a run loses at most at its beginning.
pub const KEYFRAME_INTERVAL: Duration = Duration::from_secs(1);
/// How often the health of bus and drives is recorded: ten times a second shows every heartbeat that is late.
pub const HEALTH_INTERVAL: Duration = Duration::from_millis(100);

/// What the loop works with. Build it before real time begins: the loop itself allocates nothing.
pub struct ControlLoop<'a, const J: usize, const N: usize> {
    /// From counts to torques.
    pub path: SignalPath<'a, J, N>,
    /// How long after SYNC the drives' positions are waited for; what comes later is lost.
    pub feedback_timeout: Duration,
    /// Latencies of the cycles so far.
    pub timing: TimingRecorder,
    /// What others may look at while the loop runs.
    pub progress: &'a Progress<N>,
    /// Asks the loop to end.
    pub stop: &'a StopRequest,
}

/// Why a loop ended as it should.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoopEnd {
    /// The motion is over.
    Completed,
    /// Somebody asked for the end.
    Interrupted,
}

/// Why a loop ended otherwise.
#[derive(Debug, thiserror::Error)]
pub enum LoopFault<E> {
    /// The drives or the bus failed.
    #[error(transparent)]
    Drives(E),
    /// The signals: an encoder, a limit of the robot, a torque that cannot be sent.
    #[error(transparent)]
    Signals(#[from] SignalFault),
    /// A cycle came late, and the policy is to stop then.
    #[error(transparent)]
    Overrun(#[from] Overrun),
}

impl<const J: usize, const N: usize> ControlLoop<'_, J, N> {
    /// Runs cycles for as long as `supervisor` lets torque flow: until the motion is over, the torques have faded after somebody asked
    /// for the end, or something fails. The caller then stops the drives, whatever this returns, and tells the supervisor of a fault.
    ///
    /// # Errors
    /// [`LoopFault`] names the first cause.
    pub fn run<D: RobotDrives<J>, C: Clock, F>(
        &mut self,
        drives: &mut D,
        clock: &mut C,
        schedule: &mut Schedule,
        recorder: &mut impl Recorder<J, N>,
        supervisor: &mut Supervisor<F>,
    ) -> Result<LoopEnd, LoopFault<D::CycleError>> {
        const { crate::dimensions::check::<J, N>() };
        let mut due = PeriodicRecords::default();
        recorder.keyframe(&self.path.freeze(), clock.now());
        loop {
            let tick = schedule.wait(clock)?;
            self.hear(supervisor);
            let end = if supervisor.state() == State::Running { LoopEnd::Completed } else { LoopEnd::Interrupted };
            let TorquePermission::Granted(authority) = supervisor.torque() else { return Ok(end) };
            let mut record = match self.cycle(&tick, drives, clock, schedule, authority) {
                Ok(record) => record,
                Err(fault) => {
                    self.timing.record_unfinished(clock.now().since(tick.scheduled));
                    return Err(fault);
                }
            };
            let supervised = drives.housekeeping(clock.now());
            record.torque_actual = self.path.torque.actual(drives.torque_actual());
            record.instants.done = clock.now();
            recorder.record(&record);
            self.timing.record(&record.instants, tick.elapsed);
            self.progress.publish(&record);
            self.record_periodically(&mut due, drives, record.instants.done, recorder, supervisor.state());
            supervised.map_err(LoopFault::Drives)?;
            self.look_for_the_end(supervisor, schedule);
            if supervisor.torque() == TorquePermission::Withheld {
                return Ok(end);
            }
        }
    }

    /// Tells the supervisor what others ask for.
    fn hear<F>(&self, supervisor: &mut Supervisor<F>) {
        let requests = self.stop.count();
        if requests > 0 {
            supervisor.take(Ordinary::StopRequested);
        }
        if requests > 1 {
            supervisor.take(Ordinary::StopRequestedAgain);
        }
        if supervisor.state() == State::Stopping && self.path.torque.fade.ramp().duration().is_zero() {
            supervisor.take(Ordinary::Faded);
        }
    }

    /// Tells the supervisor if this was the last cycle.
    fn look_for_the_end<F>(&self, supervisor: &mut Supervisor<F>, schedule: &Schedule) {
        if self.path.torque.fade.is_over() {
            supervisor.take(Ordinary::Faded);
        }
        if self.path.task_clock.next(schedule.period()) >= self.path.motion.end() {
            supervisor.take(Ordinary::Completed);
        }
    }

    /// One cycle: SYNC, counts, angles and velocities, reference, torque, limits, torque out.
    fn cycle<D: RobotDrives<J>, C: Clock>(
        &mut self,
        tick: &Tick,
        drives: &mut D,
        clock: &C,
        schedule: &Schedule,
        authority: Authority,
    ) -> Result<CycleRecord<J, N>, LoopFault<D::CycleError>> {
        let sync_sent = drives.sync(tick.woke).map_err(LoopFault::Drives)?;
        // Counted from SYNC, so that a late wake-up is an overrun and not a silent drive.
        let feedback = drives.collect(sync_sent + self.feedback_timeout).map_err(LoopFault::Drives)?;
        let counts_in = clock.now();

        let signals = self.path.step(tick, sync_sent, &feedback.positions, schedule.period(), authority)?;
        let torque_out = drives.send_torques(signals.torque.sent).map_err(LoopFault::Drives)?;

        let instants = CycleInstants {
            scheduled: tick.scheduled,
            woke: tick.woke,
            sync_sent,
            counts_in,
            torque_out,
            done: torque_out,
        };
        let statuswords = feedback.statuswords.map(Statusword::bits);
        let mut record = CycleRecord::new(tick, &instants, &statuswords, &signals);
        record.set_parameters(self.path.controller.parameters());
        Ok(record)
    }

    /// Records what is not worth a record in each cycle. A stop is too short for a keyframe, which would have to hold its ramp.
    fn record_periodically<D: RobotDrives<J>>(
        &self,
        due: &mut PeriodicRecords,
        drives: &D,
        now: Instant,
        recorder: &mut impl Recorder<J, N>,
        state: State,
    ) {
        if now >= due.next_keyframe && state != State::Stopping {
            due.next_keyframe = now + KEYFRAME_INTERVAL;
            recorder.keyframe(&self.path.freeze(), now);
        }
        if now >= due.next_health {
            due.next_health = now + HEALTH_INTERVAL;
            recorder.health(&HealthRecord { at: now, network: drives.health(), link: drives.link_health() });
        }
    }
}

/// When the next periodic records are due; at the end of the first cycle both are.
#[derive(Clone, Copy, Debug, Default)]
struct PeriodicRecords {
    next_keyframe: Instant,
    next_health: Instant,
}
