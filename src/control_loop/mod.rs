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
//! | [`record`] | what a cycle leaves behind |
//! | [`timing`] | latencies and their verdict |
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing, clippy::as_conversions)
)]

pub mod estimation;
pub mod guard;
pub mod motion;
pub mod progress;
pub mod record;
pub mod schedule;
pub mod task_clock;
pub mod timing;
pub mod torque;

use hinf_control::{Controller, PerformanceIndices, TrackingError};
use uarm_io::drive::cia402::Statusword;
use uarm_io::drive::network::{CycleError, DriveNetwork};
use uarm_io::link::{Link, LinkError};
use uarm_io::time::Clock;
use uarm_io::torque::TorqueError;

use crate::signals::StopRequest;
use estimation::{Estimation, EstimationError};
use guard::{Guard, LimitViolation};
use motion::Motion;
use progress::Progress;
use record::{CycleFlags, CycleRecord, Recorder};
use schedule::{Overrun, Schedule, Tick};
use task_clock::TaskClock;
use timing::{CycleInstants, TimingRecorder};
use torque::TorqueStage;

/// Joints of the robot, the passive base included.
pub const JOINTS: usize = 3;

/// What the loop works with. Build it before real time begins: the loop itself allocates nothing.
pub struct ControlLoop<'a> {
    /// From counts to measurements.
    pub estimation: Estimation,
    /// The desired motion.
    pub motion: Motion,
    /// The law.
    pub controller: &'a mut dyn Controller<f64>,
    /// From the law's torque to the drives'.
    pub torque: TorqueStage,
    /// The robot's limits.
    pub guard: Guard,
    /// Time and period as the laws are told them.
    pub task_clock: TaskClock,
    /// L2 and E so far.
    pub indices: PerformanceIndices<f64>,
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
    /// The encoders.
    #[error(transparent)]
    Estimation(#[from] EstimationError),
    /// A limit of the robot.
    #[error(transparent)]
    Limit(#[from] LimitViolation),
    /// A torque that cannot be sent.
    #[error(transparent)]
    Torque(#[from] TorqueError),
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
        loop {
            let tick = schedule.wait(clock)?;
            if self.stop.is_made() {
                return Ok(LoopEnd::Interrupted);
            }
            let record = self.cycle(&tick, drives, clock, schedule)?;
            recorder.record(&record);
            self.timing.record(&record.instants, tick.elapsed);
            self.progress.publish(&record);
            drives.housekeeping(clock.now())?;
            if self.task_clock.next(schedule.period()) >= self.motion.end() {
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

        let (time, period) = self.task_clock.advance(tick, sync_sent, schedule.period());
        let estimate = self.estimation.estimate(&feedback.positions, period)?;
        let measurement = estimate.measurement();
        let reference = self.motion.at(time);
        self.guard.check(time, tick.elapsed, &estimate, &reference)?;

        let command = self.controller.update(&measurement, &reference, period);
        // The first cycle's period is zero, but its torque, too, has a period to rise in.
        let rise_time = period.max(schedule.period().seconds(1));
        let torque = self.torque.prepare(command.torque, time, rise_time)?;
        self.controller.limited(torque.limited.limited);
        let torque_out = drives.send_torques(torque.sent)?;

        let error = TrackingError::new(&measurement, &reference);
        if self.motion.is_task(time) {
            self.indices.record(&error, &torque.limited.applied, schedule.period().seconds(1));
        }
        let mut record = CycleRecord {
            tick: tick.index,
            time,
            period,
            instants: CycleInstants { scheduled: tick.scheduled, woke: tick.woke, sync_sent, counts_in, torque_out },
            counts: feedback.positions,
            statuswords: feedback.statuswords.map(Statusword::bits),
            position: estimate.position(),
            rate: estimate.rate(),
            base_acceleration: measurement.base.acceleration,
            reference_position: reference.position.into(),
            reference_rate: reference.rate.into(),
            reference_acceleration: reference.acceleration.into(),
            control_input: command.control_input.into(),
            torque_requested: command.torque.into(),
            torque_applied: torque.limited.applied.into(),
            torque_sent: torque.sent,
            disturbance: torque.disturbance.into(),
            parameters: [0.0; record::PARAMETER_CAPACITY],
            parameter_count: 0,
            flags: CycleFlags {
                limited: torque.limited.limited,
                projected: command.adaptation.projected,
                frozen: command.adaptation.frozen,
                fell_back: command.adaptation.fell_back,
            },
        };
        record.set_parameters(self.controller.parameters());
        Ok(record)
    }
}
