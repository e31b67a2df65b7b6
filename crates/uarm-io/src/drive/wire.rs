//! Every frame on the bus: identifiers and payloads, in both directions.
//!
//! The connection set is the predefined one of CiA 301; node *i* is joint *i*.
//!
//! | channel | identifier | payload |
//! |---|---|---|
//! | NMT command | `000h` | command, node (0: all) |
//! | SYNC | `080h` | counter 1 … [`SYNC_COUNTER_OVERFLOW`] |
//! | emergency | `080h` + node | error code u16, error register u8, five bytes of the maker |
//! | TPDO1, latched at SYNC | `180h` + node | [`DriveFeedback`] |
//! | RPDO1, acts on reception | `200h` + node | [`DriveCommand`] |
//! | SDO answer, request | `580h`, `600h` + node | eight bytes |
//! | heartbeat | `700h` + node | NMT state |

use super::cia402::{Controlword, Statusword};
use super::objects::{CONTROLWORD, Object, POSITION_ACTUAL, STATUSWORD, TARGET_TORQUE, TORQUE_ACTUAL};
use crate::frame::Frame;
use canopen_rs::{ErrorRegister, MappingEntry, NmtCommand, NmtState, TransmissionType, emcy, nmt, sdo, sync};
use core::fmt;
use embedded_can::StandardId;

pub use canopen_rs::{EmergencyMessage, NodeId, SyncCounter};

/// The electronic data sheet (CiA 306) of a drive as this master expects it and as `uarm-sim` emulates it: text in the INI
/// format. A test of `uarm-sim` compares each entry with the emulated drive's object dictionary.
pub const DRIVE_EDS: &str = include_str!("../../wire/uarm-drive.eds");

/// The frames of the bus as a Vector CAN database (DBC). A test of `uarm-sim` compares its signals with the encoders and
/// decoders of this module.
pub const FRAMES_DBC: &str = include_str!("../../wire/uarm.dbc");

/// The SYNC counter runs from 1 to this and starts again: the largest value of 1019h.
pub const SYNC_COUNTER_OVERFLOW: u8 = 240;

/// The node id under which the master sends its heartbeat: the last one, as masters do by custom.
pub const MASTER_NODE: u8 = 127;

/// TPDO1 is sent after every SYNC.
pub const TPDO1_TRANSMISSION: TransmissionType = TransmissionType::SynchronousCyclic(1);

/// RPDO1 acts when it comes: waiting for the next SYNC would add a period of delay to the torque.
pub const RPDO1_TRANSMISSION: TransmissionType = TransmissionType::EventDrivenProfile;

/// What TPDO1 carries, in this order.
pub const TPDO1_MAPPING: [MappingEntry; 2] = [mapping(&STATUSWORD, 16), mapping(&POSITION_ACTUAL, 32)];

/// What RPDO1 carries, in this order.
pub const RPDO1_MAPPING: [MappingEntry; 2] = [mapping(&CONTROLWORD, 16), mapping(&TARGET_TORQUE, 16)];

/// What the second TPDO carries, where torque feedback is wanted.
pub const TORQUE_FEEDBACK_MAPPING: MappingEntry = mapping(&TORQUE_ACTUAL, 16);

const fn mapping(object: &Object, bits: u8) -> MappingEntry {
    MappingEntry::new(object.index, object.subindex, bits)
}

const TPDO1_BASE: u16 = 0x180;
const RPDO1_BASE: u16 = 0x200;
/// An identifier is its channel's base plus the node in the low seven bits.
const NODE_MASK: u16 = 0x7F;

/// What a frame is for, told by its identifier alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Channel {
    /// Command to the NMT state machines.
    NmtCommand,
    /// SYNC.
    Sync,
    /// Emergency message of a node.
    Emergency(NodeId),
    /// Feedback of a drive.
    Tpdo1(NodeId),
    /// Command to a drive.
    Rpdo1(NodeId),
    /// SDO answer of a node.
    SdoResponse(NodeId),
    /// SDO request to a node.
    SdoRequest(NodeId),
    /// Heartbeat or boot-up of a node.
    Heartbeat(NodeId),
}

impl Channel {
    /// The channel of an identifier; `None` for one that this connection set does not use.
    pub fn of(identifier: StandardId) -> Option<Self> {
        let raw = identifier.as_raw();
        match raw {
            nmt::NMT_COMMAND_COB_ID => return Some(Self::NmtCommand),
            sync::SYNC_COB_ID => return Some(Self::Sync),
            _ => {}
        }
        let node = NodeId::new(u8::try_from(raw & NODE_MASK).ok()?).ok()?;
        match raw & !NODE_MASK {
            emcy::EMCY_COB_BASE => Some(Self::Emergency(node)),
            TPDO1_BASE => Some(Self::Tpdo1(node)),
            RPDO1_BASE => Some(Self::Rpdo1(node)),
            sdo::SDO_RESPONSE_COB_BASE => Some(Self::SdoResponse(node)),
            sdo::SDO_REQUEST_COB_BASE => Some(Self::SdoRequest(node)),
            nmt::HEARTBEAT_COB_BASE => Some(Self::Heartbeat(node)),
            _ => None,
        }
    }

    /// The identifier of the channel.
    pub fn identifier(self) -> StandardId {
        let (base, node) = match self {
            Self::NmtCommand => (nmt::NMT_COMMAND_COB_ID, NodeId::BROADCAST),
            Self::Sync => (sync::SYNC_COB_ID, NodeId::BROADCAST),
            Self::Emergency(node) => (emcy::EMCY_COB_BASE, node),
            Self::Tpdo1(node) => (TPDO1_BASE, node),
            Self::Rpdo1(node) => (RPDO1_BASE, node),
            Self::SdoResponse(node) => (sdo::SDO_RESPONSE_COB_BASE, node),
            Self::SdoRequest(node) => (sdo::SDO_REQUEST_COB_BASE, node),
            Self::Heartbeat(node) => (nmt::HEARTBEAT_COB_BASE, node),
        };
        // Bases and nodes stay within 11 bits, so the fallback is never taken; MAX is the harmless one, for it has the
        // lowest priority and no channel.
        StandardId::new(base | u16::from(node.raw())).unwrap_or(StandardId::MAX)
    }
}

/// A payload that is not what its channel carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PayloadError {
    /// Wrong number of bytes.
    #[error("{found} data bytes, expected {expected}")]
    Length {
        /// Bytes that the channel carries.
        expected: usize,
        /// Bytes that came.
        found: usize,
    },
    /// A byte that is no NMT state.
    #[error("{found:#04x} is no NMT state")]
    NmtState {
        /// The byte.
        found: u8,
    },
    /// A byte that is not an NMT command, or a number that is not a node id.
    #[error("{command:#04x} for node {node} is no NMT command")]
    NmtCommand {
        /// The command byte.
        command: u8,
        /// The node byte.
        node: u8,
    },
}

fn exactly<const LENGTH: usize>(data: &[u8]) -> Result<[u8; LENGTH], PayloadError> {
    data.try_into().map_err(|_| PayloadError::Length { expected: LENGTH, found: data.len() })
}

/// TPDO1: what a drive reports after each SYNC.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DriveFeedback {
    /// 6041h.
    pub statusword: Statusword,
    /// 6064h, quadrature counts latched at the SYNC.
    pub position: i32,
}

impl DriveFeedback {
    /// Data bytes of TPDO1.
    pub const LENGTH: usize = 6;

    /// The payload, little endian.
    pub const fn encode(&self) -> [u8; Self::LENGTH] {
        let [s0, s1] = self.statusword.bits().to_le_bytes();
        let [p0, p1, p2, p3] = self.position.to_le_bytes();
        [s0, s1, p0, p1, p2, p3]
    }

    /// Reads a payload.
    ///
    /// # Errors
    /// [`PayloadError::Length`] unless there are [`DriveFeedback::LENGTH`] bytes.
    pub fn decode(data: &[u8]) -> Result<Self, PayloadError> {
        let [s0, s1, p0, p1, p2, p3] = exactly(data)?;
        Ok(Self {
            statusword: Statusword::from_bits(u16::from_le_bytes([s0, s1])),
            position: i32::from_le_bytes([p0, p1, p2, p3]),
        })
    }

    /// The frame that `node` sends.
    pub fn frame(&self, node: NodeId) -> Frame {
        Frame::with(Channel::Tpdo1(node).identifier(), self.encode())
    }
}

/// The torque of a drive's second TPDO, per mille of its rated torque.
///
/// # Errors
/// [`PayloadError::Length`] unless there are two bytes.
pub fn decode_torque_feedback(data: &[u8]) -> Result<i16, PayloadError> {
    exactly(data).map(i16::from_le_bytes)
}

/// RPDO1: what the master asks of a drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DriveCommand {
    /// 6040h.
    pub controlword: Controlword,
    /// 6071h, per mille of the rated torque.
    pub target_torque: i16,
}

impl DriveCommand {
    /// Data bytes of RPDO1.
    pub const LENGTH: usize = 4;

    /// The payload, little endian.
    pub const fn encode(&self) -> [u8; Self::LENGTH] {
        let [c0, c1] = self.controlword.bits().to_le_bytes();
        let [t0, t1] = self.target_torque.to_le_bytes();
        [c0, c1, t0, t1]
    }

    /// Reads a payload.
    ///
    /// # Errors
    /// [`PayloadError::Length`] unless there are [`DriveCommand::LENGTH`] bytes.
    pub fn decode(data: &[u8]) -> Result<Self, PayloadError> {
        let [c0, c1, t0, t1] = exactly(data)?;
        Ok(Self {
            controlword: Controlword::from_bits(u16::from_le_bytes([c0, c1])),
            target_torque: i16::from_le_bytes([t0, t1]),
        })
    }

    /// The frame to `node`.
    pub fn frame(&self, node: NodeId) -> Frame {
        Frame::with(Channel::Rpdo1(node).identifier(), self.encode())
    }
}

/// A SYNC with its counter.
pub fn sync_frame(counter: u8) -> Frame {
    Frame::with(Channel::Sync.identifier(), sync::encode_counter(counter))
}

/// A SYNC without a counter.
pub fn plain_sync_frame() -> Frame {
    Frame::with(Channel::Sync.identifier(), [])
}

/// The counter of a SYNC; `None` for one without.
///
/// # Errors
/// [`PayloadError::Length`] for more than one byte.
pub fn decode_sync(data: &[u8]) -> Result<Option<u8>, PayloadError> {
    sync::decode(data).map_err(|_| PayloadError::Length { expected: 1, found: data.len() })
}

/// An NMT command to one node, or to all with [`NodeId::BROADCAST`].
pub fn nmt_frame(command: NmtCommand, node: NodeId) -> Frame {
    Frame::with(Channel::NmtCommand.identifier(), nmt::encode_command(command, node))
}

/// The command of an NMT frame and the node it is for.
///
/// # Errors
/// [`PayloadError`] if there are not two bytes, or they are no command.
pub fn decode_nmt(data: &[u8]) -> Result<(NmtCommand, NodeId), PayloadError> {
    let bytes = exactly::<2>(data)?;
    let [command, node] = bytes;
    nmt::decode_command(&bytes).map_err(|_| PayloadError::NmtCommand { command, node })
}

/// A heartbeat of `node`; [`NmtState::Initialising`] makes it a boot-up message.
pub fn heartbeat_frame(node: NodeId, state: NmtState) -> Frame {
    Frame::with(Channel::Heartbeat(node).identifier(), nmt::encode_heartbeat(state))
}

/// The state that a heartbeat reports; [`NmtState::Initialising`] is a boot-up message.
///
/// # Errors
/// [`PayloadError`] if there is not one byte, or it is no state.
pub fn decode_heartbeat(data: &[u8]) -> Result<NmtState, PayloadError> {
    let [byte] = exactly::<1>(data)?;
    nmt::decode_heartbeat(&[byte]).map_err(|_| PayloadError::NmtState { found: byte })
}

/// The master's heartbeat.
pub fn master_heartbeat_frame() -> Frame {
    let identifier = StandardId::new(nmt::HEARTBEAT_COB_BASE | u16::from(MASTER_NODE)).unwrap_or(StandardId::MAX);
    Frame::with(identifier, nmt::encode_heartbeat(NmtState::Operational))
}

/// The value of 1016h:01 that makes a drive listen to the master's heartbeat.
pub fn consumer_heartbeat_entry(timeout_milliseconds: u16) -> u32 {
    (u32::from(MASTER_NODE) << 16) | u32::from(timeout_milliseconds)
}

/// The node and the time in ms of an entry of 1016h.
pub fn decode_consumer_heartbeat_entry(entry: u32) -> (u8, u16) {
    let [low, high, node, _] = entry.to_le_bytes();
    (node, u16::from_le_bytes([low, high]))
}

/// An emergency message of `node`.
pub fn emergency_frame(node: NodeId, message: &EmergencyMessage) -> Frame {
    Frame::with(Channel::Emergency(node).identifier(), message.encode())
}

/// Reads an emergency message of any length: CiA 301 says eight bytes, and drives that leave the maker's out exist. Bytes
/// that are missing are 0; one too short for its error code is a generic error, for it is no *error reset* either.
pub fn decode_emergency(data: &[u8]) -> EmergencyMessage {
    let mut bytes = [0; 8];
    for (byte, sent) in bytes.iter_mut().zip(data) {
        *byte = *sent;
    }
    let [low, high, register, maker @ ..] = bytes;
    let error_code = if data.len() < 2 { emcy::error_code::GENERIC } else { u16::from_le_bytes([low, high]) };
    EmergencyMessage::new(error_code, ErrorRegister(register), maker)
}

/// An SDO request to `node`.
pub fn sdo_request_frame(node: NodeId, payload: &[u8; 8]) -> Frame {
    Frame::with(Channel::SdoRequest(node).identifier(), *payload)
}

/// An SDO answer of `node`.
pub fn sdo_response_frame(node: NodeId, payload: &[u8; 8]) -> Frame {
    Frame::with(Channel::SdoResponse(node).identifier(), *payload)
}

/// Reads the payload of an SDO frame of either direction.
///
/// # Errors
/// [`PayloadError::Length`] unless there are eight bytes.
pub fn decode_sdo(data: &[u8]) -> Result<[u8; 8], PayloadError> {
    exactly(data)
}

impl fmt::Display for Channel {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NmtCommand => formatter.write_str("NMT command"),
            Self::Sync => formatter.write_str("SYNC"),
            Self::Emergency(node) => write!(formatter, "emergency of node {}", node.raw()),
            Self::Tpdo1(node) => write!(formatter, "TPDO1 of node {}", node.raw()),
            Self::Rpdo1(node) => write!(formatter, "RPDO1 to node {}", node.raw()),
            Self::SdoResponse(node) => write!(formatter, "SDO answer of node {}", node.raw()),
            Self::SdoRequest(node) => write!(formatter, "SDO request to node {}", node.raw()),
            Self::Heartbeat(node) => write!(formatter, "heartbeat of node {}", node.raw()),
        }
    }
}

#[cfg(test)]
mod tests;
