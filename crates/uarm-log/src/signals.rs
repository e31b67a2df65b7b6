//! The signals of a cycle by name: the one list from which CSV files are written and replays are compared.

use std::fmt;

use serde::Serialize;
use uarm_loop::dimensions::number_of_active;
use uarm_loop::estimation::AngleSource;
use uarm_loop::record::{CycleRecord, Unexplained};
use uarm_loop::supervisor::Authority;

/// The value of a signal.
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

/// One signal of one cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Signal {
    /// What it is, such as `position`.
    pub quantity: &'static str,
    /// The joint or parameter, counted from 1, if there is more than one.
    pub number: Option<usize>,
    /// Its unit as a suffix, such as `_rad`; empty for a number without one.
    pub unit: &'static str,
    /// Its value.
    pub value: Value,
}

impl Signal {
    /// The name of a CSV column, such as `position_2_rad`.
    pub fn name(&self) -> String {
        let Self { quantity, number, unit, .. } = self;
        number.map_or_else(|| format!("{quantity}{unit}"), |number| format!("{quantity}_{number}{unit}"))
    }
}

/// Every signal of a cycle, in the order of a CSV file's columns; the adapted parameters come last.
pub fn signals<const J: usize, const N: usize>(record: &CycleRecord<J, N>) -> Vec<Signal> {
    let mut list = List(Vec::new());
    let first_active = number_of_active::<J, N>(0);
    list.one("time", "_s", Value::Number(record.time));
    list.one("period", "_s", Value::Number(record.period));
    list.each("counts", "", 1, record.counts.map(|count| Value::Integer(count.into())));
    list.each("predicted", "", 1, record.angle_sources.map(|source| Value::Flag(source != AngleSource::Measured)));
    list.each("statusword", "", 1, record.statuswords.map(|word| Value::Integer(word.into())));
    list.each("position", "_rad", 1, record.position.map(Value::Number));
    list.each("measured_position", "_rad", 1, record.measured_position.map(Value::Number));
    list.each("velocity", "_rad_per_s", 1, record.velocity.map(Value::Number));
    if J > N {
        list.each("base_acceleration", "_rad_per_s2", 1, [Value::Number(record.base_acceleration)]);
    }
    list.each("reference_position", "_rad", first_active, record.reference_position.map(Value::Number));
    list.each("reference_velocity", "_rad_per_s", first_active, record.reference_velocity.map(Value::Number));
    list.each("reference_acceleration", "_rad_per_s2", first_active, record.reference_acceleration.map(Value::Number));
    list.each("control_input", "", first_active, record.control_input.map(Value::Number));
    list.each("torque_requested", "_nm", first_active, record.torque_requested.map(Value::Number));
    list.each("torque_applied", "_nm", first_active, record.torque_applied.map(Value::Number));
    list.each("torque_sent", "_per_mille", 1, record.torque_sent.map(|sent| Value::Integer(sent.into())));
    list.each("disturbance", "_nm", first_active, record.disturbance.map(Value::Number));
    let unexplained = record.unexplained.unwrap_or(Unexplained { residual: [f64::NAN; N], limit: [f64::NAN; N] });
    list.each("residual", "_nm", first_active, unexplained.residual.map(Value::Number));
    list.each("residual_limit", "_nm", first_active, unexplained.limit.map(Value::Number));
    list.each("limited", "", first_active, record.flags.limited.map(Value::Flag));
    list.one("projected", "", Value::Flag(record.flags.projected));
    list.one("at_bound", "", Value::Flag(record.flags.at_bound));
    list.one("frozen", "", Value::Flag(record.flags.frozen));
    list.one("fell_back", "", Value::Flag(record.flags.fell_back));
    list.one("stopping", "", Value::Flag(record.authority == Authority::Fading));
    list.each("phi", "", 1, record.parameters().iter().copied().map(Value::Number));
    list.0
}

struct List(Vec<Signal>);

impl List {
    fn one(&mut self, quantity: &'static str, unit: &'static str, value: Value) {
        self.0.push(Signal { quantity, number: None, unit, value });
    }

    fn each(
        &mut self,
        quantity: &'static str,
        unit: &'static str,
        first: usize,
        values: impl IntoIterator<Item = Value>,
    ) {
        let signals = values.into_iter().zip(first..);
        self.0.extend(signals.map(|(value, number)| Signal { quantity, number: Some(number), unit, value }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nan_equals_itself_and_the_zeros_differ() {
        assert_eq!(Value::Number(f64::NAN), Value::Number(f64::NAN));
        assert_ne!(Value::Number(0.0), Value::Number(-0.0));
        assert_ne!(Value::Integer(0), Value::Flag(false));
    }

    #[test]
    fn joints_are_numbered_as_people_count_them() {
        let mut record = CycleRecord::<3, 2>::default();
        record.set_parameters(&[0.5]);
        record.torque_applied[1] = 0.25;
        record.counts[2] = -7;
        let signals = signals(&record);
        let value = |name: &str| signals.iter().find(|signal| signal.name() == name).map(|signal| signal.value);
        assert_eq!(value("torque_applied_3_nm"), Some(Value::Number(0.25)));
        assert_eq!(value("counts_3"), Some(Value::Integer(-7)));
        assert_eq!(value("phi_1"), Some(Value::Number(0.5)));
        assert_eq!(value("torque_applied_1_nm"), None);
    }
}
