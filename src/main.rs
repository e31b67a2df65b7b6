//! `uarm`: from the model to torques on a CAN bus every 3 ms. The subcommands are in [`uarm::commands`]; the control loop
//! is [`uarm_loop::control_loop`].
#![forbid(unsafe_code)]

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    uarm::cli::execute(&uarm::cli::CommandLine::parse().command).unwrap_or_else(|error| {
        uarm::console::tell(format_args!("uarm: {}", uarm::error_text::with_causes(&error)));
        uarm::exit::Exit::of(&error).into()
    })
}
