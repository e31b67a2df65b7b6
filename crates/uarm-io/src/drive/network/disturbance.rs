//! What must not happen on the bus between a drive's set-up and its stop.

use super::foreign::ForeignFrame;
use core::fmt;

/// Why the drives cannot be relied on any more, whoever or whatever caused it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Disturbance {
    /// A drive sent a boot-up message after it had been addressed: what was written to it is lost, its watchdog on the
    /// master too.
    Rebooted {
        /// The drive's node id.
        node: u8,
    },
    /// Somebody sent what only this master may send.
    AnotherMaster(ForeignFrame),
    /// A drive's node id answered a SYNC twice.
    Twins {
        /// The node id.
        node: u8,
    },
    /// A drive's node id answered an SDO request twice.
    SdoTwins {
        /// The node id.
        node: u8,
    },
}

impl fmt::Display for Disturbance {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rebooted { node } => write!(
                formatter,
                "node {node} booted anew: its settings and its watchdog are lost; was it reset by somebody, or its supply cut?"
            ),
            Self::AnotherMaster(frame) => {
                write!(formatter, "another master is on this bus: it sent {frame}")
            }
            Self::Twins { node } => {
                write!(formatter, "two answers to one SYNC from node {node}: are there two drives with node id {node}?")
            }
            Self::SdoTwins { node } => write!(
                formatter,
                "two answers to one SDO request from node {node}: are there two drives with node id {node}?"
            ),
        }
    }
}

impl From<ForeignFrame> for Disturbance {
    fn from(frame: ForeignFrame) -> Self {
        Self::AnotherMaster(frame)
    }
}

impl core::error::Error for Disturbance {}
