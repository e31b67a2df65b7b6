//! What the drive's SDO server refuses beyond types and access rights: values out of range, and PDO parameters changed
//! in an order that CiA 301 (7.5.2.36) does not allow. Real drives refuse the same, so a master is tested on it here.

use super::dictionary::Mappable;
use super::homing_state::HomingMethod;
use super::numbers::number_of;
use super::objects::DriveDictionary;
use canopen_rs::sync::is_valid_counter_overflow;
use canopen_rs::{Address, MappingEntry, ObjectDictionary, TransmissionType, Value, pdo};
use uarm_io::drive::cia402::PowerState;
use uarm_io::drive::objects as od;

/// Why an access is refused, as an SDO abort code (CiA 301, 7.2.4.3.17).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// Toggle bit not alternated.
    Toggle,
    /// Unsupported access: the PDO has to be switched off first.
    PdoInUse,
    /// Attempt to write a read only object.
    ReadOnly,
    /// No such object.
    NoObject,
    /// The object cannot be mapped to the PDO.
    CannotBeMapped,
    /// The mapped objects are longer than a PDO.
    TooLong,
    /// The parameter is incompatible with another one.
    Incompatible,
    /// More bytes than the object has.
    TooManyBytes,
    /// Fewer bytes than the object has.
    TooFewBytes,
    /// The object has no such sub-index.
    NoSubindex,
    /// Value out of range.
    ValueRange,
    /// Value too high.
    TooHigh,
    /// Value too low.
    TooLow,
    /// Not in the present state of the device.
    State,
    /// No data to give.
    NoData,
}

impl Refusal {
    /// The abort code.
    pub const fn code(self) -> u32 {
        match self {
            Self::Toggle => 0x0503_0000,
            Self::PdoInUse => 0x0601_0000,
            Self::ReadOnly => 0x0601_0002,
            Self::NoObject => 0x0602_0000,
            Self::CannotBeMapped => 0x0604_0041,
            Self::TooLong => 0x0604_0042,
            Self::Incompatible => 0x0604_0043,
            Self::TooManyBytes => 0x0607_0012,
            Self::TooFewBytes => 0x0607_0013,
            Self::NoSubindex => 0x0609_0011,
            Self::ValueRange => 0x0609_0030,
            Self::TooHigh => 0x0609_0031,
            Self::TooLow => 0x0609_0032,
            Self::State => 0x0800_0022,
            Self::NoData => 0x0800_0024,
        }
    }
}

/// What a write is judged by.
#[derive(Debug)]
pub struct Rules<'a, const N: usize> {
    /// The values in force.
    pub values: &'a ObjectDictionary<N>,
    /// The objects that the drive has.
    pub objects: &'a DriveDictionary,
    /// The state of the power stage.
    pub power: PowerState,
}

impl<const N: usize> Rules<'_, N> {
    /// Whether there is an object at `address`.
    pub fn exists(&self, address: Address) -> Result<(), Refusal> {
        match self.objects.object(address) {
            Some(_) => Ok(()),
            None if self.objects.has_index(address.index) => Err(Refusal::NoSubindex),
            None => Err(Refusal::NoObject),
        }
    }

    /// Whether `value` may be written.
    pub fn check(&self, address: Address, value: Value) -> Result<(), Refusal> {
        if let Some(number) = number_of(&value) {
            self.check_limits(address, number)?;
        }
        let in_range = match (address.index, address.subindex, value) {
            (0x1003, 0, Value::Unsigned8(count)) => count == 0,
            (0x1016, 1.., Value::Unsigned32(entry)) => return self.check_consumer(address, entry),
            (0x1019, 0, Value::Unsigned8(overflow)) => is_valid_counter_overflow(overflow),
            (0x1029, 1, Value::Unsigned8(behaviour)) => behaviour <= 2,
            (0x1400..=0x15FF | 0x1800..=0x19FF, 1, Value::Unsigned32(identifier)) => {
                return self.check_identifier(address, identifier);
            }
            (0x1400..=0x15FF, 2, Value::Unsigned8(kind)) => receives(kind),
            (0x1800..=0x19FF, 2, Value::Unsigned8(kind)) => transmits(kind),
            (0x1600..=0x17FF | 0x1A00..=0x1BFF, 0, Value::Unsigned8(count)) => {
                return self.check_count(address.index, count);
            }
            (0x1600..=0x17FF | 0x1A00..=0x1BFF, _, Value::Unsigned32(mapping)) => {
                return self.check_mapping(address.index, MappingEntry::from_u32(mapping));
            }
            (0x6007, 0, Value::Integer16(option)) => (0..=3).contains(&option),
            (0x605A, 0, Value::Integer16(option)) => (0..=8).contains(&option),
            (0x6060, 0, Value::Integer8(mode)) => mode == 0 || self.knows_mode(mode),
            (0x6075 | 0x6076, 0, Value::Unsigned32(_)) if self.power == PowerState::OperationEnabled => {
                return Err(Refusal::State);
            }
            (0x6075 | 0x6076, 0, Value::Unsigned32(rated)) => rated > 0,
            (0x6098, 0, Value::Integer8(method)) => method == 0 || HomingMethod::of(method.into()).is_some(),
            (0x60C2, 1, Value::Unsigned8(mantissa)) => mantissa > 0,
            _ => true,
        };
        if in_range { Ok(()) } else { Err(Refusal::ValueRange) }
    }

    /// The limits of a maker's dictionary. Words of several fields have none, whatever it says: an entry of 1016h with a
    /// node in it is no larger number than one without.
    fn check_limits(&self, address: Address, number: i128) -> Result<(), Refusal> {
        let is_packed = matches!((address.index, address.subindex), (0x1016 | 0x1600..=0x17FF | 0x1A00..=0x1BFF, 1..) | (0x1400..=0x15FF | 0x1800..=0x19FF, 1));
        let Some(object) = self.objects.object(address).filter(|_| !is_packed) else { return Ok(()) };
        if object.high.is_some_and(|high| number > high) {
            return Err(Refusal::TooHigh);
        }
        if object.low.is_some_and(|low| number < low) {
            return Err(Refusal::TooLow);
        }
        Ok(())
    }

    /// Bit n − 1 of 6502h stands for mode n.
    fn knows_mode(&self, mode: i8) -> bool {
        let modes = self.values.read(od::SUPPORTED_MODES.address()).ok().and_then(|modes| number_of(&modes));
        let bit = u32::try_from(mode).ok().and_then(|mode| mode.checked_sub(1)).and_then(|bit| 1_i128.checked_shl(bit));
        match (modes, bit) {
            (Some(modes), Some(bit)) => modes & bit != 0,
            (None, _) => mode == od::CYCLIC_SYNCHRONOUS_TORQUE,
            (Some(_), None) => false,
        }
    }

    /// An entry names a node of 1 to 127, or is unused; no two entries name one node.
    fn check_consumer(&self, address: Address, entry: u32) -> Result<(), Refusal> {
        let (node, time) = (entry >> 16, entry & 0xFFFF);
        if node > 127 || node == 0 && time != 0 {
            return Err(Refusal::ValueRange);
        }
        let others = self.objects.objects().iter().filter(|other| {
            other.address.index == address.index && other.address.subindex > 0 && other.address != address
        });
        let taken = others
            .filter_map(|other| number_of(&self.values.read(other.address).ok()?))
            .any(|other| other >> 16 == i128::from(node) && other & 0xFFFF != 0);
        if taken && time != 0 { Err(Refusal::Incompatible) } else { Ok(()) }
    }

    /// The identifier of a PDO in use may not change; it has to be switched off (bit 31) first.
    fn check_identifier(&self, address: Address, identifier: u32) -> Result<(), Refusal> {
        let Ok(Value::Unsigned32(current)) = self.values.read(address) else { return Ok(()) };
        let both_valid = pdo::pdo_is_valid(current) && pdo::pdo_is_valid(identifier);
        let changed = pdo::pdo_can_id(current) != pdo::pdo_can_id(identifier);
        if identifier & EXTENDED != 0 || both_valid && changed { Err(Refusal::ValueRange) } else { Ok(()) }
    }

    /// A mapping may change only while its PDO is switched off.
    fn pdo_is_off(&self, mapping_index: u16) -> Result<(), Refusal> {
        // 1600h belongs to 1400h, 1A00h to 1800h.
        match self.values.read(Address::new(mapping_index - 0x200, 1)) {
            Ok(Value::Unsigned32(identifier)) if pdo::pdo_is_valid(identifier) => Err(Refusal::PdoInUse),
            _ => Ok(()),
        }
    }

    fn check_count(&self, index: u16, count: u8) -> Result<(), Refusal> {
        self.pdo_is_off(index)?;
        let longest =
            self.objects.objects().iter().filter(|object| object.address.index == index).count().saturating_sub(1);
        if usize::from(count) > longest || count > LONGEST_MAPPING {
            return Err(Refusal::TooLong);
        }
        let mut bits = 0_u32;
        for subindex in 1..=count {
            let Ok(Value::Unsigned32(mapping)) = self.values.read(Address::new(index, subindex)) else { continue };
            self.check_mappable(index, MappingEntry::from_u32(mapping))?;
            bits += u32::from(MappingEntry::from_u32(mapping).bit_length);
        }
        if bits > 64 { Err(Refusal::TooLong) } else { Ok(()) }
    }

    fn check_mapping(&self, index: u16, mapping: MappingEntry) -> Result<(), Refusal> {
        self.pdo_is_off(index)?;
        match self.values.read(Address::new(index, 0)) {
            Ok(Value::Unsigned8(0)) => {}
            _ => return Err(Refusal::PdoInUse),
        }
        // Zero empties the entry.
        if mapping.to_u32() == 0 { Ok(()) } else { self.check_mappable(index, mapping) }
    }

    fn check_mappable(&self, index: u16, mapping: MappingEntry) -> Result<(), Refusal> {
        let receives = index < 0x1800;
        let fits = self.objects.object(mapping.address).is_some_and(|object| match object.mappable {
            Mappable::No => false,
            Mappable::Transmit => !receives,
            Mappable::Receive => true,
        });
        let bytes = self.values.entry(mapping.address).map(|entry| entry.value.size());
        let same_width = bytes.is_some_and(|bytes| usize::from(mapping.bit_length) == 8 * bytes);
        if fits && same_width { Ok(()) } else { Err(Refusal::CannotBeMapped) }
    }
}

/// Bit 29 of a PDO's identifier: a 29-bit identifier, which this drive does not know.
const EXTENDED: u32 = 1 << 29;
/// A PDO has eight bytes, and no object less than one.
const LONGEST_MAPPING: u8 = 8;

/// Transmission types that an RPDO of this drive knows: at SYNC, or on reception.
fn receives(kind: u8) -> bool {
    use TransmissionType::{EventDrivenManufacturer, EventDrivenProfile, SynchronousAcyclic, SynchronousCyclic};
    matches!(
        TransmissionType::from_byte(kind),
        Ok(SynchronousAcyclic | SynchronousCyclic(_) | EventDrivenManufacturer | EventDrivenProfile)
    )
}

/// Transmission types that a TPDO of this drive knows: the same. It answers no remote frames.
fn transmits(kind: u8) -> bool {
    receives(kind)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::dictionary::CAPACITY;
    use crate::drive::parameters::{DriveParameters, tests::description};

    struct Drive {
        objects: DriveDictionary,
        values: ObjectDictionary<CAPACITY>,
        power: PowerState,
    }

    fn drive() -> Drive {
        let objects = DriveDictionary::own(&DriveParameters::new(description(3)).unwrap());
        Drive { values: objects.at_power_on(), objects, power: PowerState::SwitchOnDisabled }
    }

    fn write(drive: &mut Drive, index: u16, subindex: u8, value: Value) -> Result<(), Refusal> {
        let address = Address::new(index, subindex);
        let rules = Rules { values: &drive.values, objects: &drive.objects, power: drive.power };
        rules.exists(address)?;
        rules.check(address, value)?;
        drive.values.write(address, value).unwrap();
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
            (0x1003, 0, Value::Unsigned8(1)),
            (0x1800, 2, Value::Unsigned8(253)),
            (0x6007, 0, Value::Integer16(4)),
            (0x605A, 0, Value::Integer16(9)),
            (0x6060, 0, Value::Integer8(8)),
            (0x6098, 0, Value::Integer8(1)),
            (0x6076, 0, Value::Unsigned32(0)),
            (0x60C2, 1, Value::Unsigned8(0)),
        ] {
            assert_eq!(write(&mut drive, index, subindex, value), Err(Refusal::ValueRange), "{index:x}");
        }
        assert_eq!(write(&mut drive, 0x6060, 0, Value::Integer8(10)), Ok(()));
    }

    #[test]
    fn a_heartbeats_sender_is_a_node_and_named_once() {
        let mut drive = drive();
        let consumer = |node: u32, time: u32| Value::Unsigned32(node << 16 | time);
        assert_eq!(write(&mut drive, 0x1016, 1, consumer(200, 50)), Err(Refusal::ValueRange));
        assert_eq!(write(&mut drive, 0x1016, 1, consumer(0, 50)), Err(Refusal::ValueRange));
        assert_eq!(write(&mut drive, 0x1016, 1, consumer(127, 50)), Ok(()));
        assert_eq!(write(&mut drive, 0x1016, 1, consumer(0, 0)), Ok(()));
        assert_eq!(write(&mut drive, 0x1016, 2, consumer(127, 50)), Err(Refusal::NoSubindex));
        assert_eq!(write(&mut drive, 0x1015, 0, consumer(0, 0)), Err(Refusal::NoObject));
    }

    #[test]
    fn ratings_stand_while_the_motor_is_on() {
        let mut drive = drive();
        assert_eq!(write(&mut drive, 0x6076, 0, Value::Unsigned32(100)), Ok(()));
        drive.power = PowerState::OperationEnabled;
        assert_eq!(write(&mut drive, 0x6076, 0, Value::Unsigned32(200)), Err(Refusal::State));
    }

    /// Elmo's dictionary limits 1016h to 65535, which has no room for a node.
    #[test]
    fn a_makers_limits_hold_but_for_packed_words() {
        let mut drive = drive();
        let limited = |object: &crate::drive::objects::DriveObject| match object.address.index {
            0x1016 | 0x1017 => crate::drive::objects::DriveObject { low: Some(10), high: Some(65_535), ..*object },
            _ => *object,
        };
        let parameters = DriveParameters::new(description(3)).unwrap();
        drive.objects = DriveDictionary::of_maker(&parameters, drive.objects.objects().iter().map(limited));
        assert_eq!(write(&mut drive, 0x1017, 0, Value::Unsigned16(9)), Err(Refusal::TooLow));
        assert_eq!(write(&mut drive, 0x1017, 0, Value::Unsigned16(10)), Ok(()));
        assert_eq!(write(&mut drive, 0x1016, 1, Value::Unsigned32(0x007F_0032)), Ok(()));
    }
}
