//! The summary for people.

use std::io::{self, Write};

use super::summary::{FlightRecord, StopRamp, Summary};
use crate::inspection::health;
use uarm_log::description::ClockKind;

/// Prints a summary, the first cause of a fault before everything else.
///
/// # Errors
/// If the output cannot be written.
pub fn print(summary: &Summary, output: &mut impl Write) -> io::Result<()> {
    if let Some(fault) = &summary.fault {
        print_fault(fault, output)?;
    }
    summary.report.print(output)?;
    if let Some(StopRamp { from_s, cycles }) = summary.stop_ramp {
        writeln!(output, "  stop               torques faded from {from_s:.3} s on, in {cycles} cycles")?;
    }
    if !summary.part.is_all() {
        writeln!(output, "  part               {}: figures are of this part alone", summary.part)?;
    }
    for disagreement in &summary.disagreements {
        let (figure, recorded) = (&disagreement.figure, &disagreement.recorded);
        writeln!(output, "  DIFFERS            {figure}: the run recorded {recorded}, its cycles in the log give")?;
        writeln!(output, "                     {}", disagreement.recomputed)?;
    }
    print_origin(summary, output)?;
    if let Some(health) = &summary.health {
        writeln!(output, "  bus and drives at the end")?;
        for line in health::lines(health) {
            writeln!(output, "    {line}")?;
        }
    }
    if !summary.warnings.is_empty() {
        writeln!(output, "  warnings")?;
    }
    for warning in &summary.warnings {
        let severity = if warning.fatal { "FATAL" } else { "warning" };
        writeln!(output, "    {:>9.3} s  {severity}: {}", warning.at_s, warning.text)?;
    }
    Ok(())
}

fn print_fault(fault: &FlightRecord, output: &mut impl Write) -> io::Result<()> {
    writeln!(output, "FAULT, the first cause: {}", fault.cause)?;
    match fault.last_tick {
        Some(tick) => writeln!(output, "  at                 {:.3} s, after tick {tick}", fault.at_s)?,
        None => writeln!(output, "  at                 {:.3} s, before the first cycle", fault.at_s)?,
    }
    writeln!(
        output,
        "  flight recorder    the last {:.2} s: {} cycles and {} frames",
        fault.window_s, fault.cycles, fault.frames
    )?;
    if fault.cycles_kept + fault.frames_kept > 0 {
        writeln!(
            output,
            "                     of them {} cycles and {} frames kept while the disk stood still",
            fault.cycles_kept, fault.frames_kept
        )?;
    }
    Ok(())
}

fn print_origin(summary: &Summary, output: &mut impl Write) -> io::Result<()> {
    let contents = &summary.contents;
    let machine = |name: &str| summary.machine.get(name).map_or("", String::as_str);
    for (drive, label) in summary.drives.iter().zip(std::iter::once("drives").chain(std::iter::repeat(""))) {
        writeln!(output, "  {label:<18} node {}: {}", drive.node, drive.identity())?;
    }
    let begin = match summary.report.clock {
        ClockKind::Monotonic => format!("{}, ", contents.begin),
        ClockKind::Virtual => String::new(),
    };
    writeln!(
        output,
        "  recorded           {begin}{:.2} s: {} cycles, {} frames, {} keyframes",
        contents.duration_s, contents.cycles, contents.frames, contents.keyframes
    )?;
    writeln!(output, "  by                 uarm {} (commit {})", machine("version"), machine("commit"))?;
    writeln!(output, "  on                 {}; {}", machine("kernel"), machine("cpu"))?;
    writeln!(
        output,
        "  real time          {}, priority {}, processor {}",
        machine("realtime"),
        machine("priority"),
        machine("processor")
    )
}
