//! `uarm compare`: the controllers side by side, beside the paper's Table 4.

mod caveat;
pub mod comparison;
mod csv;
pub mod draws;
pub mod experiments;
mod merge;
pub mod monte_carlo;
mod statistics;
mod study;
mod table;
pub mod variant;

use std::num::{NonZeroU32, NonZeroUsize};
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Context;
use hinf_control::Disturbance;

use crate::console;
use crate::exit::Exit;
use crate::options::{choice, positive};
use crate::output_files::{Force, OutputFiles};
use crate::robot::RobotText;
use crate::robot::shape::for_shape;
use crate::simulated_plant::PlantChoice;
use crate::study::parallel::all_cores;
use crate::study::progress::progress_bar;
use crate::study::shard::Shard;
use crate::study::spread::Spread;
use crate::study::start::StartVariation;
use crate::usage::UsageError;
use comparison::ComparisonSettings;
use monte_carlo::MonteCarloSettings;
use variant::{ControllerVariants, RobotFiles};

/// Arguments of `uarm compare`.
#[derive(Debug, clap::Args)]
#[command(
    args_conflicts_with_subcommands = true,
    after_help = "\
Examples:
  uarm compare                               the paper's six, five experiments each, beside Table 4
  uarm compare --controllers all             also other readings of the paper, our extensions and the baseline
  uarm compare --plant ideal --controllers nonlinear,nonlinear-omitted,nonlinear-reduced
  uarm compare --repeat 20 --seed 7 --csv experiments.csv
  uarm compare --monte-carlo 1000 --spread 20% --csv draws.csv
  uarm compare --monte-carlo 10000 --shard 2/8 --draws 2.jsonl   a part of it; `uarm compare merge` joins them
  uarm compare --variation none --repeat 1   the numbers of `uarm run --virtual-time`

Controllers, by name: nonlinear, adaptive, neural, neural-model, fuzzy, fuzzy-model (`paper`, as the robot file has them);
nonlinear-measured, nonlinear-omitted (other readings: where the base acceleration comes from); nonlinear-reduced,
nonlinear-reduced-momentum, neural-model-reduced, fuzzy-model-reduced (ours: docs/theory.md); computed-torque (a baseline).

Repetition k of a seed starts at the same angles for every controller. The numbers are the same on any number of threads."
)]
pub struct Arguments {
    #[command(subcommand)]
    merge: Option<Command>,
    #[command(flatten)]
    run: RunArguments,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// Make a whole of the files of parts of a Monte Carlo study
    Merge(merge::Arguments),
}

#[derive(Debug, clap::Args)]
struct RunArguments {
    /// The controllers: `paper` (its six), `all`, or names with commas between
    #[arg(long, default_value = "paper", value_name = "NAMES")]
    controllers: ControllerVariants,
    /// The robot file; without it the paper's UARM, which is built in
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// Let the fuzzy laws run with the sets in this file, as uarm train writes it; without it with the untrained grid
    #[arg(long, value_name = "FILE.toml")]
    fuzzy_sets: Option<PathBuf>,
    /// What the robot is; by default it has the imperfections of the robot file's [plant], and is "ideal" without
    #[arg(long, value_parser = choice::<PlantChoice>(), value_name = "PLANT")]
    plant: Option<PlantChoice>,
    /// The disturbance of the plant's joints; by default the paper's of eq. 48 on its arm, and none on others
    #[arg(long, value_parser = choice::<Disturbance>(), value_name = "KIND")]
    disturbance: Option<Disturbance>,
    /// Experiments with each controller; the paper made five
    #[arg(long, default_value = "5", value_parser = positive::<NonZeroU32>, value_name = "N")]
    repeat: NonZeroU32,
    /// Instead of repetitions on one plant: this many plants drawn around the UARM, one experiment with each controller
    #[arg(long, value_parser = positive::<NonZeroU32>, value_name = "N", conflicts_with = "repeat")]
    monte_carlo: Option<NonZeroU32>,
    /// How far each parameter of the drawn plants may be from the robot file's, as 20% or 0.2
    #[arg(long, default_value = "20%", value_name = "SHARE", requires = "monte_carlo")]
    spread: Spread,
    /// Only this part of the draws, such as 2/8
    #[arg(long, value_name = "PART/PARTS", requires = "draws", conflicts_with = "repeat")]
    shard: Option<Shard>,
    /// Write every draw to this file, a line of JSON each, for `uarm compare merge`
    #[arg(long, value_name = "FILE.jsonl", requires = "monte_carlo", conflicts_with = "repeat")]
    draws: Option<PathBuf>,
    /// What differs between the experiments
    #[arg(long, value_enum, default_value_t, value_name = "WHAT")]
    variation: StartVariation,
    /// What the differences are drawn from
    #[arg(long, default_value_t = 1, value_name = "SEED")]
    seed: u64,
    /// How many experiments run at a time; by default as many as the machine has processors
    #[arg(long, value_parser = positive::<NonZeroUsize>, value_name = "N")]
    threads: Option<NonZeroUsize>,
    /// Write every experiment to this file
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Print the study as JSON
    #[arg(long)]
    json: bool,
}

impl RunArguments {
    fn files(&self) -> RobotFiles<'_> {
        RobotFiles { robot: self.robot.as_deref(), fuzzy_sets: self.fuzzy_sets.as_deref() }
    }
}

/// Runs the study and prints it.
///
/// # Errors
/// If the robot file is wrong, an experiment cannot be begun, or a file cannot be written.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let arguments = match &arguments.merge {
        Some(Command::Merge(arguments)) => return merge::execute(arguments),
        None => &arguments.run,
    };
    let outputs = OutputFiles::new(
        arguments.force,
        [&arguments.robot, &arguments.fuzzy_sets].into_iter().flatten().map(PathBuf::as_path),
    );
    outputs
        .check([&arguments.csv, &arguments.draws].into_iter().flatten().map(PathBuf::as_path))
        .context("--csv, --draws")?;
    let shape = RobotText::read(arguments.robot.as_deref())?.shape()?;
    match arguments.monte_carlo {
        None => for_shape!(shape, compare(arguments, &outputs)),
        Some(draws) => monte_carlo(arguments, draws, &outputs),
    }
}

fn monte_carlo(arguments: &RunArguments, draws: NonZeroU32, outputs: &OutputFiles) -> anyhow::Result<ExitCode> {
    if arguments.plant.unwrap_or_default() != PlantChoice::Uarm {
        let message =
            "--monte-carlo draws the imperfections of the UARM, expected --plant uarm: the other plants have none";
        return Err(UsageError::new(message).into());
    }
    let settings = MonteCarloSettings {
        files: arguments.files(),
        variants: arguments.controllers.as_slice(),
        disturbance: arguments.disturbance.unwrap_or(Disturbance::Paper),
        draws,
        spread: arguments.spread,
        variation: arguments.variation,
        seed: arguments.seed,
        threads: arguments.threads.unwrap_or_else(all_cores),
    };
    let shard = arguments.shard.unwrap_or(Shard::WHOLE);
    let bar = progress_bar(shard.of(draws.get().into()).count() as u64, "robots");
    let draws = monte_carlo::run(&settings, shard, || bar.inc(1));
    bar.finish_and_clear();
    let draws = draws?;
    if let Some(path) = &arguments.draws {
        outputs.write(path, |output| draws.write(output)).context("--draws")?;
    }
    study::tell(&draws, arguments.csv.as_deref(), arguments.json, outputs)
}

fn compare<const J: usize, const N: usize>(
    arguments: &RunArguments,
    outputs: &OutputFiles,
) -> anyhow::Result<ExitCode> {
    let (variants, left_out) = arguments.controllers.on_robot::<J, N>(arguments.files())?;
    let settings = ComparisonSettings {
        files: arguments.files(),
        variants: &variants,
        left_out: &left_out,
        plant: arguments.plant,
        disturbance: arguments.disturbance,
        repetitions: arguments.repeat,
        variation: arguments.variation,
        seed: arguments.seed,
        threads: arguments.threads.unwrap_or_else(all_cores),
    };
    let experiments = settings.variants.len() as u64 * u64::from(settings.repetitions.get());
    let bar = progress_bar(experiments, "experiments");
    let comparison = comparison::run::<J, N>(&settings, || bar.inc(1));
    bar.finish_and_clear();
    let comparison = comparison?;
    if let Some(path) = &arguments.csv {
        outputs.write(path, |output| csv::write_comparison(&comparison, output)).context("--csv")?;
    }
    if arguments.json {
        console::print_json(&comparison)?;
    } else {
        table::print_comparison(&comparison, &mut console::output())?;
    }
    let exit = match (comparison.controllers.is_empty(), comparison.failures.is_empty()) {
        (true, _) => Exit::Failure,
        (false, false) => Exit::Loss,
        (false, true) => Exit::Ok,
    };
    Ok(exit.into())
}
