//! The arguments of `uarm replay`.

use std::path::{Path, PathBuf};
use std::time::Duration;

use hinf_control::{AdaptationGuard, BaseAcceleration, Disturbance, Law};
use uarm_loop::task_clock::PeriodSource;
use uarm_plot::output::FigureFile;

use crate::options::{self, choice};
use crate::output_files::{Force, OutputFiles};
use crate::robot::overrides::Overrides;

/// Arguments of `uarm replay`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  uarm replay                                 the newest log in runs/, every signal compared bit for bit
  uarm replay run.mcap --from 2               from the last keyframe before 2 s
  uarm replay run.mcap --controller neural --plot what-if.svg
                                              what `neural` would have asked for on the same measurements
  uarm replay bus.log --controller adaptive   a file of candump -L: the torques on the bus, with the law that ran

A candump file is read as far as it is whole. Ticks come from the SYNC counter, so a clock that was set while it was recorded
does not matter; where SYNC has no counter, the time decides.

Exit codes: 0 equal (or a what-if was made), 1 something differs or nothing was compared, 3 equal as far as the log goes, but
parts are missing.")]
pub struct Arguments {
    /// A log of `uarm run`, or a file of `candump -L`; without it the newest log in runs/
    #[arg(value_name = "FILE")]
    pub file: Option<PathBuf>,
    /// Begin with the last keyframe before this task time, s
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true, value_parser = options::seconds)]
    pub from: Option<f64>,
    /// With a candump file of several interfaces: the one that the drives are on
    #[arg(long, value_name = "INTERFACE")]
    pub interface: Option<String>,
    /// Another controller on the same measurements; with a candump file: the one that ran
    #[arg(long, value_parser = choice::<Law>(), value_name = "LAW")]
    pub controller: Option<Law>,
    /// Another robot file; with a candump file: the one that the run had
    #[arg(long, value_name = "FILE")]
    pub robot: Option<PathBuf>,
    /// Another way for the law to have the base acceleration, where it has a choice
    #[arg(long, value_parser = choice::<BaseAcceleration>(), value_name = "MODE")]
    pub base_acceleration: Option<BaseAcceleration>,
    /// Other fuzzy sets
    #[arg(long, value_name = "FILE.toml")]
    pub fuzzy_sets: Option<PathBuf>,
    /// Another guard of the adapted parameters; with a candump file: the one that the run had, by default "bounded"
    #[arg(long, value_parser = choice::<AdaptationGuard>(), value_name = "GUARD")]
    pub adaptation: Option<AdaptationGuard>,
    /// With a candump file: where the period came from
    #[arg(long, value_parser = choice::<PeriodSource>(), value_name = "SOURCE")]
    pub dt: Option<PeriodSource>,
    /// With a candump file: the loop's period, instead of the robot file's
    #[arg(long, allow_hyphen_values = true, value_parser = options::period, value_name = "TIME")]
    pub period: Option<Duration>,
    /// With a candump file: the disturbance on the sent torque
    #[arg(long, value_parser = choice::<Disturbance>(), value_name = "KIND")]
    pub disturbance: Option<Disturbance>,
    /// Draw the recorded torques and the other controller's to this file, .svg or .png
    #[arg(long, value_name = "FILE.svg|FILE.png")]
    pub plot: Option<FigureFile>,
    /// Write both torques of each cycle to this file
    #[arg(long, value_name = "FILE.csv")]
    pub csv: Option<PathBuf>,
    #[command(flatten)]
    pub(super) force: Force,
    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

impl Arguments {
    /// Whether anything is said about controller or robot.
    pub fn asks_for_another(&self) -> bool {
        self.controller.is_some()
            || self.robot.is_some()
            || self.base_acceleration.is_some()
            || self.fuzzy_sets.is_some()
            || self.adaptation.is_some()
    }

    /// Where outputs may go: not over what is read.
    pub fn outputs(&self, recording: &Path) -> OutputFiles {
        let files = [&self.robot, &self.fuzzy_sets];
        OutputFiles::new(self.force, files.into_iter().flatten().map(PathBuf::as_path).chain([recording]))
    }

    /// What the robot file is to say otherwise.
    pub fn overrides(&self, law: Law) -> Overrides {
        Overrides { period: self.period, hold: None, base_acceleration: self.base_acceleration.map(|mode| (law, mode)) }
    }
}
