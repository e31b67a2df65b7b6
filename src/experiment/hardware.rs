//! Drives on a CAN interface.

use anyhow::Context;
use uarm_io::socketcan_link::{Reception, SocketCanLink};

use crate::robot::Robot;

/// A link to the drives of `robot` on `interface`. The kernel passes on only frames that they send.
///
/// # Errors
/// If the interface cannot be used, with how to get it.
pub fn link(robot: &Robot, interface: &str) -> anyhow::Result<SocketCanLink> {
    let name = interface.parse().with_context(|| format!("--can {interface}"))?;
    let identifiers: Vec<_> = robot.network_configuration()?.receive_identifiers().collect();
    Ok(SocketCanLink::open(name, Reception::Exactly(&identifiers))?)
}
