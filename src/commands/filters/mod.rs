//! `uarm filters`: the velocity estimators compared on the paper's motion.

mod motion;
mod study;
mod tuning;
mod variant;

use std::io::{self, Write};
use std::process::ExitCode;

use serde::Serialize;

use crate::console;
use motion::{Jitter, PERIOD};
use study::{FilterStudy, Row};
use variant::EstimatorVariant;

/// Arguments of `uarm filters`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The motion is the paper's quintic, quantised by encoders of 2 000 to 65 536 counts per revolution, at 3 ms. Each estimator
has one setting, tuned for each encoder to the least RMS error with the paper's disturbance on the motion; the paper's own
filter enters as it is. The delay is the lag at which the estimate fits the true velocity best.")]
pub struct Arguments {
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// A row of the comparison as JSON gives it; velocities in degrees.
#[derive(Serialize)]
struct JsonRow {
    estimator: String,
    setting: f64,
    setting_name: &'static str,
    counts_per_revolution: u32,
    period_jitter: f64,
    rms_error_deg_per_s: f64,
    delay_ms: f64,
    rms_at_delay_deg_per_s: f64,
    rms_error_disturbed_deg_per_s: f64,
}

#[derive(Serialize)]
struct JsonStudy {
    rows: Vec<JsonRow>,
    default: String,
    best: String,
    reason: String,
}

/// Prints the comparison.
///
/// # Errors
/// If standard output cannot be written.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let study = FilterStudy::of_the_paper()?;
    if arguments.json {
        console::print_json(&json(&study))?;
    } else {
        print(&mut console::output(), &study)?;
    }
    Ok(ExitCode::SUCCESS)
}

const fn jitter_share(jitter: Jitter) -> f64 {
    match jitter {
        Jitter::None => 0.0,
        Jitter::TenPercent => 0.1,
    }
}

fn json(study: &FilterStudy) -> JsonStudy {
    let row = |row: &Row| JsonRow {
        estimator: row.variant.to_string(),
        setting: row.setting,
        setting_name: row.variant.setting_name(),
        counts_per_revolution: row.counts_per_revolution,
        period_jitter: jitter_share(row.jitter),
        rms_error_deg_per_s: row.rms_error.to_degrees(),
        delay_ms: row.delay * 1e3,
        rms_at_delay_deg_per_s: row.rms_at_delay.to_degrees(),
        rms_error_disturbed_deg_per_s: row.rms_error_disturbed.to_degrees(),
    };
    JsonStudy {
        rows: study.rows.iter().map(row).collect(),
        default: study.verdict.default.to_string(),
        best: study.verdict.best.to_string(),
        reason: study.verdict.reason.clone(),
    }
}

fn print(output: &mut impl Write, study: &FilterStudy) -> io::Result<()> {
    writeln!(
        output,
        "joint velocity from an encoder at {} ms, on the paper's motion (RMS in deg/s, delay in ms)",
        PERIOD * 1e3
    )?;
    for jitter in [Jitter::None, Jitter::TenPercent] {
        writeln!(output, "\nperiod jitter {:.0} %", jitter_share(jitter) * 100.0)?;
        writeln!(
            output,
            "{:>10}  {:<17} {:>11}  {:>8}  {:>8}  {:>9}  {:>9}  setting",
            "counts/rev", "estimator", "1 count is", "RMS", "delay", "RMS there", "disturbed"
        )?;
        for row in study.rows.iter().filter(|row| row.jitter == jitter) {
            print_row(output, row)?;
        }
    }
    writeln!(output, "\nbest by the numbers: {}; default: {}", study.verdict.best, study.verdict.default)?;
    writeln!(output, "{}", study.verdict.reason)
}

fn print_row(output: &mut impl Write, row: &Row) -> io::Result<()> {
    let one_count = 360.0 / (f64::from(row.counts_per_revolution) * PERIOD);
    // The encoder stands only beside its first estimator: a table is easier to read in groups.
    let encoder = if row.variant == EstimatorVariant::PaperLowPass {
        (row.counts_per_revolution.to_string(), format!("{one_count:.1} deg/s"))
    } else {
        (String::new(), String::new())
    };
    writeln!(
        output,
        "{:>10}  {:<17} {:>11}  {:>8.3}  {:>8.2}  {:>9.3}  {:>9.3}  {:.4} {}",
        encoder.0,
        row.variant,
        encoder.1,
        row.rms_error.to_degrees(),
        row.delay * 1e3,
        row.rms_at_delay.to_degrees(),
        row.rms_error_disturbed.to_degrees(),
        row.setting,
        row.variant.setting_name()
    )
}
