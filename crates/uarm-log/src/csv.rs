//! CSV files: every signal of every cycle, one row a cycle. Numbers are written so that reading them back gives the same
//! bits.

use std::io::{self, Write};

use uarm_loop::record::CycleRecord;
use uarm_loop::torque::ActualTorque;

use crate::signals::{Value, signals};

/// The columns that tell when things happened, in nanoseconds after the cycle was due. They stand last: all columns before
/// them are the same, byte for byte, in any lockstep run of the same experiment.
pub const TIMING_COLUMNS: [&str; 5] = ["woke_ns", "sync_sent_ns", "counts_in_ns", "torque_out_ns", "done_ns"];

/// Writes cycles, under a header that names the columns: `tick`, the [`signals`], the torques that drives reported, if any did,
/// [`TIMING_COLUMNS`]. A torque that was not reported is an empty field, and so is what is no number: the residuals of a run whose
/// supervision is off.
///
/// # Errors
/// If the output cannot be written.
pub fn write<const J: usize, const N: usize>(cycles: &[CycleRecord<J, N>], mut output: impl Write) -> io::Result<()> {
    let Some(first) = cycles.first() else { return output.flush() };
    let mut reporting = Reporting::default();
    cycles.iter().for_each(|record| reporting.look_at(record));
    write_header(first, &reporting, &mut output)?;
    for record in cycles {
        write_row(record, &reporting, &mut output)?;
    }
    output.flush()
}

/// Writes the header, as [`write()`] does, of cycles like `first`.
///
/// # Errors
/// If the output cannot be written.
pub fn write_header<const J: usize, const N: usize>(
    first: &CycleRecord<J, N>,
    reporting: &Reporting<J>,
    output: &mut impl Write,
) -> io::Result<()> {
    write!(output, "tick")?;
    for signal in signals(first) {
        write!(output, ",{}", signal.name())?;
    }
    for joint in reporting.joints() {
        write!(output, ",torque_actual_{number}_per_mille,torque_actual_{number}_nm", number = joint + 1)?;
    }
    writeln!(output, ",{}", TIMING_COLUMNS.join(","))
}

/// Writes the row of a cycle, as [`write()`] does.
///
/// # Errors
/// If the output cannot be written.
pub fn write_row<const J: usize, const N: usize>(
    record: &CycleRecord<J, N>,
    reporting: &Reporting<J>,
    output: &mut impl Write,
) -> io::Result<()> {
    write!(output, "{}", record.tick)?;
    for signal in signals(record) {
        match signal.value {
            Value::Number(number) if number.is_nan() => write!(output, ",")?,
            Value::Number(number) => write!(output, ",{number}")?,
            Value::Integer(integer) => write!(output, ",{integer}")?,
            Value::Flag(flag) => write!(output, ",{}", u8::from(flag))?,
        }
    }
    for joint in reporting.joints() {
        match record.torque_actual.get(joint).copied().flatten() {
            Some(ActualTorque { per_mille, newton_metres }) => write!(output, ",{per_mille},{newton_metres}")?,
            None => write!(output, ",,")?,
        }
    }
    let instants = &record.instants;
    for instant in [instants.woke, instants.sync_sent, instants.counts_in, instants.torque_out, instants.done] {
        write!(output, ",{}", instant.since(instants.scheduled).as_nanos())?;
    }
    writeln!(output)
}

/// Whose drives reported a torque in any cycle.
#[derive(Clone, Copy, Debug)]
pub struct Reporting<const J: usize>([bool; J]);

impl<const J: usize> Default for Reporting<J> {
    /// Nobody's.
    fn default() -> Self {
        Self([false; J])
    }
}

impl<const J: usize> Reporting<J> {
    /// Takes in a cycle.
    pub fn look_at<const N: usize>(&mut self, record: &CycleRecord<J, N>) {
        for (reports, torque) in self.0.iter_mut().zip(&record.torque_actual) {
            *reports |= torque.is_some();
        }
    }

    /// The joints, counted from 0.
    fn joints(&self) -> impl Iterator<Item = usize> {
        self.0.iter().enumerate().filter(|(_, reports)| **reports).map(|(joint, _)| joint)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_row_has_the_columns_of_the_header() {
        let mut record = CycleRecord::<3, 2> { tick: 7, time: 0.1, ..CycleRecord::default() };
        record.set_parameters(&[1.5, -2.5]);
        record.flags.limited[1] = true;
        let mut text = Vec::new();
        write(&[record, record], &mut text).unwrap();
        let text = String::from_utf8(text).unwrap();
        let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
        assert_eq!(rows.len(), 3);
        assert!(rows.iter().all(|row| row.len() == rows[0].len()));
        let value = |name: &str| rows[1][rows[0].iter().position(|column| *column == name).unwrap()];
        assert_eq!((value("tick"), value("time_s"), value("phi_2")), ("7", "0.1", "-2.5"));
        assert_eq!((value("limited_2"), value("limited_3")), ("0", "1"));
    }

    #[test]
    fn residuals_that_nobody_computed_are_empty_fields() {
        let record = CycleRecord::<3, 2> { unexplained: None, ..CycleRecord::default() };
        let mut text = Vec::new();
        write(&[record], &mut text).unwrap();
        let text = String::from_utf8(text).unwrap();
        let [header, row] = text.lines().collect::<Vec<_>>().try_into().unwrap();
        let named = |name: &str| header.split(',').zip(row.split(',')).find(|(column, _)| *column == name).unwrap().1;
        for name in ["residual_2_nm", "residual_3_nm", "residual_limit_2_nm", "residual_limit_3_nm"] {
            assert_eq!(named(name), "", "{name}");
        }
        assert!(!row.contains("NaN"), "{row}");
    }

    /// Nobody must take a torque that was not reported for one of zero.
    #[test]
    fn torques_have_columns_for_drives_that_report_them_and_empty_fields_where_they_did_not() {
        let silent = CycleRecord::<3, 2>::default();
        let mut reported = silent;
        reported.torque_actual[2] = Some(ActualTorque { per_mille: -257, newton_metres: -0.5 });
        let lines = |cycles: &[CycleRecord<3, 2>]| {
            let mut text = Vec::new();
            write(cycles, &mut text).unwrap();
            String::from_utf8(text).unwrap().lines().map(str::to_owned).collect::<Vec<_>>()
        };
        assert!(!lines(&[silent])[0].contains("torque_actual"));
        let lines = lines(&[silent, reported]);
        assert!(lines[0].ends_with(
            "fell_back,stopping,torque_actual_3_per_mille,torque_actual_3_nm,woke_ns,sync_sent_ns,counts_in_ns,torque_out_ns,done_ns"
        ));
        assert!(lines[1].ends_with(",0,,,0,0,0,0,0"), "{}", lines[1]);
        assert!(lines[2].ends_with(",0,-257,-0.5,0,0,0,0,0"), "{}", lines[2]);
    }
}
