//! `uarm drive torque-test`: a small torque on one joint, watched; does the joint move, and which way does it count then?

mod trial;

use std::io::{IsTerminal, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::Context;
use serde::Serialize;
use uarm_io::drive::{DriveNetwork, NodeId};
use uarm_io::link::Link;
use uarm_io::monotonic::MonotonicClock;
use uarm_io::realtime::RealtimePolicy;
use uarm_io::socketcan_link::{InterfaceName, Reception, SocketCanLink};
use uarm_io::time::Clock;
use uarm_loop::robot::Joint;
use uarm_loop::stop_request::StopRequest;

use super::confirmation::{Confirmation, confirm};
use super::enabled::{Brakes, enabled};
use crate::console;
use crate::exit::Exit;
use crate::options::node_id;
use crate::realtime::RealtimeArguments;
use crate::robot::on_bus::JointsOnBus;
use crate::signals;
use trial::{Plan, Trial};

/// Less than this share of the window is no motion, but play and noise.
const MOTION_SHARE: f64 = 0.02;
/// Time from zero torque to the asked one, and back.
const RAMP: Duration = Duration::from_millis(500);
/// How long it is held.
const HOLD: Duration = Duration::from_millis(500);

/// Arguments of `uarm drive torque-test`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
THE MOTOR MOVES, and its brake opens. Support the arm, and keep a hand on an emergency stop that cuts the motors' power.
The torque rises in 0.5 s, holds 0.5 s and falls; it ends at once when the joint goes too far or too fast. Every end brakes: torque
0, quick stop, power off; Ctrl-C too. The drive is reset, read, configured and watched as in `uarm run`; other drives get nothing.
Exit code 0 if the joint moved and its counts went the way of the torque.
Example:
  uarm drive torque-test --can can0 --robot my-robot.toml --node 2 --per-mille 20")]
pub struct Arguments {
    /// The CAN interface
    #[arg(long, value_name = "INTERFACE")]
    can: InterfaceName,
    /// The robot file
    #[arg(long, value_name = "FILE")]
    robot: PathBuf,
    /// The drive's node id
    #[arg(long, value_parser = node_id, value_name = "1..126")]
    node: NodeId,
    /// The torque, per mille as object 6071h has it: the drive's own sense of direction, 1 to 200 either way
    #[arg(long, allow_hyphen_values = true, value_parser = clap::value_parser!(i16).range(-200..=200), value_name = "N")]
    per_mille: i16,
    /// End when the joint has moved so far, degrees
    #[arg(long, default_value_t = 5.0, value_name = "DEG")]
    window: f64,
    /// End when the joint is so fast, degrees per second
    #[arg(long, default_value_t = 20.0, value_name = "DEG/S")]
    speed: f64,
    /// Confirmed already: do not ask
    #[arg(long)]
    yes: bool,
    #[command(flatten)]
    realtime: RealtimeArguments,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Tries the torque and prints what came of it.
///
/// # Errors
/// If it is not allowed by the robot file or not confirmed, or the drive cannot be started or is lost.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let robot = JointsOnBus::load(&arguments.robot)?;
    let joint = &robot.joints[robot.joint_of(arguments.node)?];
    let plan = plan(arguments, joint, robot.period)?;
    let realtime = arguments.realtime.settings(RealtimePolicy::Enforce)?;
    let node = arguments.node.raw();
    console::tell(format_args!(
        "{}, node {node} on {}: {} per mille of the rated torque, at most {} deg and {} deg/s; THE MOTOR WILL MOVE",
        joint.name, arguments.can, plan.per_mille, arguments.window, arguments.speed
    ));
    let statement = format!("the arm is supported and node {node} may move");
    let terminal = std::io::stdin().is_terminal();
    match confirm(&statement, &node.to_string(), arguments.yes, terminal, &mut std::io::stdin().lock())? {
        Confirmation::Given => {}
        Confirmation::Refused => anyhow::bail!("not confirmed: nothing was sent"),
    }
    let stop = signals::stop_request().context("signal handlers")?;
    let configuration = robot.network_configuration_of(joint)?;
    let identifiers: Vec<_> = configuration.receive_identifiers().collect();
    let link = SocketCanLink::open(arguments.can, Reception::Exactly(&identifiers))?;
    let _thread = realtime.enter_unrecorded()?;
    let report = attempt(DriveNetwork::new(link, configuration), &mut MonotonicClock, &plan, &stop)?;
    let mut output = std::io::stdout().lock();
    if arguments.json {
        serde_json::to_writer_pretty(&mut output, &report)?;
        writeln!(output)?;
    } else {
        write!(output, "{}", report.text(&joint.name, node))?;
    }
    Ok(if report.is_good() { Exit::Ok } else { Exit::Failure }.into())
}

fn plan(arguments: &Arguments, joint: &Joint, period: Duration) -> anyhow::Result<Plan> {
    let most = if joint.torque_limit > 0.0 { joint.torque_scale.ceiling.per_mille() } else { 0 };
    anyhow::ensure!(
        arguments.per_mille != 0 && arguments.per_mille.abs() <= most,
        "--per-mille {}: the robot file allows {} 1 to {most} either way",
        arguments.per_mille,
        joint.name
    );
    let counts = |name: &str, degrees: f64, most: f64| {
        anyhow::ensure!(degrees > 0.0 && degrees <= most, "--{name} {degrees}: expected above 0, at most {most}");
        Ok(degrees.to_radians() / joint.encoder.counts_per_revolution.resolution())
    };
    Ok(Plan {
        per_mille: arguments.per_mille,
        ramp: RAMP,
        hold: HOLD,
        period,
        window: counts("window", arguments.window, 90.0)?,
        speed: counts("speed", arguments.speed, joint.limits.velocity.to_degrees())?,
    })
}

/// Starts the drive, tries the torque, and brakes in any case.
fn attempt<L: Link, C: Clock>(
    mut network: DriveNetwork<L, 1>,
    clock: &mut C,
    plan: &Plan,
    stop: &StopRequest,
) -> anyhow::Result<Report>
where
    L::Error: Send + Sync + 'static,
{
    let (trial, brakes) =
        enabled(&mut network, clock, |drive| trial::run(drive, plan, stop).map_err(anyhow::Error::new))?;
    let moved = trial.travelled_counts.unsigned_abs() as f64 > MOTION_SHARE * plan.window;
    Ok(Report { trial, braked: brakes == Brakes::Closed, moved })
}

/// What came of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
struct Report {
    trial: Trial,
    /// The drive confirmed that its power is off.
    braked: bool,
    /// The joint moved.
    moved: bool,
}

impl Report {
    /// True if the counts went the way of the torque.
    const fn agrees(&self) -> bool {
        self.moved && (self.trial.travelled_counts > 0) == (self.trial.sent_per_mille > 0)
    }

    const fn is_good(&self) -> bool {
        self.braked && self.agrees()
    }

    fn text(&self, name: &str, node: u8) -> String {
        let Trial { end, sent_per_mille, travelled_counts, seconds } = self.trial;
        let verdict = match (self.moved, self.agrees()) {
            (false, _) => "the joint did not move: more torque, or is its brake closed?",
            (true, true) => "the counts went the way of the torque",
            (true, false) => {
                "THE COUNTS WENT AGAINST THE TORQUE: a loop on this joint runs away; set polarity 607Eh or the wiring right"
            }
        };
        let brakes = if self.braked { Brakes::Closed } else { Brakes::NotConfirmed };
        format!(
            "{name} (node {node}): {sent_per_mille:+} per mille, {travelled_counts:+} counts in {seconds:.2} s, {end:?}\n  \
             {verdict}\n  {brakes}\n"
        )
    }
}

#[cfg(test)]
mod tests;
