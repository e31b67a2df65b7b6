//! What a run tells when it is over.

use std::io::{self, Write};
use std::path::PathBuf;

use hinf_control::Law;
use serde::Serialize;

use uarm_log::description::ClockKind;
use uarm_loop::outcome::Indices;
use uarm_loop::timing::{LatencySummary, TimingSummary, Verdict};

use crate::dimensions::{ACTIVE, LoopRobot, Outcome};

/// How a run that ended as planned tells it.
pub const COMPLETED: &str = "completed";

/// The summary of one run, as printed and as `--json` gives it. Angles in degrees, torques in N·m, indices as in
/// Table 4 of the paper.
#[derive(Clone, Debug, Serialize)]
pub struct RunReport {
    /// The robot's name.
    pub robot: String,
    /// What moved: the simulated plant, or the interface.
    pub plant: String,
    /// The control law.
    pub controller: String,
    /// How it ended.
    pub end: String,
    /// The first cause of an end that was not asked for.
    pub fault: Option<String>,
    /// Did it end as planned?
    pub completed: bool,
    /// The indices over the task's duration.
    pub indices: Indices,
    /// The paper's, where it has any.
    pub paper: Option<Indices>,
    /// Tracking error of joints 2 and 3 in the last cycle, degrees.
    pub final_error_deg: [f64; ACTIVE],
    /// Largest torques applied, N·m.
    pub peak_torque_nm: [f64; ACTIVE],
    /// How far the base turned from the first cycle to the last, degrees.
    pub base_drift_deg: f64,
    /// Cycles in which the limiter cut a torque.
    pub limited_cycles: u64,
    /// The clock that the loop ran on.
    pub clock: ClockKind,
    /// Timing of the loop.
    pub timing: TimingSummary,
    /// What to make of it; nothing in virtual time, which has no latencies.
    pub timing_verdict: Option<Verdict>,
    /// The bus, computed from the robot file.
    pub bus: BusReport,
    /// Page faults of the loop's thread between its first cycle and its last; with locked memory there are none. In
    /// virtual time they do not matter, and are not told.
    pub page_faults: Option<u64>,
    /// The log.
    pub log: Option<PathBuf>,
    /// Records that a log or trace lost.
    pub records_dropped: u64,
    /// Files that could not be written, and other losses.
    pub losses: Vec<String>,
}

/// What a run was, for its report.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// The robot.
    pub robot: &'a LoopRobot,
    /// The simulated plant, or the interface.
    pub plant: &'a str,
    /// The name of the control law; logs may name one that this version does not know.
    pub controller: &'a str,
    /// The clock of the loop.
    pub clock: ClockKind,
}

/// How a run ended, in words.
#[derive(Clone, Debug)]
pub struct Ending {
    /// The end in words.
    pub text: String,
    /// The first cause of an end that was not asked for.
    pub fault: Option<String>,
    /// Did it end as planned?
    pub completed: bool,
}

/// Bus time, computed with worst-case bit stuffing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BusReport {
    /// Time on the bus per cycle, µs.
    pub time_per_cycle_us: f64,
    /// Share of the period.
    pub load: f64,
}

impl RunReport {
    /// The report of a run of which no record was lost.
    pub fn new(subject: Subject<'_>, ending: Ending, outcome: &Outcome, log: Option<PathBuf>) -> Self {
        let Subject { robot, plant, controller, clock } = subject;
        let (bus, timing) = (robot.bus.time, outcome.timing);
        let in_real_time = clock == ClockKind::Monotonic;
        Self {
            robot: robot.name.clone(),
            plant: plant.to_owned(),
            controller: controller.to_owned(),
            end: ending.text,
            fault: ending.fault,
            completed: ending.completed,
            indices: outcome.indices,
            paper: Law::from_name(controller).and_then(Indices::published),
            final_error_deg: outcome.final_error.map(f64::to_degrees),
            peak_torque_nm: outcome.peak_torque,
            base_drift_deg: outcome.base_drift.to_degrees(),
            limited_cycles: outcome.limited_cycles,
            clock,
            timing,
            timing_verdict: in_real_time.then(|| timing.verdict()),
            bus: BusReport { time_per_cycle_us: bus.cyclic.as_secs_f64() * 1e6, load: bus.load },
            page_faults: in_real_time.then_some(outcome.page_faults.minor + outcome.page_faults.major),
            log,
            records_dropped: 0,
            losses: Vec::new(),
        }
    }

    /// Was anything lost on the way?
    pub fn has_loss(&self) -> bool {
        self.records_dropped > 0 || !self.losses.is_empty()
    }

    /// The figures of the report by name, for the log.
    pub fn figures(&self) -> Vec<(String, String)> {
        let Indices { l2, e } = self.indices;
        let timing = &self.timing;
        let mut figures = vec![
            ("l2", l2.to_string()),
            ("e_nm_s", e.to_string()),
            ("cycles", timing.cycles.to_string()),
            ("missed_deadlines", timing.missed_deadlines.to_string()),
            ("skipped_ticks", timing.skipped_ticks.to_string()),
            ("limited_cycles", self.limited_cycles.to_string()),
        ];
        figures.extend(self.page_faults.map(|faults| ("page_faults", faults.to_string())));
        figures.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
    }

    /// Prints the report for people.
    ///
    /// # Errors
    /// If the output cannot be written.
    pub fn print(&self, output: &mut impl Write) -> io::Result<()> {
        writeln!(output, "{} on {}, controller {}: {}", self.robot, self.plant, self.controller, self.end)?;
        self.print_indices(output)?;
        let [error_2, error_3] = self.final_error_deg;
        let [peak_2, peak_3] = self.peak_torque_nm;
        writeln!(output, "  error at the end   joint 2 {error_2:+.3} deg   joint 3 {error_3:+.3} deg")?;
        writeln!(output, "  peak torque        joint 2 {peak_2:.4} N m   joint 3 {peak_3:.4} N m")?;
        writeln!(output, "  base drift         {:+.2} deg", self.base_drift_deg)?;
        if self.limited_cycles > 0 {
            writeln!(output, "  torque limited     in {} cycles", self.limited_cycles)?;
        }
        self.print_timing(output)?;
        if let Some(log) = &self.log {
            writeln!(output, "  log                {}", log.display())?;
        }
        for loss in &self.losses {
            writeln!(output, "  LOST               {loss}")?;
        }
        Ok(())
    }

    fn print_indices(&self, output: &mut impl Write) -> io::Result<()> {
        let Indices { l2, e } = self.indices;
        match self.paper {
            Some(paper) => {
                let row =
                    |value: f64, paper: f64| format!("{value:.4}   paper {paper:.4}   ratio {:.2}", value / paper);
                writeln!(output, "  L2                 {}", row(l2, paper.l2))?;
                writeln!(output, "  E (N m s)          {}", row(e, paper.e))
            }
            None => writeln!(output, "  L2                 {l2:.4}\n  E (N m s)          {e:.4}"),
        }
    }

    fn print_timing(&self, output: &mut impl Write) -> io::Result<()> {
        let timing = &self.timing;
        let milliseconds = timing.period_ns as f64 / 1e6;
        match self.timing_verdict {
            None => {
                writeln!(output, "  loop               {} cycles of {milliseconds} ms, in virtual time", timing.cycles)?
            }
            Some(verdict) => {
                writeln!(
                    output,
                    "  loop               {} cycles of {milliseconds} ms, {} deadlines missed, {} ticks skipped",
                    timing.cycles, timing.missed_deadlines, timing.skipped_ticks
                )?;
                for line in latency_table(timing) {
                    writeln!(output, "    {line}")?;
                }
                if let Some(faults) = self.page_faults {
                    writeln!(output, "  page faults        {faults} in the loop")?;
                }
                writeln!(output, "  verdict            {}: {}", verdict_word(verdict), advice(verdict))?;
            }
        }
        writeln!(
            output,
            "  bus                {:.0} us of each cycle ({:.0} % load, computed for the worst case)",
            self.bus.time_per_cycle_us,
            self.bus.load * 100.0
        )
    }
}

/// The latencies of a loop, line by line.
pub fn latency_table(timing: &TimingSummary) -> [String; 4] {
    [
        format!("{:<16} {:>8}  {:>8}  {:>8}  {:>8}  {:>8}", "latency (us)", "min", "mean", "p99", "p99.9", "max"),
        latency_row("wake-up", &timing.wake_up),
        latency_row("SYNC to counts", &timing.feedback_latency),
        latency_row("total", &timing.total),
    ]
}

fn latency_row(name: &str, latency: &LatencySummary) -> String {
    let microseconds = |nanoseconds: u64| nanoseconds as f64 / 1e3;
    format!(
        "{name:<16} {:>8.1}  {:>8.1}  {:>8.1}  {:>8.1}  {:>8.1}",
        microseconds(latency.minimum_ns),
        latency.mean_ns / 1e3,
        microseconds(latency.p99_ns),
        microseconds(latency.p999_ns),
        microseconds(latency.maximum_ns)
    )
}

/// What to do about a verdict.
fn advice(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Good => "the loop keeps its deadline with half of the period to spare",
        Verdict::Tight => {
            "no deadline was missed, but little is left: run `uarm doctor`, and see docs/realtime.md for a real-time \
             kernel, priorities and an isolated CPU"
        }
        Verdict::Missed => {
            "do not run motors like this: run `uarm doctor`, use a PREEMPT_RT kernel, let uarm have SCHED_FIFO and locked \
             memory (--rt enforce), keep other load off its CPU (docs/realtime.md)"
        }
    }
}

fn verdict_word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Good => "good",
        Verdict::Tight => "tight",
        Verdict::Missed => "deadlines missed",
    }
}

/// Prints the means over several experiments, as the paper gives them over five.
///
/// # Errors
/// If the output cannot be written.
pub fn print_mean(reports: &[RunReport], output: &mut impl Write) -> io::Result<()> {
    let count = reports.len() as f64;
    let mean = |value: fn(&RunReport) -> f64| reports.iter().map(value).sum::<f64>() / count;
    writeln!(
        output,
        "mean of {} experiments: L2 {:.4}, E {:.4} N m s",
        reports.len(),
        mean(|report| report.indices.l2),
        mean(|report| report.indices.e)
    )
}
