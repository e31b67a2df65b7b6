//! The object dictionary entries of CiA 301 and CiA 402 that this project touches.

use canopen_rs::{Address, DataType};
use core::fmt;

/// An entry of a drive's object dictionary: where it is, what it holds, what the standard calls it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Object {
    /// Index, as in `6060h`.
    pub index: u16,
    /// Sub-index.
    pub subindex: u8,
    /// Type of its value.
    pub data_type: DataType,
    /// The standard's name for it.
    pub name: &'static str,
}

impl Object {
    /// An object.
    pub const fn new(index: u16, subindex: u8, data_type: DataType, name: &'static str) -> Self {
        Self { index, subindex, data_type, name }
    }

    /// Its address in the dictionary.
    pub const fn address(&self) -> Address {
        Address::new(self.index, self.subindex)
    }

    /// The object of this module at `address`, if it is one of them.
    pub fn at(address: Address) -> Option<&'static Self> {
        ALL.iter().copied().find(|object| object.address() == address)
    }
}

impl fmt::Display for Object {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{:04X}h:{:02X} ({})", self.index, self.subindex, self.name)
    }
}

/// Declares each object as a constant, and [`ALL`] of them.
macro_rules! objects {
    ($($(#[$doc:meta])* $constant:ident = $index:literal : $subindex:literal $data_type:ident $name:literal;)*) => {
        $($(#[$doc])* pub const $constant: Object = Object::new($index, $subindex, DataType::$data_type, $name);)*

        /// Every object of this module, in the order of its declaration.
        pub const ALL: &[&Object] = &[$(&$constant),*];
    };
}

objects! {
    /// Device type: low word [`DEVICE_PROFILE_CIA402`] for a drive.
    DEVICE_TYPE = 0x1000:0 Unsigned32 "device type";
    /// Bit field of present errors; its bits are those of an emergency message.
    ERROR_REGISTER = 0x1001:0 Unsigned8 "error register";
    /// Identifier of the SYNC message; bit 30 set makes the drive send it.
    SYNC_IDENTIFIER = 0x1005:0 Unsigned32 "COB-ID SYNC";
    /// Identifier of the drive's emergency messages.
    EMERGENCY_IDENTIFIER = 0x1014:0 Unsigned32 "COB-ID EMCY";
    /// Whom the drive listens to and for how long it bears silence: `node << 16 | milliseconds`.
    CONSUMER_HEARTBEAT_TIME = 0x1016:1 Unsigned32 "consumer heartbeat time";
    /// The period of the drive's own heartbeat, ms; 0 switches it off.
    PRODUCER_HEARTBEAT_TIME = 0x1017:0 Unsigned16 "producer heartbeat time";
    /// Identity: vendor.
    VENDOR_ID = 0x1018:1 Unsigned32 "vendor-ID";
    /// Identity: product code.
    PRODUCT_CODE = 0x1018:2 Unsigned32 "product code";
    /// Identity: revision.
    REVISION_NUMBER = 0x1018:3 Unsigned32 "revision number";
    /// Identity: serial number.
    SERIAL_NUMBER = 0x1018:4 Unsigned32 "serial number";
    /// The value after which the SYNC counter starts again at 1; 0 for a SYNC without counter.
    SYNC_COUNTER_OVERFLOW = 0x1019:0 Unsigned8 "synchronous counter overflow value";

    /// Identifier of RPDO1; bit 31 set switches the PDO off.
    RPDO1_IDENTIFIER = 0x1400:1 Unsigned32 "RPDO1 COB-ID";
    /// Transmission type of RPDO1.
    RPDO1_TRANSMISSION_TYPE = 0x1400:2 Unsigned8 "RPDO1 transmission type";
    /// After how many ms without RPDO1 the drive reacts; 0 switches it off.
    RPDO1_EVENT_TIMER = 0x1400:5 Unsigned16 "RPDO1 event timer";
    /// How many objects RPDO1 carries; 0 while the mapping is being changed.
    RPDO1_MAPPED_OBJECTS = 0x1600:0 Unsigned8 "RPDO1 number of mapped objects";
    /// First object of RPDO1.
    RPDO1_FIRST_OBJECT = 0x1600:1 Unsigned32 "RPDO1 first mapped object";
    /// Second object of RPDO1.
    RPDO1_SECOND_OBJECT = 0x1600:2 Unsigned32 "RPDO1 second mapped object";
    /// Identifier of TPDO1; bit 31 set switches the PDO off.
    TPDO1_IDENTIFIER = 0x1800:1 Unsigned32 "TPDO1 COB-ID";
    /// Transmission type of TPDO1.
    TPDO1_TRANSMISSION_TYPE = 0x1800:2 Unsigned8 "TPDO1 transmission type";
    /// How many objects TPDO1 carries; 0 while the mapping is being changed.
    TPDO1_MAPPED_OBJECTS = 0x1A00:0 Unsigned8 "TPDO1 number of mapped objects";
    /// First object of TPDO1.
    TPDO1_FIRST_OBJECT = 0x1A00:1 Unsigned32 "TPDO1 first mapped object";
    /// Second object of TPDO1.
    TPDO1_SECOND_OBJECT = 0x1A00:2 Unsigned32 "TPDO1 second mapped object";

    /// What the drive does when it loses its master: 0 nothing, 1 fault, 2 disable voltage, 3 quick stop.
    ABORT_CONNECTION_OPTION = 0x6007:0 Integer16 "abort connection option code";
    /// The last error's code; the codes are those of an emergency message.
    ERROR_CODE = 0x603F:0 Unsigned16 "error code";
    /// See [`crate::drive::cia402::Controlword`].
    CONTROLWORD = 0x6040:0 Unsigned16 "controlword";
    /// See [`crate::drive::cia402::Statusword`].
    STATUSWORD = 0x6041:0 Unsigned16 "statusword";
    /// What quick stop does.
    QUICK_STOP_OPTION = 0x605A:0 Integer16 "quick stop option code";
    /// The wanted mode; [`CYCLIC_SYNCHRONOUS_TORQUE`] here.
    MODE_OF_OPERATION = 0x6060:0 Integer8 "modes of operation";
    /// The mode the drive is in.
    MODE_OF_OPERATION_DISPLAY = 0x6061:0 Integer8 "modes of operation display";
    /// Quadrature counts.
    POSITION_ACTUAL = 0x6064:0 Integer32 "position actual value";
    /// Per mille of the rated torque.
    TARGET_TORQUE = 0x6071:0 Integer16 "target torque";
    /// The drive's own limit, per mille of the rated torque.
    MAXIMUM_TORQUE = 0x6072:0 Unsigned16 "max torque";
    /// The drive's own current limit, per mille of the rated current.
    MAXIMUM_CURRENT = 0x6073:0 Unsigned16 "max current";
    /// mA.
    RATED_CURRENT = 0x6075:0 Unsigned32 "motor rated current";
    /// mN·m; some makers count µN·m.
    RATED_TORQUE = 0x6076:0 Unsigned32 "motor rated torque";
    /// Per mille of the rated torque.
    TORQUE_ACTUAL = 0x6077:0 Integer16 "torque actual value";
    /// Voltage of the drive's supply, mV.
    DC_LINK_VOLTAGE = 0x6079:0 Unsigned32 "DC link circuit voltage";
    /// Signs between motor and position (bit 7), velocity (bit 6) and torque (bit 5); 0 turns nothing round.
    POLARITY = 0x607E:0 Unsigned8 "polarity";
    /// Counts in [`ENCODER_REVOLUTIONS`] revolutions.
    ENCODER_INCREMENTS = 0x608F:1 Unsigned32 "encoder increments";
    /// Revolutions in which [`ENCODER_INCREMENTS`] are counted; 1 as a rule.
    ENCODER_REVOLUTIONS = 0x608F:2 Unsigned32 "motor revolutions";
    /// Motor revolutions in [`GEAR_SHAFT_REVOLUTIONS`].
    GEAR_MOTOR_REVOLUTIONS = 0x6091:1 Unsigned32 "gear ratio, motor revolutions";
    /// Shaft revolutions in which [`GEAR_MOTOR_REVOLUTIONS`] are made.
    GEAR_SHAFT_REVOLUTIONS = 0x6091:2 Unsigned32 "gear ratio, shaft revolutions";
    /// Position units in [`FEED_SHAFT_REVOLUTIONS`].
    FEED = 0x6092:1 Unsigned32 "feed constant, feed";
    /// Shaft revolutions in which [`FEED`] is made.
    FEED_SHAFT_REVOLUTIONS = 0x6092:2 Unsigned32 "feed constant, shaft revolutions";
    /// From the home position to the drive's zero position, counts.
    HOME_OFFSET = 0x607C:0 Integer32 "home offset";
    /// How the drive finds its home.
    HOMING_METHOD = 0x6098:0 Integer8 "homing method";
    /// How fast the drive looks for a switch, in its own unit of velocity.
    HOMING_SWITCH_SPEED = 0x6099:1 Unsigned32 "speed during search for switch";
    /// How fast the drive looks for the edge of the switch, or for the index, in the same unit.
    HOMING_ZERO_SPEED = 0x6099:2 Unsigned32 "speed during search for zero";
    /// How fast it gets there, in its own unit of acceleration.
    HOMING_ACCELERATION = 0x609A:0 Unsigned32 "homing acceleration";
    /// Mantissa of the cycle time: value · 10^exponent s.
    INTERPOLATION_TIME_VALUE = 0x60C2:1 Unsigned8 "interpolation time period value";
    /// Exponent of the cycle time.
    INTERPOLATION_TIME_EXPONENT = 0x60C2:2 Integer8 "interpolation time index";
    /// Bit field of the modes that the drive knows; bit 9 is [`CYCLIC_SYNCHRONOUS_TORQUE`].
    SUPPORTED_MODES = 0x6502:0 Unsigned32 "supported drive modes";
}

/// The objects that a drive need not have; [`crate::drive::plan`] says what comes of their absence.
pub const OPTIONAL: &[&Object] = &[
    &MAXIMUM_CURRENT,
    &RATED_CURRENT,
    &POLARITY,
    &GEAR_MOTOR_REVOLUTIONS,
    &GEAR_SHAFT_REVOLUTIONS,
    &FEED,
    &FEED_SHAFT_REVOLUTIONS,
    &HOME_OFFSET,
    &HOMING_METHOD,
    &HOMING_SWITCH_SPEED,
    &HOMING_ZERO_SPEED,
    &HOMING_ACCELERATION,
];

/// Low word of [`DEVICE_TYPE`] of a drive: device profile 402.
pub const DEVICE_PROFILE_CIA402: u16 = 402;

/// The value of [`MODE_OF_OPERATION`] for cyclic synchronous torque (CiA 402-2, 6060h).
pub const CYCLIC_SYNCHRONOUS_TORQUE: i8 = 10;

/// The bit of [`SUPPORTED_MODES`] that stands for cyclic synchronous torque (CiA 402-2, 6502h).
pub const CYCLIC_SYNCHRONOUS_TORQUE_BIT: u32 = 1 << 9;

/// The value of [`MODE_OF_OPERATION`] for homing (CiA 402-2, 6060h).
pub const HOMING: i8 = 6;

/// The bit of [`SUPPORTED_MODES`] that stands for homing (CiA 402-2, 6502h).
pub const HOMING_BIT: u32 = 1 << 5;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_address_is_declared_twice() {
        for (position, object) in ALL.iter().enumerate() {
            assert!(ALL[position + 1..].iter().all(|other| other.address() != object.address()), "{object}");
        }
    }

    #[test]
    fn objects_are_found_and_named() {
        let found = Object::at(Address::new(0x6064, 0)).unwrap();
        assert_eq!(*found, POSITION_ACTUAL);
        assert_eq!(std::format!("{found}"), "6064h:00 (position actual value)");
        assert_eq!(Object::at(Address::new(0x6064, 1)), None);
    }
}
