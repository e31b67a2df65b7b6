//! Where the joints with incremental encoders are: a pose that somebody confirmed, stored with what shows that it still holds.
//!
//! An incremental counter keeps its meaning while the drive has power. Its loss is seen by a marker, a value written into an
//! object that the drive forgets with its power, or by a bit of the statusword with which the maker says so; the robot file
//! names at least one of them. A drive that was exchanged is seen by its serial number, a counter that cannot be right by a
//! window of angles.
//!
//! | module | subject |
//! |---|---|
//! | [`store`] | the file beside the robot file |
//! | [`drive`] | what a drive shows of itself |
//! | [`mod@verify`] | does a stored reference still hold? |

pub mod drive;
pub mod store;
pub mod verify;

use std::path::Path;

use anyhow::Context;
use uarm_io::monotonic::MonotonicClock;
use uarm_io::socketcan_link::{InterfaceName, Reception, SocketCanLink};
use uarm_loop::robot::{Bus, Joint, Protocol};

use crate::robot::Robot;
use crate::robot::file::{self, Encoder, ReferenceKind};
use crate::sdo_access;
use drive::{Shown, show};
use store::References;
use verify::verify;

/// Those of `joints` whose angles are unknown after power-up, by index.
pub fn incremental_joints(joints: &[file::Joint]) -> Vec<usize> {
    let is_incremental = |encoder: &Encoder| encoder.reference == ReferenceKind::Incremental;
    joints.iter().enumerate().filter(|(_, joint)| is_incremental(&joint.encoder)).map(|(index, _)| index).collect()
}

/// A link that hears the SDO answers and heartbeats of the drives of `joints` on `bus`, for a [`show`] of each.
///
/// # Errors
/// If the interface cannot be used, or the drives do not speak CANopen.
pub fn link(bus: &Bus, joints: &[Joint], interface: InterfaceName) -> anyhow::Result<SocketCanLink> {
    anyhow::ensure!(
        bus.protocol == Protocol::Canopen,
        "encoder.reference = \"incremental\" needs drives that speak CANopen"
    );
    let identifiers: Vec<_> = joints.iter().flat_map(|joint| sdo_access::identifiers(joint.node)).collect();
    Ok(SocketCanLink::open(interface, Reception::Exactly(&identifiers))?)
}

/// `robot`, read from `file`, with the stored references of its incremental joints, each held against its drive on
/// `interface`; and a line of text for each. Drives are read and get no command but as [`sdo_access::ensure`] says. A robot without such joints stays as it is, and
/// no drive is read.
///
/// # Errors
/// If a reference is missing or no longer holds: the message says why, and how to set it.
pub fn apply<const J: usize, const N: usize>(
    robot: Robot<J, N>,
    file: Option<&Path>,
    interface: InterfaceName,
) -> anyhow::Result<(Robot<J, N>, Vec<String>)> {
    let joints = incremental_joints(&robot.file.joints);
    let (Some(file), false) = (file, joints.is_empty()) else { return Ok((robot, Vec::new())) };
    let how =
        || format!("set it with `uarm drive reference --robot {} --can {interface} --angles ...`", file.display());
    let stored = References::read_beside(file)?.with_context(|| format!("the robot is not referenced: {}", how()))?;
    let mut link = link(&robot.description.bus, &robot.description.joints, interface)?;
    let mut shown = Vec::new();
    for joint in joints {
        let found =
            show(&mut link, &MonotonicClock, robot.description.joints[joint].node, &robot.file.joints[joint].encoder)?;
        shown.push((joint, found));
    }
    referenced(robot, file, &stored, &shown).with_context(how)
}

/// See [`apply`]: with what the drives have shown.
fn referenced<const J: usize, const N: usize>(
    robot: Robot<J, N>,
    file: &Path,
    stored: &References,
    shown: &[(usize, Shown)],
) -> anyhow::Result<(Robot<J, N>, Vec<String>)> {
    let mut changed = robot.file.clone();
    let mut lines = Vec::new();
    for (joint, found) in shown {
        let name = &robot.description.joints[*joint].name;
        let node = robot.file.joints[*joint].node;
        let reference = stored.of_node(node).with_context(|| {
            format!("{name} (node {node}) is not referenced in {}", References::path(file).display())
        })?;
        let angle = verify(&robot.file.joints[*joint], &robot.description.joints[*joint], reference, found)
            .with_context(|| format!("{name} (node {node}) is not referenced any more"))?;
        changed.joints[*joint].encoder.zero_counts = reference.zero_counts;
        lines.push(format!(
            "  {name}: reference of {} at {} deg{}; now at {:.2} deg ({} counts)",
            reference.date,
            reference.angle_deg,
            reference.how(),
            angle.to_degrees(),
            found.position
        ));
    }
    let referenced = Robot::check(file, &robot.source, changed)?;
    Ok((Robot { profiles: robot.profiles, ..referenced }, lines))
}

#[cfg(test)]
mod tests;
