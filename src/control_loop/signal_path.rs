//! From counts to torques, without I/O: estimate, reference, limits of the robot, law, limits of the torque.
//!
//! The live loop and a replay run this same code, on the same numbers: so a replay gives the same bits.

use hinf_control::{Command, Controller, Measurement, PerformanceIndices, Reference, TrackingError};
use uarm_io::time::Instant;

use super::JOINTS;
use super::estimation::{Estimate, Estimation, EstimationError};
use super::guard::{Guard, LimitViolation};
use super::motion::Motion;
use super::schedule::{Period, Tick};
use super::task_clock::TaskClock;
use super::torque::{PreparedTorque, TorqueStage};
use uarm_io::torque::TorqueError;

/// All between the counts that come in and the torques that go out.
pub struct SignalPath<'a> {
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
}

/// The signals of one cycle.
#[derive(Clone, Copy, Debug)]
pub struct Signals {
    /// Task time, s.
    pub time: f64,
    /// The period that estimators and law were told, s.
    pub period: f64,
    /// What the encoders told.
    pub estimate: Estimate,
    /// The same as the law saw it.
    pub measurement: Measurement<f64>,
    /// The desired motion.
    pub reference: Reference<f64>,
    /// What the law asked for.
    pub command: Command<f64>,
    /// What becomes of it.
    pub torque: PreparedTorque,
}

/// Why there is no torque to send.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SignalFault {
    /// The encoders.
    #[error(transparent)]
    Estimation(#[from] EstimationError),
    /// A limit of the robot.
    #[error(transparent)]
    Limit(#[from] LimitViolation),
    /// A torque that cannot be sent.
    #[error(transparent)]
    Torque(#[from] TorqueError),
}

impl SignalPath<'_> {
    /// Makes torques of the counts that the drives latched at `sync_sent`.
    ///
    /// # Errors
    /// [`SignalFault`]: an encoder that cannot be believed, or a limit of the robot that was passed.
    pub fn step(
        &mut self,
        tick: &Tick,
        sync_sent: Instant,
        counts: &[i32; JOINTS],
        nominal: Period,
    ) -> Result<Signals, SignalFault> {
        let (time, period) = self.task_clock.advance(tick, sync_sent, nominal);
        let estimate = self.estimation.estimate(counts, period)?;
        let measurement = estimate.measurement();
        let reference = self.motion.at(time);
        self.guard.check(time, tick.elapsed, &estimate, &reference)?;

        let command = self.controller.update(&measurement, &reference, period);
        // The first cycle's period is zero, but its torque, too, has a period to rise in.
        let rise_time = period.max(nominal.seconds(1));
        let torque = self.torque.prepare(command.torque, time, rise_time)?;
        self.controller.limited(torque.limited.limited);

        if self.motion.is_task(time) {
            let error = TrackingError::new(&measurement, &reference);
            self.indices.record(&error, &torque.limited.applied, nominal.seconds(1));
        }
        Ok(Signals { time, period, estimate, measurement, reference, command, torque })
    }
}
