//! Which objects a drive has: its own, or those of a maker's dictionary.

use super::dictionary::{Mappable, OBJECTS};
use super::numbers::{number_of, zero_of};
use super::parameters::DriveParameters;
use alloc::boxed::Box;
use alloc::vec::Vec;
use canopen_rs::object_dictionary::AccessType;
use canopen_rs::{Address, DataType, Entry, ObjectDictionary, Value};

/// An object as a drive has it at power-on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveObject {
    /// Where it is.
    pub address: Address,
    /// The type of its value.
    pub data_type: DataType,
    /// What the master may do with it.
    pub access: AccessType,
    /// Whether it may be part of a PDO.
    pub mappable: Mappable,
    /// Its value at power-on; `None` leaves it to the emulation.
    pub value: Option<Value>,
    /// The smallest number that it takes.
    pub low: Option<i128>,
    /// The largest number that it takes.
    pub high: Option<i128>,
}

/// Why a dictionary is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum DictionaryError {
    /// More objects than the drive holds.
    #[error("{found} objects, expected at most {most}")]
    TooManyObjects {
        /// How many there are.
        found: usize,
        /// How many the drive can hold.
        most: usize,
    },
    /// Not there, or of another type.
    #[error("object {index:04X}h:{subindex:02X}: {value:?} is not its type, or there is no such object")]
    Value {
        /// Its index.
        index: u16,
        /// Its sub-index.
        subindex: u8,
        /// What was to be its value.
        value: Value,
    },
}

/// All objects of a drive, at power-on.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveDictionary {
    objects: Box<[DriveObject]>,
}

impl DriveDictionary {
    /// The emulated drive's own, as the EDS file of `uarm-io` describes it.
    pub fn own(drive: &DriveParameters) -> Self {
        let objects = OBJECTS.iter().map(|object| {
            let value = (object.default)(drive);
            DriveObject {
                address: object.address,
                data_type: value.data_type(),
                access: object.access,
                mappable: object.mappable,
                value: Some(value),
                low: None,
                high: None,
            }
        });
        Self { objects: objects.collect() }
    }

    /// A maker's objects. Where one has no value, the emulated drive's own object of that address lends it, or it is zero.
    ///
    /// A number of the identity (1018h) or a rating (6075h, 6076h, 608Fh) that cannot be written and is said to be 0 has the emulated
    /// drive's value too: a dictionary that says so knows nothing of the drive or its motor.
    pub fn of_maker(drive: &DriveParameters, objects: impl IntoIterator<Item = DriveObject>) -> Self {
        let mut objects: Vec<DriveObject> = objects.into_iter().collect();
        objects.sort_by_key(|object| object.address);
        objects.dedup_by_key(|object| object.address);
        for object in &mut objects {
            let is_rating = matches!(object.address.index, 0x1018 | 0x6075 | 0x6076 | 0x608F);
            if is_rating && !object.access.is_writable() && object.value.and_then(|value| number_of(&value)) == Some(0)
            {
                object.value = None;
            }
            object.value = object.value.or_else(|| lent(drive, object));
        }
        Self { objects: objects.into_boxed_slice() }
    }

    /// The same with another value at power-on: what a drive has stored.
    ///
    /// # Errors
    /// [`DictionaryError::Value`] if there is no such object, or the value is not of its type.
    pub fn storing(mut self, address: Address, value: Value) -> Result<Self, DictionaryError> {
        let object = self.objects.iter_mut().find(|object| object.address == address);
        match object.filter(|object| object.data_type == value.data_type()) {
            Some(object) => object.value = Some(value),
            None => {
                return Err(DictionaryError::Value { index: address.index, subindex: address.subindex, value });
            }
        }
        Ok(self)
    }

    /// All of them.
    pub fn objects(&self) -> &[DriveObject] {
        &self.objects
    }

    /// One of them.
    pub fn object(&self, address: Address) -> Option<&DriveObject> {
        let position = self.objects.binary_search_by_key(&address, |object| object.address).ok()?;
        self.objects.get(position)
    }

    /// Whether there is any object of this index.
    pub(super) fn has_index(&self, index: u16) -> bool {
        let first = self.objects.partition_point(|object| object.address.index < index);
        self.objects.get(first).is_some_and(|object| object.address.index == index)
    }

    /// As the protocol stack holds them at power-on.
    pub(super) fn at_power_on<const N: usize>(&self) -> ObjectDictionary<N> {
        let mut dictionary = ObjectDictionary::new();
        // The stack searches from the front: first what each cycle needs, then what a start needs, then the maker's.
        for rank in Rank::ALL {
            for object in self.objects.iter().filter(|object| Rank::of(object.address) == rank) {
                if let Some(value) = object.value {
                    // Never full: the number was checked when the drive was made.
                    let _ = dictionary.insert(object.address, Entry { value, access: object.access });
                }
            }
        }
        dictionary
    }
}

/// How often an object is needed.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Rank {
    Cycle,
    /// What says of what PDOs are made.
    Pdo,
    Start,
    Maker,
}

impl Rank {
    const ALL: [Self; 4] = [Self::Cycle, Self::Pdo, Self::Start, Self::Maker];

    fn of(address: Address) -> Self {
        const FIRST_OF_PROFILE: u16 = 0x6000;
        const PDOS: core::ops::RangeInclusive<u16> = 0x1400..=0x1BFF;
        match OBJECTS.binary_search_by_key(&address, |object| object.address) {
            Ok(_) if address.index >= FIRST_OF_PROFILE => Self::Cycle,
            Ok(_) if PDOS.contains(&address.index) => Self::Pdo,
            Ok(_) => Self::Start,
            Err(_) => Self::Maker,
        }
    }
}

fn lent(drive: &DriveParameters, object: &DriveObject) -> Option<Value> {
    let own = OBJECTS.iter().find(|own| own.address == object.address).map(|own| (own.default)(drive));
    own.filter(|value| value.data_type() == object.data_type).or_else(|| zero_of(object.data_type))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::parameters::tests::description;

    fn drive() -> DriveParameters {
        DriveParameters::new(description(3)).unwrap()
    }

    fn object(index: u16, data_type: DataType, access: AccessType, value: Option<Value>) -> DriveObject {
        let address = Address::new(index, 0);
        DriveObject { address, data_type, access, mappable: Mappable::No, value, low: None, high: None }
    }

    #[test]
    fn a_value_that_the_maker_does_not_state_is_the_drives_own_or_zero() {
        let dictionary = DriveDictionary::of_maker(
            &drive(),
            [
                object(0x6502, DataType::Unsigned32, AccessType::Ro, None),
                object(0x6076, DataType::Unsigned32, AccessType::Ro, Some(Value::Unsigned32(0))),
                object(0x2000, DataType::Integer16, AccessType::Rw, None),
                object(0x6075, DataType::Unsigned32, AccessType::Rw, Some(Value::Unsigned32(0))),
            ],
        );
        let value = |index| dictionary.object(Address::new(index, 0)).unwrap().value;
        assert_eq!(value(0x6502), Some(Value::Unsigned32(0x220)));
        assert_eq!(value(0x6076), Some(Value::Unsigned32(200)), "a rating of 0 that nobody can set is no rating");
        assert_eq!(value(0x6075), Some(Value::Unsigned32(0)), "this one is to be set");
        assert_eq!(value(0x2000), Some(Value::Integer16(0)));
        assert!(dictionary.has_index(0x2000) && !dictionary.has_index(0x1000) && !dictionary.has_index(0x7000));
    }

    #[test]
    fn what_a_drive_has_stored_must_fit_the_object() {
        let own = DriveDictionary::own(&drive());
        let stored = own.clone().storing(Address::new(0x1017, 0), Value::Unsigned16(50)).unwrap();
        assert_eq!(stored.object(Address::new(0x1017, 0)).unwrap().value, Some(Value::Unsigned16(50)));
        assert!(own.clone().storing(Address::new(0x1017, 0), Value::Unsigned32(50)).is_err());
        assert!(own.storing(Address::new(0x2017, 0), Value::Unsigned32(50)).is_err());
    }
}
