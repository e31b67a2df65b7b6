//! `uarm compare merge`: a Monte Carlo study of the files of parts.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Context;

use super::draws::Draws;
use super::study::tell;
use crate::output_files::{Force, OutputFiles};

/// Arguments of `uarm compare merge`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Example:
  uarm compare merge parts/*.jsonl --draws study.jsonl --csv study.csv

The files must be of one study, and have each of its draws once. What is written and printed has the same bytes as that of a
study that was run in one piece.")]
pub struct Arguments {
    /// The files of all parts
    #[arg(required = true, value_name = "FILE.jsonl")]
    parts: Vec<PathBuf>,
    /// Write the whole to this file
    #[arg(long, value_name = "FILE.jsonl")]
    draws: Option<PathBuf>,
    /// Write every experiment to this file
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Print the study as JSON
    #[arg(long)]
    json: bool,
}

/// Merges, and tells what came of the whole.
///
/// # Errors
/// If a file cannot be read or written, or the parts make no whole.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let outputs = OutputFiles::new(arguments.force, arguments.parts.iter().map(PathBuf::as_path));
    outputs
        .check([&arguments.draws, &arguments.csv].into_iter().flatten().map(PathBuf::as_path))
        .context("--draws, --csv")?;
    let whole = Draws::merge(&arguments.parts)?;
    if let Some(path) = &arguments.draws {
        outputs.write(path, |output| whole.write(output)).context("--draws")?;
    }
    tell(&whole, arguments.csv.as_deref(), arguments.json, &outputs)
}
