//! Links to the emulated robot, and wrappers around any link.

mod faulty;
mod in_process;

pub use faulty::{FaultCounts, FaultRateError, FaultRates, FaultyLink};
pub use in_process::{InProcessError, InProcessLink};
