//! The emulated drive's own objects, as one table: the EDS file of `uarm-io` says the same, and a test compares.

use super::memory::ERROR_HISTORY;
use super::parameters::DriveParameters;
use canopen_rs::object_dictionary::AccessType;
use canopen_rs::{Address, ByteString, MappingEntry, Value};
use uarm_io::drive::objects;
use uarm_io::drive::wire::{RPDO1_MAPPING, RPDO1_TRANSMISSION, TPDO1_MAPPING, TPDO1_TRANSMISSION};

/// Whether, and in which direction, an object may be part of a PDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mappable {
    /// Not at all.
    No,
    /// In a TPDO: the drive sends it.
    Transmit,
    /// In an RPDO (and in a TPDO): the drive receives it.
    Receive,
}

/// One object of the dictionary.
#[derive(Clone, Copy, Debug)]
pub struct DictionaryEntry {
    /// Where it is.
    pub address: Address,
    /// What the master may do with it.
    pub access: AccessType,
    /// Whether it may be part of a PDO.
    pub mappable: Mappable,
    /// Its value at power-on.
    pub default: fn(&DriveParameters) -> Value,
}

const fn entry(index: u16, sub: u8, access: AccessType, default: fn(&DriveParameters) -> Value) -> DictionaryEntry {
    DictionaryEntry { address: Address::new(index, sub), access, mappable: Mappable::No, default }
}

const fn mapped(
    mappable: Mappable,
    index: u16,
    access: AccessType,
    default: fn(&DriveParameters) -> Value,
) -> DictionaryEntry {
    DictionaryEntry { address: Address::new(index, 0), access, mappable, default }
}

/// Device type: profile 402, servo drive (bit 17).
const SERVO_DRIVE: u32 = 0x0002_0000 | 402;
/// No vendor has number 0: CiA assigns them from 1 on, and this drive is not a product.
const NO_VENDOR: u32 = 0;
const PRODUCT_CODE: u32 = 0x5541_524D; // "UARM"
const REVISION: u32 = 0x0001_0000;
/// What 1008h says.
pub const DEVICE_NAME: &str = "UARM emulated drive";
/// Bit 31 of a PDO's identifier: the PDO is off.
pub const PDO_OFF: u32 = 1 << 31;
/// Entries of a PDO's mapping.
pub const MAPPING_ENTRIES: u8 = 4;
/// 6007h: a lost master is a fault.
const ABORT_IS_FAULT: i16 = 1;
/// 605Ah: stop and stay in *Quick stop active* until the master leaves it.
const QUICK_STOP_STAYS: i16 = 6;

use AccessType::{Const, Ro, Rw};

fn name(text: &str) -> Value {
    Value::VisibleString(ByteString::from_str(text).unwrap_or_default())
}

fn identifier(base: u32, drive: &DriveParameters) -> Value {
    Value::Unsigned32(base + u32::from(drive.node().raw()))
}

fn no_error(_: &DriveParameters) -> Value {
    Value::Unsigned32(0)
}

fn first_of([mapping, _]: &[MappingEntry; 2]) -> Value {
    Value::Unsigned32(mapping.to_u32())
}

fn second_of([_, mapping]: &[MappingEntry; 2]) -> Value {
    Value::Unsigned32(mapping.to_u32())
}

fn mapping(index: u16, bits: u8) -> Value {
    Value::Unsigned32(MappingEntry::new(index, 0, bits).to_u32())
}

fn unmapped(_: &DriveParameters) -> Value {
    Value::Unsigned32(0)
}

/// Every object of the drive. PDO parameters start as the predefined connection set and `uarm_io`'s wire define them.
#[rustfmt::skip]
pub const OBJECTS: &[DictionaryEntry] = &[
    entry(0x1000, 0, Const, |_| Value::Unsigned32(SERVO_DRIVE)),
    entry(0x1001, 0, Ro, |_| Value::Unsigned8(0)),
    entry(0x1003, 0, Rw, |_| Value::Unsigned8(0)),
    entry(0x1003, 1, Ro, no_error),
    entry(0x1003, 2, Ro, no_error),
    entry(0x1003, 3, Ro, no_error),
    entry(0x1003, 4, Ro, no_error),
    entry(0x1003, 5, Ro, no_error),
    entry(0x1003, 6, Ro, no_error),
    entry(0x1003, 7, Ro, no_error),
    entry(0x1003, ERROR_HISTORY, Ro, no_error),
    entry(0x1005, 0, Ro, |_| Value::Unsigned32(0x80)),
    entry(0x1008, 0, Const, |_| name(DEVICE_NAME)),
    entry(0x1014, 0, Ro, |drive| identifier(0x80, drive)),
    entry(0x1016, 0, Const, |_| Value::Unsigned8(1)),
    entry(0x1016, 1, Rw, |_| Value::Unsigned32(0)),
    entry(0x1017, 0, Rw, |_| Value::Unsigned16(0)),
    entry(0x1018, 0, Const, |_| Value::Unsigned8(4)),
    entry(0x1018, 1, Const, |drive| Value::Unsigned32(drive.identity().vendor.unwrap_or(NO_VENDOR))),
    entry(0x1018, 2, Const, |drive| Value::Unsigned32(drive.identity().product.unwrap_or(PRODUCT_CODE))),
    entry(0x1018, 3, Const, |_| Value::Unsigned32(REVISION)),
    entry(0x1018, 4, Ro, |drive| Value::Unsigned32(drive.identity().serial.unwrap_or(drive.node().raw().into()))),
    entry(0x1019, 0, Rw, |_| Value::Unsigned8(0)),
    entry(0x1029, 0, Const, |_| Value::Unsigned8(1)),
    entry(0x1029, 1, Rw, |_| Value::Unsigned8(0)),
    entry(0x1400, 0, Const, |_| Value::Unsigned8(5)),
    entry(0x1400, 1, Rw, |drive| identifier(0x200, drive)),
    entry(0x1400, 2, Rw, |_| Value::Unsigned8(RPDO1_TRANSMISSION.to_byte())),
    entry(0x1400, 5, Rw, |_| Value::Unsigned16(0)),
    entry(0x1600, 0, Rw, |_| Value::Unsigned8(2)),
    entry(0x1600, 1, Rw, |_| first_of(&RPDO1_MAPPING)),
    entry(0x1600, 2, Rw, |_| second_of(&RPDO1_MAPPING)),
    entry(0x1600, 3, Rw, unmapped),
    entry(0x1600, MAPPING_ENTRIES, Rw, unmapped),
    entry(0x1800, 0, Const, |_| Value::Unsigned8(2)),
    entry(0x1800, 1, Rw, |drive| identifier(0x180, drive)),
    entry(0x1800, 2, Rw, |_| Value::Unsigned8(TPDO1_TRANSMISSION.to_byte())),
    entry(0x1801, 0, Const, |_| Value::Unsigned8(2)),
    entry(0x1801, 1, Rw, |drive| identifier(PDO_OFF | 0x280, drive)),
    entry(0x1801, 2, Rw, |_| Value::Unsigned8(TPDO1_TRANSMISSION.to_byte())),
    entry(0x1802, 0, Const, |_| Value::Unsigned8(2)),
    entry(0x1802, 1, Rw, |drive| identifier(PDO_OFF | 0x380, drive)),
    entry(0x1802, 2, Rw, |_| Value::Unsigned8(TPDO1_TRANSMISSION.to_byte())),
    entry(0x1803, 0, Const, |_| Value::Unsigned8(2)),
    entry(0x1803, 1, Rw, |drive| identifier(PDO_OFF | 0x480, drive)),
    entry(0x1803, 2, Rw, |_| Value::Unsigned8(TPDO1_TRANSMISSION.to_byte())),
    entry(0x1A00, 0, Rw, |_| Value::Unsigned8(2)),
    entry(0x1A00, 1, Rw, |_| first_of(&TPDO1_MAPPING)),
    entry(0x1A00, 2, Rw, |_| second_of(&TPDO1_MAPPING)),
    entry(0x1A00, 3, Rw, unmapped),
    entry(0x1A00, MAPPING_ENTRIES, Rw, unmapped),
    entry(0x1A01, 0, Rw, |_| Value::Unsigned8(1)),
    entry(0x1A01, 1, Rw, |_| mapping(0x6077, 16)),
    entry(0x1A01, 2, Rw, unmapped),
    entry(0x1A01, 3, Rw, unmapped),
    entry(0x1A01, MAPPING_ENTRIES, Rw, unmapped),
    entry(0x1A02, 0, Rw, |_| Value::Unsigned8(2)),
    entry(0x1A02, 1, Rw, |_| mapping(0x603F, 16)),
    entry(0x1A02, 2, Rw, |_| mapping(0x6061, 8)),
    entry(0x1A02, 3, Rw, unmapped),
    entry(0x1A02, MAPPING_ENTRIES, Rw, unmapped),
    entry(0x1A03, 0, Rw, |_| Value::Unsigned8(1)),
    entry(0x1A03, 1, Rw, |_| mapping(0x6074, 16)),
    entry(0x1A03, 2, Rw, unmapped),
    entry(0x1A03, 3, Rw, unmapped),
    entry(0x1A03, MAPPING_ENTRIES, Rw, unmapped),
    mapped(Mappable::Transmit, 0x2010, Ro, |_| Value::Integer16(TEMPERATURE_TENTHS)),
    entry(0x6007, 0, Rw, |_| Value::Integer16(ABORT_IS_FAULT)),
    mapped(Mappable::Transmit, 0x603F, Ro, |_| Value::Unsigned16(0)),
    mapped(Mappable::Receive, 0x6040, Rw, |_| Value::Unsigned16(0)),
    mapped(Mappable::Transmit, 0x6041, Ro, |_| Value::Unsigned16(0)),
    entry(0x605A, 0, Rw, |_| Value::Integer16(QUICK_STOP_STAYS)),
    mapped(Mappable::Receive, 0x6060, Rw, |_| Value::Integer8(0)),
    mapped(Mappable::Transmit, 0x6061, Ro, |_| Value::Integer8(0)),
    mapped(Mappable::Transmit, 0x6064, Ro, |_| Value::Integer32(0)),
    mapped(Mappable::Receive, 0x6071, Rw, |_| Value::Integer16(0)),
    mapped(Mappable::Receive, 0x6072, Rw, |drive| Value::Unsigned16(drive.maximum_torque())),
    mapped(Mappable::Transmit, 0x6074, Ro, |_| Value::Integer16(0)),
    entry(0x6075, 0, Rw, |drive| Value::Unsigned32(drive.rated_current())),
    entry(0x6076, 0, Rw, |drive| Value::Unsigned32(drive.rated_torque())),
    mapped(Mappable::Transmit, 0x6077, Ro, |_| Value::Integer16(0)),
    mapped(Mappable::Transmit, 0x6079, Ro, |_| Value::Unsigned32(SUPPLY_MILLIVOLTS)),
    entry(0x607C, 0, Rw, |_| Value::Integer32(0)),
    entry(0x6081, 0, Rw, |_| Value::Unsigned32(0)),
    entry(0x608F, 0, Const, |_| Value::Unsigned8(2)),
    entry(0x608F, 1, Ro, |drive| Value::Unsigned32(drive.encoder().description().counts_per_revolution)),
    entry(0x608F, 2, Ro, |_| Value::Unsigned32(1)),
    entry(0x6098, 0, Rw, |_| Value::Integer8(0)),
    entry(0x6099, 0, Const, |_| Value::Unsigned8(2)),
    entry(0x6099, 1, Rw, |_| Value::Unsigned32(0)),
    entry(0x6099, 2, Rw, |_| Value::Unsigned32(0)),
    entry(0x609A, 0, Rw, |_| Value::Unsigned32(0)),
    entry(0x60C2, 0, Const, |_| Value::Unsigned8(2)),
    entry(0x60C2, 1, Rw, |_| Value::Unsigned8(1)),
    entry(0x60C2, 2, Rw, |_| Value::Integer8(-3)),
    mapped(Mappable::Transmit, 0x60FD, Ro, |_| Value::Unsigned32(0)),
    entry(0x60FE, 0, Const, |_| Value::Unsigned8(1)),
    entry(0x60FE, 1, Ro, |_| Value::Unsigned32(BRAKE_OUTPUT)),
    entry(0x6502, 0, Ro, |_| Value::Unsigned32(objects::CYCLIC_SYNCHRONOUS_TORQUE_BIT | objects::HOMING_BIT)),
];

/// 6079h of a drive with a good supply, mV.
pub const SUPPLY_MILLIVOLTS: u32 = 24_000;

/// 2010h, the motor's temperature, of a cool one, 0.1 °C: an object of this drive's own, since the standard has none.
pub const TEMPERATURE_TENTHS: i16 = 300;

/// Bit 0 of 60FEh:01, digital outputs: the brake is set.
pub const BRAKE_OUTPUT: u32 = 1;

/// How many objects the drive's own dictionary holds.
pub const CAPACITY: usize = OBJECTS.len();

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::parameters::tests::description;
    use uarm_io::drive::DataType;

    #[test]
    fn every_object_is_there_once() {
        for (row, object) in OBJECTS.iter().enumerate() {
            assert!(OBJECTS[row + 1..].iter().all(|other| other.address != object.address), "{:?}", object.address);
        }
        assert!(OBJECTS.is_sorted_by_key(|object| object.address));
    }

    /// The master reads and writes these objects: they must be there, with the type that it expects.
    #[test]
    fn the_masters_objects_are_there() {
        let drive = DriveParameters::new(description(2)).unwrap();
        for object in objects::ALL.iter().filter(|object| !objects::OPTIONAL.contains(object)) {
            let row = OBJECTS.iter().find(|row| row.address == object.address()).unwrap();
            let found: DataType = (row.default)(&drive).data_type();
            assert_eq!(found, object.data_type, "{object}");
        }
    }
}
