//! Links to the emulated robot, and wrappers around any link.

mod faulty;
mod in_process;
mod observed;

pub use faulty::{FaultCounts, FaultRateError, FaultRates, FaultyLink};
pub use in_process::{InProcessError, InProcessLink};
pub use observed::{Direction, ObservedLink};
