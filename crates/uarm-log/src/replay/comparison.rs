//! Two records of one cycle, bit for bit.

use std::fmt;

use serde::Serialize;

use crate::signals::{Value, signals};
use uarm_loop::record::CycleRecord;

/// Where a replay and the record part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// The tick of the cycle.
    pub tick: u64,
    /// Its task time, s.
    pub time: f64,
    /// The signal, with its joint or number.
    pub signal: String,
    /// The value as it was recorded.
    pub recorded: Value,
    /// The value as the replay gives it.
    pub replayed: Value,
}

impl fmt::Display for Difference {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { tick, time, signal, recorded, replayed } = self;
        write!(formatter, "tick {tick} ({time:.3} s): {signal} was {recorded}, replayed {replayed}")
    }
}

/// Compares two records of one cycle; gives the number of signals compared, and those that differ.
pub fn compare<const J: usize, const N: usize>(
    recorded: &CycleRecord<J, N>,
    replayed: &CycleRecord<J, N>,
) -> (u64, Vec<Difference>) {
    let (one, other) = (signals(recorded), signals(replayed));
    let mut differences = Vec::new();
    if one.len() != other.len() {
        let count =
            |record: &CycleRecord<J, N>| Value::Integer(i64::try_from(record.parameter_count).unwrap_or(i64::MAX));
        differences.push(difference(recorded, "phi: count", count(recorded), count(replayed)));
    }
    let differing = one.iter().zip(&other).filter(|(one, other)| one.value != other.value);
    differences.extend(differing.map(|(one, other)| difference(recorded, &one.name(), one.value, other.value)));
    (u64::try_from(one.len()).unwrap_or(u64::MAX), differences)
}

fn difference<const J: usize, const N: usize>(
    record: &CycleRecord<J, N>,
    signal: &str,
    recorded: Value,
    replayed: Value,
) -> Difference {
    Difference { tick: record.tick, time: record.time, signal: signal.to_owned(), recorded, replayed }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_bit_is_a_difference_and_is_named() {
        let recorded = CycleRecord::<3, 2>::default();
        let mut replayed = recorded;
        assert!(compare(&recorded, &replayed).1.is_empty());
        replayed.torque_applied[1] = f64::from_bits(1);
        replayed.flags.limited[0] = true;
        replayed.torque_sent[2] = -4;
        let (_, differences) = compare(&recorded, &replayed);
        let names: Vec<_> = differences.iter().map(|difference| difference.signal.as_str()).collect();
        assert_eq!(names, ["torque_applied_3_nm", "torque_sent_3_per_mille", "limited_2"]);
        assert!(differences[0].to_string().contains("was 0.0 (0000000000000000), replayed 5e-324 (0000000000000001)"));
    }
}
