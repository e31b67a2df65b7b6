//! What the drives speak: checked.

use uarm_io::drive::odrive::Positions;
use uarm_io::drive::odrive::wire::AxisNode;
use uarm_io::time::Duration;
use uarm_loop::robot::Protocol;

use super::error::{Checker, RobotError};
use super::file;

pub(super) fn check(bus: &file::Bus, joints: &[file::Joint], check: &Checker<'_>) -> Result<Protocol, RobotError> {
    if bus.protocol == file::Protocol::Canopen {
        return match bus.odrive {
            None => Ok(Protocol::Canopen),
            Some(_) => Err(check.refuse("bus.odrive", "a table", "none, unless bus.protocol = \"odrive\"")),
        };
    }
    for (index, joint) in joints.iter().enumerate() {
        if AxisNode::new(joint.node).is_none() {
            let range = AxisNode::RANGE;
            let expected = format!("a node id of an ODrive axis, {} to {}", range.start(), range.end());
            return Err(check.refuse(format!("joints[{index}].node"), joint.node, expected));
        }
        for (name, number) in [("vendor", joint.drive.identity.vendor), ("serial", joint.drive.identity.serial)] {
            if let Some(number) = number {
                let field = format!("joints[{index}].drive.identity.{name}");
                return Err(check.refuse(
                    field,
                    number,
                    "absent: Get_Version of an ODrive axis tells its product only",
                ));
            }
        }
        if !joint.drive.writes.is_empty() {
            let field = format!("joints[{index}].drive.writes");
            let expected = "none: ODrive axes have no CANopen objects";
            return Err(check.refuse(field, format!("{} objects", joint.drive.writes.len()), expected));
        }
    }
    Ok(Protocol::Odrive(match bus.odrive.map_or(0, |odrive| odrive.encoder_msg_rate_ms) {
        0 => Positions::OnRequest,
        milliseconds => Positions::Cyclic { every: Duration::from_millis(milliseconds.into()) },
    }))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::robot::overrides::Overrides;
    use crate::robot::{BUILT_IN, Robot};

    const ODRIVE: &str = include_str!("../../robots/uarm-odrive.toml");

    fn protocol(text: &str, from: &str, to: &str) -> Result<Protocol, String> {
        assert!(text.contains(from), "{from}");
        let text = text.replacen(from, to, 1);
        let robot = Robot::parse(Path::new("test.toml"), &text, &Overrides::default());
        robot.map(|robot| robot.description.bus.protocol).map_err(|error| error.to_string())
    }

    #[test]
    fn canopen_is_the_default_and_odrive_asks_for_positions_unless_they_come_by_themselves() {
        assert_eq!(protocol(BUILT_IN, "", ""), Ok(Protocol::Canopen));
        assert_eq!(protocol(BUILT_IN, "[bus]", "[bus]\nprotocol = \"canopen\""), Ok(Protocol::Canopen));
        assert_eq!(protocol(ODRIVE, "", ""), Ok(Protocol::Odrive(Positions::OnRequest)));
        let every = Duration::from_millis(2);
        let cyclic = protocol(ODRIVE, "encoder_msg_rate_ms = 0", "encoder_msg_rate_ms = 2");
        assert_eq!(cyclic, Ok(Protocol::Odrive(Positions::Cyclic { every })));
    }

    #[test]
    fn what_an_odrive_axis_does_not_have_is_refused() {
        let refused = |from, to| protocol(ODRIVE, from, to).unwrap_err();
        let message = refused("node = 3", "node = 63");
        assert!(message.contains("joints[2].node = 63") && message.contains("1 to 62"), "{message}");
        let message = refused("writes = []", "writes = [{ index = 0x6007, subindex = 0, type = \"i16\", value = 1 }]");
        assert!(message.contains("joints[0].drive.writes = 1 objects"), "{message}");
        let message = refused("protocol = \"odrive\"", "protocol = \"moteus\"");
        assert!(message.contains("moteus") && message.contains("canopen"), "{message}");
        let message = refused("protocol = \"odrive\"", "protocol = \"canopen\"");
        assert!(message.contains("bus.odrive"), "{message}");
        let message = refused("bitrate_hz = 1000000", "bitrate_hz = 250000");
        assert!(message.contains("bus time"), "the budget is that of the protocol's frames: {message}");
    }

    /// Hardware is all that an axis tells.
    #[test]
    fn an_odrive_axis_is_pinned_by_its_product() {
        let pinned = |identity| {
            protocol(ODRIVE, "\ndrive = { ", &format!("\ndrive = {{ identity = {{ {identity} }}, ")).map(drop)
        };
        assert_eq!(pinned("product = 0x0004043A"), Ok(()));
        for (identity, field) in [("vendor = 1", "identity.vendor = 1"), ("serial = 7", "identity.serial = 7")] {
            let message = pinned(identity).unwrap_err();
            assert!(message.contains(&format!("joints[0].drive.{field}: expected absent")), "{message}");
        }
    }

    /// Logs written before there was a choice and those of CANopen robots have the same text.
    #[test]
    fn the_default_is_not_written_into_logs() {
        let logged = |text| {
            let robot = Robot::parse(Path::new("test.toml"), text, &Overrides::default()).unwrap();
            robot.for_log().unwrap().toml
        };
        assert!(!logged(BUILT_IN).contains("protocol"));
        assert!(logged(ODRIVE).contains("protocol = \"odrive\""));
    }
}
