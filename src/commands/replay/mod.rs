//! `uarm replay`: a recorded run again, bit for bit; or another law on its measurements.

mod arguments;
mod bus_file;
mod chart;
mod exact;
mod recorded;
mod report;
mod what_if;

use std::path::Path;
use std::process::ExitCode;

use anyhow::Context;
use uarm_plot::output::FigureFile;

use crate::log_files::newest;
use crate::output_files::OutputFiles;
use crate::robot::shape::for_shape;
pub use arguments::Arguments;
use exact::exact;
use recorded::{read, shape};
use what_if::what_if;

/// Replays a file.
///
/// # Errors
/// If it cannot be read, or holds nothing to replay.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let path = arguments.file.clone().map_or_else(newest, Ok)?;
    let outputs = arguments.outputs(&path);
    outputs.check(arguments.plot.as_ref().map(FigureFile::path)).context("--plot")?;
    outputs.check(arguments.csv.as_deref()).context("--csv")?;
    for_shape!(shape(&path, arguments)?, replay(&path, arguments, &outputs))
}

fn replay<const J: usize, const N: usize>(
    path: &Path,
    arguments: &Arguments,
    outputs: &OutputFiles,
) -> anyhow::Result<ExitCode> {
    let mut recorded = read::<J, N>(path, arguments)?;
    let file = path.display().to_string();
    if recorded.is_a_log() && arguments.asks_for_another() {
        what_if(arguments, &mut recorded, &file, outputs)
    } else {
        exact(arguments, &mut recorded, &file)
    }
}
