//! What the drive's SDO server refuses beyond types and access rights: values out of range, and PDO parameters changed
//! in an order that CiA 301 (7.5.2.36) does not allow. Real drives refuse the same, so a master is tested on it here.

use super::dictionary::{CAPACITY, MAPPING_ENTRIES, Mappable, QUICK_STOP_STAYS, object};
use canopen_rs::sync::is_valid_counter_overflow;
use canopen_rs::{Address, MappingEntry, ObjectDictionary, TransmissionType, Value, pdo};
use uarm_io::drive::objects::CYCLIC_SYNCHRONOUS_TORQUE;

/// Why a write is refused, as an SDO abort code (CiA 301, 7.2.4.3.17).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// Command specifier not valid: every object that can be written fits an expedited transfer.
    NotExpedited,
    /// Unsupported access: the PDO has to be switched off first.
    PdoInUse,
    /// The object cannot be mapped to the PDO.
    CannotBeMapped,
    /// The mapped objects are longer than a PDO.
    TooLong,
    /// Value out of range.
    ValueRange,
}

impl Refusal {
    /// The abort code.
    pub const fn code(self) -> u32 {
        match self {
            Self::NotExpedited => 0x0504_0001,
            Self::PdoInUse => 0x0601_0000,
            Self::CannotBeMapped => 0x0604_0041,
            Self::TooLong => 0x0604_0042,
            Self::ValueRange => 0x0609_0030,
        }
    }
}

type Dictionary = ObjectDictionary<CAPACITY>;

/// Command byte of an SDO download's first frame, and its flag for data within that frame (CiA 301, 7.2.4.3.3).
const DOWNLOAD: u8 = 0x20;
const COMMAND_MASK: u8 = 0xE0;
const EXPEDITED: u8 = 0x02;
const ABORT: u8 = 0x80;

/// The abort that answers `request` if the drive refuses it; `None` if the server may go on with it.
pub fn abort(dictionary: &Dictionary, request: &[u8; 8]) -> Option<[u8; 8]> {
    let [command, low, high, subindex, d0, d1, d2, d3] = *request;
    if command & COMMAND_MASK != DOWNLOAD {
        return None;
    }
    let address = Address::new(u16::from_le_bytes([low, high]), subindex);
    let entry = dictionary.entry(address).filter(|entry| entry.access.is_writable())?;
    let refusal = if command & EXPEDITED == 0 {
        Refusal::NotExpedited
    } else {
        let data = [d0, d1, d2, d3];
        let data = data.get(..entry.value.size())?;
        let value = Value::decode_le(entry.value.data_type(), data).ok()?;
        check(dictionary, address, value).err()?
    };
    let [c0, c1, c2, c3] = refusal.code().to_le_bytes();
    Some([ABORT, low, high, subindex, c0, c1, c2, c3])
}

/// Whether `value` may be written.
fn check(dictionary: &Dictionary, address: Address, value: Value) -> Result<(), Refusal> {
    let in_range = match (address.index, address.subindex, value) {
        (0x1019, 0, Value::Unsigned8(overflow)) => is_valid_counter_overflow(overflow),
        (0x1029, 1, Value::Unsigned8(behaviour)) => behaviour <= 2,
        (0x1400 | 0x1800, 1, Value::Unsigned32(identifier)) => {
            return check_identifier(dictionary, address, identifier);
        }
        (0x1400, 2, Value::Unsigned8(kind)) => receives(kind),
        // Only "at each SYNC": this drive has no other trigger.
        (0x1800, 2, Value::Unsigned8(kind)) => kind == 1,
        (0x1600 | 0x1A00, 0, Value::Unsigned8(count)) => return check_count(dictionary, address.index, count),
        (0x1600 | 0x1A00, _, Value::Unsigned32(mapping)) => {
            return check_mapping(dictionary, address.index, MappingEntry::from_u32(mapping));
        }
        (0x6007, 0, Value::Integer16(option)) => (0..=3).contains(&option),
        (0x605A, 0, Value::Integer16(option)) => option == QUICK_STOP_STAYS,
        (0x6060, 0, Value::Integer8(mode)) => mode == 0 || mode == CYCLIC_SYNCHRONOUS_TORQUE,
        (0x6075 | 0x6076, 0, Value::Unsigned32(rated)) => rated > 0,
        (0x60C2, 1, Value::Unsigned8(mantissa)) => mantissa > 0,
        _ => true,
    };
    if in_range { Ok(()) } else { Err(Refusal::ValueRange) }
}

/// Transmission types that an RPDO of this drive knows: at SYNC, or on reception.
fn receives(kind: u8) -> bool {
    use TransmissionType::{EventDrivenManufacturer, EventDrivenProfile, SynchronousAcyclic, SynchronousCyclic};
    matches!(
        TransmissionType::from_byte(kind),
        Ok(SynchronousAcyclic | SynchronousCyclic(_) | EventDrivenManufacturer | EventDrivenProfile)
    )
}

/// Bit 29 of a PDO's identifier: a 29-bit identifier, which this drive does not know.
const EXTENDED: u32 = 1 << 29;

/// The identifier of a PDO in use may not change; it has to be switched off (bit 31) first.
fn check_identifier(dictionary: &Dictionary, address: Address, identifier: u32) -> Result<(), Refusal> {
    let Ok(Value::Unsigned32(current)) = dictionary.read(address) else { return Ok(()) };
    let both_valid = pdo::pdo_is_valid(current) && pdo::pdo_is_valid(identifier);
    let changed = pdo::pdo_can_id(current) != pdo::pdo_can_id(identifier);
    if identifier & EXTENDED != 0 || both_valid && changed { Err(Refusal::ValueRange) } else { Ok(()) }
}

/// A mapping may change only while its PDO is switched off.
fn pdo_is_off(dictionary: &Dictionary, mapping_index: u16) -> Result<(), Refusal> {
    // 1600h belongs to 1400h, 1A00h to 1800h.
    match dictionary.read(Address::new(mapping_index - 0x200, 1)) {
        Ok(Value::Unsigned32(identifier)) if pdo::pdo_is_valid(identifier) => Err(Refusal::PdoInUse),
        _ => Ok(()),
    }
}

fn check_count(dictionary: &Dictionary, index: u16, count: u8) -> Result<(), Refusal> {
    pdo_is_off(dictionary, index)?;
    if count > MAPPING_ENTRIES {
        return Err(Refusal::TooLong);
    }
    let mut bits = 0_u32;
    for subindex in 1..=count {
        let Ok(Value::Unsigned32(mapping)) = dictionary.read(Address::new(index, subindex)) else { continue };
        check_mappable(dictionary, index, MappingEntry::from_u32(mapping))?;
        bits += u32::from(MappingEntry::from_u32(mapping).bit_length);
    }
    if bits > 64 { Err(Refusal::TooLong) } else { Ok(()) }
}

fn check_mapping(dictionary: &Dictionary, index: u16, mapping: MappingEntry) -> Result<(), Refusal> {
    pdo_is_off(dictionary, index)?;
    match dictionary.read(Address::new(index, 0)) {
        Ok(Value::Unsigned8(0)) => {}
        _ => return Err(Refusal::PdoInUse),
    }
    // Zero empties the entry.
    if mapping.to_u32() == 0 { Ok(()) } else { check_mappable(dictionary, index, mapping) }
}

fn check_mappable(dictionary: &Dictionary, index: u16, mapping: MappingEntry) -> Result<(), Refusal> {
    let receives = index < 0x1800;
    let fits = object(mapping.address).is_some_and(|object| match object.mappable {
        Mappable::No => false,
        Mappable::Transmit => !receives,
        Mappable::Receive => true,
    });
    let bytes = dictionary.entry(mapping.address).map(|entry| entry.value.size());
    let same_width = bytes.is_some_and(|bytes| usize::from(mapping.bit_length) == 8 * bytes);
    if fits && same_width { Ok(()) } else { Err(Refusal::CannotBeMapped) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::dictionary::dictionary;
    use crate::drive::parameters::{DriveParameters, tests::description};

    fn drive() -> Dictionary {
        dictionary(&DriveParameters::new(description(3)).unwrap())
    }

    fn write(dictionary: &mut Dictionary, index: u16, subindex: u8, value: Value) -> Result<(), Refusal> {
        let address = Address::new(index, subindex);
        check(dictionary, address, value)?;
        dictionary.write(address, value).unwrap();
        Ok(())
    }

    #[test]
    fn a_mapping_changes_in_the_standards_order_only() {
        let mut drive = drive();
        let torque = Value::Unsigned32(MappingEntry::new(0x6077, 0, 16).to_u32());
        assert_eq!(write(&mut drive, 0x1A00, 0, Value::Unsigned8(0)), Err(Refusal::PdoInUse));
        write(&mut drive, 0x1800, 1, Value::Unsigned32(0x8000_0183)).unwrap();
        assert_eq!(write(&mut drive, 0x1A00, 3, torque), Err(Refusal::PdoInUse));
        write(&mut drive, 0x1A00, 0, Value::Unsigned8(0)).unwrap();
        write(&mut drive, 0x1A00, 3, torque).unwrap();
        write(&mut drive, 0x1A00, 0, Value::Unsigned8(3)).unwrap();
        write(&mut drive, 0x1800, 1, Value::Unsigned32(0x183)).unwrap();
    }

    #[test]
    fn only_what_fits_is_mapped() {
        let mut drive = drive();
        write(&mut drive, 0x1400, 1, Value::Unsigned32(0x8000_0203)).unwrap();
        write(&mut drive, 0x1600, 0, Value::Unsigned8(0)).unwrap();
        let mut map = |index, bits| {
            let mapping = Value::Unsigned32(MappingEntry::new(index, 0, bits).to_u32());
            write(&mut drive, 0x1600, 1, mapping)
        };
        assert_eq!(map(0x6041, 16), Err(Refusal::CannotBeMapped), "the drive's status is not the master's to write");
        assert_eq!(map(0x6071, 32), Err(Refusal::CannotBeMapped), "a target torque has 16 bits");
        assert_eq!(map(0x6502, 32), Err(Refusal::CannotBeMapped));
        assert_eq!(map(0x9999, 8), Err(Refusal::CannotBeMapped));
        assert_eq!(map(0x6071, 16), Ok(()));
    }

    #[test]
    fn a_pdo_in_use_keeps_its_identifier() {
        let mut drive = drive();
        assert_eq!(write(&mut drive, 0x1400, 1, Value::Unsigned32(0x303)), Err(Refusal::ValueRange));
        assert_eq!(write(&mut drive, 0x1400, 1, Value::Unsigned32(0x203)), Ok(()));
        assert_eq!(write(&mut drive, 0x1400, 1, Value::Unsigned32(0x8000_0303)), Ok(()));
        assert_eq!(write(&mut drive, 0x1400, 1, Value::Unsigned32(0x303)), Ok(()));
    }

    #[test]
    fn values_have_ranges() {
        let mut drive = drive();
        for (index, subindex, value) in [
            (0x1019, 0, Value::Unsigned8(1)),
            (0x1029, 1, Value::Unsigned8(3)),
            (0x1400, 2, Value::Unsigned8(241)),
            (0x1800, 2, Value::Unsigned8(255)),
            (0x6007, 0, Value::Integer16(4)),
            (0x605A, 0, Value::Integer16(2)),
            (0x6060, 0, Value::Integer8(8)),
            (0x6076, 0, Value::Unsigned32(0)),
            (0x60C2, 1, Value::Unsigned8(0)),
        ] {
            assert_eq!(write(&mut drive, index, subindex, value), Err(Refusal::ValueRange), "{index:x}");
        }
        assert_eq!(write(&mut drive, 0x6060, 0, Value::Integer8(10)), Ok(()));
    }

    #[test]
    fn refusals_reach_the_wire_as_aborts() {
        let drive = drive();
        let mode_8 = [0x2F, 0x60, 0x60, 0x00, 8, 0, 0, 0];
        assert_eq!(abort(&drive, &mode_8), Some([0x80, 0x60, 0x60, 0x00, 0x30, 0x00, 0x09, 0x06]));
        let mode_10 = [0x2F, 0x60, 0x60, 0x00, 10, 0, 0, 0];
        assert_eq!(abort(&drive, &mode_10), None);
        let segmented = [0x21, 0x60, 0x60, 0x00, 1, 0, 0, 0];
        assert_eq!(abort(&drive, &segmented), Some([0x80, 0x60, 0x60, 0x00, 0x01, 0x00, 0x04, 0x05]));
        let upload = [0x40, 0x60, 0x60, 0x00, 0, 0, 0, 0];
        assert_eq!(abort(&drive, &upload), None);
    }
}
