//! `uarm stability`: is the sampled loop stable with its period, estimator and delay? Nothing moves, no bus is needed.

mod figure;

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::Context;
use hinf_control::{BaseAcceleration, Law};
use serde::Serialize;
use uarm_loop::dimensions;
use uarm_loop::stability::survey::Worst;
use uarm_loop::stability::{DelayError, TransportDelay};
use uarm_plot::output::FigureFile;
use uarm_plot::sheet::Sheet;

use crate::console;
use crate::exit::Exit;
use crate::options::{self, choice};
use crate::output_files::{Force, OutputFiles};
use crate::robot::error::RobotError;
use crate::robot::overrides::Overrides;
use crate::robot::shape::for_shape;
use crate::robot::{Robot, RobotText};
use crate::stability::Analysis;
use crate::study::progress::progress_bar;
use crate::words::in_words;
use figure::RobotCurves;

/// Arguments of `uarm stability`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The torque is held for a period, velocities come through a filter, and the drive applies the torque some time after the counts
were latched: each is a delay, and with too much of it the loop swings up. Frozen at rest in one configuration the loop is
linear, x(k+1) = A x(k). It is stable there if the spectral radius of A is below 1; the distance to 1 is how fast it settles.
Looked at: the task with its start tolerance, and a grid of the joints' limits, every 10 degrees. docs/theory.md, section 13.

Not in it: friction, which damps; quantisation and saturation; the adaptation of laws that adapt (Φ as it starts); an arm that
is not as the model says. So below 1 is needed, and no guarantee.

Examples:
  uarm stability                                              the paper's UARM as the robot file has it
  uarm stability --base-acceleration reduced --delay 1        1.008 at the task's start, 1.012 with the arm stretched
  uarm stability --robot robots/uarm-hardware.toml --controller adaptive
  uarm stability --figure delay.svg --beside my-robot.toml    both against the delay, 0 to 2 cycles

Exit code: 0 stable along the task, 1 not. `uarm run --can` refuses what is not.")]
pub struct Arguments {
    /// The control law
    #[arg(long, default_value = Law::Nonlinear.name(), value_parser = choice::<Law>(), value_name = "LAW")]
    controller: Law,
    /// The robot file; without it the paper's UARM
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// How the law has the base acceleration, where it has a choice, instead of the robot file's
    #[arg(long, value_parser = choice::<BaseAcceleration>(), value_name = "MODE")]
    base_acceleration: Option<BaseAcceleration>,
    /// The loop's period, such as 3ms or 1ms, instead of the robot file's
    #[arg(long, allow_hyphen_values = true, value_parser = options::period, value_name = "TIME")]
    period: Option<Duration>,
    /// From the latch of the counts to the torque, 0 to 3 cycles, instead of what bus and drives take by the robot file
    #[arg(long, value_parser = delay, value_name = "CYCLES")]
    delay: Option<TransportDelay>,
    /// Draw the spectral radius against the delay, 0 to 2 cycles, into this file; its name ends with .svg or .png
    #[arg(long, value_name = "FILE")]
    figure: Option<FigureFile>,
    /// Draw another robot file into the figure, too; may be given several times
    #[arg(long, requires = "figure", value_name = "FILE")]
    beside: Vec<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

impl Arguments {
    /// A robot with what the command line changes in its file.
    fn robot<const J: usize, const N: usize>(&self, file: &RobotText) -> Result<Robot<J, N>, RobotError> {
        let overrides = Overrides {
            period: self.period,
            base_acceleration: self.base_acceleration.map(|mode| (self.controller, mode)),
            ..Overrides::default()
        };
        Robot::of_text(&file.name, &file.text, &overrides)
    }
}

fn delay(text: &str) -> Result<TransportDelay, String> {
    let cycles: f64 = text.parse().map_err(|_| format!("{text} is no number of cycles"))?;
    TransportDelay::cycles(cycles).map_err(|error: DelayError| error.to_string())
}

/// The delays of the table, cycles.
const TABLE: [f64; 7] = [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0];

/// The worst of some configurations.
#[derive(Debug, Serialize)]
struct Place {
    spectral_radius: f64,
    joints_deg: Vec<f64>,
    stable: bool,
}

/// The radius along the task with another delay.
#[derive(Debug, Serialize)]
struct Row {
    delay_cycles: f64,
    spectral_radius: f64,
}

#[derive(Debug, Serialize)]
struct Report {
    robot: String,
    controller: &'static str,
    period_ms: f64,
    estimator: String,
    /// The number of the first active joint, counted from 1.
    #[serde(skip)]
    first_active: usize,
    delay_cycles: Vec<f64>,
    task: Place,
    workspace: Place,
    by_delay: Vec<Row>,
    /// With this delay the loop is unstable along the task; none up to 3 cycles if absent.
    delay_limit_cycles: Option<f64>,
}

/// Prints the spectral radius of the loop, and draws it.
///
/// # Errors
/// If a robot file is wrong, its estimator is not linear, or the figure cannot be written.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let inputs = arguments.robot.iter().chain(&arguments.beside).map(PathBuf::as_path);
    let outputs = OutputFiles::new(arguments.force, inputs);
    outputs.check(arguments.figure.as_ref().map(FigureFile::path)).context("--figure")?;
    let robot = RobotText::read(arguments.robot.as_deref())?;
    let beside = arguments.beside.iter().map(|file| RobotText::read(Some(file)).context("--beside"));
    let beside = beside.collect::<anyhow::Result<Vec<_>>>()?;
    for other in &beside {
        for_shape!(other.shape().context("--beside")?, check(arguments, other)).context("--beside")?;
    }
    let report = for_shape!(robot.shape()?, report(arguments, &robot))?;
    if let Some(file) = &arguments.figure {
        let robots: Vec<_> = std::iter::once(robot).chain(beside).collect();
        let bytes = file.render(&draw(&robots, arguments)?).context("--figure")?;
        outputs.write(file.path(), |output| output.write_all(&bytes)).context("--figure")?;
    }
    if arguments.json {
        console::print_json(&report)?;
    } else {
        print(&mut console::output(), &report)?;
    }
    Ok(if report.task.stable { Exit::Ok } else { Exit::Failure }.into())
}

/// Finds what is wrong with a robot file before anything takes long.
fn check<const J: usize, const N: usize>(arguments: &Arguments, file: &RobotText) -> anyhow::Result<()> {
    Ok(arguments.robot::<J, N>(file).map(drop)?)
}

fn draw(robots: &[RobotText], arguments: &Arguments) -> anyhow::Result<Sheet> {
    let law = arguments.controller;
    let bar = progress_bar(robots.len() as u64 * figure::POINTS, "points");
    let done = || bar.inc(1);
    let curves = robots.iter().map(|robot| for_shape!(robot.shape()?, curves(arguments, robot, &done)));
    let curves = curves.collect::<anyhow::Result<Vec<_>>>()?;
    bar.finish_and_clear();
    let mode = arguments.base_acceleration.map(|mode| format!(", base acceleration {}", mode.name()));
    let note = format!("Frozen loop at rest, controller {}{}", law.name(), mode.unwrap_or_default());
    Ok(figure::sheet(&curves, note))
}

fn curves<const J: usize, const N: usize>(
    arguments: &Arguments,
    file: &RobotText,
    done: &dyn Fn(),
) -> anyhow::Result<RobotCurves> {
    let robot = arguments.robot::<J, N>(file)?;
    let analysis =
        Analysis::new(&robot, arguments.controller, arguments.delay).with_context(|| robot.description.name.clone())?;
    Ok(RobotCurves::of(&robot, analysis, done)?)
}

fn report<const J: usize, const N: usize>(arguments: &Arguments, file: &RobotText) -> anyhow::Result<Report> {
    let robot = arguments.robot::<J, N>(file)?;
    let mut analysis = Analysis::new(&robot, arguments.controller, arguments.delay)?;
    let by_delay = TABLE.map(|cycles| {
        let delay = TransportDelay::cycles(cycles)?;
        let spectral_radius = analysis.with_delay(delay, |other| other.along_the_task().radius);
        Ok(Row { delay_cycles: cycles, spectral_radius })
    });
    Ok(Report {
        robot: robot.description.name.clone(),
        controller: arguments.controller.name(),
        period_ms: robot.description.period.duration().as_secs_f64() * 1e3,
        estimator: robot.file.estimator.to_string(),
        first_active: dimensions::number_of_active::<J, N>(0),
        delay_cycles: analysis.delays().map(TransportDelay::get).to_vec(),
        task: place(&analysis.along_the_task()),
        workspace: place(&analysis.in_the_workspace()),
        by_delay: by_delay.into_iter().collect::<Result<_, DelayError>>()?,
        delay_limit_cycles: analysis.delay_limit(),
    })
}

fn place<const N: usize>(worst: &Worst<N>) -> Place {
    // Half a degree's rounding would print −0.
    let degrees = |angle: &f64| angle.to_degrees() + 0.0;
    Place {
        spectral_radius: worst.radius,
        joints_deg: worst.configuration.iter().map(degrees).collect(),
        stable: !worst.is_unstable(),
    }
}

fn print(output: &mut impl Write, report: &Report) -> std::io::Result<()> {
    let Report { robot, controller, period_ms, estimator, .. } = report;
    let numbers = || report.first_active..;
    writeln!(output, "{robot}, controller {controller}: a cycle every {period_ms} ms, estimator {estimator}")?;
    let delays = report.delay_cycles.iter().zip(numbers());
    let delays = in_words(delays.map(|(delay, joint)| format!("{delay:.2} (joint {joint})")));
    writeln!(output, "torques act {delays} cycles after the counts were latched\n")?;
    let joints: Vec<_> = report.delay_cycles.iter().zip(numbers()).map(|(_, joint)| format!("q{joint}")).collect();
    // Each angle below takes eight characters, and one before it.
    let width = 9 * joints.len() - 1;
    writeln!(
        output,
        "{:<17} {:>15}  {:>width$}",
        "worst",
        "spectral radius",
        format!("at {} (deg)", joints.join(", "))
    )?;
    for (name, place) in [("along the task", &report.task), ("in the workspace", &report.workspace)] {
        let angles: String = place.joints_deg.iter().map(|angle| format!(" {angle:>8.1}")).collect();
        let verdict = if place.stable { "stable" } else { "UNSTABLE" };
        writeln!(output, "{name:<17} {:>15.4} {angles}  {verdict}", place.spectral_radius)?;
    }
    writeln!(output, "\n{:<17} {:>15}", "delay (cycles)", "along the task")?;
    for row in &report.by_delay {
        writeln!(output, "{:<17.2} {:>15.4}", row.delay_cycles, row.spectral_radius)?;
    }
    match report.delay_limit_cycles {
        Some(limit) => writeln!(output, "unstable along the task from {limit:.2} cycles of delay on"),
        None => writeln!(output, "stable along the task up to {} cycles of delay", TransportDelay::LONGEST),
    }
}
