//! The reference of one joint, from what its drive shows.

use std::time::SystemTime;

use uarm_io::drive::NodeId;

use crate::reference::drive::Shown;
use crate::reference::store::{JointReference, References};
use crate::robot::on_bus::JointsOnBus;

/// What is known of a joint's angle: so many degrees at so many counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fix {
    /// The joint, from 0.
    pub joint: usize,
    /// Its angle, degrees.
    pub angle_deg: f64,
    /// 6064h there.
    pub position_counts: i32,
    /// The drive's homing method that found it.
    pub homing_method: Option<i8>,
}

/// The reference that follows from `fix` for the drive that showed `shown`, before its marker was written.
///
/// # Errors
/// If the marker reads so already, although no reference in `earlier` wrote it: a loss of power would not be seen.
pub fn joint_reference(
    robot: &JointsOnBus,
    fix: &Fix,
    shown: &Shown,
    earlier: Option<&References>,
) -> anyhow::Result<JointReference> {
    let (file, description) = (&robot.written[fix.joint], &robot.joints[fix.joint]);
    let marker = file.encoder.power_marker.as_ref().and_then(|marker| marker.as_value());
    let is_new = earlier.and_then(|earlier| earlier.of_node(file.node)).is_none();
    anyhow::ensure!(
        marker.is_none() || !is_new || shown.marker != marker,
        "{}: the object of its power_marker reads as the marker before it was written, so that a loss of power would not be \
         seen: choose another value or object",
        description.name
    );
    Ok(JointReference {
        name: description.name.clone(),
        node: file.node,
        date: humantime::format_rfc3339_seconds(SystemTime::now()).to_string(),
        angle_deg: fix.angle_deg,
        position_counts: fix.position_counts,
        homing_method: fix.homing_method,
        zero_counts: description.encoder.referenced(fix.position_counts, fix.angle_deg.to_radians()).zero,
        counts_per_revolution: file.encoder.counts_per_revolution,
        gear_ratio: file.gear_ratio,
        direction: file.encoder.direction,
        window_deg: [file.limits.minimum_deg, file.limits.maximum_deg],
        vendor: shown.vendor,
        product: shown.product,
        serial: shown.serial,
        power_marker: file.encoder.power_marker.clone(),
    })
}

/// The node of a joint's drive.
pub fn node(robot: &JointsOnBus, joint: usize) -> NodeId {
    robot.joints[joint].node
}
