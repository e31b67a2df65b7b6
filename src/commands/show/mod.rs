//! `uarm show`: what a log tells, also of a run that was killed.

mod print;
mod summary;
mod tally;

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context;
use clap::error::ErrorKind;
use uarm_plot::output::FigureFile;
use uarm_plot::sheet::Sheet;

use uarm_log::description::RunDescription;
use uarm_log::ordered::InOrder;
use uarm_log::reader::ReadError;
use uarm_log::{candump, csv};

use crate::console;
use crate::dimensions::{OrderedLog, RunLog};
use crate::exit::Exit;
use crate::inspection::panels::RunPlots;
use crate::inspection::{chart, plain_text};
use crate::log_files;
use crate::output_files::{Force, OutputFiles};
use crate::robot::Robot;
use crate::robot::shape::{Shape, for_shape};
use summary::Summary;
use tally::Tally;

/// What frames of a simulated robot, which has no interface, are exported under: most likely to be played back there.
const INTERFACE_OF_SIMULATED_ROBOTS: &str = "vcan0";

/// Arguments of `uarm show`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Indices, peaks and timing are recomputed from the cycles in the log, and compared with what the run recorded at its end.
Exit codes: 0 the log is whole, 3 something is missing or damaged (all that is left is told), 1 it is no log.

Examples:
  uarm show                                  the newest log in runs/
  uarm show run.mcap --plot                  with plots in the terminal
  uarm show run.mcap --figure run.svg --figure run.png
  uarm show run.mcap --csv -                 every signal of every cycle, one row a cycle
  uarm show run.mcap --candump - | canplayer vcan0=can0")]
pub struct Arguments {
    /// The log; without it the newest in runs/
    #[arg(value_name = "FILE")]
    file: Option<PathBuf>,
    /// Plot errors, torques, base and latencies in the terminal
    #[arg(long)]
    plot: bool,
    /// Write the same plots as a figure; the extension says of which kind, and the option may be given twice
    #[arg(long, value_name = "FILE.svg|FILE.png")]
    figure: Vec<FigureFile>,
    /// Write every signal of every cycle, one row a cycle; "-" for standard output, without the summary
    #[arg(long, value_name = "FILE.csv|-", value_parser = destination)]
    csv: Option<Destination>,
    /// Write the frames as candump -L does; "-" for standard output, without the summary
    #[arg(long, value_name = "FILE|-", value_parser = destination)]
    candump: Option<Destination>,
    #[command(flatten)]
    force: Force,
    /// Print the summary as JSON
    #[arg(long, conflicts_with = "plot")]
    json: bool,
}

/// Where an export goes.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Destination {
    StandardOutput,
    File(PathBuf),
}

fn destination(text: &str) -> Result<Destination, std::convert::Infallible> {
    Ok(match text {
        "-" => Destination::StandardOutput,
        file => Destination::File(file.into()),
    })
}

impl Destination {
    fn file(&self) -> Option<&Path> {
        match self {
            Self::StandardOutput => None,
            Self::File(path) => Some(path),
        }
    }

    fn write(&self, outputs: &OutputFiles, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> anyhow::Result<()> {
        match self {
            Self::StandardOutput => {
                let mut output = BufWriter::new(console::output());
                write(&mut output)?;
                output.flush()?;
            }
            Self::File(path) => outputs.write(path, write)?,
        }
        Ok(())
    }
}

/// Reads a log and tells what is asked for.
///
/// # Errors
/// If it is no log, or a file cannot be written.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    is_standard_output_taken(arguments);
    let path = arguments.file.clone().map_or_else(log_files::newest, Ok)?;
    let outputs = OutputFiles::new(arguments.force, [path.as_path()]);
    outputs.check(arguments.output_files())?;
    let run = OrderedLog::<3, 2>::new(&path).run()?;
    let shape = Shape::of(&path, &run.robot.toml).context("the robot in the log")?;
    for_shape!(shape, show(&path, &run, arguments, &outputs))
}

fn show<const J: usize, const N: usize>(
    path: &Path,
    run: &RunDescription,
    arguments: &Arguments,
    outputs: &OutputFiles,
) -> anyhow::Result<ExitCode> {
    let mut log = OrderedLog::<J, N>::new(path);
    let robot = Robot::from_log(path, &run.robot).context("the robot in the log")?;
    let (tally, told) = Tally::of(&mut log, &robot)?;
    let summary = Summary::of(&told, &tally, &robot);
    export(arguments, &mut log, &told, &tally, outputs)?;
    let sheet = if arguments.plot || !arguments.figure.is_empty() { Some(sheet(&mut log, &told)?) } else { None };
    if let Some(sheet) = &sheet {
        for figure in &arguments.figure {
            let bytes = figure.render(sheet).context("--figure")?;
            outputs.write(figure.path(), |output| output.write_all(&bytes)).context("--figure")?;
        }
    }
    let mut output = console::output();
    if is_standard_output_taken(arguments) {
        for loss in &summary.report.losses {
            console::tell(format_args!("uarm: {}: {loss}", path.display()));
        }
    } else if arguments.json {
        console::print_json(&summary)?;
    } else {
        print::print(&summary, &mut output)?;
    }
    if let Some(sheet) = sheet.filter(|_| arguments.plot) {
        output.write_all(chart::plain(&sheet, plain_text::columns()).as_bytes())?;
    }
    let exit = if summary.is_whole() { Exit::Ok } else { Exit::Loss };
    Ok(exit.into())
}

impl Arguments {
    fn output_files(&self) -> impl Iterator<Item = &Path> {
        let exports = [&self.csv, &self.candump].into_iter().flatten().filter_map(Destination::file);
        exports.chain(self.figure.iter().map(FigureFile::path))
    }
}

/// Whether an export goes to standard output; two of them, or one and the JSON or the plots, would be unreadable there.
fn is_standard_output_taken(arguments: &Arguments) -> bool {
    let exports = [&arguments.csv, &arguments.candump];
    let takers = exports.iter().filter(|export| ***export == Some(Destination::StandardOutput)).count();
    let others = usize::from(arguments.json) + usize::from(arguments.plot);
    if takers > 0 && takers + others > 1 {
        let message = "only one of --csv -, --candump -, --json and --plot can have standard output";
        clap::Error::raw(ErrorKind::ArgumentConflict, format!("{message}\n")).exit();
    }
    takers > 0
}

fn export<const J: usize, const N: usize>(
    arguments: &Arguments,
    log: &mut OrderedLog<J, N>,
    told: &RunLog<J, N>,
    tally: &Tally<J, N>,
    outputs: &OutputFiles,
) -> anyhow::Result<()> {
    if let Some(destination) = &arguments.csv {
        destination.write(outputs, |output| write_csv(log, tally, output)).context("--csv")?;
    }
    if let Some(destination) = &arguments.candump {
        let interface = told.run.interface().unwrap_or(INTERFACE_OF_SIMULATED_ROBOTS);
        let write = |mut output: &mut dyn Write| {
            write_each(log, |record| match record {
                InOrder::Frame(frame) => candump::write_frame(frame, interface, told.run.axis, &mut output),
                InOrder::Cycle(_) | InOrder::Keyframe(_) => Ok(()),
            })
        };
        destination.write(outputs, write).context("--candump")?;
    }
    Ok(())
}

/// The plots, in a pass of their own: which part of them is marked is only known at the end of a log.
fn sheet<const J: usize, const N: usize>(log: &mut OrderedLog<J, N>, told: &RunLog<J, N>) -> Result<Sheet, ReadError> {
    let take = |plots: &mut RunPlots<J, N>, record: InOrder<'_, J, N>| {
        if let InOrder::Cycle(record) = record {
            plots.take(record);
        }
    };
    let (plots, _) = log.pass(|| RunPlots::new(told), take)?;
    Ok(plots.sheet(told))
}

fn write_csv<const J: usize, const N: usize>(
    log: &mut OrderedLog<J, N>,
    tally: &Tally<J, N>,
    mut output: &mut dyn Write,
) -> io::Result<()> {
    let Some(first) = &tally.first else { return Ok(()) };
    csv::write_header(first, &tally.reporting, &mut output)?;
    write_each(log, |record| match record {
        InOrder::Cycle(record) => csv::write_row(record, &tally.reporting, &mut output),
        InOrder::Frame(_) | InOrder::Keyframe(_) => Ok(()),
    })
}

/// Goes through a log until something cannot be written.
fn write_each<const J: usize, const N: usize>(
    log: &mut OrderedLog<J, N>,
    mut write: impl FnMut(InOrder<'_, J, N>) -> io::Result<()>,
) -> io::Result<()> {
    let take = |written: &mut io::Result<()>, record: InOrder<'_, J, N>| {
        if written.is_ok() {
            *written = write(record);
        }
    };
    let (written, _) = log.pass(|| Ok(()), take).map_err(io::Error::other)?;
    written
}
