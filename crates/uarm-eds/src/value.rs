//! Values by data type.

use crate::number::{Expression, expression};
use canopen_rs::{ByteString, DataType};

/// The type of an object's value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A basic type.
    Basic(DataType),
    /// Any other index of a type: time, 24-bit numbers, a structure.
    Other(u16),
}

impl Kind {
    /// The type at an index of the dictionary.
    pub fn from_index(index: u16) -> Self {
        DataType::from_index(index).map_or(Self::Other(index), Self::Basic)
    }

    /// Smallest and largest value; `None` for what is no integer of CiA 301's basic types.
    fn range(self) -> Option<(i128, i128)> {
        let Self::Basic(kind) = self else { return None };
        let bits = 8 * u32::try_from(kind.fixed_size()?).ok()?;
        match kind {
            DataType::Boolean => Some((0, 1)),
            DataType::Unsigned8 | DataType::Unsigned16 | DataType::Unsigned32 | DataType::Unsigned64 => {
                Some((0, (1 << bits) - 1))
            }
            DataType::Integer8 | DataType::Integer16 | DataType::Integer32 | DataType::Integer64 => {
                Some((-(1 << (bits - 1)), (1 << (bits - 1)) - 1))
            }
            _ => None,
        }
    }

    /// `number` as this type holds it; a negative number may be written as its two's complement, `0xFE` for −2.
    fn fit(self, number: i128) -> Option<i128> {
        let Some((low, high)) = self.range() else { return Some(number) };
        if (low..=high).contains(&number) {
            return Some(number);
        }
        let width = high - low + 1;
        (low < 0 && number > high && number < width).then_some(number - width)
    }
}

/// A value.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// An integer of any width, or a truth value (0 or 1).
    Integer(i128),
    /// A floating-point number.
    Real(f64),
    /// A text: a visible string, or what a type that this crate does not know says.
    Text(String),
}

impl Value {
    /// The integer, if it is one.
    pub const fn integer(&self) -> Option<i128> {
        match self {
            Self::Integer(number) => Some(*number),
            _ => None,
        }
    }

    /// The value as the protocol stack holds it; `None` if the type has no place for it.
    pub fn to_wire(&self, kind: Kind) -> Option<canopen_rs::Value> {
        use canopen_rs::Value as Wire;
        let Kind::Basic(kind) = kind else { return None };
        Some(match (kind, self) {
            (DataType::Boolean, Self::Integer(number)) => Wire::Boolean(*number != 0),
            (DataType::Integer8, Self::Integer(number)) => Wire::Integer8(i8::try_from(*number).ok()?),
            (DataType::Integer16, Self::Integer(number)) => Wire::Integer16(i16::try_from(*number).ok()?),
            (DataType::Integer32, Self::Integer(number)) => Wire::Integer32(i32::try_from(*number).ok()?),
            (DataType::Integer64, Self::Integer(number)) => Wire::Integer64(i64::try_from(*number).ok()?),
            (DataType::Unsigned8, Self::Integer(number)) => Wire::Unsigned8(u8::try_from(*number).ok()?),
            (DataType::Unsigned16, Self::Integer(number)) => Wire::Unsigned16(u16::try_from(*number).ok()?),
            (DataType::Unsigned32, Self::Integer(number)) => Wire::Unsigned32(u32::try_from(*number).ok()?),
            (DataType::Unsigned64, Self::Integer(number)) => Wire::Unsigned64(u64::try_from(*number).ok()?),
            #[expect(clippy::as_conversions, reason = "the only way from f64 to f32; a file's number is rounded to it")]
            (DataType::Real32, Self::Real(number)) => Wire::Real32(*number as f32),
            (DataType::Real64, Self::Real(number)) => Wire::Real64(*number),
            (DataType::VisibleString, Self::Text(text)) => Wire::VisibleString(ByteString::from_str(text).ok()?),
            (DataType::OctetString, Self::Text(text)) => Wire::OctetString(ByteString::from_str(text).ok()?),
            (DataType::Domain, Self::Text(text)) => Wire::Domain(ByteString::from_str(text).ok()?),
            _ => return None,
        })
    }
}

/// What a file states as a value: the node's id may be part of it.
#[derive(Clone, Debug, PartialEq)]
pub enum Stated {
    /// The same for every node.
    Fixed(Value),
    /// The node's id and so much.
    WithNode(i128),
}

impl Stated {
    /// Reads what a file says of a value of `kind`.
    ///
    /// # Errors
    /// What was expected instead.
    pub fn parse(kind: Kind, text: &str) -> Result<Self, &'static str> {
        match kind {
            Kind::Basic(DataType::VisibleString | DataType::OctetString | DataType::Domain) => {
                Ok(Self::Fixed(Value::Text(text.to_owned())))
            }
            Kind::Basic(DataType::Real32) => real(text, 32).ok_or("a floating-point number").map(Self::Fixed),
            Kind::Basic(DataType::Real64) => real(text, 64).ok_or("a floating-point number").map(Self::Fixed),
            Kind::Basic(DataType::Boolean) if text.eq_ignore_ascii_case("true") => Ok(Self::Fixed(Value::Integer(1))),
            Kind::Basic(DataType::Boolean) if text.eq_ignore_ascii_case("false") => Ok(Self::Fixed(Value::Integer(0))),
            Kind::Basic(_) => {
                let Expression { with_node, offset } = expression(text)
                    .ok_or("a number: 10, 0xA or 012, with $NODEID+ before it where it depends on the node")?;
                if with_node {
                    return Ok(Self::WithNode(offset));
                }
                let number = kind.fit(offset).ok_or("a number that the data type can hold")?;
                Ok(Self::Fixed(Value::Integer(number)))
            }
            Kind::Other(_) => Ok(match expression(text) {
                Some(Expression { with_node: true, offset }) => Self::WithNode(offset),
                Some(Expression { with_node: false, offset }) => Self::Fixed(Value::Integer(offset)),
                None => Self::Fixed(Value::Text(text.to_owned())),
            }),
        }
    }

    /// The value at a node; `None` if with this node's id the type cannot hold it.
    pub fn at(&self, kind: Kind, node: u8) -> Option<Value> {
        match self {
            Self::Fixed(value) => Some(value.clone()),
            Self::WithNode(offset) => kind.fit(offset + i128::from(node)).map(Value::Integer),
        }
    }
}

/// A floating-point number, or its bits in hexadecimal digits.
fn real(text: &str, bits: u32) -> Option<Value> {
    let hexadecimal = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X"));
    let number = match hexadecimal {
        Some(digits) if bits == 32 => f64::from(f32::from_bits(u32::from_str_radix(digits, 16).ok()?)),
        Some(digits) => f64::from_bits(u64::from_str_radix(digits, 16).ok()?),
        None => text.parse().ok()?,
    };
    number.is_finite().then_some(Value::Real(number))
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNSIGNED32: Kind = Kind::Basic(DataType::Unsigned32);
    const INTEGER8: Kind = Kind::Basic(DataType::Integer8);
    const REAL32: Kind = Kind::Basic(DataType::Real32);

    fn fixed(kind: Kind, text: &str) -> Option<Value> {
        Stated::parse(kind, text).ok()?.at(kind, 0)
    }

    #[test]
    fn a_negative_number_may_be_written_as_its_bits() {
        assert_eq!(fixed(INTEGER8, "-2"), Some(Value::Integer(-2)));
        assert_eq!(fixed(INTEGER8, "0xFE"), Some(Value::Integer(-2)));
        assert_eq!(fixed(INTEGER8, "256"), None);
        assert_eq!(fixed(UNSIGNED32, "0xFFFFFFFF"), Some(Value::Integer(4_294_967_295)));
        assert_eq!(fixed(UNSIGNED32, "-1"), None);
    }

    #[test]
    fn the_nodes_id_is_added_within_the_type() {
        let identifier = Stated::parse(UNSIGNED32, "$NODEID+0x40000180").unwrap();
        assert_eq!(identifier.at(UNSIGNED32, 3), Some(Value::Integer(0x4000_0183)));
        assert_eq!(Stated::WithNode(0xFF).at(Kind::Basic(DataType::Unsigned8), 3), None);
    }

    #[test]
    fn reals_are_numbers_or_bits_and_finite() {
        assert_eq!(fixed(REAL32, "1.5"), Some(Value::Real(1.5)));
        assert_eq!(fixed(REAL32, "0x3FC00000"), Some(Value::Real(1.5)));
        assert_eq!(fixed(REAL32, "inf"), None);
        assert_eq!(fixed(REAL32, "0x7F800000"), None);
        assert_eq!(Value::Real(1.5).to_wire(REAL32), Some(canopen_rs::Value::Real32(1.5)));
    }

    #[test]
    fn strings_stay_what_they_are_and_unknown_types_are_read_as_far_as_possible() {
        assert_eq!(fixed(Kind::from_index(9), "0x10"), Some(Value::Text("0x10".into())));
        assert_eq!(fixed(Kind::from_index(0x16), "0x10"), Some(Value::Integer(16)));
        assert_eq!(Value::Integer(16).to_wire(Kind::Other(0x16)), None);
        let long = Value::Text("x".repeat(33));
        assert_eq!(long.to_wire(Kind::from_index(9)), None);
    }
}
