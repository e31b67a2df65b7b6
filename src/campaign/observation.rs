//! What was seen of a run.

use std::fmt;

use uarm_io::time::Duration;
use uarm_loop::choice::Choice;
use uarm_loop::fault_code::FaultCode;
use uarm_sim::Brake;

use super::injection::Seen;
use crate::dimensions::JOINTS;

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The motion came to its end.
    Completed,
    /// It was asked for.
    Interrupted,
    /// A fault ended it.
    Fault(FaultCode),
}

impl fmt::Display for End {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Completed => "completed",
            Self::Interrupted => "interrupted",
            Self::Fault(code) => code.name(),
        })
    }
}

/// What a run left behind.
#[derive(Clone, Copy, Debug)]
pub struct Observation {
    /// How it ended.
    pub end: End,
    /// What was seen of wire and joints.
    pub seen: Seen,
    /// The brakes in the end.
    pub brakes: [Brake; JOINTS],
    /// Cycles that were recorded.
    pub recorded: u64,
}

impl Observation {
    /// From the fault to brakes that are all closed; nothing if the run went on to its end.
    pub fn reaction(&self) -> Option<Duration> {
        let took = self.seen.braked_at?.since(self.seen.fault_at?);
        (self.end != End::Completed).then_some(took)
    }
}
