//! What came of a Monte Carlo study, told.

use std::path::Path;
use std::process::ExitCode;

use anyhow::Context;

use super::draws::Draws;
use super::monte_carlo::MonteCarlo;
use super::{csv, table};
use crate::console;
use crate::output_files::OutputFiles;

/// Prints the study of `draws`, and writes its experiments to `csv`.
///
/// # Errors
/// If it cannot be written.
pub fn tell(draws: &Draws, csv: Option<&Path>, json: bool, outputs: &OutputFiles) -> anyhow::Result<ExitCode> {
    let study = MonteCarlo::new(draws)?;
    if let Some(path) = csv {
        outputs.write(path, |output| csv::write_monte_carlo(&study, draws, output)).context("--csv")?;
    }
    if json {
        console::print_json(&study)?;
    } else {
        table::print_monte_carlo(&study, &mut console::output())?;
    }
    Ok(ExitCode::SUCCESS)
}
