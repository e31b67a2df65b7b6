//! The file of references: beside the robot file, as TOML. It is written beside its place and renamed, so that it is whole or
//! not there.

use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use anyhow::Context;
use serde::{Deserialize, Serialize};
use uarm_io::encoder::Direction;

use crate::robot::file::ObjectWrite;
use crate::text_file;

/// The version of the format.
const SCHEMA: u32 = 1;

/// The references of a robot's incremental joints.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct References {
    /// The version of the format.
    schema: u32,
    /// One for each joint that was referenced.
    pub joints: Vec<JointReference>,
}

/// Where a joint was, and by what it is seen whether that still tells its angle.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct JointReference {
    /// The joint's name, for people.
    pub name: String,
    /// The node id of its drive.
    pub node: u8,
    /// When it was set, RFC 3339.
    pub date: String,
    /// The angle that was confirmed, degrees.
    pub angle_deg: f64,
    /// 6064h there.
    pub position_counts: i32,
    /// The method by which the drive itself found it, 6098h; absent for a pose.
    pub homing_method: Option<i8>,
    /// 6064h at angle zero, which follows from them.
    pub zero_counts: i32,
    /// The robot file's counts per revolution, from which it follows.
    pub counts_per_revolution: u32,
    /// The robot file's gear ratio, from which it follows.
    pub gear_ratio: Option<[u32; 2]>,
    /// The robot file's direction, from which it follows.
    pub direction: Direction,
    /// The angles between which a reading is believed, degrees.
    pub window_deg: [f64; 2],
    /// 1018h:01, if the drive has one.
    pub vendor: Option<u32>,
    /// 1018h:02, if the drive has one.
    pub product: Option<u32>,
    /// 1018h:04, if the drive has one.
    pub serial: Option<u32>,
    /// What was written into the drive to see the loss of its power.
    pub power_marker: Option<ObjectWrite>,
}

impl JointReference {
    /// By what it was found, in words to be appended; nothing for a pose.
    pub fn how(&self) -> String {
        self.homing_method.map_or_else(String::new, |method| format!(" by homing method {method}"))
    }
}

impl References {
    /// These references.
    pub const fn new(joints: Vec<JointReference>) -> Self {
        Self { schema: SCHEMA, joints }
    }

    /// These references with `joint` in the place of what they say of its node.
    #[must_use]
    pub fn with(mut self, joint: JointReference) -> Self {
        self.joints.retain(|other| other.node != joint.node);
        self.joints.push(joint);
        self
    }

    /// Where the references of the robot file `robot` are: `my-robot.toml` has `my-robot.reference.toml`.
    pub fn path(robot: &Path) -> PathBuf {
        robot.with_extension("reference.toml")
    }

    /// The references beside the robot file `robot`; `None` if there are none.
    ///
    /// # Errors
    /// If the file cannot be read or is not one of references.
    pub fn read_beside(robot: &Path) -> anyhow::Result<Option<Self>> {
        let path = Self::path(robot);
        let text = match text_file::read(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(error).with_context(|| path.display().to_string()),
        };
        let references: Self = toml::from_str(&text).with_context(|| path.display().to_string())?;
        anyhow::ensure!(
            references.schema == SCHEMA,
            "{}: schema = {}: expected {SCHEMA}",
            path.display(),
            references.schema
        );
        Ok(Some(references))
    }

    /// Writes them beside the robot file `robot`; returns where.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_beside(&self, robot: &Path) -> anyhow::Result<PathBuf> {
        let path = Self::path(robot);
        let beside = path.with_extension("toml.new");
        let text = toml::to_string(self)?;
        let written = fs::File::create(&beside).and_then(|mut file| {
            file.write_all(text.as_bytes())?;
            file.sync_all()
        });
        written.and_then(|()| fs::rename(&beside, &path)).with_context(|| path.display().to_string())?;
        Ok(path)
    }

    /// The reference of the drive with this node id.
    pub fn of_node(&self, node: u8) -> Option<&JointReference> {
        self.joints.iter().find(|joint| joint.node == node)
    }
}
