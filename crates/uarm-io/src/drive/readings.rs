//! What a drive is asked for in a run beside its motion: supply voltage and temperature, and between which limits they may be.

use canopen_rs::{Address, DataType, Value};
use core::fmt;

/// What is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The voltage of the drive's supply, V.
    SupplyVoltage,
    /// The temperature of drive or motor, °C.
    Temperature,
}

impl Quantity {
    /// Every one.
    pub const ALL: [Self; QUANTITIES] = [Self::SupplyVoltage, Self::Temperature];

    /// Its name, for messages.
    pub const fn name(self) -> &'static str {
        match self {
            Self::SupplyVoltage => "supply voltage",
            Self::Temperature => "temperature",
        }
    }

    /// Its unit.
    pub const fn unit(self) -> &'static str {
        match self {
            Self::SupplyVoltage => "V",
            Self::Temperature => "deg C",
        }
    }
}

/// How many quantities there are.
pub const QUANTITIES: usize = 2;

/// What is read of a drive, by [`Quantity`].
pub type Readings = [Option<Reading>; QUANTITIES];

/// Between which values a quantity may be, in its unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReadingLimits {
    /// The least and the most of which nothing is said.
    warn: [f64; 2],
    /// The least and the most with which a run goes on.
    stop: [f64; 2],
}

impl ReadingLimits {
    /// A run ends outside `stop`, and it is told outside `warn`, the least and the most of each; infinite where there is none. `None`
    /// unless `warn` is a range within `stop`.
    pub fn new(warn: [f64; 2], stop: [f64; 2]) -> Option<Self> {
        let ([warn_below, warn_above], [stop_below, stop_above]) = (warn, stop);
        let is_ordered = stop_below <= warn_below && warn_below < warn_above && warn_above <= stop_above;
        is_ordered.then_some(Self { warn, stop })
    }

    /// What there is to say of `value`. A value that is no number ends a run.
    pub fn verdict(&self, value: f64) -> Verdict {
        let is_within = |[least, most]: [f64; 2]| value >= least && value <= most;
        if is_within(self.warn) {
            Verdict::Good
        } else if is_within(self.stop) {
            Verdict::Warning
        } else {
            Verdict::Stop
        }
    }

    /// The least and the most with which a run goes on.
    pub const fn stop(&self) -> [f64; 2] {
        self.stop
    }

    /// The least and the most of which nothing is said.
    pub const fn warn(&self) -> [f64; 2] {
        self.warn
    }
}

/// What there is to say of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Nothing.
    Good,
    /// It is told.
    Warning,
    /// The run ends.
    Stop,
}

/// An object that is read again and again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// The object.
    pub object: Address,
    /// A number of at most four bytes.
    pub data_type: DataType,
    /// What one of its units is, in the quantity's.
    pub scale: f64,
    /// What the value may be.
    pub limits: ReadingLimits,
}

impl Reading {
    /// The value in the quantity's unit; `None` if it is no number.
    pub fn value(&self, value: Value) -> Option<f64> {
        let number = match value {
            Value::Unsigned8(number) => f64::from(number),
            Value::Unsigned16(number) => f64::from(number),
            Value::Unsigned32(number) => f64::from(number),
            Value::Integer8(number) => f64::from(number),
            Value::Integer16(number) => f64::from(number),
            Value::Integer32(number) => f64::from(number),
            _ => return None,
        };
        Some(number * self.scale)
    }
}

/// A value that a drive reported.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// Of what.
    pub quantity: Quantity,
    /// In the quantity's unit.
    pub value: f64,
    /// With what a run goes on.
    pub allowed: [f64; 2],
}

impl fmt::Display for Found {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, unit, [least, most]) = (self.quantity.name(), self.quantity.unit(), self.allowed);
        write!(formatter, "{name} {:.1} {unit}, expected ", self.value)?;
        match (least.is_finite(), most.is_finite()) {
            (true, true) => write!(formatter, "{least} to {most} {unit}"),
            (true, false) => write!(formatter, "at least {least} {unit}"),
            _ => write!(formatter, "at most {most} {unit}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_told_apart() {
        let limits = ReadingLimits::new([22.0, 26.0], [20.0, 28.0]).unwrap();
        for (value, expected) in [
            (19.9, Verdict::Stop),
            (20.0, Verdict::Warning),
            (22.0, Verdict::Good),
            (26.0, Verdict::Good),
            (26.1, Verdict::Warning),
            (28.1, Verdict::Stop),
            (f64::NAN, Verdict::Stop),
        ] {
            assert_eq!(limits.verdict(value), expected, "{value}");
        }
        assert_eq!(ReadingLimits::new([19.0, 26.0], [20.0, 28.0]), None, "it would stop before it warns");
        assert_eq!(ReadingLimits::new([f64::NAN, 26.0], [20.0, 28.0]), None);
        assert!(ReadingLimits::new([f64::NEG_INFINITY, 70.0], [f64::NEG_INFINITY, 80.0]).is_some());
    }

    #[test]
    fn a_reading_is_in_the_unit_of_its_quantity() {
        let limits = ReadingLimits::new([20.0, 30.0], [20.0, 30.0]).unwrap();
        let object = Address::new(0x6079, 0);
        let reading = Reading { object, data_type: DataType::Unsigned32, scale: 1e-3, limits };
        assert_eq!(reading.value(Value::Unsigned32(24_000)), Some(24.0));
        let found = Found { quantity: Quantity::SupplyVoltage, value: 31.0, allowed: [20.0, 30.0] };
        assert_eq!(std::format!("{found}"), "supply voltage 31.0 V, expected 20 to 30 V");
        let hot = Found { quantity: Quantity::Temperature, value: 81.0, allowed: [f64::NEG_INFINITY, 80.0] };
        assert_eq!(std::format!("{hot}"), "temperature 81.0 deg C, expected at most 80 deg C");
    }
}
