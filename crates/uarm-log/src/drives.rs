//! Which drives moved the robot, as they said themselves: the metadata record `uarm.drives`.
//!
//! Its fields are `joint_1_node`, `joint_1_vendor`, `joint_1_product`, `joint_1_revision`, `joint_1_serial` and so on, decimal.
//! What a drive does not say has no field. The record is written once the drives are set up, before any has power.

use serde::Serialize;
use uarm_loop::uarm_io::drive::DriveIdentity;

use crate::description::Fields;

/// Name of the metadata record that tells which drives moved the robot.
pub const DRIVES: &str = "uarm.drives";

/// A drive as a log tells it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct LoggedDrive {
    /// Its joint, counted from 1.
    pub joint: usize,
    /// Its node id.
    pub node: u8,
    /// Its vendor, if it said so; as all below.
    pub vendor: Option<u32>,
    /// Its product code.
    pub product: Option<u32>,
    /// Its revision.
    pub revision: Option<u32>,
    /// Its serial number.
    pub serial: Option<u32>,
}

impl LoggedDrive {
    /// What the drive said of itself.
    pub const fn identity(&self) -> DriveIdentity {
        let Self { vendor, product, revision, serial, .. } = *self;
        DriveIdentity { vendor, product, revision, serial }
    }
}

/// The record [`DRIVES`] of drives with these `nodes`, joint 1 first.
pub fn fields<const J: usize>(nodes: [u8; J], identities: &[DriveIdentity; J]) -> Fields {
    let mut fields = Fields::new();
    for ((node, identity), joint) in nodes.into_iter().zip(identities).zip(1..) {
        let DriveIdentity { vendor, product, revision, serial } = *identity;
        let said = [("vendor", vendor), ("product", product), ("revision", revision), ("serial", serial)];
        let node = [("node", Some(node.into()))];
        for (name, number) in node.into_iter().chain(said) {
            fields.extend(number.map(|number: u32| (format!("joint_{joint}_{name}"), number.to_string())));
        }
    }
    fields
}

/// The drives of a record [`DRIVES`], joint 1 first, up to the first joint without a node id.
pub fn drives(fields: &Fields) -> Vec<LoggedDrive> {
    let drive = |joint: usize| {
        let number = |name: &str| fields.get(&format!("joint_{joint}_{name}"))?.parse::<u32>().ok();
        Some(LoggedDrive {
            joint,
            node: u8::try_from(number("node")?).ok()?,
            vendor: number("vendor"),
            product: number("product"),
            revision: number("revision"),
            serial: number("serial"),
        })
    };
    (1..).map_while(drive).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_drives_said_comes_back_and_what_they_did_not_say_has_no_field() {
        let said = DriveIdentity { vendor: Some(0x9A), product: Some(1), revision: Some(u32::MAX), serial: Some(1001) };
        let vendor = DriveIdentity { vendor: Some(7), ..DriveIdentity::default() };
        let identities = [said, vendor, DriveIdentity::default()];
        let fields = fields([1, 12, 3], &identities);
        assert_eq!(fields.get("joint_1_vendor").map(String::as_str), Some("154"));
        assert_eq!(fields.len(), 3 + 4 + 1, "nodes, four numbers, one number");
        let drives = drives(&fields);
        assert_eq!(drives.iter().map(|drive| (drive.joint, drive.node)).collect::<Vec<_>>(), [(1, 1), (2, 12), (3, 3)]);
        assert_eq!(drives.iter().map(LoggedDrive::identity).collect::<Vec<_>>(), identities);
    }
}
