//! `uarm monitor`: a live view of a running controller, from the log that it writes anyway.

pub mod snapshot;
pub mod source;
pub mod state;
mod terminal;
pub mod view;

use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context;

use crate::console;
use crate::exit::Exit;
use crate::robot::shape::{Shape, for_shape};
use crate::signals;
use snapshot::Snapshot;
use source::Source;
use uarm_loop::stop_request::StopRequest;

/// Arguments of `uarm monitor`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The view reads the log that the run writes, and has no other connection to it: it costs the loop nothing. The log grows
four times a second, so that the view lags behind the robot by up to a quarter of a second: it is no emergency stop.
q, Esc and Ctrl-C quit the view; the run goes on.

Examples:
  uarm monitor --wait                        in a second terminal: opens when the next run begins
  uarm monitor runs/first.mcap
  uarm monitor --json | jq .cycle.time_s     one snapshot for a script")]
pub struct Arguments {
    /// The log of the run; without it the newest in runs/
    #[arg(value_name = "FILE")]
    file: Option<PathBuf>,
    /// Wait until FILE is there; without FILE, until a run begins a log in runs/
    #[arg(long)]
    wait: bool,
    /// Print what is known now as text, and end; so it is too where standard output is no terminal
    #[arg(long)]
    once: bool,
    /// Print what is known now as JSON, and end
    #[arg(long, conflicts_with = "once")]
    json: bool,
}

/// Shows a log while it grows, or prints what it has told so far.
///
/// # Errors
/// If there is no log, or it cannot be read.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let stop = signals::stop_request().context("signal handlers")?;
    let Some(path) = source::find(arguments.file.as_deref(), arguments.wait, &stop)? else {
        return Ok(Exit::Ok.into());
    };
    // A log that has only begun does not say of which robot it is.
    let mut shape = Shape::PAPER;
    loop {
        match for_shape!(shape, follow(arguments, &path, &stop))? {
            Followed::ToItsEnd(exit) => return Ok(exit.into()),
            Followed::OfAnother(found) => shape = found,
        }
    }
}

/// How following a log as one of a robot of so many joints went.
enum Followed {
    /// All that was asked for was shown.
    ToItsEnd(Exit),
    /// It is of a robot of another shape.
    OfAnother(Shape),
}

fn follow<const J: usize, const N: usize>(
    arguments: &Arguments,
    path: &Path,
    stop: &StopRequest,
) -> anyhow::Result<Followed> {
    let mut source = Source::<J, N>::open(path)?;
    source.catch_up()?;
    if let Some(found) = source.other_shape() {
        return Ok(Followed::OfAnother(found));
    }
    if arguments.json {
        console::print_json(&Snapshot::of(&source.state))?;
    } else if arguments.once || !io::stdout().is_terminal() {
        console::output().write_all(view::plain(&source.state).as_bytes())?;
    } else if let Some(found) = terminal::show(&mut source, stop)? {
        return Ok(Followed::OfAnother(found));
    }
    Ok(Followed::ToItsEnd(if source.state.damage.is_empty() { Exit::Ok } else { Exit::Loss }))
}
