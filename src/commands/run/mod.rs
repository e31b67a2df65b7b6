//! `uarm run`: the paper's experiment, on the simulated robot or on real drives.

mod learned;
mod loop_thread;
mod place;
mod recording;
mod rehearsal;
mod session;
mod stability;
mod watch;
mod way;

use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::Context;
use hinf_control::{AdaptationGuard, BaseAcceleration, Disturbance, Law};
use uarm_io::realtime::RealtimePolicy;
use uarm_log::parts::{NewestBytes, SizeLimit};
use uarm_loop::schedule::OverrunPolicy;
use uarm_loop::settings::Settings;
use uarm_loop::task_clock::PeriodSource;
use uarm_loop::torque::DisturbanceSite;

use crate::bought::{Bought, DictionaryArguments};
use crate::console;
use crate::exit::Exit;
use crate::log_files::LogChoice;
use crate::options::{self, choice};
use crate::realtime::{Realtime, RealtimeArguments};
use crate::reference;
use crate::report::{RunReport, print_mean};
use crate::robot::Robot;
use crate::robot::RobotText;
use crate::robot::overrides::Overrides;
use crate::robot::shape::for_shape;
use crate::signals;
use crate::simulated_plant::{PlantChoice, usual_disturbance};
use crate::usage::UsageError;
use place::Place;
use recording::Repetition;
pub use rehearsal::{SimulatedEnd, rehearse, simulate};
use session::Session;

/// Arguments of `uarm run`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  uarm run                                   the paper's task on the simulated robot, in real time
  uarm run --virtual-time --log run.mcap     the same in milliseconds, recorded in a file of your choice
  uarm run --controller adaptive --plant ideal
  uarm plant --can vcan0 &  uarm run --can vcan0
  uarm run --can can0 --robot my-robot.toml  real drives: keep a hand on the emergency stop
  uarm run --virtual-time --robot my-robot.toml --eds drive.eds --node 2 --eds drive.eds --node 3

The simulated robot has the joints and limits of the robot file, and drives of its own, or with the objects of makers' dictionaries
(--eds): a robot of bought drives is rehearsed so before it is wired.")]
pub struct Arguments {
    /// The control law
    #[arg(long, default_value = Law::Nonlinear.name(), value_parser = choice::<Law>(), value_name = "LAW")]
    controller: Law,
    /// The robot file; without it the paper's UARM, which is built in
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// Drive the real drives on this CAN interface, such as can0 or vcan0
    #[arg(long, value_name = "INTERFACE", conflicts_with_all = ["plant", "virtual_time", "eds"])]
    can: Option<String>,
    /// What the simulated robot is; by default it has the imperfections of the robot file's [plant], and is "ideal" without
    #[arg(long, value_parser = choice::<PlantChoice>(), value_name = "PLANT")]
    plant: Option<PlantChoice>,
    #[command(flatten)]
    dictionaries: DictionaryArguments,
    /// Run the simulated robot in virtual time: the same loop, as fast as it goes, bit for bit the same each time
    #[arg(long)]
    virtual_time: bool,
    /// The loop's period, such as 3ms or 1ms, instead of the robot file's
    #[arg(long, allow_hyphen_values = true, value_parser = options::period, value_name = "TIME")]
    period: Option<Duration>,
    /// How long the end of the motion is held, such as 500ms or 60s, instead of the robot file's
    #[arg(long, allow_hyphen_values = true, value_parser = options::hold, value_name = "TIME")]
    hold: Option<Duration>,
    /// Go to the start of the motion first, from wherever the joints are, in this time, such as 5s
    #[arg(long, allow_hyphen_values = true, value_parser = options::approach, value_name = "TIME")]
    approach: Option<Duration>,
    /// How the law has the base acceleration, where it has a choice, instead of the robot file's
    #[arg(long, value_parser = choice::<BaseAcceleration>(), value_name = "MODE")]
    base_acceleration: Option<BaseAcceleration>,
    /// What keeps adapted parameters from drifting; by default "bounded" with --can and "none" otherwise, as in the paper
    #[arg(long, value_parser = choice::<AdaptationGuard>(), value_name = "GUARD")]
    adaptation: Option<AdaptationGuard>,
    /// Let the fuzzy laws run with the sets in this file, as uarm train writes it; without it with the untrained grid
    #[arg(long, value_name = "FILE.toml")]
    fuzzy_sets: Option<PathBuf>,
    /// Run the experiment this many times
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000), value_name = "N")]
    repeat: u32,
    /// The disturbance (paper eq. 48); by default "paper" on the paper's arm, simulated, and "none" on others and with --can
    #[arg(long, value_parser = choice::<Disturbance>(), value_name = "KIND")]
    disturbance: Option<Disturbance>,
    /// Where the disturbance acts; by default on the simulated plant's joints, and on the sent torque with --can
    #[arg(long, value_parser = choice::<DisturbanceSite>(), value_name = "SITE")]
    disturbance_site: Option<DisturbanceSite>,
    /// What to do when a cycle ends after the next should have begun
    #[arg(long, value_parser = choice::<OverrunPolicy>(), default_value = "skip", value_name = "POLICY")]
    overrun: OverrunPolicy,
    /// Where the period that estimators and laws are told comes from
    #[arg(long, value_parser = choice::<PeriodSource>(), default_value = "scheduled", value_name = "SOURCE")]
    dt: PeriodSource,
    #[command(flatten)]
    realtime: RealtimeArguments,
    /// Where the run is recorded, as MCAP for Foxglove, `uarm show` and `uarm replay`: a new file, or "none"; without this
    /// option runs/TIME-CONTROLLER.mcap
    #[arg(long, allow_hyphen_values = true, value_name = "FILE|none")]
    log: Option<LogChoice>,
    /// Keep the newest of the recording, at most so much, such as 500MB or 2GiB, in parts that each replay on their own; the
    /// oldest are deleted; without this option all is kept
    #[arg(long, value_parser = options::size, value_name = "SIZE")]
    log_limit: Option<u64>,
    /// Print the reports as JSON
    #[arg(long)]
    json: bool,
}

/// Runs the experiments and prints their reports.
///
/// # Errors
/// If the robot file is wrong, or an experiment cannot be begun.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let text = RobotText::read(arguments.robot.as_deref())?;
    for_shape!(text.shape()?, run_robot(arguments, &text))
}

fn run_robot<const J: usize, const N: usize>(arguments: &Arguments, text: &RobotText) -> anyhow::Result<ExitCode> {
    let robot = robot::<J, N>(arguments, text)?;
    let place = place(arguments, &robot)?;
    for line in stability::admit(&robot, arguments.controller, &place)? {
        console::tell(line);
    }
    let stop = signals::stop_request().context("signal handlers")?;
    let session = Session {
        settings: settings(arguments, usual_disturbance(&robot)),
        place,
        realtime: realtime(arguments)?,
        log: arguments.log.clone().unwrap_or_default(),
        log_limit: log_limit(arguments, robot.description.period.duration())?,
        bought: Bought::read(&arguments.dictionaries, &robot.description.nodes())?,
    };
    let mut reports = Vec::new();
    for number in 1..=arguments.repeat {
        if stop.is_made() {
            break;
        }
        let report = session.run(&robot, Repetition { number, of: arguments.repeat }, &stop)?;
        if !arguments.json {
            deliver(|output| report.print(output));
        }
        let completed = report.completed;
        if !completed {
            console::tell(format_args!("uarm: {}", report.end));
        }
        reports.push(report);
        if !completed {
            break;
        }
    }
    if arguments.json {
        if let Err(error) = console::print_json(&reports) {
            tell_instead(&error, |output| reports.iter().try_for_each(|report| report.print(output)));
        }
    } else if reports.len() > 1 {
        deliver(|output| print_mean(&reports, output));
    }
    Ok(outcome(&reports, arguments.can.is_some()).into())
}

/// Prints to standard output, or, where that fails, to standard error: the motion was made, and its report must not be lost.
/// What the run came to is not changed by who reads of it.
fn deliver(print: impl Fn(&mut dyn Write) -> io::Result<()>) {
    let mut output = console::output();
    if let Err(error) = print(&mut output).and_then(|()| output.flush()) {
        tell_instead(&error, print);
    }
}

fn tell_instead(error: &io::Error, print: impl Fn(&mut dyn Write) -> io::Result<()>) {
    let mut text = Vec::new();
    // A `Vec` takes everything.
    let _ = print(&mut text);
    console::tell(format_args!("uarm: {error}; the report:\n{}", String::from_utf8_lossy(&text)));
}

/// Missed deadlines are a loss where motors were driven; on the simulated robot they only tell of the machine.
fn outcome(reports: &[RunReport], drives: bool) -> Exit {
    let late = |report: &RunReport| report.timing.missed_deadlines + report.timing.skipped_ticks > 0;
    if reports.iter().any(|report| !report.completed) {
        Exit::Failure
    } else if reports.iter().any(|report| report.has_loss() || (drives && late(report))) {
        Exit::Loss
    } else {
        Exit::Ok
    }
}

fn robot<const J: usize, const N: usize>(arguments: &Arguments, text: &RobotText) -> anyhow::Result<Robot<J, N>> {
    let overrides = Overrides {
        period: arguments.period,
        hold: arguments.hold,
        base_acceleration: arguments.base_acceleration.map(|mode| (arguments.controller, mode)),
    };
    let mut robot = Robot::<J, N>::of_text(&text.name, &text.text, &overrides)?;
    if let Some(interface) = &arguments.can {
        let name = interface.parse().with_context(|| format!("--can {interface}"))?;
        let (referenced, lines) = reference::apply(robot, arguments.robot.as_deref(), name)?;
        lines.iter().for_each(console::tell);
        robot = referenced;
    }
    robot.load_fuzzy_sets(arguments.fuzzy_sets.as_deref(), std::iter::once(arguments.controller))?;
    Ok(robot)
}

/// On drives, what is safe; on the simulated robot, what the paper did.
fn settings(arguments: &Arguments, of_plant: Disturbance) -> Settings {
    let (guard, disturbance, disturbance_site) = match &arguments.can {
        Some(_) => (AdaptationGuard::Bounded, Disturbance::None, DisturbanceSite::Command),
        None => (AdaptationGuard::None, of_plant, DisturbanceSite::Plant),
    };
    Settings {
        law: arguments.controller,
        guard: arguments.adaptation.unwrap_or(guard),
        overrun: arguments.overrun,
        period_source: arguments.dt,
        approach: arguments.approach,
        disturbance: arguments.disturbance.unwrap_or(disturbance),
        disturbance_site: arguments.disturbance_site.unwrap_or(disturbance_site),
    }
}

fn place<const J: usize, const N: usize>(arguments: &Arguments, robot: &Robot<J, N>) -> anyhow::Result<Place> {
    let plant = PlantChoice::asked(arguments.plant, robot)?;
    Ok(match (&arguments.can, arguments.virtual_time) {
        (Some(interface), _) => Place::Interface(interface.clone()),
        (None, true) => Place::SimulatedVirtualTime(plant),
        (None, false) => Place::SimulatedRealTime(plant),
    })
}

fn log_limit(arguments: &Arguments, period: Duration) -> anyhow::Result<SizeLimit> {
    let Some(bytes) = arguments.log_limit else { return Ok(SizeLimit::Unlimited) };
    if arguments.log == Some(LogChoice::None) {
        return Err(UsageError::new("--log-limit: expected a log, --log none writes none").into());
    }
    let least = NewestBytes::least(period);
    let limit = NewestBytes::new(bytes, period);
    let limit = limit.map(SizeLimit::Newest).ok_or_else(|| {
        UsageError::new(format!(
            "--log-limit: {bytes} bytes, expected at least {least}, eight parts of 4 s with a period of {period:?}"
        ))
    });
    Ok(limit?)
}

fn realtime(arguments: &Arguments) -> anyhow::Result<Realtime> {
    let default = if arguments.can.is_some() { RealtimePolicy::Enforce } else { RealtimePolicy::Prefer };
    arguments.realtime.settings(default)
}

#[cfg(test)]
mod tests {
    use clap::Parser;
    use uarm_loop::outcome::Indices;
    use uarm_loop::timing::{LatencySummary, TimingSummary};

    use super::*;
    use crate::report::{BusReport, Coverage};

    /// A run that completed in time and lost nothing.
    fn report() -> RunReport {
        let latency = LatencySummary::default();
        RunReport {
            robot: "UARM".to_owned(),
            plant: "can0".to_owned(),
            controller: "nonlinear".to_owned(),
            end: "completed".to_owned(),
            fault: None,
            fault_code: None,
            completed: true,
            coverage: Coverage { until_s: 3.0, task_s: 3.0, cycles_are_missing: false },
            indices: Some(Indices { l2: 0.1, e: 0.1 }),
            paper: None,
            final_error_deg: None,
            peak_torque_nm: None,
            base_drift_deg: None,
            limited_cycles: 7,
            predicted_cycles: 0,
            reading_warnings: 0,
            clock: uarm_log::description::ClockKind::Monotonic,
            timing: TimingSummary {
                period_ns: 3_000_000,
                cycles: 1_000,
                missed_deadlines: 0,
                skipped_ticks: 0,
                wake_up: latency,
                feedback_latency: latency,
                total: latency,
            },
            timing_verdict: None,
            bus: BusReport { time_per_cycle_us: 695.0, load: 0.23 },
            page_faults: None,
            first_active: 2,
            log: None,
            log_parts: None,
            records_dropped: 0,
            losses: Vec::new(),
        }
    }

    #[test]
    fn late_cycles_are_a_loss_where_motors_were_driven() {
        let mut missed = report();
        missed.timing.missed_deadlines = 1;
        let mut skipped = report();
        skipped.timing.skipped_ticks = 1;
        assert_eq!(outcome(&[report()], true), Exit::Ok);
        for late in [missed, skipped] {
            assert_eq!(outcome(&[report(), late.clone(), report()], true), Exit::Loss);
            assert_eq!(outcome(&[late], false), Exit::Ok, "on the simulated robot they tell of the machine");
        }
    }

    #[test]
    fn lost_records_are_a_loss_everywhere_and_a_failure_is_worse() {
        let dropped = RunReport { records_dropped: 1, ..report() };
        let unwritten = RunReport { losses: vec!["a file".to_owned()], ..report() };
        let failed = RunReport { completed: false, ..report() };
        for drives in [false, true] {
            assert_eq!(outcome(std::slice::from_ref(&dropped), drives), Exit::Loss);
            assert_eq!(outcome(&[report(), unwritten.clone()], drives), Exit::Loss);
            assert_eq!(outcome(&[dropped.clone(), failed.clone()], drives), Exit::Failure);
        }
    }

    #[derive(clap::Parser)]
    struct CommandLine {
        #[command(flatten)]
        arguments: Arguments,
    }

    fn settings_of(options: &[&str]) -> (AdaptationGuard, Disturbance, DisturbanceSite) {
        let words = std::iter::once("run").chain(options.iter().copied());
        let Settings { guard, disturbance, disturbance_site, .. } =
            settings(&CommandLine::try_parse_from(words).unwrap().arguments, Disturbance::Paper);
        (guard, disturbance, disturbance_site)
    }

    #[test]
    fn drives_get_what_is_safe_and_the_simulated_robot_what_the_paper_did() {
        let paper = (AdaptationGuard::None, Disturbance::Paper, DisturbanceSite::Plant);
        assert_eq!(settings_of(&[]), paper);
        assert_eq!(settings_of(&["--virtual-time", "--plant", "ideal"]), paper);
        let safe = (AdaptationGuard::Bounded, Disturbance::None, DisturbanceSite::Command);
        assert_eq!(settings_of(&["--can", "can0"]), safe);
        let asked = ["--adaptation", "none", "--disturbance", "paper", "--disturbance-site", "plant"];
        assert_eq!(settings_of(&[["--can", "can0"].as_slice(), asked.as_slice()].concat()), paper);
        let asked = ["--adaptation", "bounded", "--disturbance", "none", "--disturbance-site", "command"];
        assert_eq!(settings_of(&asked), safe);
    }
}
