//! `uarm`: from the model to torques on a CAN bus every 3 ms. One file per subcommand in [`uarm::commands`]; the control
//! loop itself is [`uarm::control_loop`].
#![forbid(unsafe_code)]

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    let command_line = uarm::cli::CommandLine::parse();
    uarm::commands::execute(&command_line.command).unwrap_or_else(|error| {
        eprintln!("uarm: {error:#}");
        uarm::commands::exit_code(uarm::commands::Outcome::Failure)
    })
}
