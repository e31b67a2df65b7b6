//! Two records of one cycle, bit for bit.

use std::fmt;

use serde::Serialize;

use crate::control_loop::record::CycleRecord;

/// A value of a signal.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(untagged)]
pub enum Value {
    /// A real number: equal if all bits are.
    Number(f64),
    /// A whole number.
    Integer(i64),
    /// A flag.
    Flag(bool),
}

impl PartialEq for Value {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Number(one), Self::Number(other)) => one.to_bits() == other.to_bits(),
            (Self::Integer(one), Self::Integer(other)) => one == other,
            (Self::Flag(one), Self::Flag(other)) => one == other,
            _ => false,
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            // The bits as well: two numbers may differ where no decimal does.
            Self::Number(number) => write!(formatter, "{number:?} ({:016x})", number.to_bits()),
            Self::Integer(integer) => write!(formatter, "{integer}"),
            Self::Flag(flag) => write!(formatter, "{flag}"),
        }
    }
}

/// Where a replay and the record part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// The cycle.
    pub tick: u64,
    /// Its task time, s.
    pub time: f64,
    /// The signal, with its joint or number.
    pub signal: String,
    /// As recorded.
    pub recorded: Value,
    /// As replayed.
    pub replayed: Value,
}

impl fmt::Display for Difference {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { tick, time, signal, recorded, replayed } = self;
        write!(formatter, "tick {tick} ({time:.3} s): {signal} was {recorded}, replayed {replayed}")
    }
}

/// The signals of a record by name and number; joints as they are counted.
fn signals(record: &CycleRecord) -> Vec<(&'static str, usize, Value)> {
    let mut signals = vec![
        ("time_s", 0, Value::Number(record.time)),
        ("period_s", 0, Value::Number(record.period)),
        ("base_acceleration_rad_per_s2", 1, Value::Number(record.base_acceleration)),
        ("projected", 0, Value::Flag(record.flags.projected)),
        ("at_bound", 0, Value::Flag(record.flags.at_bound)),
        ("frozen", 0, Value::Flag(record.flags.frozen)),
        ("fell_back", 0, Value::Flag(record.flags.fell_back)),
    ];
    let mut numbers = |name, first: usize, values: &[f64]| {
        signals.extend(values.iter().zip(first..).map(|(value, number)| (name, number, Value::Number(*value))));
    };
    numbers("measured_position_rad", 1, &record.measured_position);
    numbers("position_rad", 1, &record.position);
    numbers("rate_rad_per_s", 1, &record.rate);
    numbers("reference_position_rad", 2, &record.reference_position);
    numbers("reference_rate_rad_per_s", 2, &record.reference_rate);
    numbers("reference_acceleration_rad_per_s2", 2, &record.reference_acceleration);
    numbers("phi", 1, record.parameters());
    numbers("control_input", 2, &record.control_input);
    numbers("torque_requested_nm", 2, &record.torque_requested);
    numbers("torque_applied_nm", 2, &record.torque_applied);
    numbers("disturbance_nm", 2, &record.disturbance);
    let integer = |value: i64| Value::Integer(value);
    signals.extend(record.counts.iter().zip(1..).map(|(count, joint)| ("counts", joint, integer((*count).into()))));
    let statuswords = record.statuswords.iter().zip(1..);
    signals.extend(statuswords.map(|(word, joint)| ("statusword", joint, integer((*word).into()))));
    let sent = record.torque_sent.iter().zip(1..);
    signals.extend(sent.map(|(torque, joint)| ("torque_sent_per_mille", joint, integer((*torque).into()))));
    let limited = record.flags.limited.iter().zip(2..);
    signals.extend(limited.map(|(limited, joint)| ("limited", joint, Value::Flag(*limited))));
    signals
}

/// Compares two records of one cycle; gives the number of signals compared, and those that differ.
pub fn compare(recorded: &CycleRecord, replayed: &CycleRecord) -> (u64, Vec<Difference>) {
    let (one, other) = (signals(recorded), signals(replayed));
    let mut differences = Vec::new();
    if one.len() != other.len() {
        let count = |record: &CycleRecord| Value::Integer(i64::try_from(record.parameter_count).unwrap_or(i64::MAX));
        differences.push(difference(recorded, "phi: count", count(recorded), count(replayed)));
    }
    let pairs = one.iter().zip(&other);
    differences.extend(pairs.filter(|((.., one), (.., other))| one != other).map(
        |((name, number, one), (.., other))| {
            let name = if *number == 0 { (*name).to_owned() } else { format!("{name}_{number}") };
            difference(recorded, &name, *one, *other)
        },
    ));
    (u64::try_from(one.len()).unwrap_or(u64::MAX), differences)
}

fn difference(record: &CycleRecord, signal: &str, recorded: Value, replayed: Value) -> Difference {
    Difference { tick: record.tick, time: record.time, signal: signal.to_owned(), recorded, replayed }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control_loop::record::tests::record;

    #[test]
    fn one_bit_is_a_difference_and_is_named() {
        let recorded = record();
        let mut replayed = recorded;
        assert!(compare(&recorded, &replayed).1.is_empty());
        replayed.torque_applied[1] = f64::from_bits(1);
        replayed.flags.limited[0] = true;
        replayed.torque_sent[2] = -4;
        let (_, differences) = compare(&recorded, &replayed);
        let names: Vec<_> = differences.iter().map(|difference| difference.signal.as_str()).collect();
        assert_eq!(names, ["torque_applied_nm_3", "torque_sent_per_mille_3", "limited_2"]);
        assert!(differences[0].to_string().contains("was 0.0 (0000000000000000), replayed 5e-324 (0000000000000001)"));
    }

    #[test]
    fn nan_equals_itself_and_the_zeros_differ() {
        assert_eq!(Value::Number(f64::NAN), Value::Number(f64::NAN));
        assert_ne!(Value::Number(0.0), Value::Number(-0.0));
    }
}
