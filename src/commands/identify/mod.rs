//! `uarm identify`: friction, inertia, gain and tilt of a robot from recorded runs.

mod recording;
mod report;

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Context;
use uarm_identify::{Gain, MOST_STEPS, Uarm, identify};
use uarm_loop::choice;

use crate::console;
use crate::exit::Exit;
use crate::options::choice as of_choices;
use crate::output_files::{Force, OutputFiles};
use crate::robot::model::Mechanics;
use crate::study::progress::progress_bar;
use recording::{Recordings, TorqueSource};
use report::Report;

/// Arguments of `uarm identify`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Simulates the recorded robot, in windows of 0.3 s, under the torques that it was given, and changes its friction, inertia, gain and tilt
until the simulated angles are those of the encoders. Each number has a standard error; what the runs do not tell is said, and is not
written. docs/theory.md has the method.

Without a known disturbance a motion says nothing of the scale: twice the gain, friction and inertia move the same way. The gain is then
the robot file's, or 1.

Take runs that turn every joint to and fro at several velocities, such as the task there and back. A run against limits or with an
operator's hand on the arm is no use.

Examples:
  uarm run --virtual-time --controller neural --log run.mcap
  uarm identify run.mcap                             numbers with their errors
  uarm identify there.mcap back.mcap --out my-plant.toml
  uarm run --virtual-time --robot my-plant.toml      the simulated robot is now the recorded one

Exit code: 0 all found, 3 some are not told or the model does not explain the motion.")]
pub struct Arguments {
    /// Recorded runs of one robot
    #[arg(required = true, value_name = "FILE.mcap")]
    runs: Vec<PathBuf>,
    /// Whether the torque at the joints per commanded torque is sought
    #[arg(long, value_parser = of_choices::<GainChoice>(), default_value = "auto", value_name = "HOW")]
    gain: GainChoice,
    /// Whose torques are those of the motors
    #[arg(long, value_parser = of_choices::<TorqueSource>(), default_value = "sent", value_name = "SOURCE")]
    torque: TorqueSource,
    /// Write the robot file of the runs with the numbers in [plant]
    #[arg(long, short, value_name = "FILE.toml")]
    out: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Whether the gain is sought.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum GainChoice {
    /// If a disturbance is known.
    #[default]
    Auto,
    /// It is.
    Sought,
    /// It is the robot file's.
    Known,
}

choice! {
    GainChoice:
    Auto = "auto", "Sought if the log has a disturbance of the plant's joints, known otherwise";
    Sought = "sought", "Sought";
    Known = "known", "That of the robot file's [plant], or 1";
}

/// Finds the numbers and prints them.
///
/// # Errors
/// If a run cannot be read, is of another robot than the others, or the robot file cannot be written.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let outputs = OutputFiles::new(arguments.force, arguments.runs.iter().map(PathBuf::as_path));
    outputs.check(arguments.out.as_deref()).context("--out")?;
    let recordings = recording::read(&arguments.runs, arguments.torque)?;
    let gain = gain(arguments.gain, &recordings);
    let Mechanics::ThreeLinks { dem, .. } = recordings.robot.mechanics else {
        anyhow::bail!("expected the paper's arm, of which the imperfections have a model");
    };
    let model = Uarm::new(dem, gain);
    let resolution =
        recordings.robot.description.joints.each_ref().map(|joint| joint.encoder.counts_per_revolution.resolution());
    let bar = progress_bar(MOST_STEPS as u64, "steps");
    let found = identify(&model, &recordings.pieces, resolution, |_| bar.inc(1));
    bar.finish_and_clear();
    let known = match gain {
        Gain::Known(gain) => Some(gain),
        Gain::Sought => None,
    };
    let report = Report::new(&recordings, arguments.runs.len(), &model, known, &found?);
    if let Some(path) = arguments.out.as_ref().filter(|_| report.explains()) {
        let text = robot_file(&recordings, &report)?;
        outputs.write(path, |output| output.write_all(text.as_bytes())).context("--out")?;
    }
    if let Some(path) = arguments.out.as_ref().filter(|_| !report.explains()) {
        console::tell(format_args!(
            "uarm: {}: not written, since the numbers do not explain the motion",
            path.display()
        ));
    }
    if arguments.json {
        console::print_json(&report)?;
    } else {
        report.print(&mut console::output())?;
    }
    Ok(if report.is_whole() { Exit::Ok } else { Exit::Loss }.into())
}

fn gain(choice: GainChoice, recordings: &Recordings) -> Gain {
    let known = Gain::Known(recordings.robot.plant.uarm.gain());
    match choice {
        GainChoice::Sought => Gain::Sought,
        GainChoice::Known => known,
        GainChoice::Auto if recordings.is_disturbed => Gain::Sought,
        GainChoice::Auto => known,
    }
}

/// The robot file of the runs with what was found.
fn robot_file(recordings: &Recordings, report: &Report) -> anyhow::Result<String> {
    let mut file = recordings.robot.file.clone();
    file.plant = Some(report.plant().clone());
    let text = toml::to_string(&file).context("the robot file")?;
    Ok(format!("# The robot of the runs that uarm identify was given, with [plant] as it was found there.\n{text}"))
}
