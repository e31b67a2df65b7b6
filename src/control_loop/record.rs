//! What one cycle leaves behind: a fixed-size record, handed over without waiting.

use hinf_control::TrackingError;
use nalgebra::Vector2;
use uarm_io::drive::network::NetworkHealth;
use uarm_io::link::LinkHealth;
use uarm_io::time::Instant;

use super::JOINTS;
use super::keyframe::Keyframe;
use super::schedule::Tick;
use super::signal_path::Signals;
use super::timing::CycleInstants;

/// The most adapted parameters that a law has: two fuzzy systems of nine rules with three consequents each.
pub const PARAMETER_CAPACITY: usize = 54;

/// Every signal of one cycle. All instants are on the loop's clock; the measured half (counts, angles, rates) belongs
/// to the SYNC of this cycle, the torques leave after it and act until the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CycleRecord {
    /// Ticks since the start of the run.
    pub tick: u64,
    /// Ticks since the previous cycle: 1 unless some were skipped, 0 in the first cycle.
    pub elapsed_ticks: u64,
    /// Task time: when the reference was evaluated, s.
    pub time: f64,
    /// The period that estimators and laws were told, s; 0 on the first cycle.
    pub period: f64,
    /// The instants of the cycle.
    pub instants: CycleInstants,
    /// Encoder counts of joints 1, 2, 3 as the drives sent them.
    pub counts: [i32; 3],
    /// CiA 402 statuswords.
    pub statuswords: [u16; 3],
    /// Joint angles as the encoders give them, rad.
    pub measured_position: [f64; 3],
    /// Estimated joint angles, rad: some estimators filter them.
    pub position: [f64; 3],
    /// Estimated joint rates, rad/s.
    pub rate: [f64; 3],
    /// Estimated base acceleration, rad/s².
    pub base_acceleration: f64,
    /// Desired angles of joints 2 and 3, rad.
    pub reference_position: [f64; 2],
    /// Desired rates, rad/s.
    pub reference_rate: [f64; 2],
    /// Desired accelerations, rad/s².
    pub reference_acceleration: [f64; 2],
    /// The H∞ control input u.
    pub control_input: [f64; 2],
    /// Torques that the law asked for, N·m.
    pub torque_requested: [f64; 2],
    /// Torques after the limiter, N·m: what E is computed from.
    pub torque_applied: [f64; 2],
    /// Target torques as sent, per mille of the rated torque.
    pub torque_sent: [i16; 3],
    /// The experiment's disturbance at this instant, N·m.
    pub disturbance: [f64; 2],
    /// Adapted parameters Φ; those beyond `parameter_count` are zero.
    pub parameters: [f64; PARAMETER_CAPACITY],
    /// How many parameters the law has.
    pub parameter_count: usize,
    /// What happened in this cycle.
    pub flags: CycleFlags,
}

/// What happened in a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CycleFlags {
    /// The limiter cut the torque of joint 2, joint 3.
    pub limited: [bool; 2],
    /// The projection held Φ at the border of its set.
    pub projected: bool,
    /// Φ is on or beyond the border of that set.
    pub at_bound: bool,
    /// Φ stood still because the torque was limited.
    pub frozen: bool,
    /// The law met a non-finite value and used its fallback.
    pub fell_back: bool,
}

/// What was seen of bus and drives until `at`.
#[derive(Clone, Copy, Debug)]
pub struct HealthRecord {
    /// When.
    pub at: Instant,
    /// The drives, as their master sees them.
    pub network: NetworkHealth<JOINTS>,
    /// The interface, as far as the link knows one.
    pub link: LinkHealth,
}

impl CycleRecord {
    /// The record of one cycle, but for the adapted parameters.
    pub fn new(
        tick: &Tick,
        instants: &CycleInstants,
        counts: &[i32; JOINTS],
        statuswords: &[u16; JOINTS],
        signals: &Signals,
    ) -> Self {
        let Signals { time, period, estimate, measurement, reference, command, torque } = signals;
        Self {
            tick: tick.index,
            elapsed_ticks: tick.elapsed,
            time: *time,
            period: *period,
            instants: *instants,
            counts: *counts,
            statuswords: *statuswords,
            measured_position: estimate.measured,
            position: estimate.position(),
            rate: estimate.rate(),
            base_acceleration: measurement.base.acceleration,
            reference_position: reference.position.into(),
            reference_rate: reference.velocity.into(),
            reference_acceleration: reference.acceleration.into(),
            control_input: command.control_input.into(),
            torque_requested: command.torque.into(),
            torque_applied: torque.limited.applied.into(),
            torque_sent: torque.sent,
            disturbance: torque.disturbance.into(),
            parameters: [0.0; PARAMETER_CAPACITY],
            parameter_count: 0,
            flags: CycleFlags {
                limited: torque.limited.limited,
                projected: command.adaptation.projected,
                at_bound: command.adaptation.at_bound,
                frozen: command.adaptation.frozen,
                fell_back: command.adaptation.fell_back,
            },
        }
    }

    /// Takes over the adapted parameters Φ of a law; those beyond [`PARAMETER_CAPACITY`] are left out.
    pub fn set_parameters(&mut self, parameters: &[f64]) {
        self.parameter_count = parameters.len().min(PARAMETER_CAPACITY);
        for (to, from) in self.parameters.iter_mut().zip(parameters) {
            *to = *from;
        }
    }

    /// Estimated less desired motion of joints 2 and 3.
    pub fn tracking_error(&self) -> TrackingError<f64> {
        let ([_, position_2, position_3], [_, rate_2, rate_3]) = (self.position, self.rate);
        TrackingError {
            velocity: Vector2::new(rate_2, rate_3) - Vector2::from(self.reference_rate),
            position: Vector2::new(position_2, position_3) - Vector2::from(self.reference_position),
        }
    }

    /// The adapted parameters Φ.
    pub fn parameters(&self) -> &[f64] {
        self.parameters.get(..self.parameter_count).unwrap_or(&[])
    }
}

/// Takes records from the loop. Must neither wait nor allocate when the loop is a real-time one.
pub trait Recorder {
    /// Takes one record.
    fn record(&mut self, record: &CycleRecord);

    /// Takes the whole inner state as it is at `at`, between two cycles.
    fn keyframe(&mut self, _keyframe: &Keyframe, _at: Instant) {}

    /// Takes the health of bus and drives.
    fn health(&mut self, _health: &HealthRecord) {}
}

/// Keeps nothing.
#[derive(Clone, Copy, Debug)]
pub struct NoRecorder;

impl Recorder for NoRecorder {
    fn record(&mut self, _record: &CycleRecord) {}
}

impl Recorder for Vec<CycleRecord> {
    fn record(&mut self, record: &CycleRecord) {
        self.push(*record);
    }
}

impl<R: Recorder + ?Sized> Recorder for &mut R {
    fn record(&mut self, record: &CycleRecord) {
        (**self).record(record);
    }
    fn keyframe(&mut self, keyframe: &Keyframe, at: Instant) {
        (**self).keyframe(keyframe, at);
    }
    fn health(&mut self, health: &HealthRecord) {
        (**self).health(health);
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A record of nothing.
    pub(crate) fn record() -> CycleRecord {
        CycleRecord {
            tick: 0,
            elapsed_ticks: 0,
            time: 0.0,
            period: 0.0,
            instants: CycleInstants::default(),
            counts: [0; 3],
            statuswords: [0; 3],
            measured_position: [0.0; 3],
            position: [0.0; 3],
            rate: [0.0; 3],
            base_acceleration: 0.0,
            reference_position: [0.0; 2],
            reference_rate: [0.0; 2],
            reference_acceleration: [0.0; 2],
            control_input: [0.0; 2],
            torque_requested: [0.0; 2],
            torque_applied: [0.0; 2],
            torque_sent: [0; 3],
            disturbance: [0.0; 2],
            parameters: [0.0; PARAMETER_CAPACITY],
            parameter_count: 0,
            flags: CycleFlags::default(),
        }
    }
}
