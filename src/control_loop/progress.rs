//! What others may look at while the loop runs: a few numbers, written without waiting.

use std::sync::atomic::{AtomicU64, Ordering};

use super::record::CycleRecord;

/// The latest state of the loop. Numbers of one cycle may be seen beside those of the next.
#[derive(Debug, Default)]
pub struct Progress {
    time: AtomicU64,
    error: [AtomicU64; 2],
    torque: [AtomicU64; 2],
}

/// A look at the loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glimpse {
    /// Task time, s.
    pub time: f64,
    /// Position errors of joints 2 and 3, rad.
    pub error: [f64; 2],
    /// Applied torques, N·m.
    pub torque: [f64; 2],
}

impl Progress {
    /// Shows a cycle.
    pub fn publish(&self, record: &CycleRecord) {
        let [_, position_2, position_3] = record.position;
        let [reference_2, reference_3] = record.reference_position;
        let store = |to: &AtomicU64, value: f64| to.store(value.to_bits(), Ordering::Relaxed);
        store(&self.time, record.time);
        let [error_2, error_3] = &self.error;
        store(error_2, position_2 - reference_2);
        store(error_3, position_3 - reference_3);
        for (to, value) in self.torque.iter().zip(record.torque_applied) {
            store(to, value);
        }
    }

    /// Looks.
    pub fn glimpse(&self) -> Glimpse {
        let load = |from: &AtomicU64| f64::from_bits(from.load(Ordering::Relaxed));
        Glimpse {
            time: load(&self.time),
            error: self.error.each_ref().map(load),
            torque: self.torque.each_ref().map(load),
        }
    }
}
