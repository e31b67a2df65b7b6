//! What the ODrive master must know of a robot's axes.

use uarm_io::drive::odrive::wire::AxisNode;
use uarm_io::drive::odrive::{OdriveAxis, OdriveConfiguration, OdriveTimes, Positions};
use uarm_io::encoder::CountsPerRevolution;

use crate::robot::{Joint, Robot};

/// A joint whose node id no ODrive axis can have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{joint}: node {node}, expected {} to {} for an ODrive axis", AxisNode::RANGE.start(), AxisNode::RANGE.end())]
pub struct AxisNodeError {
    /// The joint's name.
    pub joint: String,
    /// Its node id.
    pub node: u8,
}

impl<const J: usize, const N: usize> Robot<J, N> {
    /// The ODrive master's configuration; positions come as `positions` says.
    ///
    /// # Errors
    /// [`AxisNodeError`] for a joint whose node id no axis can have.
    pub fn odrive_configuration(&self, positions: Positions) -> Result<OdriveConfiguration<J>, AxisNodeError> {
        if let Some(joint) = self.joints.iter().find(|joint| AxisNode::new(joint.node.raw()).is_none()) {
            return Err(AxisNodeError { joint: joint.name.clone(), node: joint.node.raw() });
        }
        let axes = self.joints.each_ref().map(axis);
        let bus = &self.bus;
        let times = OdriveTimes {
            heartbeat: bus.drive_heartbeat,
            heartbeat_timeout: bus.drive_timeout,
            watchdog: bus.controller_timeout,
            feed: bus.controller_heartbeat,
            listen: bus.listen,
            presence: bus.timeouts.boot,
            state: bus.timeouts.power,
        };
        Ok(OdriveConfiguration { axes, positions, times })
    }
}

fn axis(joint: &Joint) -> OdriveAxis {
    OdriveAxis {
        // The caller has checked the node, so the fallback is never taken.
        node: AxisNode::new(joint.node.raw()).unwrap_or(AxisNode::FIRST),
        // The axis counts turns of its motor, on which the encoder is.
        counts_per_turn: of_motor(joint),
        rated_torque: joint.torque_scale.rated_torque,
        product: joint.drive.identity.product,
        readings: joint.drive.readings.map(|reading| reading.map(|reading| reading.limits)),
    }
}

/// Counts of a revolution of the motor. A checked robot file says them in whole numbers; the joint's are those without a gear.
fn of_motor(joint: &Joint) -> CountsPerRevolution {
    let of_joint = joint.encoder.counts_per_revolution;
    let counts = of_joint.of_motor(joint.torque_scale.transmission.ratio());
    counts.and_then(|counts| CountsPerRevolution::new(counts).ok()).unwrap_or(of_joint)
}
