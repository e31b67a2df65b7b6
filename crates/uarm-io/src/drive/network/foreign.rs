//! Frames that only the drives' own master sends.

use crate::drive::wire;
use core::fmt;

/// A frame that another master sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ForeignFrame {
    /// An NMT command, to whichever node.
    NmtCommand,
    /// A SYNC.
    Sync,
    /// A heartbeat under this master's own node id.
    MasterHeartbeat,
    /// A command to one of the drives, on any of its RPDOs.
    Rpdo {
        /// The drive's node id.
        node: u8,
        /// The frame's identifier.
        identifier: u16,
    },
    /// An SDO request to one of the drives.
    SdoRequest {
        /// The drive's node id.
        node: u8,
    },
}

impl fmt::Display for ForeignFrame {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NmtCommand => formatter.write_str("an NMT command (000h)"),
            Self::Sync => formatter.write_str("a SYNC (080h)"),
            Self::MasterHeartbeat => {
                let identifier = wire::master_heartbeat_frame().id().as_raw();
                write!(formatter, "a heartbeat of node {}, this master's own ({identifier:03X}h)", wire::MASTER_NODE)
            }
            Self::Rpdo { node, identifier } => write!(formatter, "an RPDO to node {node} ({identifier:03X}h)"),
            Self::SdoRequest { node } => {
                write!(formatter, "an SDO request to node {node} ({:03X}h)", 0x600 | u16::from(*node))
            }
        }
    }
}
