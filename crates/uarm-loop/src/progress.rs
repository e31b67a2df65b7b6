//! What others may look at while the loop runs: a few numbers, written without waiting.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::record::CycleRecord;

/// The latest state of the loop. Numbers of one cycle may be seen beside those of the next.
#[derive(Debug)]
pub struct Progress<const N: usize> {
    time: AtomicU64,
    error: [AtomicU64; N],
    torque: [AtomicU64; N],
}

impl<const N: usize> Default for Progress<N> {
    fn default() -> Self {
        let zeros = || std::array::from_fn(|_| AtomicU64::new(0));
        Self { time: AtomicU64::new(0), error: zeros(), torque: zeros() }
    }
}

/// The latest state of the loop as one look found it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProgressSnapshot<const N: usize> {
    /// Task time, s.
    pub time: f64,
    /// Position errors of the active joints, rad.
    pub error: [f64; N],
    /// Applied torques of the active joints, N·m.
    pub torque: [f64; N],
}

impl<const N: usize> Progress<N> {
    /// Makes the numbers of a cycle those that others see.
    pub fn publish<const J: usize>(&self, record: &CycleRecord<J, N>) {
        let store = |to: &AtomicU64, value: f64| to.store(value.to_bits(), Ordering::Relaxed);
        store(&self.time, record.time);
        for (to, error) in self.error.iter().zip(&record.tracking_error().position) {
            store(to, *error);
        }
        for (to, value) in self.torque.iter().zip(record.torque_applied) {
            store(to, value);
        }
    }

    /// The numbers that were published last.
    pub fn snapshot(&self) -> ProgressSnapshot<N> {
        let load = |from: &AtomicU64| f64::from_bits(from.load(Ordering::Relaxed));
        ProgressSnapshot {
            time: load(&self.time),
            error: self.error.each_ref().map(load),
            torque: self.torque.each_ref().map(load),
        }
    }
}
