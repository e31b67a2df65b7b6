//! Sections to objects.

use crate::number::integer;
use crate::object::{Access, Object};
use crate::problem::Problem;
use crate::text::Section;
use crate::value::{Kind, Stated};
use canopen_rs::{Address, DataType};
use std::collections::BTreeMap;

/// What a section says of the entries of a compact array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OfEntries {
    Values,
    Names,
}

/// Which object a section describes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// `[1018]`: a variable, or the head of an array or record.
    Index(u16),
    /// `[1018sub1]`.
    Entry(Address),
    /// `[1003Value]`, `[1003Name]`: what the entries of a compact array have of their own.
    Entries(u16, OfEntries),
}

pub fn place(name: &str) -> Option<Place> {
    let (digits, rest) = name.split_at_checked(4)?;
    let hexadecimal = |digits: &str| digits.bytes().all(|digit| digit.is_ascii_hexdigit());
    let index = u16::from_str_radix(digits, 16).ok().filter(|_| hexadecimal(digits))?;
    let rest = rest.to_ascii_lowercase();
    if rest.is_empty() {
        return Some(Place::Index(index));
    }
    match rest.as_str() {
        "value" => return Some(Place::Entries(index, OfEntries::Values)),
        "name" => return Some(Place::Entries(index, OfEntries::Names)),
        _ => {}
    }
    let subindex = rest.strip_prefix("sub").filter(|digits| hexadecimal(digits))?;
    Some(Place::Entry(Address::new(index, u8::from_str_radix(subindex, 16).ok()?)))
}

/// Codes of `ObjectType` that hold no value themselves (CiA 301, table 42).
const ARRAY: i128 = 8;
const RECORD: i128 = 9;
/// A large block of data.
const DOMAIN: i128 = 2;
/// Descriptions of types, not objects.
const TYPE_DEFINITIONS: [i128; 2] = [5, 6];

pub struct Reader<'a> {
    pub file: &'a str,
    pub problems: Vec<Problem>,
    pub objects: BTreeMap<Address, Object>,
}

impl Reader<'_> {
    /// Keeps what is wrong with a key; without an entry of that key, it is the section that lacks it.
    pub fn refuse(&mut self, section: &Section, key: &str, expected: impl Into<String>) {
        let entry = section.entries.get(key);
        self.problems.push(Problem {
            file: self.file.to_owned(),
            line: entry.map_or(section.line, |entry| entry.line),
            section: section.name.clone(),
            key: key.to_owned(),
            value: entry.map(|entry| entry.value.clone()).unwrap_or_default(),
            expected: expected.into(),
        });
    }

    pub fn number(&mut self, section: &Section, key: &str) -> Option<i128> {
        let entry = section.get(key)?;
        let number = integer(&entry.value);
        if number.is_none() {
            self.refuse(section, key, "a number");
        }
        number
    }

    pub fn section(&mut self, section: &Section) {
        let place = match place(&section.name) {
            Some(Place::Index(index)) => Address::new(index, 0),
            Some(Place::Entry(address)) => address,
            Some(Place::Entries(..)) | None => return,
        };
        let is_head = !section.name.to_ascii_lowercase().contains("sub");
        let object_type = self.number(section, "objecttype");
        let compact = if is_head { self.number(section, "compactsubobj").filter(|count| *count != 0) } else { None };
        match (object_type, compact) {
            (Some(kind), _) if TYPE_DEFINITIONS.contains(&kind) => {}
            (_, Some(count)) => self.compact_array(section, place.index, count),
            (Some(ARRAY | RECORD), None) if is_head => {}
            // A head without a type but with a number of entries.
            (None, None) if is_head && section.get("subnumber").is_some() && section.get("datatype").is_none() => {}
            (object_type, _) => {
                if let Some(object) = self.object(section, place, object_type == Some(DOMAIN)) {
                    self.insert(section, object);
                }
            }
        }
    }

    pub fn insert(&mut self, section: &Section, object: Object) {
        let address = object.address;
        if let Some(first) = self.objects.get(&address) {
            if *first != object {
                self.refuse(section, "", "one section for each object; the first holds");
            }
            return;
        }
        self.objects.insert(address, object);
    }

    pub fn object(&mut self, section: &Section, address: Address, is_domain: bool) -> Option<Object> {
        let kind = self.kind(section, is_domain)?;
        let access = self.access(section, is_domain)?;
        let name = section.get("parametername").map(|entry| entry.value.clone()).unwrap_or_default();
        let mappable = self.number(section, "pdomapping").is_some_and(|mapping| mapping != 0);
        Some(Object {
            address,
            name,
            kind,
            access,
            mappable,
            default: self.stated(section, kind, "defaultvalue"),
            configured: self.stated(section, kind, "parametervalue"),
            low: self.stated(section, kind, "lowlimit"),
            high: self.stated(section, kind, "highlimit"),
        })
    }

    fn kind(&mut self, section: &Section, is_domain: bool) -> Option<Kind> {
        if section.get("datatype").is_none() && is_domain {
            return Some(Kind::Basic(DataType::Domain));
        }
        let index = section.get("datatype").and_then(|entry| u16::try_from(integer(&entry.value)?).ok());
        if index.is_none() {
            self.refuse(section, "datatype", "the index of a data type, such as 0x0007");
        }
        index.map(Kind::from_index)
    }

    fn access(&mut self, section: &Section, is_domain: bool) -> Option<Access> {
        if section.get("accesstype").is_none() && is_domain {
            return Some(Access::ReadWrite);
        }
        let access = section.get("accesstype").and_then(|entry| Access::parse(&entry.value));
        if access.is_none() {
            self.refuse(section, "accesstype", "ro, wo, rw, rwr, rww or const");
        }
        access
    }

    fn stated(&mut self, section: &Section, kind: Kind, key: &str) -> Option<Stated> {
        let entry = section.get(key)?;
        match Stated::parse(kind, &entry.value) {
            Ok(stated) => Some(stated),
            Err(expected) => {
                self.refuse(section, key, expected);
                None
            }
        }
    }
}
