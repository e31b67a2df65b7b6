//! `uarm man`: manual pages.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Context;

use crate::output_files::{Force, OutputFiles};

/// It is there if the others are.
const FIRST_PAGE: &str = "uarm.1";

/// Arguments of `uarm man`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
A page for the program and one for each command: uarm.1, uarm-run.1, uarm-drive-check.1.
Example: uarm man /usr/local/share/man/man1")]
pub struct Arguments {
    /// The folder for the pages; it is made if it is not there
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    #[command(flatten)]
    force: Force,
}

/// Writes the manual pages of `command`.
///
/// # Errors
/// If pages are there already and are not to be replaced, or the folder cannot be made or written to.
pub fn execute(arguments: &Arguments, command: clap::Command) -> anyhow::Result<ExitCode> {
    let folder = &arguments.folder;
    let named = || folder.display().to_string();
    std::fs::create_dir_all(folder).with_context(named)?;
    OutputFiles::new(arguments.force, []).check([folder.join(FIRST_PAGE).as_path()])?;
    clap_mangen::generate_to(command, folder).with_context(named)?;
    Ok(ExitCode::SUCCESS)
}
