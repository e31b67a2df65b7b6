//! What a file describes in few lines for many objects (CiA 306-1): arrays of equal entries, and PDOs.

use crate::number::integer;
use crate::object::{Access, Object};
use crate::reader::{OfEntries, Place, Reader, place};
use crate::text::Section;
use crate::value::{Kind, Stated, Value};
use canopen_rs::{Address, DataType};

/// The highest sub-index of an entry: 255 describes the object itself.
const HIGHEST_SUBINDEX: u8 = 254;
/// How many PDOs of a kind there can be (CiA 301).
const MOST_PDOS: u16 = 512;
/// An identifier with this bit (31) is that of a PDO that is off.
const PDO_OFF: i128 = 1 << 31;
/// Objects that a PDO can carry, at most.
const MOST_MAPPED: u8 = 64;
/// From the index of a PDO's communication parameter to that of its mapping.
const TO_MAPPING: u16 = 0x200;

/// The sub-indices of a PDO's communication parameter: bit n of `CompactPDO` is the entry at place n.
const COMMUNICATION: [(u8, &str, DataType); 6] = [
    (1, "COB-ID", DataType::Unsigned32),
    (2, "Transmission type", DataType::Unsigned8),
    (3, "Inhibit time", DataType::Unsigned16),
    (4, "Compatibility entry", DataType::Unsigned8),
    (5, "Event timer", DataType::Unsigned16),
    (6, "SYNC start value", DataType::Unsigned8),
];

/// The PDOs of one direction.
struct Direction {
    /// The key that tells how many there are.
    key: &'static str,
    /// The index of the first's communication parameter.
    first: u16,
    /// The predefined identifiers of the first four, less the node's id (CiA 301, predefined connection set).
    identifiers: [i128; 4],
}

const DIRECTIONS: [Direction; 2] = [
    Direction { key: "nrofrxpdo", first: 0x1400, identifiers: [0x200, 0x300, 0x400, 0x500] },
    Direction { key: "nroftxpdo", first: 0x1800, identifiers: [0x180, 0x280, 0x380, 0x480] },
];

impl Reader<'_> {
    /// An array of which all entries are alike (`CompactSubObj`).
    pub fn compact_array(&mut self, section: &Section, index: u16, count: i128) {
        let Some(count) = u8::try_from(count).ok().filter(|count| *count <= HIGHEST_SUBINDEX) else {
            return self.refuse(section, "compactsubobj", format!("0 to {HIGHEST_SUBINDEX} entries"));
        };
        let Some(pattern) = self.object(section, Address::new(index, 1), false) else { return };
        let number = entry(Address::new(index, 0), "NrOfObjects", DataType::Unsigned8, Access::ReadOnly);
        self.insert(section, Object { default: fixed(count.into()), ..number });
        for subindex in 1..=count {
            let name = format!("{}{subindex}", pattern.name);
            self.insert(section, Object { address: Address::new(index, subindex), name, ..pattern.clone() });
        }
    }

    /// `[1003Value]`: `3=0x10` configures entry 3; `[1003Name]`: `3=Third` names it.
    pub fn compact_entries(&mut self, section: &Section) {
        let Some(Place::Entries(index, what)) = place(&section.name) else { return };
        for (key, entry) in
            section.entries.iter().filter(|(key, entry)| *key != "nrofentries" && !entry.value.is_empty())
        {
            let subindex = integer(key).and_then(|subindex| u8::try_from(subindex).ok());
            let object = subindex.and_then(|subindex| self.objects.get_mut(&Address::new(index, subindex)));
            let Some(object) = object else {
                self.refuse(section, key, "the sub-index of an entry as key");
                continue;
            };
            match what {
                OfEntries::Names => object.name.clone_from(&entry.value),
                OfEntries::Values => match Stated::parse(object.kind, &entry.value) {
                    Ok(value) => object.configured = Some(value),
                    Err(expected) => self.refuse(section, key, expected),
                },
            }
        }
    }

    /// PDOs without sections of their own, as `[DeviceInfo]` has them: `CompactPDO` tells which parameters each has, `NrOfRXPDO`
    /// and `NrOfTXPDO` how many PDOs there are with those that have sections.
    ///
    /// The first four have the predefined identifiers, the others are off; mappings can be changed, and what they are is not said.
    pub fn compact_pdos(&mut self, section: &Section) {
        let Some(mask) = self.number(section, "compactpdo").filter(|mask| *mask != 0) else { return };
        for direction in DIRECTIONS {
            let Some(count) = self.number(section, direction.key) else { continue };
            let Some(count) = u16::try_from(count).ok().filter(|count| *count <= MOST_PDOS) else {
                self.refuse(section, direction.key, format!("0 to {MOST_PDOS} PDOs"));
                continue;
            };
            let own = (0..MOST_PDOS).filter(|offset| self.has_pdo(&direction, *offset)).count();
            let mut missing = usize::from(count).saturating_sub(own);
            for offset in 0..MOST_PDOS {
                if !self.has_pdo(&direction, offset) {
                    let Some(fewer) = missing.checked_sub(1) else { continue };
                    missing = fewer;
                }
                self.compact_pdo(&direction, offset, mask);
            }
        }
    }

    fn has_pdo(&self, direction: &Direction, offset: u16) -> bool {
        self.has(direction.first + offset) || self.has(direction.first + TO_MAPPING + offset)
    }

    fn has(&self, index: u16) -> bool {
        self.objects.range(Address::new(index, 0)..=Address::new(index, u8::MAX)).next().is_some()
    }

    /// Adds what a PDO has no section for.
    fn compact_pdo(&mut self, direction: &Direction, offset: u16, mask: i128) {
        let (communication, mapping) = (direction.first + offset, direction.first + TO_MAPPING + offset);
        if !self.has(communication) {
            let entries = COMMUNICATION.iter().enumerate().filter(|(bit, _)| mask >> bit & 1 == 1);
            let mut highest = 0;
            for (_, (subindex, name, data_type)) in entries {
                let mut object = entry(Address::new(communication, *subindex), name, *data_type, Access::ReadWrite);
                if *subindex == 1 {
                    let predefined = direction.identifiers.get(usize::from(offset));
                    object.default =
                        predefined.map_or_else(|| fixed(PDO_OFF), |identifier| Some(Stated::WithNode(*identifier)));
                }
                self.add(object);
                highest = *subindex;
            }
            let number = entry(Address::new(communication, 0), HIGHEST_NAME, DataType::Unsigned8, Access::Constant);
            self.add(Object { default: fixed(highest.into()), ..number });
        }
        if !self.has(mapping) {
            self.add(entry(Address::new(mapping, 0), HIGHEST_NAME, DataType::Unsigned8, Access::ReadWrite));
            for subindex in 1..=MOST_MAPPED {
                let name = format!("Application object {subindex}");
                self.add(entry(Address::new(mapping, subindex), &name, DataType::Unsigned32, Access::ReadWrite));
            }
        }
    }

    fn add(&mut self, object: Object) {
        self.objects.insert(object.address, object);
    }
}

const HIGHEST_NAME: &str = "Highest sub-index supported";

fn fixed(number: i128) -> Option<Stated> {
    Some(Stated::Fixed(Value::Integer(number)))
}

/// An entry without a value and without limits.
fn entry(address: Address, name: &str, data_type: DataType, access: Access) -> Object {
    Object {
        address,
        name: name.to_owned(),
        kind: Kind::Basic(data_type),
        access,
        mappable: false,
        default: None,
        configured: None,
        low: None,
        high: None,
    }
}
