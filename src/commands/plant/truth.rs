//! The plant's truth as a CSV file: one line for each SYNC while plant time passes.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::Context;
use uarm_sim::Brake;

use super::bench::Truth;
use crate::output_files::OutputFiles;

/// The columns. `run` counts the runs of the plant from 1: each NMT reset of all drives ends one. `brake` is 1 while it holds.
const HEADER: &str = "run,time_s,position_1_rad,position_2_rad,position_3_rad,\
    velocity_1_rad_per_s,velocity_2_rad_per_s,velocity_3_rad_per_s,torque_1_nm,torque_2_nm,torque_3_nm,brake_1,brake_2,brake_3";

/// The file.
#[derive(Debug)]
pub struct TruthFile {
    path: PathBuf,
    file: BufWriter<File>,
    run: u32,
    last: Option<Duration>,
}

impl TruthFile {
    /// Begins a file.
    ///
    /// # Errors
    /// If it cannot be written, or may not be replaced.
    pub fn create(path: &Path, outputs: &OutputFiles) -> anyhow::Result<Self> {
        let file = outputs.create(path)?;
        let mut truth = Self { path: path.to_owned(), file: BufWriter::new(file), run: 0, last: None };
        truth.line(HEADER)?;
        Ok(truth)
    }

    /// Writes a line, if plant time passes.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&mut self, truth: Option<&Truth>) -> anyhow::Result<()> {
        let Some(truth) = truth else {
            self.last = None;
            return self.flush();
        };
        if self.last.is_none_or(|last| truth.time < last) {
            self.run += 1;
        }
        self.last = Some(truth.time);
        let line = line_of(self.run, truth);
        self.line(&line)
    }

    /// Writes what is still to be written.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(mut self) -> anyhow::Result<()> {
        self.flush()
    }

    fn line(&mut self, line: &str) -> anyhow::Result<()> {
        writeln!(self.file, "{line}").with_context(|| self.path.display().to_string())
    }

    fn flush(&mut self) -> anyhow::Result<()> {
        self.file.flush().with_context(|| self.path.display().to_string())
    }
}

/// Numbers are written so that they read back as the same bits.
fn line_of(run: u32, truth: &Truth) -> String {
    let numbers = truth.position.iter().chain(truth.velocity.iter()).chain(truth.torque.iter());
    let numbers: Vec<String> = numbers.map(ToString::to_string).collect();
    let brakes = truth.brakes.map(|brake| if brake == Brake::Engaged { "1" } else { "0" });
    format!("{run},{},{},{}", truth.time.as_secs_f64(), numbers.join(","), brakes.join(","))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn a_line_has_as_many_fields_as_the_header() {
        let truth = Truth {
            time: Duration::from_millis(3),
            position: Vector3::new(0.0, 0.1, 0.2),
            velocity: Vector3::new(-1.0, 0.5, 1e-9),
            torque: Vector3::new(0.0, 0.025, -0.0125),
            brakes: [Brake::Engaged, Brake::Released, Brake::Released],
        };
        let line = line_of(2, &truth);
        assert_eq!(line, "2,0.003,0,0.1,0.2,-1,0.5,0.000000001,0,0.025,-0.0125,1,0,0");
        assert_eq!(line.split(',').count(), HEADER.split(',').count());
    }
}
