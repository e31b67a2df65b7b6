//! One object of a dictionary.

use crate::value::{Kind, Stated, Value};
use canopen_rs::Address;

/// Who may do what with an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Always the same value.
    Constant,
    /// The master reads it.
    ReadOnly,
    /// The master writes it.
    WriteOnly,
    /// Both.
    ReadWrite,
    /// Both, and a TPDO may carry it (`rwr`).
    ReadWriteInput,
    /// Both, and an RPDO may carry it (`rww`).
    ReadWriteOutput,
}

impl Access {
    /// What a file calls it, in either case.
    pub fn parse(text: &str) -> Option<Self> {
        Some(match text.to_ascii_lowercase().as_str() {
            "const" => Self::Constant,
            "ro" => Self::ReadOnly,
            "wo" => Self::WriteOnly,
            "rw" => Self::ReadWrite,
            "rwr" => Self::ReadWriteInput,
            "rww" => Self::ReadWriteOutput,
            _ => return None,
        })
    }

    /// Whether an SDO reads it.
    pub const fn is_readable(self) -> bool {
        !matches!(self, Self::WriteOnly)
    }

    /// Whether an SDO writes it.
    pub const fn is_writable(self) -> bool {
        !matches!(self, Self::Constant | Self::ReadOnly)
    }
}

/// An object that holds a value: a variable, or an entry of an array or a record.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// Where it is.
    pub address: Address,
    /// What the maker calls it.
    pub name: String,
    /// The type of its value.
    pub kind: Kind,
    /// Who may do what with it.
    pub access: Access,
    /// Whether a PDO may carry it.
    pub mappable: bool,
    /// Its value after power-up, as an EDS says (`DefaultValue`).
    pub default: Option<Stated>,
    /// Its value in the device as configured, as a DCF says (`ParameterValue`).
    pub configured: Option<Stated>,
    /// The smallest value that it takes (`LowLimit`).
    pub low: Option<Stated>,
    /// The largest value that it takes (`HighLimit`).
    pub high: Option<Stated>,
}

impl Object {
    /// Its value at a node: as configured, else the default; `None` if the file states neither.
    pub fn value(&self, node: u8) -> Option<Value> {
        self.configured.as_ref().or(self.default.as_ref())?.at(self.kind, node)
    }

    /// Smallest and largest integer that it takes at a node; `None` where the file sets no limit.
    ///
    /// Two equal zeros, as some tools write for "no limits", are none; a pair in the wrong order is none either.
    pub fn limits(&self, node: u8) -> (Option<i128>, Option<i128>) {
        let limit = |stated: &Option<Stated>| stated.as_ref()?.at(self.kind, node)?.integer();
        match (limit(&self.low), limit(&self.high)) {
            (Some(low), Some(high)) if low > high || (low, high) == (0, 0) => (None, None),
            limits => limits,
        }
    }

    /// Whether it takes `number`, as far as the file says.
    pub fn takes(&self, number: i128, node: u8) -> bool {
        let (low, high) = self.limits(node);
        low.is_none_or(|low| number >= low) && high.is_none_or(|high| number <= high)
    }
}
