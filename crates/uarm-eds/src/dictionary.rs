//! All objects of a file, and the device that has them.

use crate::number::integer;
use crate::object::Object;
use crate::problem::Problem;
use crate::reader::Reader;
use crate::text::{Section, decode, sections};
use crate::value::Value;
use canopen_rs::Address;
use std::collections::BTreeMap;

/// Files with more bytes are refused: the largest known has 200 kB.
pub const LARGEST_FILE: usize = 4 << 20;
/// More objects are refused. A compact array stands for 254 in a few lines.
const MOST_OBJECTS: usize = 200_000;

/// The index of the identity object.
const IDENTITY: u16 = 0x1018;

/// Why a file is no dictionary.
#[derive(Debug, thiserror::Error)]
pub enum EdsError {
    /// Too many bytes.
    #[error("{file}: {found} bytes, expected at most {LARGEST_FILE}")]
    TooLarge {
        /// The file's name.
        file: String,
        /// Its size.
        found: usize,
    },
    /// It is no text.
    #[error("{file}: not a text, expected an EDS or DCF file (CiA 306)")]
    NoText {
        /// The file's name.
        file: String,
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
    /// Reads the bytes of a file whose name messages shall tell.
    ///
    /// # Errors
    /// [`EdsError`] if they are no dictionary.
    pub fn parse(file: &str, bytes: &[u8]) -> Result<Self, EdsError> {
        if bytes.len() > LARGEST_FILE {
            return Err(EdsError::TooLarge { file: file.to_owned(), found: bytes.len() });
        }
        if bytes.contains(&0) {
            return Err(EdsError::NoText { file: file.to_owned() });
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
            reader.compact_entries(section);
        }
        // Behind all others: a PDO that has sections of its own is as they say.
        if let Some(section) = named(&sections, "DeviceInfo") {
            reader.compact_pdos(section);
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

    /// The number of the identity (1018h) that `[DeviceInfo]` tells: the maker's at sub-index 1, the product's at 2. 0 is none.
    pub fn identity(&self, address: Address) -> Option<u32> {
        let number = match (address.index, address.subindex) {
            (IDENTITY, 1) => self.device.vendor_number,
            (IDENTITY, 2) => self.device.product_number,
            _ => None,
        };
        number.filter(|number| *number != 0)
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
