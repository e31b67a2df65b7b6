//! `uarm plant`: the emulated robot on a CAN interface, for hardware-in-the-loop tests without hardware.

mod bench;
mod faults;
mod power_up;
mod serve;
mod truth;

use std::io;
use std::panic::resume_unwind;
use std::path::PathBuf;
use std::process::ExitCode;
use std::thread;
use std::time::Duration;

use anyhow::Context;
use hinf_control::Disturbance;
use uarm_io::socketcan_link::{Reception, SocketCanLink};
use uarm_loop::robot::Protocol;
use uarm_sim::{IntegrationStep, Pacing};

use crate::bought::{Bought, DictionaryArguments};
use crate::console;
use crate::options::{self, choice};
use crate::output_files::{Force, OutputFiles};
use crate::reference::incremental_joints;
use crate::robot::overrides::Overrides;
use crate::robot::shape::for_shape;
use crate::robot::{Robot, RobotText};
use crate::signals;
use crate::simulated_plant::{PlantChoice, SimulatedPlant};
use crate::simulated_robot::simulated_with;
use crate::usage::UsageError;
use bench::Bench;
use faults::{ACTIONS, OrderSource, Schedule};
use power_up::StartOf;
use serve::{Extras, serve};
use truth::TruthFile;

/// Arguments of `uarm plant`.
#[derive(Debug, clap::Args)]
#[command(after_help = format!("\
Examples:
  ip link add vcan0 type vcan && ip link set vcan0 up
  uarm plant --can vcan0 &
  uarm run --can vcan0

  uarm plant --can vcan0 --robot my-robot.toml --eds drive.eds --node 2 --eds drive.eds --node 3
  uarm plant --can vcan0 --fault 2@1.5s:over-temperature --truth truth.mcap

A joint whose encoder.reference is incremental counts from zero after each power-up of its drive: the whole path from power-up over
`uarm drive reference` to the run and the loss of power can be rehearsed.
The drives listen when the line `ready: nodes 1 2 3 on vcan0` has come on standard output.
Faults: {ACTIONS}, which takes all of a drive away. Times are of the plant, from the first SYNC with all drives enabled, in every run
anew.
An NMT reset of all drives, with which each run begins, puts the robot back to the start of its motion.
It never ends by itself: SIGINT or SIGTERM ends it. When the interface goes down it waits for it to come back."))]
pub struct Arguments {
    /// The CAN interface
    #[arg(long, value_name = "INTERFACE")]
    can: String,
    /// The robot file; without it the paper's UARM
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// What the robot is; by default it has the imperfections of the robot file's [plant], and is "ideal" without
    #[arg(long, value_parser = choice::<PlantChoice>(), value_name = "PLANT")]
    plant: Option<PlantChoice>,
    /// How plant time passes
    #[arg(long, value_enum, default_value_t, value_name = "PACING")]
    pacing: PacingChoice,
    /// What disturbs the joints, counted from the first SYNC with a drive enabled
    #[arg(long, value_parser = choice::<Disturbance>(), default_value = "none", value_name = "KIND")]
    disturbance: Disturbance,
    /// The period of lockstep, such as 3ms, instead of the robot file's
    #[arg(long, allow_hyphen_values = true, value_parser = options::period, value_name = "TIME")]
    period: Option<Duration>,
    /// How finely the motion is integrated; 1ms is as good as exact for the encoders, and takes a tenth of the processor
    #[arg(long, allow_hyphen_values = true, value_parser = step, default_value = "100us", value_name = "TIME")]
    step: IntegrationStep,
    #[command(flatten)]
    dictionaries: DictionaryArguments,
    /// How a drive starts: boot-time=700ms, emergency=8140, fault=3220, separated by commas, codes in hexadecimal digits; and what it
    /// has stored, such as 1801.1=0x282 for a TPDO2 that is on
    #[arg(long, value_name = "NODE:HOW")]
    start: Vec<StartOf>,
    /// A fault of a drive, at a time of the plant or at once; - takes them as lines from standard input
    #[arg(long, value_name = "NODE[@TIME]:FAULT")]
    fault: Vec<OrderSource>,
    /// Write the plant's true motion for each SYNC: to an MCAP file if the name ends in .mcap, else as CSV
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
}

/// How plant time passes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum PacingChoice {
    /// One period of plant per SYNC, whenever it comes: the motion is the same to the bit in every run
    #[default]
    Lockstep,
    /// With the clock, as a real robot
    WallClock,
}

/// A step of the integration.
fn step(text: &str) -> Result<IntegrationStep, String> {
    let step = humantime::parse_duration(text).ok().and_then(IntegrationStep::new);
    step.ok_or_else(|| {
        format!("expected a time from {:?} to {:?}, such as 1ms", IntegrationStep::SHORTEST, IntegrationStep::LONGEST)
    })
}

/// Is the robot, until somebody asks for the end.
///
/// # Errors
/// If the robot file is wrong or the interface cannot be used.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let mut emulated = emulated(arguments)?;
    check_nodes(&arguments.fault, &emulated.nodes)?;
    let name = arguments.can.parse().with_context(|| format!("--can {}", arguments.can))?;
    let inputs = arguments.robot.iter().chain(&arguments.dictionaries.eds).map(PathBuf::as_path);
    let outputs = OutputFiles::new(arguments.force, inputs);
    outputs.check(arguments.truth.as_deref())?;
    let link = SocketCanLink::open(name, Reception::Everything)?;
    let joints = emulated.nodes.len();
    let truth = arguments.truth.as_deref().map(|path| TruthFile::create(path, joints, &outputs)).transpose()?;
    let stop = signals::stop_request().context("signal handlers")?;
    let nodes = emulated.nodes.iter().map(u8::to_string).collect::<Vec<_>>().join(" ");
    console::tell(format_args!(
        "{}: emulated drives, nodes {nodes}, on {} ({:?})",
        emulated.name, arguments.can, emulated.pacing
    ));
    let ready = format!("ready: nodes {nodes} on {}", arguments.can);
    serve(emulated.bench.as_mut(), link, &stop, Extras { faults: Schedule::of(&arguments.fault), truth, ready })?;
    Ok(ExitCode::SUCCESS)
}

/// A robot that is not on a bus yet.
struct Emulated {
    name: String,
    /// Of its drives, from the base outwards.
    nodes: Vec<u8>,
    pacing: Pacing,
    bench: Box<dyn Bench + Send>,
}

/// Makes the robot, on a stack with room for the objects of its drives.
fn emulated(arguments: &Arguments) -> anyhow::Result<Emulated> {
    let text = RobotText::read(arguments.robot.as_deref())?;
    let shape = text.shape()?;
    let make = || for_shape!(shape, emulated_of(arguments, &text));
    let made = thread::scope(|scope| Ok(thread::Builder::new().stack_size(STACK).spawn_scoped(scope, make)?.join()));
    made.unwrap_or_else(|error: io::Error| Ok(Err(error.into()))).unwrap_or_else(|panic| resume_unwind(panic))
}

fn emulated_of<const J: usize, const N: usize>(arguments: &Arguments, text: &RobotText) -> anyhow::Result<Emulated> {
    let overrides = Overrides { period: arguments.period, ..Overrides::default() };
    let robot = Robot::<J, N>::of_text(&text.name, &text.text, &overrides)?;
    let pacing = match arguments.pacing {
        PacingChoice::Lockstep => Pacing::Lockstep { period: robot.description.period.duration() },
        PacingChoice::WallClock => Pacing::WallClock,
    };
    let nodes = robot.description.nodes();
    let starts = arguments.start.iter().map(|start| (start.node, start.past.clone()));
    let bought = Bought::read(&arguments.dictionaries, &nodes)?.starting(starts, &nodes)?;
    let bought = bought.counting_from_zero(&incremental_joints(&robot.file.joints));
    let is_bench = !bought.is_none() || !arguments.fault.is_empty() || arguments.truth.is_some();
    let is_canopen = matches!(robot.description.bus.protocol, Protocol::Canopen);
    anyhow::ensure!(
        is_canopen || !is_bench,
        "--eds, --start, --fault, --truth and incremental encoders: only with bus.protocol = \"canopen\""
    );
    let choice = PlantChoice::asked(arguments.plant, &robot)?;
    let plant = SimulatedPlant::new(&robot, choice, arguments.disturbance)?.with_integration_step(arguments.step);
    let bench = Box::new(simulated_with(&robot, plant, pacing, &bought)?);
    Ok(Emulated { name: robot.description.name, nodes: nodes.to_vec(), pacing, bench })
}

/// Drives with makers' dictionaries hold their objects by value, 0.4 MB each, and are made on the stack.
const STACK: usize = 64 << 20;

/// # Errors
/// A usage error if a fault is for a node that the robot has not.
fn check_nodes(sources: &[OrderSource], nodes: &[u8]) -> Result<(), UsageError> {
    for source in sources {
        if let OrderSource::Planned(order) = source
            && !nodes.contains(&order.node.raw())
        {
            return Err(UsageError::no_such_node(&format!("--fault {}:...", order.node.raw()), nodes));
        }
    }
    Ok(())
}
