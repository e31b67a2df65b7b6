//! The hard loop: wait, read, estimate, control, limit, write, record.
//!
//! One source for every robot: it sees a [`Link`] and a [`Clock`], so that real drives on SocketCAN in real time and the
//! embedded robot in virtual time run the same code, and the latter bit for bit the same each time. Nothing in here
//! allocates, locks, logs, reads a file or panics.
//!
//! | module | subject |
//! |---|---|
//! | [`schedule`] | ticks, and what happens when one is late |
//! | [`task_clock`] | what time and period the laws are told |
//! | [`motion`] | the desired motion |
//! | [`estimation`] | from counts to what the laws know of the robot |
//! | [`guard`] | the limits of the robot, beyond which the run ends |
//! | [`torque`] | from the law's torque to the drives': limits, per mille, injected disturbance |
//! | [`signal_path`] | the above in their order, without I/O: what a replay runs again |
//! | [`keyframe`] | the whole inner state, frozen |
//! | [`record`] | what a cycle leaves behind |
//! | [`timing`] | latencies and their verdict |
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing, clippy::as_conversions)
)]

pub mod estimation;
pub mod guard;
pub mod keyframe;
pub mod motion;
pub mod progress;
pub mod record;
pub mod schedule;
pub mod signal_path;
pub mod task_clock;
pub mod timing;
pub mod torque;

use uarm_io::drive::cia402::Statusword;
use uarm_io::drive::network::{CycleError, DriveNetwork};
use uarm_io::link::{Link, LinkError};
use uarm_io::time::{Clock, Duration, Instant};

use crate::signals::StopRequest;
use progress::Progress;
use record::{CycleRecord, HealthRecord, Recorder};
use schedule::{Overrun, Schedule, Tick};
use signal_path::{SignalFault, SignalPath};
use timing::{CycleInstants, TimingRecorder};

/// Joints of the robot, the passive base included.
pub const JOINTS: usize = 3;

/// How often the whole inner state is recorded: what a replay from the middle of a run loses at most at its beginning.
pub const KEYFRAME_INTERVAL: Duration = Duration::from_secs(1);
/// How often the health of bus and drives is recorded: ten times a second shows every heartbeat that is late.
pub const HEALTH_INTERVAL: Duration = Duration::from_millis(100);

/// What the loop works with. Build it before real time begins: the loop itself allocates nothing.
pub struct ControlLoop<'a> {
    /// From counts to torques.
    pub path: SignalPath<'a>,
    /// Timing so far.
    pub timing: TimingRecorder,
    /// What others may look at while the loop runs.
    pub progress: &'a Progress,
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
pub enum LoopFault<E: LinkError> {
    /// The drives or the bus.
    #[error(transparent)]
    Drives(#[from] CycleError<E>),
    /// The signals: an encoder, a limit of the robot, a torque that cannot be sent.
    #[error(transparent)]
    Signals(#[from] SignalFault),
    /// A late cycle.
    #[error(transparent)]
    Overrun(#[from] Overrun),
}

impl ControlLoop<'_> {
    /// Runs cycles until the motion is over, somebody asks for the end, or something fails. The caller then stops the
    /// drives, whatever this returns.
    ///
    /// # Errors
    /// [`LoopFault`] names the first cause.
    pub fn run<L: Link, C: Clock>(
        &mut self,
        drives: &mut DriveNetwork<L, JOINTS>,
        clock: &mut C,
        schedule: &mut Schedule,
        recorder: &mut impl Recorder,
    ) -> Result<LoopEnd, LoopFault<L::Error>> {
        let mut occasions = Occasions::default();
        recorder.keyframe(&self.path.freeze(), clock.now());
        loop {
            let tick = schedule.wait(clock)?;
            if self.stop.is_made() {
                return Ok(LoopEnd::Interrupted);
            }
            let mut record = self.cycle(&tick, drives, clock, schedule)?;
            let supervised = drives.housekeeping(clock.now());
            record.instants.done = clock.now();
            recorder.record(&record);
            self.timing.record(&record.instants, tick.elapsed);
            self.progress.publish(&record);
            self.occasionally(&mut occasions, drives, record.instants.done, recorder);
            supervised?;
            if self.path.task_clock.next(schedule.period()) >= self.path.motion.end() {
                return Ok(LoopEnd::Completed);
            }
        }
    }

    /// One cycle: SYNC, counts, angles and rates, reference, torque, limits, torque out.
    fn cycle<L: Link, C: Clock>(
        &mut self,
        tick: &Tick,
        drives: &mut DriveNetwork<L, JOINTS>,
        clock: &C,
        schedule: &Schedule,
    ) -> Result<CycleRecord, LoopFault<L::Error>> {
        let sync_sent = drives.sync()?;
        // Counted from SYNC, so that a late wake-up is an overrun and not a silent drive.
        let feedback = drives.collect(sync_sent + schedule.period().duration())?;
        let counts_in = clock.now();

        let signals = self.path.step(tick, sync_sent, &feedback.positions, schedule.period())?;
        let torque_out = drives.send_torques(signals.torque.sent)?;

        let instants = CycleInstants {
            scheduled: tick.scheduled,
            woke: tick.woke,
            sync_sent,
            counts_in,
            torque_out,
            done: torque_out,
        };
        let statuswords = feedback.statuswords.map(Statusword::bits);
        let mut record = CycleRecord::new(tick, &instants, &feedback.positions, &statuswords, &signals);
        record.set_parameters(self.path.controller.parameters());
        Ok(record)
    }

    /// Records what is not worth a record in each cycle.
    fn occasionally<L: Link>(
        &self,
        occasions: &mut Occasions,
        drives: &DriveNetwork<L, JOINTS>,
        now: Instant,
        recorder: &mut impl Recorder,
    ) {
        if now >= occasions.next_keyframe {
            occasions.next_keyframe = now + KEYFRAME_INTERVAL;
            recorder.keyframe(&self.path.freeze(), now);
        }
        if now >= occasions.next_health {
            occasions.next_health = now + HEALTH_INTERVAL;
            recorder.health(&HealthRecord { at: now, network: drives.health(), link: drives.link().health() });
        }
    }
}

/// When the next occasional records are due; at the end of the first cycle both are.
#[derive(Clone, Copy, Debug, Default)]
struct Occasions {
    next_keyframe: Instant,
    next_health: Instant,
}
