//! `uarm train`: fuzzy sets from recorded runs.

pub mod learn;
pub mod points;
pub mod samples;

use std::io::{IsTerminal, Write};
use std::num::NonZeroUsize;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::process::ExitCode;

use anfis::{Epoch, StopReason};
use anyhow::Context;
use hinf_control::{FuzzySets, Law};
use indicatif::{ProgressBar, ProgressStyle};
use uarm_plot::sheet::Sheet;

use crate::console;
use crate::figures::output::{Format, write};
use crate::figures::sets;
use crate::options::{self, choice};
use crate::output_files::{Force, OutputFiles};
use crate::robot::fuzzy_sets::TrainedSets;
use crate::robot::overrides::Overrides;
use crate::robot::shape::for_shape;
use crate::robot::{Robot, RobotText};
use learn::{Learned, Settings, learn};
use samples::samples;

/// Arguments of `uarm train`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The fuzzy laws weigh 9 rules by how well the errors of a joint fit 3 sets of velocity error and 3 of position error.
ANFIS (Jang 1993) learns these sets off line from recorded runs:
  inputs   velocity and position error of the active joints, measured less desired, deg/s and deg
  target   applied torque less feedback torque, N m: what the rules shall supply (paper eqs. 41 and 43)
Take runs that track well without knowing the model, such as --controller neural. One fifth of the samples checks what the
others train, or all of --check; the sets with the lowest checking error are kept.
A better fit of recorded runs need not be a better controller: the laws adapt their rules while they run, the fit is of fixed ones.
Compare before use: the sets shipped are slightly worse than the untrained grid (docs/reproduction.md).

Example:
  uarm run --virtual-time --controller neural --log neural.mcap
  uarm train neural.mcap --out sets.toml --figures figures
  uarm compare --controllers fuzzy,fuzzy-model --fuzzy-sets sets.toml
  uarm run --controller fuzzy --fuzzy-sets sets.toml")]
pub struct Arguments {
    /// Recorded runs, all of the same law or of laws with the same weights: logs, or CSV files of uarm show --csv
    #[arg(required = true, value_name = "FILE.mcap|FILE.csv")]
    runs: Vec<PathBuf>,
    /// The law that made them
    #[arg(long, default_value = Law::Neural.name(), value_parser = choice::<Law>(), value_name = "LAW")]
    controller: Law,
    /// The robot file that they were made with; without it the paper's UARM
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// Another recorded run to check with; may be given more than once
    #[arg(long, value_name = "FILE.mcap|FILE.csv")]
    check: Vec<PathBuf>,
    /// How often the sets move, at most
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(0..=1_000_000), value_name = "N")]
    epochs: u32,
    /// The first step, in halves of a universe; it adapts
    #[arg(long, default_value_t = 0.01, allow_hyphen_values = true, value_parser = options::step, value_name = "STEP")]
    step: f64,
    /// Stop after so many epochs without a lower checking error
    #[arg(long, value_name = "N")]
    patience: Option<NonZeroUsize>,
    /// Where the sets go
    #[arg(long, default_value = "fuzzy-sets.toml", value_name = "FILE.toml")]
    out: PathBuf,
    #[command(flatten)]
    force: Force,
    /// Draw the sets before and after (the paper's Fig. 12) and the errors by epoch into this directory
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,
    /// Which files are drawn
    #[arg(long, value_enum, default_value_t, value_name = "FORMAT")]
    format: Format,
}

/// Trains and writes the sets, and tells what came of it.
///
/// # Errors
/// If a recorded run or the robot file is wrong, or a file cannot be written.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let inputs = arguments.runs.iter().chain(&arguments.check).chain(&arguments.robot);
    let outputs = OutputFiles::new(arguments.force, inputs.map(PathBuf::as_path));
    outputs.check([arguments.out.as_path()]).context("--out")?;
    let robot = RobotText::read(arguments.robot.as_deref())?;
    for_shape!(robot.shape()?, train(arguments, &robot, &outputs))
}

fn train<const J: usize, const N: usize>(
    arguments: &Arguments,
    file: &RobotText,
    outputs: &OutputFiles,
) -> anyhow::Result<ExitCode> {
    let robot = Robot::<J, N>::of_text(&file.name, &file.text, &Overrides::default())?;
    let data = samples(&arguments.runs, arguments.controller, &robot)?;
    let checking = match arguments.check.as_slice() {
        [] => None,
        files => Some(samples(files, arguments.controller, &robot)?),
    };
    let settings = Settings {
        epochs: arguments.epochs as usize,
        step: arguments.step,
        patience: arguments.patience,
        firing: robot.controllers.fuzzy.firing,
    };
    let bar = progress_bar(arguments.epochs);
    let learned = learn(&data, checking.as_ref(), &settings, |epoch| {
        bar.set_position(epoch.premise_updates as u64);
        bar.set_message(format!("RMSE {:.6} N m", epoch.rmse));
        ControlFlow::Continue(())
    })?;
    bar.finish_and_clear();
    let trained = TrainedSets { firing: robot.controllers.fuzzy.firing, sets: learned.sets };
    let text = trained.to_text(&comment(arguments, &robot.description.name, &learned));
    let figures = match &arguments.figures {
        Some(directory) => write(&figures(&learned), directory, arguments.format, outputs).context("--figures")?,
        None => Vec::new(),
    };
    outputs.write(&arguments.out, |output| output.write_all(text.as_bytes())).context("--out")?;
    let mut output = console::output();
    report(&mut output, &learned)?;
    for file in [&arguments.out].into_iter().chain(&figures) {
        writeln!(output, "{}", file.display())?;
    }
    Ok(ExitCode::SUCCESS)
}

fn progress_bar(epochs: u32) -> ProgressBar {
    let bar = if std::io::stderr().is_terminal() { ProgressBar::new(epochs.into()) } else { ProgressBar::hidden() };
    let style = ProgressStyle::with_template("  {bar:30} epoch {pos}/{len}  {msg}  {eta} left");
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// What stands above the sets: where they come from, so that they can be made again.
fn comment(arguments: &Arguments, robot: &str, learned: &Learned) -> String {
    let names = |files: &[PathBuf]| {
        files.iter().map(|file| file.file_name().unwrap_or_default().to_string_lossy().into_owned()).collect::<Vec<_>>()
    };
    let mut command = format!(
        "uarm train {} --controller {} --epochs {} --step {}",
        names(&arguments.runs).join(" "),
        arguments.controller.name(),
        arguments.epochs,
        arguments.step
    );
    for file in names(&arguments.check) {
        command.push_str(&format!(" --check {file}"));
    }
    if let Some(patience) = arguments.patience {
        command.push_str(&format!(" --patience {patience}"));
    }
    let (first, kept) = (learned.trained.history.first(), learned.trained.kept_epoch());
    let before = first.map_or(f64::NAN, |epoch| epoch.rmse);
    format!(
        "Premise sets of the fuzzy controllers, trained with ANFIS (Jang 1993). Use: --fuzzy-sets FILE.\n\
         A set is mu(x) = 1 / (1 + |(x - centre) / half_width|^(2 steepness)); centres ascend.\n\
         Made with (robot {robot}, file names without their directories):\n  {command}\n\
         {} samples trained, {} checked; RMSE {before:.6} N m before, {:.6} after {} epochs.",
        learned.counts[0], learned.counts[1], kept.rmse, kept.premise_updates
    )
}

fn report(output: &mut impl Write, learned: &Learned) -> std::io::Result<()> {
    let trained = &learned.trained;
    writeln!(output, "{} samples trained, {} checked", learned.counts[0], learned.counts[1])?;
    writeln!(output, "{:>18}  {:>12}  {:>12}", "RMSE (N m)", "training", "checking")?;
    let mut row = |name: String, epoch: &Epoch| {
        let checking = epoch.checking_rmse.unwrap_or(f64::NAN);
        writeln!(output, "{name:>18}  {:>12.7}  {checking:>12.7}", epoch.rmse)
    };
    if let Some(first) = trained.history.first() {
        row("before".into(), first)?;
    }
    row(format!("kept, epoch {}", trained.kept_epoch().premise_updates), trained.kept_epoch())?;
    let why = match trained.stopped {
        StopReason::Completed => "all epochs done",
        StopReason::OutOfPatience => "no lower checking error for --patience epochs",
        StopReason::Stationary => "the gradient vanished",
        StopReason::Interrupted => "interrupted",
    };
    writeln!(output, "ended: {why}")?;
    for (name, bells) in
        [("velocity error (deg/s)", learned.sets.velocity), ("position error (deg)", learned.sets.position)]
    {
        writeln!(output, "{name}")?;
        for bell in bells {
            writeln!(
                output,
                "  centre {:>9.4}   half width {:>8.4}   steepness {:>7.4}",
                bell.centre().to_degrees(),
                bell.half_width().to_degrees(),
                bell.steepness()
            )?;
        }
    }
    Ok(())
}

/// The sets before and after, and the errors by epoch.
fn figures(learned: &Learned) -> [Sheet; 2] {
    let kept = learned.trained.kept_epoch();
    let note = format!("ANFIS, {} epochs, {} samples", kept.premise_updates, learned.counts[0]);
    let before = FuzzySets::untrained();
    [
        sets::fuzzy_sets("fuzzy-sets", &before, &learned.sets, &note),
        sets::learning_curve("learning-curve", &learned.trained),
    ]
}
