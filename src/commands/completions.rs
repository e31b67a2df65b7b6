//! `uarm completions`: shell completions.

use std::process::ExitCode;

use clap_complete::Shell;

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
/// None; the signature is that of every subcommand.
pub fn execute(arguments: &Arguments, mut command: clap::Command) -> anyhow::Result<ExitCode> {
    clap_complete::generate(arguments.shell, &mut command, "uarm", &mut std::io::stdout());
    Ok(ExitCode::SUCCESS)
}
