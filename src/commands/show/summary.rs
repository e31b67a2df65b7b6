//! All that is told of a run.

use std::time::{Duration, UNIX_EPOCH};

use serde::Serialize;

use uarm_log::decoder::LoggedNote;
use uarm_log::description::Fields;
use uarm_log::drives::LoggedDrive;
use uarm_log::proto;
use uarm_log::reader::Part;
use uarm_log::time_axis::seconds_between;
use uarm_loop::choice::Choice;
use uarm_loop::fault_code::FaultCode;
use uarm_loop::recording::Severity;

use super::tally::Tally;
use crate::dimensions::RunLog;
use crate::report::{COMPLETED, Ending, FAULT_CODE, RunReport, Subject};
use crate::robot::Robot;

/// A run as its log tells it.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Why it failed, and what the flight recorder kept.
    pub fault: Option<FlightRecord>,
    /// The run's report, recomputed from the cycles in the log. What is missing or damaged stands among its losses.
    pub report: RunReport,
    /// Which part of the run the log is.
    pub part: Part,
    /// Figures that the run itself recorded otherwise.
    pub disagreements: Vec<Disagreement>,
    /// What is in the log.
    pub contents: Contents,
    /// How the torques faded after somebody asked for the end.
    pub stop_ramp: Option<StopRamp>,
    /// Version, commit, kernel, CPU and real-time settings.
    pub machine: Fields,
    /// Which drives moved the robot, as they said themselves.
    pub drives: Vec<LoggedDrive>,
    /// Bus and drives as they were last.
    pub health: Option<proto::CanHealth>,
    /// Warnings, and what is worse.
    pub warnings: Vec<Warning>,
}

/// The end of a failed run.
#[derive(Clone, Debug, Serialize)]
pub struct FlightRecord {
    /// The first cause.
    pub cause: String,
    /// The last cycle before it.
    pub last_tick: Option<u64>,
    /// When it was, s after the first cycle was due.
    pub at_s: f64,
    /// How long the marked part of the log before it is, s.
    pub window_s: f64,
    /// Cycles in that part.
    pub cycles: usize,
    /// The number of frames in that part.
    pub frames: usize,
    /// Cycles that were kept beside the queue because the writer was late.
    pub cycles_kept: u64,
    /// Frames that were kept beside the queue.
    pub frames_kept: u64,
}

/// A figure that the run recorded otherwise than its cycles give it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Disagreement {
    /// The figure's name.
    pub figure: String,
    /// As the run recorded it.
    pub recorded: String,
    /// As the cycles in the log give it.
    pub recomputed: String,
}

/// How much is in a log.
#[derive(Clone, Debug, Serialize)]
pub struct Contents {
    /// When the first cycle was due, RFC 3339; in virtual time from 2000-01-01 on.
    pub begin: String,
    /// From there to the end of the last cycle, s.
    pub duration_s: f64,
    /// The number of cycles.
    pub cycles: usize,
    /// The number of frames.
    pub frames: usize,
    /// Keyframes, from which a replay can begin.
    pub keyframes: usize,
}

/// The ramp of a stop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StopRamp {
    /// Task time at which it began, s.
    pub from_s: f64,
    /// Cycles with fading torques.
    pub cycles: usize,
}

/// A note that matters.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Warning {
    /// When, s after the first cycle was due.
    pub at_s: f64,
    /// Whether the run failed of it.
    pub fatal: bool,
    /// The text of the note.
    pub text: String,
}

impl Summary {
    /// The summary of a log of a run of `robot`, of which `tally` has what is not in `log`: cycles and frames.
    pub fn of<const J: usize, const N: usize>(log: &RunLog<J, N>, tally: &Tally<J, N>, robot: &Robot<J, N>) -> Self {
        let begin = begin(log, tally);
        let report = report(log, tally, robot);
        Self {
            fault: log.fault.as_ref().map(|fault| flight_record(fault, tally, begin)),
            part: log.part.clone(),
            disagreements: if log.part.is_all() { disagreements(log, &report) } else { Vec::new() },
            contents: contents(log, tally, begin),
            stop_ramp: tally.stopping.map(|(from_s, cycles)| StopRamp { from_s, cycles }),
            machine: log.machine.clone(),
            drives: log.drives.clone(),
            health: log.health.last().cloned(),
            warnings: log.notes.iter().filter_map(|note| warning(note, begin)).collect(),
            report,
        }
    }

    /// Is all there that the run recorded?
    pub fn is_whole(&self) -> bool {
        !self.report.has_loss()
    }
}

/// When the first cycle was due on the file's axis, or the file begins if it has no cycle.
fn begin<const J: usize, const N: usize>(log: &RunLog<J, N>, tally: &Tally<J, N>) -> u64 {
    let first_cycle = tally.first.as_ref().map(|record| log.run.axis.at(record.instants.scheduled));
    first_cycle.or_else(|| log.notes.first().map(|note| note.at)).unwrap_or_default()
}

fn report<const J: usize, const N: usize>(log: &RunLog<J, N>, tally: &Tally<J, N>, robot: &Robot<J, N>) -> RunReport {
    let subject = Subject { robot, plant: &log.run.place, controller: &log.run.controller, clock: log.run.clock() };
    let mut outcome = tally.outcome.outcome();
    let missed = &mut outcome.timing.missed_deadlines;
    // The cycle that a fault ended has no record.
    if log.fault.is_some() && number(log, "missed_deadlines") == Some(*missed + 1) {
        *missed += 1;
    }
    let mut report = RunReport::new(subject, ending(log), &outcome, Some(log.path.clone()));
    report.page_faults = number(log, "page_faults");
    report.records_dropped = records_dropped(log);
    report.reading_warnings = log.health.last().map_or(0, reading_warnings);
    report.losses.clone_from(&log.damage);
    if report.records_dropped > 0 {
        report.losses.push(format!("{} records were dropped: the disk was too slow", report.records_dropped));
    }
    let logged = u64::try_from(tally.cycles).unwrap_or(u64::MAX);
    // The last part tells the cycles of all.
    let ran = number(log, "cycles").filter(|_| log.part.is_all()).unwrap_or(logged);
    if ran > logged {
        report.losses.push(format!("{} of {ran} cycles are not in the log", ran - logged));
    }
    let begins_late = tally.first.as_ref().is_some_and(|record| record.tick > 0);
    if !log.part.is_all() {
        report.is_part_of_a_run();
    }
    if ran > logged || tally.has_gaps || begins_late {
        report.cycles_are_missing();
    }
    // Without an end nobody knows how many cycles ran, and how the last were.
    if log.end.is_none() {
        report.timing_verdict = None;
    }
    report
}

fn reading_warnings(health: &proto::CanHealth) -> u64 {
    health.nodes.iter().map(|node| node.reading_warnings).sum()
}

fn ending<const J: usize, const N: usize>(log: &RunLog<J, N>) -> Ending {
    let recorded = |name: &str| log.end.as_ref().and_then(|end| end.get(name)).filter(|text| !text.is_empty());
    let text = recorded("end").cloned().unwrap_or_else(|| match &log.part.next {
        Some(next) => format!("goes on in {next}"),
        None => "no end is recorded".to_owned(),
    });
    let fault = log.fault.as_ref().map(|fault| fault.cause.clone()).or_else(|| recorded("fault").cloned());
    let fault_code = recorded(FAULT_CODE).and_then(|name| FaultCode::from_name(name));
    Ending { completed: text == COMPLETED, text, fault, fault_code }
}

/// A figure that the run recorded at its end.
fn number<const J: usize, const N: usize>(log: &RunLog<J, N>, name: &str) -> Option<u64> {
    log.end.as_ref()?.get(name)?.parse().ok()
}

fn records_dropped<const J: usize, const N: usize>(log: &RunLog<J, N>) -> u64 {
    let last_told = log.health.last().map(|health| health.records_dropped);
    number(log, "records_dropped").or(last_told).unwrap_or_default()
}

fn disagreements<const J: usize, const N: usize>(log: &RunLog<J, N>, report: &RunReport) -> Vec<Disagreement> {
    let Some(end) = &log.end else { return Vec::new() };
    let differs = |(figure, recomputed): (String, String)| {
        let recorded = end.get(&figure).filter(|recorded| **recorded != recomputed)?.clone();
        Some(Disagreement { figure, recorded, recomputed })
    };
    report.figures().into_iter().filter_map(differs).collect()
}

fn contents<const J: usize, const N: usize>(log: &RunLog<J, N>, tally: &Tally<J, N>, begin: u64) -> Contents {
    let end = tally.last.as_ref().map_or(begin, |record| log.run.axis.at(record.instants.done));
    Contents {
        begin: humantime::format_rfc3339_millis(UNIX_EPOCH + Duration::from_nanos(begin)).to_string(),
        duration_s: seconds_between(begin, end),
        cycles: tally.cycles,
        frames: tally.frames,
        keyframes: tally.keyframes,
    }
}

fn flight_record<const J: usize, const N: usize>(
    fault: &proto::Fault,
    tally: &Tally<J, N>,
    begin: u64,
) -> FlightRecord {
    let [cycles, frames] = tally.in_window;
    FlightRecord {
        cause: fault.cause.clone(),
        last_tick: fault.last_tick,
        at_s: seconds_between(begin, fault.at_ns),
        window_s: seconds_between(fault.window_start_ns.max(begin), fault.at_ns).max(0.0),
        cycles,
        frames,
        cycles_kept: fault.cycles_kept,
        frames_kept: fault.frames_kept,
    }
}

fn warning(note: &LoggedNote, begin: u64) -> Option<Warning> {
    let fatal = match note.severity {
        Severity::Info => return None,
        Severity::Warning => false,
        Severity::Fatal => true,
    };
    Some(Warning { at_s: seconds_between(begin, note.at), fatal, text: note.text.clone() })
}
