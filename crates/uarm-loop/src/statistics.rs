//! What a report tells of the motion, collected cycle by cycle without allocation.

use uarm_io::drive::DriveIdentity;
use uarm_io::time::Instant;

use crate::dimensions;
use crate::keyframe::Keyframe;
use crate::record::{CycleRecord, HealthRecord, Recorder};

/// Passes records on and keeps the few numbers that a report needs.
#[derive(Debug)]
pub struct Statistics<R, const N: usize> {
    next: R,
    /// Angle of the base in the first cycle, rad.
    first_base: Option<f64>,
    /// The last record's base angle, rad.
    last_base: f64,
    /// Task time of the last cycle, s; nothing if none ran.
    pub last_time: Option<f64>,
    /// Tracking error of the active joints in the last cycle, rad.
    pub final_error: [f64; N],
    /// Largest torques applied to the active joints, N·m.
    pub peak_torque: [f64; N],
    /// Cycles in which the limiter cut a torque.
    pub limited_cycles: u64,
    /// Cycles in which the angle of some joint was predicted.
    pub predicted_cycles: u64,
    /// Supply voltages and temperatures that were worth a warning, by the last health record.
    pub reading_warnings: u64,
}

impl<R, const N: usize> Statistics<R, N> {
    /// Statistics in front of `next`.
    pub const fn new(next: R) -> Self {
        Self {
            next,
            first_base: None,
            last_base: 0.0,
            last_time: None,
            final_error: [0.0; N],
            peak_torque: [0.0; N],
            limited_cycles: 0,
            predicted_cycles: 0,
            reading_warnings: 0,
        }
    }

    /// How far the base turned, rad.
    pub fn base_drift(&self) -> f64 {
        self.first_base.map_or(0.0, |first| self.last_base - first)
    }

    /// What the records were passed on to.
    pub fn into_next(self) -> R {
        self.next
    }
}

impl<R: Recorder<J, N>, const J: usize, const N: usize> Recorder<J, N> for Statistics<R, N> {
    fn record(&mut self, record: &CycleRecord<J, N>) {
        let base = dimensions::base::<_, J, N>(&record.position);
        self.first_base.get_or_insert(base);
        self.last_base = base;
        self.last_time = Some(record.time);
        self.final_error = record.tracking_error().position.into();
        for (peak, torque) in self.peak_torque.iter_mut().zip(record.torque_applied) {
            *peak = peak.max(torque.abs());
        }
        if record.flags.limited.contains(&true) {
            self.limited_cycles += 1;
        }
        if record.has_predicted_angle() {
            self.predicted_cycles += 1;
        }
        self.next.record(record);
    }

    fn keyframe(&mut self, keyframe: &Keyframe<J, N>, at: Instant) {
        self.next.keyframe(keyframe, at);
    }

    fn identities(&mut self, identities: &[DriveIdentity; J], at: Instant) {
        self.next.identities(identities, at);
    }

    fn health(&mut self, health: &HealthRecord<J>) {
        self.reading_warnings = health.network.nodes.iter().map(|node| node.reading_warnings).sum();
        self.next.health(health);
    }
}
