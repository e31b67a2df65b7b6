//! `uarm completions`: shell completions.

use std::io::Write;
use std::process::ExitCode;

use clap_complete::Shell;

use crate::console;

/// Arguments of `uarm completions`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: uarm completions bash > /etc/bash_completion.d/uarm")]
pub struct Arguments {
    /// The shell that completes
    shell: Shell,
}

/// Prints the script that completes `command` to standard output.
///
/// # Errors
/// If standard output cannot be written.
pub fn execute(arguments: &Arguments, mut command: clap::Command) -> anyhow::Result<ExitCode> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut command, "uarm", &mut script);
    let mut output = console::output();
    output.write_all(&script)?;
    output.flush()?;
    Ok(ExitCode::SUCCESS)
}
