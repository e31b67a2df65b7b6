//! `uarm monitor`: a live view of a running controller, from the log that it writes anyway.

pub mod snapshot;
pub mod source;
pub mod state;
mod terminal;
pub mod view;

use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, bail};

use crate::console;
use crate::dimensions::OrderedLog;
use crate::exit::Exit;
use crate::robot::shape::Shape;
use crate::signals;
use snapshot::Snapshot;
use source::Source;

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

/// Refuses the log of another robot than the paper's. One that has only begun does not say yet.
fn refuse_other_robots(path: &Path) -> anyhow::Result<()> {
    let Ok(run) = OrderedLog::<3, 2>::new(path).run() else { return Ok(()) };
    match Shape::of(path, &run.robot.toml) {
        Ok(found) if found != Shape::PAPER => {
            bail!(
                "{}: a run of {found}, expected one of a passive base and 2 active joints: `uarm show` shows it",
                path.display()
            )
        }
        _ => Ok(()),
    }
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
    refuse_other_robots(&path)?;
    let mut source = Source::open(&path)?;
    if arguments.json {
        source.catch_up()?;
        console::print_json(&Snapshot::of(&source.state))?;
    } else if arguments.once || !io::stdout().is_terminal() {
        source.catch_up()?;
        console::output().write_all(view::plain(&source.state).as_bytes())?;
    } else {
        terminal::show(&mut source, &stop)?;
    }
    let exit = if source.state.damage.is_empty() { Exit::Ok } else { Exit::Loss };
    Ok(exit.into())
}
