//! `uarm campaign merge`: a whole of the files of parts.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Context;

use super::outcome::tell;
use crate::campaign::store::Trials;
use crate::output_files::{Force, OutputFiles};

/// Arguments of `uarm campaign merge`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Example:
  uarm campaign merge parts/*.jsonl --output campaign.jsonl

The files must be of one campaign, and have each of its seeds once. The result has the same bytes as the file of a campaign
that was run in one piece.")]
pub struct Arguments {
    /// The files of all parts
    #[arg(required = true, value_name = "FILE.jsonl")]
    parts: Vec<PathBuf>,
    /// Write the whole to this file
    #[arg(long, short, value_name = "FILE.jsonl")]
    output: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Merges, and tells what came of the whole.
///
/// # Errors
/// If a file cannot be read or written, or the parts make no whole.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let outputs = OutputFiles::new(arguments.force, arguments.parts.iter().map(PathBuf::as_path));
    outputs.check(arguments.output.as_deref()).context("--output")?;
    let whole = Trials::merge(&arguments.parts)?;
    if let Some(path) = &arguments.output {
        outputs.write(path, |output| whole.write(output)).context("--output")?;
    }
    tell(&whole, arguments.json)
}
