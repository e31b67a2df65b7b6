//! All objects of a file, and the device that has them.

use crate::number::integer;
use crate::object::{Access, Object};
use crate::problem::Problem;
use crate::text::{Section, decode, sections};
use crate::value::{Kind, Stated, Value};
use canopen_rs::{Address, DataType};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Larger files are refused: the largest known has 200 kB.
const LARGEST_FILE: usize = 4 << 20;
/// More objects are refused. A compact array stands for 254 in a few lines.
const MOST_OBJECTS: usize = 200_000;
/// The highest sub-index of an entry: 255 describes the object itself.
const HIGHEST_SUBINDEX: u8 = 254;

/// Why a file is no dictionary.
#[derive(Debug, thiserror::Error)]
pub enum EdsError {
    /// The file cannot be read.
    #[error("{}", file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// Too many bytes.
    #[error("{file}: {found} bytes, expected at most {LARGEST_FILE}")]
    TooLarge {
        /// The file's name.
        file: String,
        /// Its size.
        found: usize,
    },
    /// Too many objects.
    #[error("{file}: more than {MOST_OBJECTS} objects")]
    TooManyObjects {
        /// The file's name.
        file: String,
    },
    /// Nothing in it describes an object.
    #[error(
        "{file}: found no object, expected an EDS or DCF file (CiA 306) with sections such as [1000]{}",
        first.as_ref().map_or_else(String::new, |problem| format!("; {problem}"))
    )]
    NoObjects {
        /// The file's name.
        file: String,
        /// The first thing in it that could not be read.
        first: Option<Box<Problem>>,
    },
}

/// What `[DeviceInfo]` says.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Device {
    /// The maker's name.
    pub vendor_name: Option<String>,
    /// The maker's number at CiA, as 1018h:01 tells it.
    pub vendor_number: Option<u32>,
    /// The product's name.
    pub product_name: Option<String>,
    /// The product's number, as 1018h:02 tells it.
    pub product_number: Option<u32>,
}

/// An EDS or DCF file.
#[derive(Clone, Debug)]
pub struct Dictionary {
    file: String,
    device: Device,
    node: Option<u8>,
    objects: BTreeMap<Address, Object>,
    problems: Vec<Problem>,
}

impl Dictionary {
    /// Reads a file.
    ///
    /// # Errors
    /// [`EdsError`] if it cannot be read or is no dictionary.
    pub fn read(path: &Path) -> Result<Self, EdsError> {
        let bytes = std::fs::read(path).map_err(|source| EdsError::File { file: path.to_owned(), source })?;
        Self::parse(&path.display().to_string(), &bytes)
    }

    /// Reads the bytes of a file whose name messages shall tell.
    ///
    /// # Errors
    /// [`EdsError`] if they are no dictionary.
    pub fn parse(file: &str, bytes: &[u8]) -> Result<Self, EdsError> {
        if bytes.len() > LARGEST_FILE {
            return Err(EdsError::TooLarge { file: file.to_owned(), found: bytes.len() });
        }
        let mut problems = Vec::new();
        let sections = sections(file, &decode(bytes), &mut problems);
        let mut reader = Reader { file, problems, objects: BTreeMap::new() };
        for section in &sections {
            reader.section(section);
            if reader.objects.len() > MOST_OBJECTS {
                return Err(EdsError::TooManyObjects { file: file.to_owned() });
            }
        }
        for section in &sections {
            reader.compact_values(section);
        }
        let Reader { objects, problems, .. } = reader;
        if objects.is_empty() {
            return Err(EdsError::NoObjects {
                file: file.to_owned(),
                first: problems.into_iter().next().map(Box::new),
            });
        }
        let (device, node) = (device(&sections), node(&sections));
        Ok(Self { file: file.to_owned(), device, node, objects, problems })
    }

    /// The file's name.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// The device.
    pub const fn device(&self) -> &Device {
        &self.device
    }

    /// The node that a DCF was made for, 1 to 127.
    pub const fn node(&self) -> Option<u8> {
        self.node
    }

    /// An object.
    pub fn object(&self, address: Address) -> Option<&Object> {
        self.objects.get(&address)
    }

    /// The value of an object at a node, if the file states one.
    pub fn value(&self, address: Address, node: u8) -> Option<Value> {
        self.object(address)?.value(node)
    }

    /// All objects, by index and sub-index.
    pub fn objects(&self) -> impl Iterator<Item = &Object> {
        self.objects.values()
    }

    /// What could not be read, in the order of the file.
    pub fn problems(&self) -> &[Problem] {
        &self.problems
    }
}

/// Which object a section describes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    /// `[1018]`: a variable, or the head of an array or record.
    Index(u16),
    /// `[1018sub1]`.
    Entry(Address),
    /// `[1018Value]`: values of a compact array.
    Values(u16),
}

fn place(name: &str) -> Option<Place> {
    let (digits, rest) = name.split_at_checked(4)?;
    let hexadecimal = |digits: &str| digits.bytes().all(|digit| digit.is_ascii_hexdigit());
    let index = u16::from_str_radix(digits, 16).ok().filter(|_| hexadecimal(digits))?;
    let rest = rest.to_ascii_lowercase();
    if rest.is_empty() {
        return Some(Place::Index(index));
    }
    if rest == "value" {
        return Some(Place::Values(index));
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

struct Reader<'a> {
    file: &'a str,
    problems: Vec<Problem>,
    objects: BTreeMap<Address, Object>,
}

impl Reader<'_> {
    /// Keeps what is wrong with a key; without an entry of that key, it is the section that lacks it.
    fn refuse(&mut self, section: &Section, key: &str, expected: impl Into<String>) {
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

    fn number(&mut self, section: &Section, key: &str) -> Option<i128> {
        let entry = section.get(key)?;
        let number = integer(&entry.value);
        if number.is_none() {
            self.refuse(section, key, "a number");
        }
        number
    }

    fn section(&mut self, section: &Section) {
        let place = match place(&section.name) {
            Some(Place::Index(index)) => Address::new(index, 0),
            Some(Place::Entry(address)) => address,
            Some(Place::Values(_)) | None => return,
        };
        let is_head = !section.name.to_ascii_lowercase().contains("sub");
        let object_type = self.number(section, "objecttype");
        match object_type {
            Some(kind) if TYPE_DEFINITIONS.contains(&kind) => {}
            Some(ARRAY | RECORD) if is_head => self.compact(section, place.index),
            _ if is_head && section.get("compactsubobj").is_some() => self.compact(section, place.index),
            // A head without a type but with a number of entries.
            None if is_head && section.get("subnumber").is_some() && section.get("datatype").is_none() => {}
            object_type => {
                if let Some(object) = self.object(section, place, object_type == Some(DOMAIN)) {
                    self.insert(section, object);
                }
            }
        }
    }

    fn insert(&mut self, section: &Section, object: Object) {
        let address = object.address;
        if let Some(first) = self.objects.get(&address) {
            if *first != object {
                self.refuse(section, "", "one section for each object; the first holds");
            }
            return;
        }
        self.objects.insert(address, object);
    }

    /// An array of which all entries are alike (CiA 306-1, 4.5.3).
    fn compact(&mut self, section: &Section, index: u16) {
        let Some(count) = self.number(section, "compactsubobj") else { return };
        let Some(count) = u8::try_from(count).ok().filter(|count| *count <= HIGHEST_SUBINDEX) else {
            return self.refuse(section, "compactsubobj", format!("0 to {HIGHEST_SUBINDEX} entries"));
        };
        let Some(pattern) = self.object(section, Address::new(index, 1), false) else { return };
        let number = Object {
            address: Address::new(index, 0),
            name: "NrOfObjects".into(),
            kind: Kind::Basic(DataType::Unsigned8),
            access: Access::ReadOnly,
            mappable: false,
            default: Some(Stated::Fixed(Value::Integer(count.into()))),
            configured: None,
            low: None,
            high: None,
        };
        self.insert(section, number);
        for subindex in 1..=count {
            let name = format!("{}{subindex}", pattern.name);
            self.insert(section, Object { address: Address::new(index, subindex), name, ..pattern.clone() });
        }
    }

    /// `[1003Value]`: `3=0x10` configures entry 3.
    fn compact_values(&mut self, section: &Section) {
        let Some(Place::Values(index)) = place(&section.name) else { return };
        for (key, entry) in
            section.entries.iter().filter(|(key, entry)| *key != "nrofentries" && !entry.value.is_empty())
        {
            let subindex = integer(key).and_then(|subindex| u8::try_from(subindex).ok());
            let object = subindex.and_then(|subindex| self.objects.get_mut(&Address::new(index, subindex)));
            let Some(object) = object else {
                self.refuse(section, key, "the sub-index of an entry as key");
                continue;
            };
            match Stated::parse(object.kind, &entry.value) {
                Ok(value) => object.configured = Some(value),
                Err(expected) => self.refuse(section, key, expected),
            }
        }
    }

    fn object(&mut self, section: &Section, address: Address, is_domain: bool) -> Option<Object> {
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

fn named<'a>(sections: &'a [Section], name: &str) -> Option<&'a Section> {
    sections.iter().find(|section| section.name.eq_ignore_ascii_case(name))
}

fn device(sections: &[Section]) -> Device {
    let Some(section) = named(sections, "DeviceInfo") else { return Device::default() };
    let text = |key| section.get(key).map(|entry| entry.value.clone());
    let number = |key| u32::try_from(integer(&section.get(key)?.value)?).ok();
    Device {
        vendor_name: text("vendorname"),
        vendor_number: number("vendornumber"),
        product_name: text("productname"),
        product_number: number("productnumber"),
    }
}

/// The standard itself spells the section with one m.
fn node(sections: &[Section]) -> Option<u8> {
    let section = named(sections, "DeviceComissioning").or_else(|| named(sections, "DeviceCommissioning"))?;
    let node = u8::try_from(integer(&section.get("nodeid")?.value)?).ok()?;
    (1..=127).contains(&node).then_some(node)
}
