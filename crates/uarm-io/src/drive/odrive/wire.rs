//! CANSimple: identifiers and payloads, defined once for both ends.
//!
//! An identifier has 11 bits: the axis's node id in the upper six, the message in the lower five. Payloads are little
//! endian, floating-point numbers IEEE 754. A message that an axis sends is requested by a frame of the same identifier
//! without data, or with the RTR bit, which is not used here.
//! Source: <https://docs.odriverobotics.com/v/latest/manual/can-protocol.html>, "CAN Messages".

use super::axis_error::AxisError;
use crate::drive::identity::DriveIdentity;
use crate::frame::Frame;
use core::fmt;
use embedded_can::StandardId;

/// Bits of an identifier that name the message.
const MESSAGE_BITS: u32 = 5;
const MESSAGE_MASK: u16 = 0x1F;

/// The node id of an axis: 1 to 62. The protocol allows 0 too, whose identifiers are those of CANopen's NMT and SYNC, and
/// uses 63 for all axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct AxisNode(u8);

impl AxisNode {
    /// The node ids that an axis may have here.
    pub const RANGE: core::ops::RangeInclusive<u8> = 1..=62;

    /// The lowest.
    pub const FIRST: Self = Self(1);

    /// The axis with this node id; `None` outside [`AxisNode::RANGE`].
    pub fn new(node: u8) -> Option<Self> {
        Self::RANGE.contains(&node).then_some(Self(node))
    }

    /// The node id.
    pub const fn raw(self) -> u8 {
        self.0
    }
}

impl fmt::Display for AxisNode {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(formatter)
    }
}

/// The messages that are used, with their command ids.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Message {
    /// 00h, axis → master, on request: what it is, and its firmware.
    Version,
    /// 01h, axis → master, cyclic: errors and state.
    Heartbeat,
    /// 02h, master → axis: disarm with an error.
    Estop,
    /// 07h, master → axis: the state that it shall go to.
    SetAxisState,
    /// 09h, axis → master, cyclic or on request: position and velocity.
    EncoderEstimates,
    /// 0Bh, master → axis: what is controlled.
    SetControllerMode,
    /// 0Eh, master → axis: the torque.
    SetInputTorque,
    /// 15h, axis → master, on request or cyclic: temperatures.
    Temperature,
    /// 17h, axis → master, on request or cyclic: its supply.
    BusVoltageCurrent,
    /// 18h, master → axis: forget all errors.
    ClearErrors,
}

impl Message {
    const ALL: [Self; 10] = [
        Self::Version,
        Self::Heartbeat,
        Self::Estop,
        Self::SetAxisState,
        Self::EncoderEstimates,
        Self::SetControllerMode,
        Self::SetInputTorque,
        Self::Temperature,
        Self::BusVoltageCurrent,
        Self::ClearErrors,
    ];

    /// The command id.
    pub const fn id(self) -> u16 {
        match self {
            Self::Version => 0x00,
            Self::Heartbeat => 0x01,
            Self::Estop => 0x02,
            Self::SetAxisState => 0x07,
            Self::EncoderEstimates => 0x09,
            Self::SetControllerMode => 0x0B,
            Self::SetInputTorque => 0x0E,
            Self::Temperature => 0x15,
            Self::BusVoltageCurrent => 0x17,
            Self::ClearErrors => 0x18,
        }
    }

    /// The messages that an axis sends.
    pub const OF_AXIS: [Self; 5] =
        [Self::Version, Self::Heartbeat, Self::EncoderEstimates, Self::Temperature, Self::BusVoltageCurrent];

    /// The messages that a master sends.
    pub const OF_MASTER: [Self; 5] =
        [Self::Estop, Self::SetAxisState, Self::SetControllerMode, Self::SetInputTorque, Self::ClearErrors];

    /// What the maker calls it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Version => "Get_Version",
            Self::Heartbeat => "Heartbeat",
            Self::Estop => "Estop",
            Self::SetAxisState => "Set_Axis_State",
            Self::EncoderEstimates => "Get_Encoder_Estimates",
            Self::SetControllerMode => "Set_Controller_Mode",
            Self::SetInputTorque => "Set_Input_Torque",
            Self::Temperature => "Get_Temperature",
            Self::BusVoltageCurrent => "Get_Bus_Voltage_Current",
            Self::ClearErrors => "Clear_Errors",
        }
    }

    /// True if a master sends it with this data; a message of an axis without data is a request for it.
    pub fn is_of_master(self, data: &[u8]) -> bool {
        Self::OF_MASTER.contains(&self) || data.is_empty()
    }

    /// The identifier of this message of or to `axis`.
    pub fn identifier(self, axis: AxisNode) -> StandardId {
        // Six and five bits fit, so the fallback is never taken.
        StandardId::new(u16::from(axis.0) << MESSAGE_BITS | self.id()).unwrap_or(StandardId::MAX)
    }

    /// The message of an identifier and the axis that it belongs to; `None` for one that is not used here.
    pub fn of(identifier: StandardId) -> Option<(Self, AxisNode)> {
        let raw = identifier.as_raw();
        let axis = AxisNode::new(u8::try_from(raw >> MESSAGE_BITS).ok()?)?;
        let message = Self::ALL.into_iter().find(|message| message.id() == raw & MESSAGE_MASK)?;
        Some((message, axis))
    }
}

/// A payload of the wrong length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{found} data bytes, expected {expected}")]
pub struct LengthError {
    /// Data bytes that the message has.
    pub expected: usize,
    /// Data bytes that came.
    pub found: usize,
}

fn exactly<const LENGTH: usize>(data: &[u8]) -> Result<[u8; LENGTH], LengthError> {
    data.try_into().map_err(|_| LengthError { expected: LENGTH, found: data.len() })
}

/// The first `LENGTH` bytes: axes take longer frames, too.
fn at_least<const LENGTH: usize>(data: &[u8]) -> Result<[u8; LENGTH], LengthError> {
    data.first_chunk().copied().ok_or(LengthError { expected: LENGTH, found: data.len() })
}

/// States of an axis (`AxisState`). Only [`AxisState::CLOSED_LOOP_CONTROL`] drives the motor by the master's torques.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct AxisState(pub u8);

impl AxisState {
    /// 1: the motor has no current, the brake output is off.
    pub const IDLE: Self = Self(1);
    /// 8: the motor follows its inputs, the brake output is on.
    pub const CLOSED_LOOP_CONTROL: Self = Self(8);
}

impl fmt::Display for AxisState {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self.0 {
            0 => "UNDEFINED",
            1 => "IDLE",
            2 => "STARTUP_SEQUENCE",
            3 => "FULL_CALIBRATION_SEQUENCE",
            4 => "MOTOR_CALIBRATION",
            6 => "ENCODER_INDEX_SEARCH",
            7 => "ENCODER_OFFSET_CALIBRATION",
            8 => "CLOSED_LOOP_CONTROL",
            9 => "LOCKIN_SPIN",
            10 => "ENCODER_DIR_FIND",
            11 => "HOMING",
            12 => "ENCODER_HALL_POLARITY_CALIBRATION",
            13 => "ENCODER_HALL_PHASE_CALIBRATION",
            14 => "ANTICOGGING_CALIBRATION",
            other => return write!(formatter, "state {other}"),
        })
    }
}

/// Heartbeat: errors and state of an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Heartbeat {
    /// Active errors and the reason of the last disarming.
    pub error: AxisError,
    /// What the axis does.
    pub state: AxisState,
    /// Result of the last procedure: 0 success, 1 busy.
    pub procedure_result: u8,
    /// Bit 0: a trajectory is done. Not used.
    pub trajectory_done: u8,
}

impl Heartbeat {
    /// Data bytes.
    pub const LENGTH: usize = 8;

    /// True if the axis follows its torque and has no error.
    pub fn is_armed(&self) -> bool {
        self.state == AxisState::CLOSED_LOOP_CONTROL && self.error.is_none()
    }

    /// Reads a payload.
    ///
    /// # Errors
    /// [`LengthError`] unless there are [`Heartbeat::LENGTH`] bytes.
    pub fn decode(data: &[u8]) -> Result<Self, LengthError> {
        let [e0, e1, e2, e3, state, procedure_result, trajectory_done, _] = exactly(data)?;
        let error = AxisError(u32::from_le_bytes([e0, e1, e2, e3]));
        Ok(Self { error, state: AxisState(state), procedure_result, trajectory_done })
    }

    /// The frame that `axis` sends.
    pub fn frame(&self, axis: AxisNode) -> Frame {
        let [e0, e1, e2, e3] = self.error.0.to_le_bytes();
        let data = [e0, e1, e2, e3, self.state.0, self.procedure_result, self.trajectory_done, 0];
        Frame::with(Message::Heartbeat.identifier(axis), data)
    }
}

/// Position and velocity of an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EncoderEstimates {
    /// `Pos_Estimate`, turns.
    pub position: f32,
    /// `Vel_Estimate`, turns/s. Not used by the loop, which estimates velocities itself.
    pub velocity: f32,
}

impl EncoderEstimates {
    /// Data bytes.
    pub const LENGTH: usize = 8;

    /// Reads a payload. Numbers that are not finite pass; [`turns`](super::turns) refuses them.
    ///
    /// # Errors
    /// [`LengthError`] unless there are [`EncoderEstimates::LENGTH`] bytes.
    pub fn decode(data: &[u8]) -> Result<Self, LengthError> {
        let [p0, p1, p2, p3, v0, v1, v2, v3] = exactly(data)?;
        Ok(Self { position: f32::from_le_bytes([p0, p1, p2, p3]), velocity: f32::from_le_bytes([v0, v1, v2, v3]) })
    }

    /// The frame that `axis` sends.
    pub fn frame(&self, axis: AxisNode) -> Frame {
        let [p0, p1, p2, p3] = self.position.to_le_bytes();
        let [v0, v1, v2, v3] = self.velocity.to_le_bytes();
        Frame::with(Message::EncoderEstimates.identifier(axis), [p0, p1, p2, p3, v0, v1, v2, v3])
    }
}

/// Asks `axis` for its encoder estimates.
pub fn estimates_request(axis: AxisNode) -> Frame {
    request(Message::EncoderEstimates, axis)
}

/// Asks `axis` for one of [`Message::OF_AXIS`]: the message's identifier without data.
pub fn request(message: Message, axis: AxisNode) -> Frame {
    Frame::with(message.identifier(axis), [])
}

/// What an axis is, and its firmware (`Get_Version`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Version {
    /// `Protocol_Version`.
    pub protocol: u8,
    /// `Hw_Version_Major`, `_Minor` and `_Variant`.
    pub hardware: [u8; 3],
    /// `Fw_Version_Major`, `_Minor` and `_Revision`.
    pub firmware: [u8; 3],
    /// `Fw_Version_Unreleased`: 0 for a firmware that the maker has released.
    pub unreleased: u8,
}

impl Version {
    /// Data bytes.
    pub const LENGTH: usize = 8;

    /// Reads a payload.
    ///
    /// # Errors
    /// [`LengthError`] unless there are [`Version::LENGTH`] bytes.
    pub fn decode(data: &[u8]) -> Result<Self, LengthError> {
        let [protocol, h0, h1, h2, f0, f1, f2, unreleased] = exactly(data)?;
        Ok(Self { protocol, hardware: [h0, h1, h2], firmware: [f0, f1, f2], unreleased })
    }

    /// The frame that `axis` sends.
    pub fn frame(&self, axis: AxisNode) -> Frame {
        let Self { protocol, hardware: [h0, h1, h2], firmware: [f0, f1, f2], unreleased } = *self;
        Frame::with(Message::Version.identifier(axis), [protocol, h0, h1, h2, f0, f1, f2, unreleased])
    }

    /// The hardware as one number, a byte for each part: 00040434h is 4, 4, 52.
    pub const fn product(&self) -> u32 {
        let [major, minor, variant] = self.hardware;
        u32::from_be_bytes([0, major, minor, variant])
    }

    /// The same as CANopen drives say it; the firmware is the revision, and there is neither maker nor serial number.
    pub const fn identity(&self) -> DriveIdentity {
        let [major, minor, revision] = self.firmware;
        let firmware = u32::from_be_bytes([major, minor, revision, self.unreleased]);
        DriveIdentity { vendor: None, product: Some(self.product()), revision: Some(firmware), serial: None }
    }
}

impl fmt::Display for Version {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { hardware: [h0, h1, h2], firmware: [f0, f1, f2], .. } = self;
        write!(formatter, "{:08X}h (hardware {h0}.{h1}.{h2}, firmware {f0}.{f1}.{f2})", self.product())
    }
}

/// Two numbers of four bytes: what [`Temperature`] and [`Supply`] are made of.
fn pair(data: &[u8]) -> Result<[f32; 2], LengthError> {
    let [a0, a1, a2, a3, b0, b1, b2, b3] = exactly(data)?;
    Ok([f32::from_le_bytes([a0, a1, a2, a3]), f32::from_le_bytes([b0, b1, b2, b3])])
}

fn pair_frame(message: Message, axis: AxisNode, [first, second]: [f32; 2]) -> Frame {
    let ([a0, a1, a2, a3], [b0, b1, b2, b3]) = (first.to_le_bytes(), second.to_le_bytes());
    Frame::with(message.identifier(axis), [a0, a1, a2, a3, b0, b1, b2, b3])
}

/// Temperatures of an axis (`Get_Temperature`), °C.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Temperature {
    /// `FET_Temperature`: of the inverter.
    pub inverter: f32,
    /// `Motor_Temperature`; of a motor without thermistor it says nothing.
    pub motor: f32,
}

impl Temperature {
    /// Reads a payload.
    ///
    /// # Errors
    /// [`LengthError`] unless there are eight bytes.
    pub fn decode(data: &[u8]) -> Result<Self, LengthError> {
        pair(data).map(|[inverter, motor]| Self { inverter, motor })
    }

    /// The frame that `axis` sends.
    pub fn frame(&self, axis: AxisNode) -> Frame {
        pair_frame(Message::Temperature, axis, [self.inverter, self.motor])
    }

    /// The higher one. One that is no number is left out.
    pub const fn highest(&self) -> f32 {
        self.inverter.max(self.motor)
    }
}

/// The supply of an axis (`Get_Bus_Voltage_Current`).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Supply {
    /// `Bus_Voltage`, V.
    pub voltage: f32,
    /// `Bus_Current`, A. Not used.
    pub current: f32,
}

impl Supply {
    /// Reads a payload.
    ///
    /// # Errors
    /// [`LengthError`] unless there are eight bytes.
    pub fn decode(data: &[u8]) -> Result<Self, LengthError> {
        pair(data).map(|[voltage, current]| Self { voltage, current })
    }

    /// The frame that `axis` sends.
    pub fn frame(&self, axis: AxisNode) -> Frame {
        pair_frame(Message::BusVoltageCurrent, axis, [self.voltage, self.current])
    }
}

/// What an axis controls (`ControlMode`, `InputMode`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ControllerMode {
    /// `Control_Mode`: 0 voltage, 1 torque, 2 velocity, 3 position.
    pub control: u32,
    /// `Input_Mode`: 1 passes the input through; the others shape it.
    pub input: u32,
}

impl ControllerMode {
    /// Torque control, input passed through: the torque is what the master said last.
    pub const TORQUE: Self = Self { control: 1, input: 1 };

    /// Reads a payload.
    ///
    /// # Errors
    /// [`LengthError`] for less than eight bytes.
    pub fn decode(data: &[u8]) -> Result<Self, LengthError> {
        let [c0, c1, c2, c3, i0, i1, i2, i3] = at_least(data)?;
        Ok(Self { control: u32::from_le_bytes([c0, c1, c2, c3]), input: u32::from_le_bytes([i0, i1, i2, i3]) })
    }

    /// The frame to `axis`.
    pub fn frame(&self, axis: AxisNode) -> Frame {
        let [c0, c1, c2, c3] = self.control.to_le_bytes();
        let [i0, i1, i2, i3] = self.input.to_le_bytes();
        Frame::with(Message::SetControllerMode.identifier(axis), [c0, c1, c2, c3, i0, i1, i2, i3])
    }
}

/// Data bytes of the torque message.
pub const TORQUE_LENGTH: usize = 4;

/// Tells `axis` its torque, N·m at the motor.
pub fn torque_frame(axis: AxisNode, newton_metres: f32) -> Frame {
    Frame::with(Message::SetInputTorque.identifier(axis), newton_metres.to_le_bytes())
}

/// The torque of a message, N·m.
///
/// # Errors
/// [`LengthError`] for less than four bytes.
pub fn decode_torque(data: &[u8]) -> Result<f32, LengthError> {
    at_least(data).map(f32::from_le_bytes)
}

/// Tells `axis` to go to `state`.
pub fn state_frame(axis: AxisNode, state: AxisState) -> Frame {
    Frame::with(Message::SetAxisState.identifier(axis), u32::from(state.0).to_le_bytes())
}

/// The state of a message; a number that is no `u8` is no state and reads as 0, `UNDEFINED`.
///
/// # Errors
/// [`LengthError`] for less than four bytes.
pub fn decode_state(data: &[u8]) -> Result<AxisState, LengthError> {
    at_least(data).map(|bytes| AxisState(u8::try_from(u32::from_le_bytes(bytes)).unwrap_or_default()))
}

/// Tells `axis` to forget its errors. The one data byte, `Identify`, would make its light blink.
pub fn clear_errors_frame(axis: AxisNode) -> Frame {
    Frame::with(Message::ClearErrors.identifier(axis), [0])
}

/// Disarms `axis` with an error.
pub fn estop_frame(axis: AxisNode) -> Frame {
    Frame::with(Message::Estop.identifier(axis), [])
}

#[cfg(test)]
mod tests;
