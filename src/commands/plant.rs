//! `uarm plant`: the emulated robot on a CAN interface, for hardware-in-the-loop tests without hardware.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::Context;
use uarm_io::link::{Link, LinkError, LinkErrorKind};
use uarm_io::monotonic::MonotonicClock;
use uarm_io::socketcan_link::{Reception, SocketCanLink};
use uarm_io::time::Clock;
use uarm_sim::{Outbox, Pacing, RobotOnBus};

use hinf_control::Disturbance;
use uarm_loop::stop_request::StopRequest;

use crate::console;
use crate::options::{self, choice};
use crate::robot::Robot;
use crate::robot::overrides::Overrides;
use crate::signals;
use crate::simulated_robot::{PlantChoice, SimulatedPlant, simulated};

/// How long the robot waits for a frame before it looks whether it shall end.
const LONGEST_WAIT: Duration = Duration::from_millis(20);

/// Arguments of `uarm plant`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Example:
  ip link add vcan0 type vcan && ip link set vcan0 up
  uarm plant --can vcan0 &
  uarm run --can vcan0

An NMT reset of all drives, with which each run begins, puts the robot back to the start of its motion.
It never ends by itself: SIGINT or SIGTERM ends it. When the interface goes down it waits for it to come back.")]
pub struct Arguments {
    /// The CAN interface
    #[arg(long, value_name = "INTERFACE")]
    can: String,
    /// The robot file; without it the paper's UARM
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// What the robot is
    #[arg(long, value_parser = choice::<PlantChoice>(), default_value = "uarm", value_name = "PLANT")]
    plant: PlantChoice,
    /// How plant time passes
    #[arg(long, value_enum, default_value_t, value_name = "PACING")]
    pacing: PacingChoice,
    /// What disturbs the joints, counted from the first SYNC with all drives enabled
    #[arg(long, value_parser = choice::<Disturbance>(), default_value = "none", value_name = "KIND")]
    disturbance: Disturbance,
    /// The period of lockstep, such as 3ms, instead of the robot file's
    #[arg(long, allow_hyphen_values = true, value_parser = options::period, value_name = "TIME")]
    period: Option<Duration>,
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

/// Is the robot, until somebody asks for the end.
///
/// # Errors
/// If the robot file is wrong or the interface cannot be used.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let overrides = Overrides { period: arguments.period, ..Overrides::default() };
    let robot = Robot::load_with(arguments.robot.as_deref(), &overrides)?;
    let pacing = match arguments.pacing {
        PacingChoice::Lockstep => Pacing::Lockstep { period: robot.description.period.duration() },
        PacingChoice::WallClock => Pacing::WallClock,
    };
    let plant = SimulatedPlant::new(&robot, arguments.plant, arguments.disturbance)?;
    let emulated = simulated(&robot, plant, pacing)?;
    let name = arguments.can.parse().with_context(|| format!("--can {}", arguments.can))?;
    let link = SocketCanLink::open(name, Reception::Everything)?;
    let stop = signals::stop_request().context("signal handlers")?;
    let nodes: Vec<_> = robot.description.nodes().iter().map(u8::to_string).collect();
    console::tell(format_args!(
        "{}: emulated drives, nodes {}, on {} ({pacing:?})",
        robot.description.name,
        nodes.join(" "),
        arguments.can
    ));
    serve(emulated, link, &stop)?;
    Ok(ExitCode::SUCCESS)
}

/// Answers frames and lets time pass, until `stop` is made.
fn serve(mut robot: impl RobotOnBus, mut link: SocketCanLink, stop: &StopRequest) -> anyhow::Result<()> {
    let clock = MonotonicClock;
    let mut outbox = Outbox::new();
    robot.power_on(clock.now(), &mut outbox);
    while !stop.is_made() {
        flush(&mut outbox, &mut link)?;
        let wait = clock.now() + LONGEST_WAIT;
        let deadline = robot.next_deadline().map_or(wait, |deadline| deadline.min(wait));
        match link.receive(deadline) {
            Ok(Some(received)) => robot.on_frame(&received.frame, clock.now(), &mut outbox),
            Ok(None) => robot.on_time(clock.now(), &mut outbox),
            Err(error) => {
                robot.on_time(clock.now(), &mut outbox);
                bear(error, &mut link)?;
            }
        }
    }
    Ok(())
}

fn flush(outbox: &mut Outbox, link: &mut SocketCanLink) -> anyhow::Result<()> {
    while let Some(pending) = outbox.pop() {
        if let Err(error) = link.send(&pending.frame) {
            bear(error, link)?;
        }
    }
    Ok(())
}

/// A robot outlives its bus: it waits, while its drives notice the silence and brake.
fn bear<E: LinkError + Send + Sync + 'static>(error: E, link: &mut SocketCanLink) -> anyhow::Result<()> {
    match error.kind() {
        LinkErrorKind::Down | LinkErrorKind::QueueFull | LinkErrorKind::Controller | LinkErrorKind::BusOff => {
            std::thread::sleep(Duration::from_millis(1));
            Ok(())
        }
        LinkErrorKind::Gone => {
            std::thread::sleep(LONGEST_WAIT);
            // As long as the interface is not back this fails, and is tried again.
            let _ = link.reopen();
            Ok(())
        }
        _ => Err(anyhow::Error::new(error)),
    }
}
