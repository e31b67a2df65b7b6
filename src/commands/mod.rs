//! One file per subcommand. Each has `Arguments` and `execute`.

pub mod compare;
pub mod completions;
pub mod doctor;
pub mod figures;
pub mod filters;
pub mod map;
pub mod monitor;
pub mod plant;
pub mod replay;
pub mod run;
pub mod show;
pub mod train;

use std::process::ExitCode;

use crate::cli::Command;

/// How a command ended, as its exit code tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Everything worked: 0.
    Ok,
    /// It failed: 1.
    Failure,
    /// Finished, but something was lost on the way: 3. (2, wrong usage, is clap's.)
    Loss,
}

/// The exit code of an outcome.
pub fn exit_code(outcome: Outcome) -> ExitCode {
    match outcome {
        Outcome::Ok => ExitCode::SUCCESS,
        Outcome::Failure => ExitCode::from(1),
        Outcome::Loss => ExitCode::from(3),
    }
}

/// Runs a subcommand.
///
/// # Errors
/// Whatever made the command fail, with its context.
pub fn execute(command: &Command) -> anyhow::Result<ExitCode> {
    match command {
        Command::Run(arguments) => run::execute(arguments),
        Command::Replay(arguments) => replay::execute(arguments),
        Command::Monitor(arguments) => monitor::execute(arguments),
        Command::Show(arguments) => show::execute(arguments),
        Command::Compare(arguments) => compare::execute(arguments),
        Command::Plant(arguments) => plant::execute(arguments),
        Command::Map(arguments) => map::execute(arguments),
        Command::Filters(arguments) => filters::execute(arguments),
        Command::Doctor(arguments) => doctor::execute(arguments),
        Command::Figures(arguments) => figures::execute(arguments),
        Command::Train(arguments) => train::execute(arguments),
        Command::Completions(arguments) => completions::execute(arguments),
    }
}
