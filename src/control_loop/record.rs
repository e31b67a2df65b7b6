//! What one cycle leaves behind: a fixed-size record, handed over without waiting.

use crate::control_loop::timing::CycleInstants;

/// The most adapted parameters that a law has: two fuzzy systems of nine rules with three consequents each.
pub const PARAMETER_CAPACITY: usize = 54;

/// Every signal of one cycle. All instants are on the loop's clock; the measured half (counts, angles, rates) belongs
/// to the SYNC of this cycle, the torques leave after it and act until the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CycleRecord {
    /// Ticks since the start of the run.
    pub tick: u64,
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
    /// Joint angles from the encoders, rad.
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
    /// Φ stood still because the torque was limited.
    pub frozen: bool,
    /// The law met a non-finite value and used its fallback.
    pub fell_back: bool,
}

impl CycleRecord {
    /// Takes over the adapted parameters Φ of a law; those beyond [`PARAMETER_CAPACITY`] are left out.
    pub fn set_parameters(&mut self, parameters: &[f64]) {
        self.parameter_count = parameters.len().min(PARAMETER_CAPACITY);
        for (to, from) in self.parameters.iter_mut().zip(parameters) {
            *to = *from;
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
}
