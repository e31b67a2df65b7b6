//! `--trace FILE.csv`: every signal of every cycle, one row a cycle. Numbers are written so that reading them back gives
//! the same bits.

use std::io::{self, Write};

use crate::control_loop::record::{CycleFlags, CycleRecord};
use crate::recording::{Entry, Sink};

/// The column names, in order. The timing columns stand last: all before them are the same, byte for byte, in any
/// lockstep run of the same experiment.
pub fn header(parameter_count: usize) -> String {
    let mut columns = vec!["tick", "time_s", "period_s"].into_iter().map(str::to_owned).collect::<Vec<_>>();
    let mut group = |names: &[&str], joints: std::ops::RangeInclusive<u8>, unit: &str| {
        for name in names {
            columns.extend(joints.clone().map(|joint| format!("{name}_{joint}{unit}")));
        }
    };
    group(&["counts", "statusword"], 1..=3, "");
    group(&["position", "measured_position"], 1..=3, "_rad");
    group(&["rate"], 1..=3, "_rad_per_s");
    group(&["base_acceleration"], 1..=1, "_rad_per_s2");
    group(&["reference_position"], 2..=3, "_rad");
    group(&["reference_rate"], 2..=3, "_rad_per_s");
    group(&["reference_acceleration"], 2..=3, "_rad_per_s2");
    group(&["control_input"], 2..=3, "");
    group(&["torque_requested", "torque_applied"], 2..=3, "_nm");
    group(&["torque_sent"], 1..=3, "_per_mille");
    group(&["disturbance"], 2..=3, "_nm");
    group(&["limited"], 2..=3, "");
    columns.extend(["projected", "at_bound", "frozen", "fell_back"].map(str::to_owned));
    columns.extend((1..=parameter_count).map(|k| format!("phi_{k}")));
    columns.extend(TIMING_COLUMNS.map(str::to_owned));
    columns.join(",")
}

/// The columns that tell when things happened, in nanoseconds after the cycle was due.
pub const TIMING_COLUMNS: [&str; 5] = ["woke_ns", "sync_sent_ns", "counts_in_ns", "torque_out_ns", "done_ns"];

/// Writes traces.
#[derive(Debug)]
pub struct TraceWriter<W: Write> {
    output: W,
    header_written: bool,
}

impl<W: Write> TraceWriter<W> {
    /// Writes to `output`, which should be buffered.
    pub const fn new(output: W) -> Self {
        Self { output, header_written: false }
    }

    /// Writes one row, before the first one the header.
    ///
    /// # Errors
    /// If the output cannot be written.
    pub fn write(&mut self, record: &CycleRecord) -> io::Result<()> {
        if !self.header_written {
            writeln!(self.output, "{}", header(record.parameter_count))?;
            self.header_written = true;
        }
        let mut row = Row { output: &mut self.output, separator: "" };
        row.put([record.tick])?;
        row.put([record.time, record.period])?;
        row.put(record.counts)?;
        row.put(record.statuswords)?;
        row.put(record.position)?;
        row.put(record.measured_position)?;
        row.put(record.rate)?;
        row.put([record.base_acceleration])?;
        row.put(record.reference_position)?;
        row.put(record.reference_rate)?;
        row.put(record.reference_acceleration)?;
        row.put(record.control_input)?;
        row.put(record.torque_requested)?;
        row.put(record.torque_applied)?;
        row.put(record.torque_sent)?;
        row.put(record.disturbance)?;
        let CycleFlags { limited, projected, at_bound, frozen, fell_back } = record.flags;
        row.put(limited.map(u8::from))?;
        row.put([projected, at_bound, frozen, fell_back].map(u8::from))?;
        row.put(record.parameters().iter().copied())?;
        let instants = &record.instants;
        row.put(
            [instants.woke, instants.sync_sent, instants.counts_in, instants.torque_out, instants.done]
                .map(|instant| instant.since(instants.scheduled).as_nanos()),
        )?;
        writeln!(self.output)
    }

    /// Hands everything to the operating system.
    ///
    /// # Errors
    /// If the output cannot be written.
    pub fn finish(&mut self) -> io::Result<()> {
        self.output.flush()
    }
}

struct Row<'a, W: Write> {
    output: &'a mut W,
    separator: &'static str,
}

impl<W: Write> Row<'_, W> {
    fn put<V: std::fmt::Display>(&mut self, values: impl IntoIterator<Item = V>) -> io::Result<()> {
        for value in values {
            write!(self.output, "{}{value}", self.separator)?;
            self.separator = ",";
        }
        Ok(())
    }
}

impl<W: Write + Send> Sink for TraceWriter<W> {
    fn name(&self) -> String {
        "trace".to_owned()
    }

    fn take(&mut self, entry: Entry<'_>) -> io::Result<()> {
        match entry {
            Entry::Cycle(record) => self.write(record),
            Entry::End(_) => self.finish(),
            Entry::Frame(_) | Entry::Occasion(..) | Entry::Note(_) | Entry::Pause => Ok(()),
        }
    }
}
