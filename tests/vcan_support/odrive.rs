//! The robot of ODrive axes, as a process.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use super::bus::Bus;
use super::process::Running;
use super::{INTERFACE, NODES, Workshop};

/// Command id of an axis's heartbeat (ODrive CAN protocol).
pub const HEARTBEAT: u16 = 0x01;

/// Longer than emulated axes take to be heard.
const START_TIME: Duration = Duration::from_secs(60);

/// The identifier of a message of an axis.
pub fn id(node: u8, message: u16) -> u16 {
    u16::from(node) * 32 + message
}

/// A copy of the ODrive robot file in the folder.
pub fn robot_file(workshop: &Workshop) -> PathBuf {
    let file = workshop.file("uarm-odrive.toml");
    std::fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/uarm-odrive.toml"), &file).unwrap();
    file
}

/// A command of the binary with that robot file.
pub fn command(workshop: &Workshop, arguments: &[&str], robot: &Path) -> Command {
    let mut command = workshop.command();
    command.args(arguments).arg("--robot").arg(robot);
    command
}

/// The emulated axes, once each has been heard.
pub fn plant(workshop: &Workshop, bus: &Bus, robot: &Path, arguments: &[&str]) -> Running {
    let running = Running::start(command(workshop, &["plant", "--can", INTERFACE], robot).args(arguments));
    // Without resting: a guest in which everything rests leaps to its next timer, and over any time limit.
    let end = Instant::now() + START_TIME;
    let mut waiting = NODES.to_vec();
    while !waiting.is_empty() {
        for seen in bus.drain() {
            waiting.retain(|node| seen.id != id(*node, HEARTBEAT) || seen.data.len() != 8);
        }
        assert!(Instant::now() < end, "no heartbeat of axes {waiting:?} within {START_TIME:?}");
        std::thread::yield_now();
    }
    running
}
