//! `uarm drive direction`: which way a joint counts, seen while somebody turns it with the motor off.

mod text;
mod turning;
mod watch;

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::Context;
use uarm_io::drive::NodeId;
use uarm_io::monotonic::MonotonicClock;
use uarm_io::socketcan_link::{InterfaceName, Reception, SocketCanLink};

use super::patient_link::PatientLink;
use crate::console;
use crate::exit::Exit;
use crate::options::node_id;
use crate::robot::on_bus::JointsOnBus;
use crate::{sdo_access, signals};
use text::Finding;

/// Arguments of `uarm drive direction`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Turn the joint counter-clockwise, the model's positive direction, by --turns revolutions. Then press Ctrl-C.
The drive is read by SDO uploads and gets no command. Its power stage must be off; release the brake by hand.
Exit code 1 if the joint was not turned, or the robot file says otherwise.
Examples:
  uarm drive direction --can can0 --node 2
  uarm drive direction --can can0 --node 2 --robot my-robot.toml --seconds 20 --json")]
pub struct Arguments {
    /// The CAN interface
    #[arg(long, value_name = "INTERFACE")]
    can: InterfaceName,
    /// The drive's node id
    #[arg(long, value_parser = node_id, value_name = "1..126")]
    node: NodeId,
    /// A robot file that the joint is compared with
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// How many revolutions the joint is turned, for the counts per revolution
    #[arg(long, default_value_t = 1.0, value_name = "N")]
    turns: f64,
    /// End after so many seconds instead of with Ctrl-C
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=86_400), value_name = "N")]
    seconds: Option<u32>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Watches the joint and prints what its counts tell.
///
/// # Errors
/// If the drive does not answer, is switched on, or the robot file has no such node.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    anyhow::ensure!(
        arguments.turns.is_finite() && arguments.turns > 0.0,
        "--turns {}: expected a number above 0",
        arguments.turns
    );
    let encoder = match &arguments.robot {
        Some(file) => Some(encoder_of(&JointsOnBus::load(file)?, arguments.node)?),
        None => None,
    };
    let stop = signals::stop_request().context("signal handlers")?;
    let identifiers = sdo_access::identifiers(arguments.node);
    let mut link = PatientLink(SocketCanLink::open(arguments.can, Reception::Exactly(&identifiers))?);
    sdo_access::ensure(&mut link, &MonotonicClock, arguments.node)?;
    let limit = arguments.seconds.map(|seconds| Duration::from_secs(seconds.into()));
    let (node, turns) = (arguments.node.raw(), arguments.turns);
    console::tell(format_args!("turn the joint of node {node} counter-clockwise by {turns} revolutions"));
    let turning = watch::watch(&mut link, &MonotonicClock, arguments.node, limit, &stop, |turning| {
        let (last, travelled) = (turning.last(), turning.travelled());
        console::tell_again(format_args!("{last:>12} counts, {travelled:+} from the start   "));
    })?;
    console::tell("");
    let finding = Finding::new(arguments.node.raw(), &turning, arguments.turns, encoder);
    if arguments.json {
        console::print_json(&finding)?;
    } else {
        console::output().write_all(finding.text().as_bytes())?;
    }
    Ok(if finding.is_good() { Exit::Ok } else { Exit::Failure }.into())
}

fn encoder_of(robot: &JointsOnBus, node: NodeId) -> anyhow::Result<uarm_io::encoder::EncoderConfiguration> {
    Ok(robot.joints[robot.joint_of(node)?].encoder)
}
