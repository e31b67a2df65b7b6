//! The command line of `uarm drive reference`.

use std::path::PathBuf;

use uarm_io::drive::NodeId;
use uarm_io::socketcan_link::InterfaceName;

use crate::options::node_id;
use crate::realtime::RealtimeArguments;

/// Arguments of `uarm drive reference`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
In a pose: put the arm into a jig or at its marks, motors off and brakes closed, and give the angles that it has there. The angles of
joints whose encoder.reference is \"absolute\" are not used. The drives get no command; the robot file's power_marker is written.
With --homing: THE MOTOR MOVES, and its brake opens. Support the arm, and keep a hand on an emergency stop that cuts the motors'
power. The drive homes by itself as encoder.homing says; it is set up and watched as in `uarm run`, other drives get nothing.
Every end brakes: quick stop, power off; Ctrl-C too.
The reference is stored beside the robot file (my-robot.toml: my-robot.reference.toml) and holds until the drive loses its power, is
reset or exchanged: `uarm run` sees that.
Examples:
  uarm drive reference --robot my-robot.toml --can can0 --angles 0,20,20
  uarm drive reference --robot my-robot.toml --can can0 --homing --node 2")]
pub struct Arguments {
    /// The robot file
    #[arg(long, value_name = "FILE")]
    pub robot: PathBuf,
    /// The CAN interface
    #[arg(long, value_name = "INTERFACE")]
    pub can: InterfaceName,
    /// The angles of all joints in the order of the robot file, in degrees
    #[arg(long, value_delimiter = ',', num_args = 1, allow_hyphen_values = true, value_name = "DEG,DEG,...")]
    #[arg(required_unless_present = "homing", conflicts_with = "homing")]
    pub angles: Vec<f64>,
    /// Let the drive of --node find its home position by itself. THE MOTOR MOVES
    #[arg(long, requires = "node")]
    pub homing: bool,
    /// The node id of the drive that homes
    #[arg(long, value_parser = node_id, requires = "homing", value_name = "1..126")]
    pub node: Option<NodeId>,
    /// Confirmed already: do not ask
    #[arg(long)]
    pub yes: bool,
    #[command(flatten)]
    pub realtime: RealtimeArguments,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}
