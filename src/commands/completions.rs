//! `uarm completions`: shell completions.

use std::process::ExitCode;

use clap::CommandFactory;
use clap_complete::Shell;

/// Arguments of `uarm completions`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: uarm completions bash > /etc/bash_completion.d/uarm")]
pub struct Arguments {
    /// The shell
    shell: Shell,
}

/// Prints the script to standard output.
///
/// # Errors
/// None; the signature is that of every subcommand.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let mut command = crate::cli::CommandLine::command();
    clap_complete::generate(arguments.shell, &mut command, "uarm", &mut std::io::stdout());
    Ok(ExitCode::SUCCESS)
}
