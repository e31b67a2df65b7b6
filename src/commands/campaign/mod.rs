//! `uarm campaign`: drawn faults, each in a run of its own, held against what must be true of any run.

mod merge;
mod outcome;

use std::num::{NonZeroU64, NonZeroUsize};
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Context;
use hinf_control::{Disturbance, Law};
use uarm_loop::robot::Protocol;

use crate::bought::Bought;
use crate::campaign::store::{CampaignHeader, Trials};
use crate::campaign::trial::Trial;
use crate::commands::run::rehearse;
use crate::options::positive;
use crate::output_files::{Force, OutputFiles};
use crate::robot::Robot;
use crate::study::parallel::{all_cores, in_parallel};
use crate::study::progress::progress_bar;
use crate::study::shard::Shard;
use crate::version::VERSION;
use outcome::tell;

/// Arguments of `uarm campaign`.
#[derive(Debug, clap::Args)]
#[command(
    args_conflicts_with_subcommands = true,
    after_help = "\
Examples:
  uarm campaign                                            300 seeds on the paper's UARM
  uarm campaign --seeds 10000 --output campaign.jsonl      what a release is held against
  uarm campaign --first 4711 --seeds 1                     one seed again, by itself
  uarm campaign --seeds 10000 --shard 2/8 --output 2.jsonl a part of it, on another machine
  uarm campaign merge 1.jsonl 2.jsonl … --output campaign.jsonl

A seed draws fault, controller, joint, instant and robot (20 % around the robot file's), and runs the loop in virtual time on
emulated CANopen drives. In every trial: torques stay within the joints' limits, no joint passes its angles, brakes close
within the fault's bound and stay closed, the first cause is the right one, and every cycle is recorded. Parts merge to the
same bytes as one run. Exit code 1 if a trial failed. docs/scale.md shows batch systems."
)]
pub struct Arguments {
    #[command(subcommand)]
    merge: Option<Command>,
    #[command(flatten)]
    run: RunArguments,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// Make a whole of the files of parts
    Merge(merge::Arguments),
}

#[derive(Debug, clap::Args)]
struct RunArguments {
    /// The robot file; without it the paper's UARM, which is built in
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// How many seeds
    #[arg(long, default_value = "300", value_parser = positive::<NonZeroU64>, value_name = "N")]
    seeds: NonZeroU64,
    /// The first of them
    #[arg(long, default_value_t = 1, value_name = "SEED")]
    first: u64,
    /// Only this part of them, such as 2/8
    #[arg(long, value_name = "PART/PARTS")]
    shard: Option<Shard>,
    /// How many run at a time; by default as many as the machine has processors
    #[arg(long, value_parser = positive::<NonZeroUsize>, value_name = "N")]
    threads: Option<NonZeroUsize>,
    /// Write every trial to this file, a line of JSON each
    #[arg(long, short, value_name = "FILE.jsonl")]
    output: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs a campaign, or merges parts of one.
///
/// # Errors
/// If the robot file is wrong, a trial cannot be begun, or a file cannot be read or written.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    match &arguments.merge {
        Some(Command::Merge(arguments)) => merge::execute(arguments),
        None => run(&arguments.run),
    }
}

fn run(arguments: &RunArguments) -> anyhow::Result<ExitCode> {
    let outputs = OutputFiles::new(arguments.force, arguments.robot.as_deref());
    outputs.check(arguments.output.as_deref()).context("--output")?;
    let robot = Robot::load(arguments.robot.as_deref())?;
    anyhow::ensure!(
        robot.description.bus.protocol == Protocol::Canopen,
        "bus: protocol: expected \"canopen\": the faults are those of CiA 402 drives"
    );
    for law in Law::ALL {
        let end = rehearse(&robot, &Bought::default(), law, Disturbance::Paper)?;
        end.completed(law.name()).context("the robot cannot do its task, even without a fault")?;
    }
    let header = header(arguments, &robot)?;
    let shard = arguments.shard.unwrap_or(Shard::WHOLE);
    let seeds: Vec<u64> = shard.of(header.seeds).map(|index| header.first_seed + index).collect();
    let bar = progress_bar(seeds.len() as u64, "trials");
    let threads = arguments.threads.unwrap_or_else(all_cores);
    let trials = in_parallel(seeds.len(), threads, |index| Trial::run(&robot, seeds[index]), || bar.inc(1));
    bar.finish_and_clear();
    let trials = Trials { header, results: trials? };
    if let Some(path) = &arguments.output {
        outputs.write(path, |output| trials.write(output)).context("--output")?;
    }
    tell(&trials, arguments.json)
}

fn header(arguments: &RunArguments, robot: &Robot) -> anyhow::Result<CampaignHeader> {
    let (first, seeds) = (arguments.first, arguments.seeds.get());
    anyhow::ensure!(
        first.checked_add(seeds).is_some(),
        "--first {first}, --seeds {seeds}: expected a last seed below {}",
        u64::MAX
    );
    Ok(CampaignHeader {
        uarm: VERSION.to_owned(),
        robot: robot.description.name.clone(),
        robot_crc32: crc32fast::hash(robot.source.as_bytes()),
        first_seed: first,
        seeds,
    })
}
