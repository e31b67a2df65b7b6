//! Integers in and out of values of any integer type: makers' dictionaries do not all use the standard's.

use canopen_rs::{ByteString, DataType, Value};

/// The integer that a value is.
pub fn number_of(value: &Value) -> Option<i128> {
    Some(match *value {
        Value::Boolean(value) => value.into(),
        Value::Integer8(value) => value.into(),
        Value::Integer16(value) => value.into(),
        Value::Integer32(value) => value.into(),
        Value::Integer64(value) => value.into(),
        Value::Unsigned8(value) => value.into(),
        Value::Unsigned16(value) => value.into(),
        Value::Unsigned32(value) => value.into(),
        Value::Unsigned64(value) => value.into(),
        _ => return None,
    })
}

/// An integer as a value of a type, if it fits.
pub fn value_of(data_type: DataType, number: i128) -> Option<Value> {
    Some(match data_type {
        DataType::Boolean => Value::Boolean(number != 0),
        DataType::Integer8 => Value::Integer8(number.try_into().ok()?),
        DataType::Integer16 => Value::Integer16(number.try_into().ok()?),
        DataType::Integer32 => Value::Integer32(number.try_into().ok()?),
        DataType::Integer64 => Value::Integer64(number.try_into().ok()?),
        DataType::Unsigned8 => Value::Unsigned8(number.try_into().ok()?),
        DataType::Unsigned16 => Value::Unsigned16(number.try_into().ok()?),
        DataType::Unsigned32 => Value::Unsigned32(number.try_into().ok()?),
        DataType::Unsigned64 => Value::Unsigned64(number.try_into().ok()?),
        _ => return None,
    })
}

/// The zero of a type, or what is empty.
pub fn zero_of(data_type: DataType) -> Option<Value> {
    match data_type {
        DataType::Real32 => Some(Value::Real32(0.0)),
        DataType::Real64 => Some(Value::Real64(0.0)),
        DataType::VisibleString => Some(Value::VisibleString(ByteString::new())),
        DataType::OctetString => Some(Value::OctetString(ByteString::new())),
        DataType::Domain => Some(Value::Domain(ByteString::new())),
        _ => value_of(data_type, 0),
    }
}
