//! Where the parameters of PDOs stand: 1400h and 1600h ff. for RPDOs, 1800h and 1A00h ff. for TPDOs.

use super::objects::Object;
use canopen_rs::DataType;
use core::fmt;

/// Which way a PDO goes, seen from the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PdoKind {
    /// RPDO: the drive receives it.
    Receive,
    /// TPDO: the drive sends it.
    Transmit,
}

/// The number of a PDO: 1 to 512.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct PdoNumber(u16);

impl PdoNumber {
    /// The first.
    pub const FIRST: Self = Self(1);
    /// The second.
    pub const SECOND: Self = Self(2);
    /// How many of a kind there can be (CiA 301).
    pub const MOST: u16 = 512;

    /// PDO `number`; `None` outside 1 … 512.
    pub const fn new(number: u16) -> Option<Self> {
        if 1 <= number && number <= Self::MOST { Some(Self(number)) } else { None }
    }

    /// The number.
    pub const fn get(self) -> u16 {
        self.0
    }

    /// All of them, from 1 on.
    pub fn all() -> impl Iterator<Item = Self> {
        (1..=Self::MOST).map(Self)
    }
}

impl PdoKind {
    const fn parameter(self, number: PdoNumber) -> u16 {
        match self {
            Self::Receive => 0x1400 + (number.0 - 1),
            Self::Transmit => 0x1800 + (number.0 - 1),
        }
    }

    const fn mapping(self, number: PdoNumber) -> u16 {
        self.parameter(number) + 0x200
    }

    const fn either(self, of_rpdo: &'static str, of_tpdo: &'static str) -> &'static str {
        match self {
            Self::Receive => of_rpdo,
            Self::Transmit => of_tpdo,
        }
    }

    /// Its identifier; bit 31 set switches the PDO off.
    pub const fn identifier(self, number: PdoNumber) -> Object {
        let name = self.either("RPDO COB-ID", "TPDO COB-ID");
        Object::new(self.parameter(number), 1, DataType::Unsigned32, name)
    }

    /// Its transmission type.
    pub const fn transmission(self, number: PdoNumber) -> Object {
        let name = self.either("RPDO transmission type", "TPDO transmission type");
        Object::new(self.parameter(number), 2, DataType::Unsigned8, name)
    }

    /// Its event timer, ms: of an RPDO the time after which its absence is noticed.
    pub const fn event_timer(self, number: PdoNumber) -> Object {
        let name = self.either("RPDO event timer", "TPDO event timer");
        Object::new(self.parameter(number), 5, DataType::Unsigned16, name)
    }

    /// How many objects it carries; 0 while the mapping is being changed.
    pub const fn mapped_objects(self, number: PdoNumber) -> Object {
        let name = self.either("RPDO number of mapped objects", "TPDO number of mapped objects");
        Object::new(self.mapping(number), 0, DataType::Unsigned8, name)
    }

    /// One of them, from sub-index 1 on.
    pub const fn mapped_object(self, number: PdoNumber, subindex: u8) -> Object {
        let name = self.either("RPDO mapped object", "TPDO mapped object");
        Object::new(self.mapping(number), subindex, DataType::Unsigned32, name)
    }
}

impl fmt::Display for PdoKind {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.either("RPDO", "TPDO"))
    }
}
