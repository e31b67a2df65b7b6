//! EDS and DCF files (CiA 306-1): what objects a CANopen device has, with type, access, default and limits.
//!
//! Makers' files differ from the standard in small ways, so the reader is lenient: a line or a value that it cannot read becomes
//! a [`Problem`], and the rest of the file is read. What a caller needs and does not find, it refuses by itself.
//!
//! ```
//! use uarm_eds::{Address, Dictionary, Value};
//!
//! let text = b"[1800]\nObjectType=9\nSubNumber=2\n\
//!              [1800sub1]\nParameterName=COB-ID\nDataType=0x0007\nAccessType=rw\nDefaultValue=$NODEID+0x180\n";
//! let dictionary = Dictionary::parse("drive.eds", text)?;
//! let object = dictionary.object(Address::new(0x1800, 1)).unwrap();
//! assert!(object.access.is_writable());
//! assert_eq!(object.value(5), Some(Value::Integer(0x185)));
//! # Ok::<(), uarm_eds::EdsError>(())
//! ```
//!
//! # Map
//!
//! | module | subject |
//! |---|---|
//! | `text` | bytes to sections of keys and values, with their lines |
//! | `number`, `value` | numbers as CiA 306 writes them; values by data type |
//! | `object` | one object |
//! | `reader` | sections to objects |
//! | `compact` | many objects in few lines: `CompactSubObj`, `CompactPDO` |
//! | `dictionary` | all of them, and the device |
//! | `problem` | what could not be read |
//!
//! # Why no INI library
//!
//! `rust-ini` 0.21 joins a line without `=` to the line after it, continues a line that ends in `\`, and tells no line of a value.
//! A maker's file then loses an object without a word.
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing, clippy::as_conversions)
)]

mod compact;
mod dictionary;
mod number;
mod object;
mod problem;
mod reader;
mod text;
mod value;

pub use canopen_rs::{Address, DataType};
pub use dictionary::{Device, Dictionary, EdsError, LARGEST_FILE};
pub use object::{Access, Object};
pub use problem::Problem;
pub use value::{Kind, Stated, Value};

/// The README's example, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
