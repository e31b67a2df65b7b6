//! What one cycle leaves behind: a fixed-size record, handed over without waiting.

use hinf_control::TrackingError;
use nalgebra::SVector;
use uarm_io::drive::DriveIdentity;
use uarm_io::drive::network::NetworkHealth;
use uarm_io::link::LinkHealth;
use uarm_io::time::Instant;

use crate::dimensions;
use crate::estimation::AngleSource;
use crate::keyframe::Keyframe;
use crate::schedule::Tick;
use crate::signal_path::Signals;
use crate::supervision::Residuals;
use crate::supervisor::Authority;
use crate::timing::CycleInstants;
use crate::torque::ActualTorque;

/// The most adapted parameters that a law has: two fuzzy systems of nine rules with three consequents each.
pub const PARAMETER_CAPACITY: usize = 54;

/// Every signal of one cycle of `J` joints of which `N` are active. All instants are on the loop's clock; the measured half (counts, angles, velocities) belongs
/// to the SYNC of this cycle, the torques leave after it and act until the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CycleRecord<const J: usize, const N: usize> {
    /// Ticks since the start of the run.
    pub tick: u64,
    /// Ticks since the previous cycle: 1 unless some were skipped, 0 in the first cycle.
    pub elapsed_ticks: u64,
    /// Task time: when the reference was evaluated, s.
    pub time: f64,
    /// The period that estimators and laws were told, s; 0 on the first cycle.
    pub period: f64,
    /// How much torque the supervisor allowed the law: full while it is *running*, fading while it is *stopping*. In no other state
    /// is there a cycle.
    pub authority: Authority,
    /// The instants of the cycle.
    pub instants: CycleInstants,
    /// Encoder counts of the joints as the drives sent them; of a predicted angle, the last one that was believed.
    pub counts: [i32; J],
    /// Where the angles come from.
    pub angle_sources: [AngleSource; J],
    /// CiA 402 statuswords of the drives.
    pub statuswords: [u16; J],
    /// Joint angles as the encoders give them or as they are predicted, rad.
    pub measured_position: [f64; J],
    /// Estimated joint angles, rad: some estimators filter them.
    pub position: [f64; J],
    /// Estimated joint velocities, rad/s.
    pub velocity: [f64; J],
    /// Estimated base acceleration, rad/s².
    pub base_acceleration: f64,
    /// Desired angles of the active joints, rad.
    pub reference_position: [f64; N],
    /// Desired velocities of the active joints, rad/s.
    pub reference_velocity: [f64; N],
    /// Desired accelerations of the active joints, rad/s².
    pub reference_acceleration: [f64; N],
    /// The H∞ control input u (eq. 10).
    pub control_input: [f64; N],
    /// Torques that the law asked for, N·m.
    pub torque_requested: [f64; N],
    /// Torques after the limiter, N·m: what E is computed from.
    pub torque_applied: [f64; N],
    /// Target torques as sent, per mille of the rated torque.
    pub torque_sent: [i16; J],
    /// Torques that the drives reported, of those that report one: for this cycle's SYNC, or for the one before if the report was
    /// still on its way when the cycle ended.
    pub torque_actual: [Option<ActualTorque>; J],
    /// The experiment's disturbance at this instant, N·m.
    pub disturbance: [f64; N],
    /// What the model does not explain, of a run that is held against it.
    pub unexplained: Option<Unexplained<N>>,
    /// Adapted parameters Φ; those beyond `parameter_count` are zero.
    pub parameters: [f64; PARAMETER_CAPACITY],
    /// How many parameters the law has.
    pub parameter_count: usize,
    /// What happened in this cycle.
    pub flags: CycleFlags<N>,
}

/// Torques on the active joints that the model does not explain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unexplained<const N: usize> {
    /// The residual of the momentum observer, N·m.
    pub residual: [f64; N],
    /// How large it may be, N·m.
    pub limit: [f64; N],
}

/// What happened in a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CycleFlags<const N: usize> {
    /// Whose torque the limiter cut, of the active joints.
    pub limited: [bool; N],
    /// The projection held Φ at the border of its set.
    pub projected: bool,
    /// Φ is on or beyond the border of that set.
    pub at_bound: bool,
    /// Φ stood still over the step to this cycle: the torque was limited, or an angle was predicted, in the one before.
    pub frozen: bool,
    /// The law met a non-finite value and used its fallback.
    pub fell_back: bool,
}

/// What was seen of bus and drives until `at`.
#[derive(Clone, Copy, Debug)]
pub struct HealthRecord<const J: usize> {
    /// The end of the cycle that it follows.
    pub at: Instant,
    /// The drives, as their master sees them.
    pub network: NetworkHealth<J>,
    /// The interface, as far as the link knows one.
    pub link: LinkHealth,
}

impl<const N: usize> Default for CycleFlags<N> {
    fn default() -> Self {
        Self { limited: [false; N], projected: false, at_bound: false, frozen: false, fell_back: false }
    }
}

impl<const J: usize, const N: usize> Default for CycleRecord<J, N> {
    /// The record of a cycle in which every signal is zero.
    fn default() -> Self {
        Self {
            tick: 0,
            elapsed_ticks: 0,
            time: 0.0,
            period: 0.0,
            authority: Authority::Full,
            instants: CycleInstants::default(),
            counts: [0; J],
            angle_sources: [AngleSource::default(); J],
            statuswords: [0; J],
            measured_position: [0.0; J],
            position: [0.0; J],
            velocity: [0.0; J],
            base_acceleration: 0.0,
            reference_position: [0.0; N],
            reference_velocity: [0.0; N],
            reference_acceleration: [0.0; N],
            control_input: [0.0; N],
            torque_requested: [0.0; N],
            torque_applied: [0.0; N],
            torque_sent: [0; J],
            torque_actual: [None; J],
            disturbance: [0.0; N],
            unexplained: None,
            parameters: [0.0; PARAMETER_CAPACITY],
            parameter_count: 0,
            flags: CycleFlags::default(),
        }
    }
}

impl<const J: usize, const N: usize> CycleRecord<J, N> {
    /// The record of one cycle, but for the adapted parameters and the torques that the drives reported.
    pub fn new(tick: &Tick, instants: &CycleInstants, statuswords: &[u16; J], signals: &Signals<J, N>) -> Self {
        let Signals { time, period, authority, estimate, measurement, reference, command, torque, residuals } = signals;
        Self {
            tick: tick.index,
            elapsed_ticks: tick.elapsed,
            time: *time,
            period: *period,
            authority: *authority,
            instants: *instants,
            counts: estimate.counts,
            angle_sources: estimate.sources,
            statuswords: *statuswords,
            measured_position: estimate.measured,
            position: estimate.position(),
            velocity: estimate.velocity(),
            base_acceleration: measurement.base.acceleration.x,
            reference_position: reference.position.into(),
            reference_velocity: reference.velocity.into(),
            reference_acceleration: reference.acceleration.into(),
            control_input: command.control_input.into(),
            torque_requested: command.torque.into(),
            torque_applied: torque.limited.applied.into(),
            torque_sent: torque.sent,
            disturbance: torque.disturbance.into(),
            unexplained: residuals.map(|Residuals { residual, limit }| Unexplained {
                residual: dimensions::active::<J, N>(&residual).into(),
                limit: dimensions::active::<J, N>(&limit).into(),
            }),
            flags: CycleFlags {
                limited: torque.limited.limited,
                projected: command.adaptation.projected,
                at_bound: command.adaptation.at_bound,
                frozen: command.adaptation.frozen,
                fell_back: command.adaptation.fell_back,
            },
            ..Self::default()
        }
    }

    /// Takes over the adapted parameters Φ of a law; those beyond [`PARAMETER_CAPACITY`] are left out.
    pub fn set_parameters(&mut self, parameters: &[f64]) {
        self.parameter_count = parameters.len().min(PARAMETER_CAPACITY);
        for (to, from) in self.parameters.iter_mut().zip(parameters) {
            *to = *from;
        }
    }

    /// Estimated less desired motion of the active joints.
    pub fn tracking_error(&self) -> TrackingError<f64, N> {
        TrackingError {
            velocity: dimensions::active(&self.velocity) - SVector::from(self.reference_velocity),
            position: dimensions::active(&self.position) - SVector::from(self.reference_position),
        }
    }

    /// Whether the angle of some joint is predicted.
    pub fn has_predicted_angle(&self) -> bool {
        self.angle_sources.iter().any(|source| *source != AngleSource::Measured)
    }

    /// The adapted parameters Φ.
    pub fn parameters(&self) -> &[f64] {
        self.parameters.get(..self.parameter_count).unwrap_or(&[])
    }
}

/// Takes records from the loop. Must neither wait nor allocate when the loop is a real-time one.
pub trait Recorder<const J: usize, const N: usize> {
    /// Takes the record of one cycle.
    fn record(&mut self, record: &CycleRecord<J, N>);

    /// Takes the whole inner state as it is at `at`, between two cycles.
    fn keyframe(&mut self, _keyframe: &Keyframe<J, N>, _at: Instant) {}

    /// Takes what the drives said of themselves, at `at`, before the first cycle.
    fn identities(&mut self, _identities: &[DriveIdentity; J], _at: Instant) {}

    /// Takes the health of bus and drives.
    fn health(&mut self, _health: &HealthRecord<J>) {}
}

/// Records where there is something to record into.
impl<R: Recorder<J, N>, const J: usize, const N: usize> Recorder<J, N> for Option<R> {
    fn record(&mut self, record: &CycleRecord<J, N>) {
        self.iter_mut().for_each(|recorder| recorder.record(record));
    }

    fn keyframe(&mut self, keyframe: &Keyframe<J, N>, at: Instant) {
        self.iter_mut().for_each(|recorder| recorder.keyframe(keyframe, at));
    }

    fn identities(&mut self, identities: &[DriveIdentity; J], at: Instant) {
        self.iter_mut().for_each(|recorder| recorder.identities(identities, at));
    }

    fn health(&mut self, health: &HealthRecord<J>) {
        self.iter_mut().for_each(|recorder| recorder.health(health));
    }
}

/// A recorder that keeps nothing.
#[derive(Clone, Copy, Debug)]
pub struct NoRecorder;

impl<const J: usize, const N: usize> Recorder<J, N> for NoRecorder {
    fn record(&mut self, _record: &CycleRecord<J, N>) {}
}

impl<const J: usize, const N: usize> Recorder<J, N> for Vec<CycleRecord<J, N>> {
    fn record(&mut self, record: &CycleRecord<J, N>) {
        self.push(*record);
    }
}

impl<const J: usize, const N: usize, R: Recorder<J, N> + ?Sized> Recorder<J, N> for &mut R {
    fn record(&mut self, record: &CycleRecord<J, N>) {
        (**self).record(record);
    }
    fn keyframe(&mut self, keyframe: &Keyframe<J, N>, at: Instant) {
        (**self).keyframe(keyframe, at);
    }
    fn identities(&mut self, identities: &[DriveIdentity; J], at: Instant) {
        (**self).identities(identities, at);
    }
    fn health(&mut self, health: &HealthRecord<J>) {
        (**self).health(health);
    }
}
