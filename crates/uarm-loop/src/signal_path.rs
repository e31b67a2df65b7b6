//! From counts to torques, without I/O: estimate, reference, limits of the robot, law, limits of the torque.
//!
//! The live loop and a replay run this same code, on the same numbers: so a replay gives the same bits.

use hinf_control::{Command, Controller, Measurement, PerformanceIndices, Reference, TrackingError};
use uarm_io::time::Instant;

use crate::barrier::Times;
use crate::dimensions;
use crate::estimation::{Estimate, Estimation, EstimationError};
use crate::finite::{self, NotFinite};
use crate::guard::{Guard, LimitViolation};
use crate::motion::Motion;
use crate::period::Period;
use crate::plausibility::Elapsed;
use crate::saturation::{LastingSaturation, SaturationWatch};
use crate::schedule::Tick;
use crate::supervision::{Observed, Residuals, Supervision, SupervisionFault};
use crate::supervisor::Authority;
use crate::task_clock::TaskClock;
use crate::torque::{PrepareError, PreparedTorque, TorqueStage};

/// All between the counts that come in and the torques that go out, for `J` joints of which `N` are active.
pub struct SignalPath<'a, const J: usize, const N: usize> {
    /// From counts to measurements.
    pub estimation: Estimation<J>,
    /// The desired motion.
    pub motion: Motion<N>,
    /// The control law.
    pub controller: &'a mut dyn Controller<f64, N>,
    /// From the law's torque to the drives'.
    pub torque: TorqueStage<J, N>,
    /// For how long the torques have been cut.
    pub saturation: SaturationWatch<N>,
    /// What holds counts and torques against the model, if anything does.
    pub supervision: Option<Supervision<J>>,
    /// The robot's limits.
    pub guard: Guard<J>,
    /// Time and period as the laws are told them.
    pub task_clock: TaskClock,
    /// L2 and E so far.
    pub indices: PerformanceIndices<f64>,
}

/// The signals of one cycle.
#[derive(Clone, Copy, Debug)]
pub struct Signals<const J: usize, const N: usize> {
    /// Task time, s.
    pub time: f64,
    /// The period that estimators and law were told, s.
    pub period: f64,
    /// How much torque the law had.
    pub authority: Authority,
    /// What the encoders told.
    pub estimate: Estimate<J>,
    /// The same as the law saw it.
    pub measurement: Measurement<f64, N>,
    /// The desired motion.
    pub reference: Reference<f64, N>,
    /// What the law asked for.
    pub command: Command<f64, N>,
    /// What the drives are sent of it.
    pub torque: PreparedTorque<J, N>,
    /// What the model does not explain, if it is watched.
    pub residuals: Option<Residuals<J>>,
}

/// Why there is no torque to send.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SignalFault {
    /// An encoder that cannot be believed.
    #[error(transparent)]
    Estimation(#[from] EstimationError),
    /// A limit of the robot that was passed.
    #[error(transparent)]
    Limit(#[from] LimitViolation),
    /// A number that is NaN or infinite.
    #[error(transparent)]
    NotFinite(#[from] NotFinite),
    /// A torque that was cut for too long.
    #[error(transparent)]
    Saturation(#[from] LastingSaturation),
    /// Counts and torques that the model does not explain.
    #[error(transparent)]
    Supervision(#[from] SupervisionFault),
    /// A torque that cannot be sent.
    #[error(transparent)]
    Torque(#[from] PrepareError),
}

impl<const J: usize, const N: usize> SignalPath<'_, J, N> {
    /// Makes torques of the counts that the drives latched at `sync_sent`, nothing of a drive that sent none, with the `authority` that the
    /// supervisor gives.
    ///
    /// # Errors
    /// [`SignalFault`]: an encoder that cannot be believed, a limit of the robot that was passed, a number that is not finite, a torque
    /// that was cut for too long, or counts and torques that contradict the model.
    pub fn step(
        &mut self,
        tick: &Tick,
        sync_sent: Instant,
        counts: &[Option<i32>; J],
        nominal: Period,
        authority: Authority,
    ) -> Result<Signals<J, N>, SignalFault> {
        let between_syncs = self.task_clock.since_sync(sync_sent);
        let (time, period) = self.task_clock.advance(tick, sync_sent, nominal);
        let before = self.estimation.angles();
        let elapsed = Elapsed { period, error: between_syncs.map_or(0.0, |between| (between - period).abs()) };
        let estimate = self.estimation.estimate(counts, elapsed)?;
        finite::check_estimate(&estimate)?;
        let measurement = estimate.measurement();
        let reference = self.motion.at(time);
        self.guard.check(time, tick.elapsed, &estimate, &reference)?;
        // After a late SYNC a joint has turned for longer than the laws are told, and not faster.
        let turned_for = between_syncs.map_or(period, |between| between.max(period));
        let times = Times { time, elapsed: turned_for, period: nominal.seconds(1) };
        self.guard.check_stopping(&times, &before, &estimate.measured)?;

        let command = self.controller.update(&measurement, &reference, period);
        finite::check_command::<J, N>(&command, self.controller.parameters())?;
        // The first cycle's period is zero, but its torque, too, has a period to rise in.
        let rise_time = period.max(nominal.seconds(1));
        let torque = self.torque.prepare(command.torque, time, rise_time, authority)?;
        self.controller.limited(torque.limited.limited);
        if estimate.is_predicted() {
            self.controller.hold_adaptation();
        }
        if authority == Authority::Full {
            self.saturation.watch::<J>(torque.limited.limited, rise_time)?;
        }

        let residuals = self.watch(between_syncs, nominal, &estimate, &torque)?;

        if self.motion.is_task(time) {
            let error = TrackingError::new(&measurement, &reference);
            self.indices.record(&error, &torque.limited.applied, nominal.seconds(1));
        }
        Ok(Signals { time, period, authority, estimate, measurement, reference, command, torque, residuals })
    }

    /// Holds counts and torques against the model.
    fn watch(
        &mut self,
        elapsed: Option<f64>,
        nominal: Period,
        estimate: &Estimate<J>,
        torque: &PreparedTorque<J, N>,
    ) -> Result<Option<Residuals<J>>, SupervisionFault> {
        let Some(supervision) = &mut self.supervision else { return Ok(None) };
        let observed = Observed {
            elapsed,
            period: nominal.seconds(1),
            angles: &estimate.measured,
            counts: &estimate.counts,
            is_predicted: estimate.is_predicted(),
            torques: &dimensions::of_all(&torque.output),
        };
        supervision.watch(&observed).map(Some)
    }
}
