//! `uarm run`: the paper's experiment, on the embedded robot or on real drives.

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::Context;
use hinf_control::Disturbance;
use hinf_control::Law;

use super::{Outcome, exit_code};
use crate::control_loop::schedule::OverrunPolicy;
use crate::control_loop::task_clock::PeriodSource;
use crate::control_loop::torque::DisturbanceSite;
use crate::controllers::AdaptationGuard;
use crate::experiment::Settings;
use crate::experiment::place::Place;
use crate::experiment::realtime::Realtime;
use crate::experiment::report::{RunReport, print_mean};
use crate::experiment::session::Session;
use crate::experiment::tape::Repetition;
use crate::robot::Robot;
use crate::robot::overrides::Overrides;
use crate::run_log::place::LogChoice;
use crate::signals::StopRequest;

/// Arguments of `uarm run`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  uarm run                                   the paper's task on the embedded robot, in real time
  uarm run --virtual-time --trace run.csv    the same in milliseconds, every signal of every cycle in a file
  uarm run --controller adaptive --plant ideal
  uarm plant --can vcan0 &  uarm run --can vcan0
  uarm run --can can0 --robot my-robot.toml  real drives: keep a hand on the emergency stop")]
pub struct Arguments {
    /// The control law
    #[arg(long, default_value = Law::Nonlinear.name(), value_parser = parse_law, value_name = "LAW")]
    controller: Law,
    /// The robot file; without it the paper's UARM, which is built in
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// Drive the real drives on this CAN interface, such as can0 or vcan0
    #[arg(long, value_name = "INTERFACE", conflicts_with_all = ["plant", "virtual_time"])]
    can: Option<String>,
    /// What the embedded robot is
    #[arg(long, value_enum, default_value_t, value_name = "PLANT")]
    plant: PlantChoice,
    /// Run the embedded robot in virtual time: the same loop, as fast as it goes, bit for bit the same each time
    #[arg(long)]
    virtual_time: bool,
    /// The loop's period, such as 3ms or 1ms, instead of the robot file's
    #[arg(long, value_parser = humantime::parse_duration, value_name = "TIME")]
    period: Option<Duration>,
    /// How long the end of the motion is held, such as 500ms or 60s, instead of the robot file's
    #[arg(long, value_parser = humantime::parse_duration, value_name = "TIME")]
    hold: Option<Duration>,
    /// Go to the start of the motion first, from wherever the joints are, in this time, such as 5s
    #[arg(long, value_parser = humantime::parse_duration, value_name = "TIME")]
    approach: Option<Duration>,
    /// How controllers 1 and 2 have the base acceleration, instead of the robot file's choice
    #[arg(long, value_enum, value_name = "MODE")]
    base_acceleration: Option<crate::robot::file::BaseAccelerationMode>,
    /// What keeps adapted parameters from drifting; by default "bounded" with --can and "none" otherwise, as in the paper
    #[arg(long, value_enum, value_name = "GUARD")]
    adaptation: Option<AdaptationGuard>,
    /// Let the fuzzy laws run with the sets in this file, as uarm train writes it; without it with the untrained grid
    #[arg(long, value_name = "FILE.toml")]
    fuzzy_sets: Option<PathBuf>,
    /// Run the experiment this many times
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000), value_name = "N")]
    repeat: u32,
    /// The disturbance (paper eq. 48); by default "paper" on the embedded robot and "none" with --can
    #[arg(long, value_enum, value_name = "KIND")]
    disturbance: Option<DisturbanceChoice>,
    /// Where the disturbance acts; by default on the embedded plant's joints, and on the sent torque with --can
    #[arg(long, value_enum, value_name = "SITE")]
    disturbance_site: Option<DisturbanceSite>,
    /// What to do when a cycle ends after the next should have begun
    #[arg(long, value_enum, default_value_t, value_name = "POLICY")]
    overrun: OverrunPolicy,
    /// Where the period that estimators and laws are told comes from
    #[arg(long, value_enum, default_value_t, value_name = "SOURCE")]
    dt: PeriodSource,
    /// Real-time scheduling of the loop; by default "enforce" with --can and "prefer" otherwise
    #[arg(long, value_enum, value_name = "POLICY")]
    rt: Option<RealtimeChoice>,
    /// SCHED_FIFO priority of the loop
    #[arg(long, default_value_t = 80, value_parser = clap::value_parser!(u8).range(1..=98), value_name = "1..98")]
    priority: u8,
    /// Keep the loop on this CPU
    #[arg(long, value_name = "CPU")]
    cpu: Option<usize>,
    /// Where the run is recorded, as MCAP for Foxglove, `uarm show` and `uarm replay`: a new file, or "none"; without this
    /// option runs/TIME-CONTROLLER.mcap
    #[arg(long, value_name = "FILE|none")]
    log: Option<LogChoice>,
    /// Also write every signal of every cycle to this file, one row a cycle
    #[arg(long, value_name = "FILE.csv")]
    trace: Option<PathBuf>,
    /// Print the reports as JSON
    #[arg(long)]
    json: bool,
}

/// The embedded robots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum PlantChoice {
    /// The UARM with its documented imperfections
    #[default]
    Uarm,
    /// The dynamically equivalent manipulator as the controllers believe it to be
    Ideal,
    /// The free-floating space manipulator itself, simulated without the DEM
    Space,
}

/// The disturbances.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum DisturbanceChoice {
    /// The paper's eq. 48, from 1 s on
    Paper,
    /// None
    None,
}

impl From<DisturbanceChoice> for Disturbance {
    fn from(choice: DisturbanceChoice) -> Self {
        match choice {
            DisturbanceChoice::Paper => Self::Paper,
            DisturbanceChoice::None => Self::None,
        }
    }
}

/// How much real time is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum RealtimeChoice {
    /// All of it, or the run does not begin
    Enforce,
    /// As much as the machine gives; the report says what
    Prefer,
    /// None
    Off,
}

/// A law by its name.
///
/// # Errors
/// The names there are.
pub fn parse_law(name: &str) -> Result<Law, String> {
    Law::from_name(name).ok_or_else(|| format!("expected one of {}", Law::ALL.map(Law::name).join(", ")))
}

/// Runs the experiments and prints their reports.
///
/// # Errors
/// If the robot file is wrong, or an experiment cannot be begun.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let robot = robot(arguments)?;
    let stop = StopRequest::on_signals().context("signal handlers")?;
    let session = Session {
        settings: settings(arguments),
        place: place(arguments),
        realtime: realtime(arguments)?,
        log: arguments.log.clone().unwrap_or_default(),
        trace: arguments.trace.clone(),
    };
    for line in session.announcement(&robot) {
        eprintln!("{line}");
    }
    let mut reports = Vec::new();
    for number in 1..=arguments.repeat {
        if stop.is_made() {
            break;
        }
        let report = session.run(&robot, Repetition { number, of: arguments.repeat }, &stop)?;
        if !arguments.json {
            report.print(&mut std::io::stdout().lock())?;
        }
        let completed = report.completed;
        if !completed {
            eprintln!("uarm: {}", report.end);
        }
        reports.push(report);
        if !completed {
            break;
        }
    }
    if arguments.json {
        let mut output = std::io::stdout().lock();
        serde_json::to_writer_pretty(&mut output, &reports)?;
        writeln!(output)?;
    } else if reports.len() > 1 {
        print_mean(&reports, &mut std::io::stdout().lock())?;
    }
    Ok(exit_code(outcome(&reports, arguments.can.is_some())))
}

/// Missed deadlines are a loss where motors were driven; on the embedded robot they only tell of the machine.
fn outcome(reports: &[RunReport], drives: bool) -> Outcome {
    let late = |report: &RunReport| report.timing.missed_deadlines + report.timing.skipped_ticks > 0;
    if reports.iter().any(|report| !report.completed) {
        Outcome::Failure
    } else if reports.iter().any(|report| report.has_loss() || (drives && late(report))) {
        Outcome::Loss
    } else {
        Outcome::Ok
    }
}

fn robot(arguments: &Arguments) -> anyhow::Result<Robot> {
    let overrides = Overrides {
        period: arguments.period,
        hold: arguments.hold,
        base_acceleration: arguments.base_acceleration.map(|mode| (arguments.controller, mode)),
    };
    let mut robot = Robot::load_with(arguments.robot.as_deref(), &overrides)?;
    robot.load_fuzzy_sets(arguments.fuzzy_sets.as_deref())?;
    Ok(robot)
}

/// On drives, what is safe; on the embedded robot, what the paper did.
fn settings(arguments: &Arguments) -> Settings {
    let (guard, disturbance, disturbance_site) = match arguments.can {
        Some(_) => (AdaptationGuard::Bounded, DisturbanceChoice::None, DisturbanceSite::Command),
        None => (AdaptationGuard::None, DisturbanceChoice::Paper, DisturbanceSite::Plant),
    };
    Settings {
        law: arguments.controller,
        guard: arguments.adaptation.unwrap_or(guard),
        overrun: arguments.overrun,
        period_source: arguments.dt,
        approach: arguments.approach,
        disturbance: arguments.disturbance.unwrap_or(disturbance).into(),
        disturbance_site: arguments.disturbance_site.unwrap_or(disturbance_site),
    }
}

fn place(arguments: &Arguments) -> Place {
    match (&arguments.can, arguments.virtual_time) {
        (Some(interface), _) => Place::Interface(interface.clone()),
        (None, true) => Place::EmbeddedVirtual(arguments.plant),
        (None, false) => Place::EmbeddedReal(arguments.plant),
    }
}

fn realtime(arguments: &Arguments) -> anyhow::Result<Realtime> {
    let default = if arguments.can.is_some() { RealtimeChoice::Enforce } else { RealtimeChoice::Prefer };
    Realtime::new(arguments.rt.unwrap_or(default), arguments.priority, arguments.cpu)
}
