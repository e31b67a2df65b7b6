//! Codes in words: SDO aborts and emergency messages.

use super::objects::Object;
use canopen_rs::{Address, DataType, NmtState, Value};
use core::fmt;

/// A type as robot files call it.
pub const fn type_name(data_type: DataType) -> &'static str {
    match data_type {
        DataType::Boolean => "bool",
        DataType::Unsigned8 => "u8",
        DataType::Unsigned16 => "u16",
        DataType::Unsigned32 => "u32",
        DataType::Unsigned64 => "u64",
        DataType::Integer8 => "i8",
        DataType::Integer16 => "i16",
        DataType::Integer32 => "i32",
        DataType::Integer64 => "i64",
        DataType::Real32 | DataType::Real64 => "a floating-point number",
        _ => "a text or other data",
    }
}

/// An NMT state as the last heartbeat told it.
pub const fn nmt_state(state: Option<NmtState>) -> &'static str {
    match state {
        None => "no heartbeat",
        Some(NmtState::Initialising) => "a new start",
        Some(NmtState::Stopped) => "NMT Stopped",
        Some(NmtState::Operational) => "NMT Operational",
        Some(NmtState::PreOperational) => "NMT Pre-operational",
    }
}

/// What an SDO abort code means (CiA 301, table of abort codes).
pub const fn abort_code(code: u32) -> &'static str {
    match code {
        0x0503_0000 => "toggle bit not alternated",
        0x0504_0000 => "SDO protocol timed out",
        0x0504_0001 => "command specifier not valid or unknown",
        0x0504_0002 => "invalid block size",
        0x0504_0003 => "invalid sequence number",
        0x0504_0004 => "CRC error",
        0x0504_0005 => "out of memory",
        0x0601_0000 => "unsupported access to an object",
        0x0601_0001 => "attempt to read a write-only object",
        0x0601_0002 => "attempt to write a read-only object",
        0x0602_0000 => "object does not exist in the object dictionary",
        0x0604_0041 => "object cannot be mapped to the PDO",
        0x0604_0042 => "mapped objects exceed the length of a PDO",
        0x0604_0043 => "general parameter incompatibility",
        0x0604_0047 => "general internal incompatibility in the device",
        0x0606_0000 => "access failed because of a hardware error",
        0x0607_0010 => "data type does not match, length of parameter does not match",
        0x0607_0012 => "data type does not match, length of parameter too high",
        0x0607_0013 => "data type does not match, length of parameter too low",
        0x0609_0011 => "sub-index does not exist",
        0x0609_0030 => "invalid value for parameter",
        0x0609_0031 => "value of parameter too high",
        0x0609_0032 => "value of parameter too low",
        0x0609_0036 => "maximum value is less than minimum value",
        0x060A_0023 => "resource not available",
        0x0800_0000 => "general error",
        0x0800_0020 => "data cannot be transferred or stored to the application",
        0x0800_0021 => "data cannot be transferred or stored because of local control",
        0x0800_0022 => "data cannot be transferred or stored because of the present device state",
        0x0800_0023 => "no object dictionary present",
        0x0800_0024 => "no data available",
        _ => "a code of the maker's or of a later standard",
    }
}

/// What an emergency error code means (CiA 301 and CiA 402): the code itself, or its class where it is not listed.
pub const fn emergency_code(code: u16) -> &'static str {
    match code {
        0x0000 => "error reset or no error",
        0x2310 => "continuous over-current",
        0x2320 => "short circuit or earth leakage",
        0x2340 => "short circuit at the motor",
        0x3210 => "DC link over-voltage",
        0x3220 => "DC link under-voltage",
        0x3331 => "field circuit interrupted",
        0x4210 => "device temperature too high",
        0x4310 => "drive temperature too high",
        0x5441 => "contact of a limit switch",
        0x6010 => "software reset (watchdog)",
        0x6320 => "parameter error",
        0x7121 => "motor blocked",
        0x7300 => "sensor",
        0x7305 => "incremental sensor 1 fault",
        0x7500 => "communication inside the device",
        0x8110 => "CAN overrun, objects lost",
        0x8120 => "CAN in error passive mode",
        0x8130 => "life guard or heartbeat error",
        0x8140 => "recovered from bus-off",
        0x8150 => "CAN identifier collision",
        0x8210 => "PDO not processed because of its length",
        0x8220 => "PDO longer than mapped",
        0x8240 => "unexpected data length of SYNC",
        0x8250 => "RPDO timeout",
        0x8300 => "torque control",
        0x8311 => "excess torque",
        0x8400 => "velocity control",
        0x8611 => "following error",
        0x8700 => "SYNC controller",
        _ => emergency_class(code),
    }
}

const fn emergency_class(code: u16) -> &'static str {
    match code >> 8 {
        0x00 => "error reset or no error",
        0x10 => "generic error",
        0x20..=0x2F => "current",
        0x30..=0x3F => "voltage",
        0x40..=0x4F => "temperature",
        0x50..=0x5F => "device hardware",
        0x60..=0x6F => "device software",
        0x70..=0x7F => "additional modules",
        0x81 | 0x82 => "communication",
        0x80..=0x8F => "monitoring",
        0x90..=0x9F => "external error",
        0xF0..=0xFE => "additional functions",
        0xFF => "device specific",
        _ => "a code that the standard reserves",
    }
}

/// An address with the object's name, where it has one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Named(pub Address);

impl fmt::Display for Named {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match Object::at(self.0) {
            Some(object) => object.fmt(formatter),
            None => write!(formatter, "{:04X}h:{:02X}", self.0.index, self.0.subindex),
        }
    }
}

/// A value of the object dictionary, whole numbers also in hexadecimal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown(pub Value);

impl fmt::Display for Shown {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Value::Boolean(value) => value.fmt(formatter),
            Value::Integer8(value) => value.fmt(formatter),
            Value::Integer16(value) => value.fmt(formatter),
            Value::Integer32(value) => value.fmt(formatter),
            Value::Integer64(value) => value.fmt(formatter),
            Value::Unsigned8(value) => write!(formatter, "{value} ({value:02X}h)"),
            Value::Unsigned16(value) => write!(formatter, "{value} ({value:04X}h)"),
            Value::Unsigned32(value) => write!(formatter, "{value} ({value:08X}h)"),
            Value::Unsigned64(value) => write!(formatter, "{value} ({value:016X}h)"),
            Value::Real32(value) => value.fmt(formatter),
            Value::Real64(value) => value.fmt(formatter),
            value => write!(formatter, "{value:?}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::format;

    #[test]
    fn codes_have_words() {
        assert_eq!(abort_code(0x0602_0000), "object does not exist in the object dictionary");
        assert_eq!(emergency_code(0x8130), "life guard or heartbeat error");
        assert_eq!(emergency_code(0x3299), "voltage");
        assert_eq!(emergency_code(0x8199), "communication");
        assert_eq!(emergency_code(0xFF01), "device specific");
    }

    #[test]
    fn objects_and_values_are_shown_as_manuals_print_them() {
        assert_eq!(format!("{}", Named(Address::new(0x608F, 1))), "608Fh:01 (encoder increments)");
        assert_eq!(format!("{}", Named(Address::new(0x2000, 3))), "2000h:03");
        assert_eq!(format!("{}", Shown(Value::Unsigned16(402))), "402 (0192h)");
        assert_eq!(format!("{}", Shown(Value::Integer8(-4))), "-4");
    }
}
