//! What `exact` and `what_if` tell alike.

use std::io::{self, Write};

use serde::Serialize;
use uarm_log::reader::Part;
use uarm_log::replay::exact::ExactReplay;
use uarm_log::replay::one_clock::ClockStep;
use uarm_log::replay::what_if::{TorqueSummary, WhatIfOutcome};

use super::recorded::Recorded;

/// The result as JSON.
#[derive(Serialize)]
pub struct Report<'a> {
    pub file: &'a str,
    pub controller: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exact: Option<&'a ExactReplay>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub what_if: Option<WhatIfReport>,
    pub part: &'a Part,
    pub damage: &'a [String],
    pub clock_steps: &'a [ClockStep],
}

/// The torques of a what-if as JSON, N·m.
#[derive(Serialize)]
pub struct WhatIfReport {
    cycles: u64,
    rms_difference_nm: Vec<f64>,
    largest_difference_nm: Vec<f64>,
    rms_recorded_nm: Vec<f64>,
    rms_other_nm: Vec<f64>,
    lost_cycles: u64,
}

impl WhatIfReport {
    pub fn new<const N: usize>(what_if: &WhatIfOutcome<N>) -> Self {
        let TorqueSummary { rms_difference, largest_difference, rms_recorded, rms_other } = what_if.summary;
        Self {
            cycles: what_if.cycles,
            rms_difference_nm: rms_difference.to_vec(),
            largest_difference_nm: largest_difference.to_vec(),
            rms_recorded_nm: rms_recorded.to_vec(),
            rms_other_nm: rms_other.to_vec(),
            lost_cycles: what_if.lost_cycles,
        }
    }
}

/// The most steps of a clock that have a line each: more are a clock that runs at another rate.
const MOST_STEPS_TOLD: usize = 5;

fn print_clock_steps(steps: &[ClockStep], output: &mut impl Write) -> io::Result<()> {
    for ClockStep { after_s, by_s } in steps.iter().take(MOST_STEPS_TOLD) {
        writeln!(output, "  clock set          by {by_s:+.3} s, {after_s:.3} s after the first frame: taken out")?;
    }
    if let Some(last) = steps.get(MOST_STEPS_TOLD..).and_then(<[_]>::last) {
        let by_s: f64 = steps.iter().map(|step| step.by_s).sum();
        let (times, after_s) = (steps.len(), last.after_s);
        writeln!(output, "  clock set          {times} times by {by_s:+.3} s in all, until {after_s:.3} s: taken out")?;
    }
    Ok(())
}

/// What is to be said of the recording itself.
pub fn print_recording<const J: usize, const N: usize>(
    recorded: &Recorded<J, N>,
    output: &mut impl Write,
) -> io::Result<()> {
    print_clock_steps(&recorded.clock_steps, output)?;
    for damage in &recorded.damage {
        writeln!(output, "  LOST               {damage}")?;
    }
    Ok(())
}
