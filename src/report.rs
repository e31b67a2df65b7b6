//! What a run tells when it is over.

use std::io::{self, Write};
use std::path::PathBuf;

use hinf_control::Law;
use serde::Serialize;

use uarm_log::description::ClockKind;
use uarm_loop::choice::Choice;
use uarm_loop::dimensions;
use uarm_loop::fault_code::FaultCode;
use uarm_loop::outcome::Indices;
use uarm_loop::timing::{LatencySummary, TimingSummary, Verdict};

use crate::dimensions::{LoopRobot, Outcome};
use crate::drives::Failure;
use crate::log_files::PartCount;
use crate::output_files::as_text;
use crate::robot::Robot;

/// How a run that ended as planned tells it.
pub const COMPLETED: &str = "completed";

/// The name of a fault's code among the figures of a log's end.
pub const FAULT_CODE: &str = "fault_code";

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
    /// Its name, which `uarm explain` explains.
    pub fault_code: Option<FaultCode>,
    /// Did it end as planned?
    pub completed: bool,
    /// How much of the task the numbers are about.
    pub coverage: Coverage,
    /// The indices over the task, as far as it is covered; nothing if no cycle of it is.
    pub indices: Option<Indices>,
    /// The paper's, where it has any: of its own robot and task, and of the whole of it.
    pub paper: Option<Indices>,
    /// Tracking error of the active joints in the last cycle, degrees; nothing without a cycle.
    pub final_error_deg: Option<Vec<f64>>,
    /// Largest torques applied, N·m; nothing without a cycle.
    pub peak_torque_nm: Option<Vec<f64>>,
    /// How far the base turned from the first cycle to the last, degrees; nothing without a cycle or a sensor.
    pub base_drift_deg: Option<f64>,
    /// Cycles in which the limiter cut a torque.
    pub limited_cycles: u64,
    /// Cycles in which the angle of some joint was predicted, since its drive sent none that could be believed.
    pub predicted_cycles: u64,
    /// Supply voltages and temperatures of drives that were worth a warning.
    pub reading_warnings: u64,
    /// The clock that the loop ran on.
    pub clock: ClockKind,
    /// Timing of the loop.
    pub timing: TimingSummary,
    /// What to make of it; nothing in virtual time, which has no latencies, and nothing where cycles are missing.
    pub timing_verdict: Option<Verdict>,
    /// The bus, computed from the robot file.
    pub bus: BusReport,
    /// Page faults of the loop's thread between its first cycle and its last; with locked memory there are none. In
    /// virtual time they do not matter, and are not told.
    pub page_faults: Option<u64>,
    /// The number of the first active joint: 2 behind a passive base.
    #[serde(skip)]
    pub first_active: usize,
    /// The log; in JSON, what of its name is no text is `U+FFFD`.
    #[serde(serialize_with = "as_text")]
    pub log: Option<PathBuf>,
    /// The parts that a long log was written into; nothing of a log in one file.
    pub log_parts: Option<PartCount>,
    /// Records that a log or trace lost.
    pub records_dropped: u64,
    /// Files that could not be written, and other losses.
    pub losses: Vec<String>,
}

/// How much of a task the numbers of a report are about.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Coverage {
    /// Task time up to which there are cycles, s.
    pub until_s: f64,
    /// The duration of the task, s.
    pub task_s: f64,
    /// Whether cycles that ran before that are missing.
    pub cycles_are_missing: bool,
}

impl Coverage {
    fn new<const J: usize, const N: usize>(robot: &LoopRobot<J, N>, outcome: &Outcome<N>, completed: bool) -> Self {
        let (task_s, period) = (robot.task.reference.duration(), robot.period.seconds(1));
        // A cycle stands for the period that follows it; the last ones of a task may have been skipped.
        let until = outcome.last_time.map_or(0.0, |time| time + period);
        let whole_periods = (until / period).round() * period;
        let until_s = if completed { task_s } else { whole_periods.clamp(0.0, task_s) };
        Self { until_s, task_s, cycles_are_missing: false }
    }

    /// Is it the whole task?
    pub fn is_whole(&self) -> bool {
        self.until_s >= self.task_s && !self.cycles_are_missing
    }
}

/// What a run was, for its report.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a, const J: usize = 3, const N: usize = 2> {
    /// The robot.
    pub robot: &'a Robot<J, N>,
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
    /// Its name; logs of other versions may have none.
    pub fault_code: Option<FaultCode>,
    /// Did it end as planned?
    pub completed: bool,
}

impl Ending {
    /// The motion came to its end.
    pub fn completed() -> Self {
        Self { text: COMPLETED.to_owned(), fault: None, fault_code: None, completed: true }
    }

    /// Somebody asked for the end; `stop` is what the drives said then.
    pub fn interrupted(stop: &str) -> Self {
        Self { text: format!("interrupted; {stop}"), fault: None, fault_code: None, completed: false }
    }

    /// A fault ended the run; `stop` is what the drives said then.
    pub fn failed(failure: &Failure, stop: &str) -> Self {
        let cause = failure.text();
        let text = format!("FAILED: {cause}; {stop}");
        Self { text, fault: Some(cause), fault_code: Some(failure.code), completed: false }
    }
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
    pub fn new<const J: usize, const N: usize>(
        subject: Subject<'_, J, N>,
        ending: Ending,
        outcome: &Outcome<N>,
        log: Option<PathBuf>,
    ) -> Self {
        let Subject { robot, plant, controller, clock } = subject;
        let description = &robot.description;
        let (bus, timing) = (description.bus.time, outcome.timing);
        let in_real_time = clock == ClockKind::Monotonic;
        let coverage = Coverage::new(description, outcome, ending.completed);
        let has_published = coverage.is_whole() && robot.is_the_papers();
        let published = || Law::from_name(controller).and_then(Indices::published);
        let has_cycles = outcome.last_time.is_some();
        let first_active = dimensions::number_of_active::<J, N>(0);
        Self {
            robot: description.name.clone(),
            plant: plant.to_owned(),
            controller: controller.to_owned(),
            end: ending.text,
            fault: ending.fault,
            fault_code: ending.fault_code,
            completed: ending.completed,
            coverage,
            indices: outcome.last_time.is_some_and(|time| time >= 0.0).then_some(outcome.indices),
            paper: has_published.then(published).flatten(),
            final_error_deg: has_cycles.then(|| outcome.final_error.map(f64::to_degrees).to_vec()),
            peak_torque_nm: has_cycles.then(|| outcome.peak_torque.to_vec()),
            base_drift_deg: (has_cycles && first_active > 1).then(|| outcome.base_drift.to_degrees()),
            limited_cycles: outcome.limited_cycles,
            predicted_cycles: outcome.predicted_cycles,
            reading_warnings: outcome.reading_warnings,
            clock,
            timing,
            timing_verdict: (in_real_time && has_cycles).then(|| timing.verdict()),
            bus: BusReport { time_per_cycle_us: bus.cyclic.as_secs_f64() * 1e6, load: bus.load },
            page_faults: in_real_time.then_some(outcome.page_faults.minor + outcome.page_faults.major),
            first_active,
            log,
            log_parts: None,
            records_dropped: 0,
            losses: Vec::new(),
        }
    }

    /// Says that cycles that ran are missing: what is computed without them is no figure of the whole run.
    pub fn cycles_are_missing(&mut self) {
        self.coverage.cycles_are_missing = true;
        self.paper = None;
        self.timing_verdict = None;
    }

    /// Says that the figures are those of a part of the run: indices and verdict are of the whole.
    pub fn is_part_of_a_run(&mut self) {
        self.indices = None;
        self.paper = None;
        self.timing_verdict = None;
    }

    /// Was anything lost on the way?
    pub fn has_loss(&self) -> bool {
        self.records_dropped > 0 || !self.losses.is_empty()
    }

    /// The figures of the report by name, for the log.
    pub fn figures(&self) -> Vec<(String, String)> {
        let timing = &self.timing;
        let mut figures = Vec::new();
        if let Some(Indices { l2, e }) = self.indices {
            figures.extend([("l2", l2.to_string()), ("e_nm_s", e.to_string())]);
        }
        figures.extend(self.fault_code.map(|code| (FAULT_CODE, code.name().to_owned())));
        figures.extend([
            ("cycles", timing.cycles.to_string()),
            ("missed_deadlines", timing.missed_deadlines.to_string()),
            ("skipped_ticks", timing.skipped_ticks.to_string()),
            ("limited_cycles", self.limited_cycles.to_string()),
            ("predicted_cycles", self.predicted_cycles.to_string()),
        ]);
        figures.extend(self.page_faults.map(|faults| ("page_faults", faults.to_string())));
        figures.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
    }

    /// Prints the report for people.
    ///
    /// # Errors
    /// If the output cannot be written.
    pub fn print(&self, output: &mut (impl Write + ?Sized)) -> io::Result<()> {
        writeln!(output, "{} on {}, controller {}: {}", self.robot, self.plant, self.controller, self.end)?;
        if let Some(code) = self.fault_code {
            let name = code.name();
            writeln!(output, "  fault              {name}: `uarm explain {name}` tells causes and cures")?;
        }
        self.print_indices(output)?;
        if let Some(errors) = &self.final_error_deg {
            writeln!(
                output,
                "  error at the end   {}",
                self.joint_by_joint(errors, |error| format!("{error:+.3} deg"))
            )?;
        }
        if let Some(peaks) = &self.peak_torque_nm {
            writeln!(output, "  peak torque        {}", self.joint_by_joint(peaks, |peak| format!("{peak:.4} N m")))?;
        }
        if let Some(base_drift) = self.base_drift_deg {
            writeln!(output, "  base drift         {base_drift:+.2} deg")?;
        }
        if self.limited_cycles > 0 {
            writeln!(output, "  torque limited     in {} cycles", self.limited_cycles)?;
        }
        if self.predicted_cycles > 0 {
            writeln!(
                output,
                "  angle predicted    in {} cycles: positions of drives were lost",
                self.predicted_cycles
            )?;
        }
        if self.reading_warnings > 0 {
            writeln!(
                output,
                "  WARNING            {} times a supply voltage or temperature was beyond what the robot file warns of",
                self.reading_warnings
            )?;
        }
        self.print_timing(output)?;
        if let Some(log) = &self.log {
            writeln!(output, "  log                {}", log.display())?;
        }
        if let Some(PartCount { written, deleted, last: Some(last) }) = &self.log_parts {
            let gone = if *deleted > 0 {
                format!("; the oldest {deleted} were deleted to keep the limit")
            } else {
                String::new()
            };
            writeln!(output, "                     in {written} parts, the last in {}{gone}", last.display())?;
        }
        for loss in &self.losses {
            writeln!(output, "  LOST               {loss}")?;
        }
        Ok(())
    }

    fn print_indices(&self, output: &mut (impl Write + ?Sized)) -> io::Result<()> {
        let Some(Indices { l2, e }) = self.indices else { return Ok(()) };
        match self.paper {
            Some(paper) => {
                let row =
                    |value: f64, paper: f64| format!("{value:.4}   paper {paper:.4}   ratio {:.2}", value / paper);
                writeln!(output, "  L2                 {}", row(l2, paper.l2))?;
                writeln!(output, "  E (N m s)          {}", row(e, paper.e))
            }
            None => {
                let part = self.part_of_the_task();
                writeln!(output, "  L2                 {l2:.4}{part}\n  E (N m s)          {e:.4}{part}")
            }
        }
    }

    fn joint_by_joint(&self, values: &[f64], text: impl Fn(f64) -> String) -> String {
        let joints = values.iter().zip(self.first_active..);
        joints.map(|(value, joint)| format!("joint {joint} {}", text(*value))).collect::<Vec<_>>().join("   ")
    }

    /// What must be said of indices that are not those of the whole task.
    fn part_of_the_task(&self) -> String {
        let Coverage { until_s, task_s, cycles_are_missing } = self.coverage;
        if until_s < task_s {
            format!("   of the first {until_s:.3} s of {task_s} s: not comparable")
        } else if cycles_are_missing {
            "   without the missing cycles: not comparable".to_owned()
        } else {
            String::new()
        }
    }

    fn print_timing(&self, output: &mut (impl Write + ?Sized)) -> io::Result<()> {
        let timing = &self.timing;
        let milliseconds = timing.period_ns as f64 / 1e6;
        match self.clock {
            _ if timing.cycles == 0 => writeln!(output, "  loop               no cycle")?,
            ClockKind::Virtual => {
                writeln!(output, "  loop               {} cycles of {milliseconds} ms, in virtual time", timing.cycles)?
            }
            ClockKind::Monotonic => {
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
                match self.timing_verdict {
                    Some(verdict) => {
                        writeln!(output, "  verdict            {}: {}", verdict_word(verdict), advice(verdict))?
                    }
                    None => writeln!(output, "  verdict            none: the log is not that of a whole run")?,
                }
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

/// Prints the means over the experiments that were completed, as the paper gives them over five.
///
/// # Errors
/// If the output cannot be written.
pub fn print_mean(reports: &[RunReport], output: &mut (impl Write + ?Sized)) -> io::Result<()> {
    let indices: Vec<_> =
        reports.iter().filter(|report| report.completed).filter_map(|report| report.indices).collect();
    if indices.len() < 2 {
        return Ok(());
    }
    let count = indices.len() as f64;
    let mean = |value: fn(&Indices) -> f64| indices.iter().map(value).sum::<f64>() / count;
    writeln!(
        output,
        "mean of {} experiments: L2 {:.4}, E {:.4} N m s",
        indices.len(),
        mean(|indices| indices.l2),
        mean(|indices| indices.e)
    )
}
