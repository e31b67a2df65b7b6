//! A robot's joints and their bus, whatever its arm is: all that commissioning has to know.

use std::path::Path;
use std::time::Duration;

use uarm_io::drive::NodeId;
use uarm_io::drive::network::NetworkConfiguration;
use uarm_loop::network::NetworkError;
use uarm_loop::robot::{Bus, Joint};

use super::error::{Checker, RobotError};
use super::homing::{self, Homing};
use super::overrides::Overrides;
use super::profile::UsedProfile;
use super::shape::for_shape;
use super::text::BUILT_IN_NAME;
use super::{Robot, RobotText, file};
use crate::usage::UsageError;

/// The joints of a checked robot, from the base outwards, and the bus that their drives are on.
#[derive(Clone, Debug)]
pub struct JointsOnBus {
    /// The joints as written.
    pub written: Vec<file::Joint>,
    /// The same, checked.
    pub joints: Vec<Joint>,
    /// The drive profiles that completed them.
    pub profiles: Vec<UsedProfile>,
    /// The bus.
    pub bus: Bus,
    /// The loop's period.
    pub period: Duration,
}

impl JointsOnBus {
    /// Those of the robot in `file`.
    ///
    /// # Errors
    /// As [`Robot::load`], if the robot has none of the shapes that the program knows.
    pub fn load(file: &Path) -> anyhow::Result<Self> {
        Self::of_text(&RobotText::read(Some(file))?)
    }

    /// Those of a robot file with this text.
    ///
    /// # Errors
    /// As [`JointsOnBus::load`].
    pub fn of_text(text: &RobotText) -> anyhow::Result<Self> {
        for_shape!(text.shape()?, read(text))
    }

    /// Those of `robot`.
    pub fn of<const J: usize, const N: usize>(robot: &Robot<J, N>) -> Self {
        let description = &robot.description;
        Self {
            written: robot.file.joints.clone(),
            joints: description.joints.to_vec(),
            profiles: robot.profiles.clone(),
            bus: description.bus,
            period: description.period.duration(),
        }
    }

    /// The drives' node ids.
    pub fn nodes(&self) -> Vec<u8> {
        self.joints.iter().map(|joint| joint.node.raw()).collect()
    }

    /// The place of the joint with this node id, which `--node` names.
    ///
    /// # Errors
    /// A usage error if no joint has it.
    pub fn joint_of(&self, node: NodeId) -> Result<usize, UsageError> {
        let joint = self.joints.iter().position(|joint| joint.node == node);
        joint.ok_or_else(|| UsageError::no_such_node(&format!("--node {}", node.raw()), &self.nodes()))
    }

    /// How the drive of a joint, counted from 0, finds its home position by itself; `None` if the file does not say.
    ///
    /// # Errors
    /// As [`Robot::load`], if the joint was changed since it was checked.
    pub fn homing(&self, joint: usize) -> Result<Option<Homing>, RobotError> {
        let check = Checker::new(Path::new(BUILT_IN_NAME));
        self.written.get(joint).map_or(Ok(None), |written| homing::check(joint, written, &check))
    }

    /// The master's configuration for the drive of `joint` alone.
    ///
    /// # Errors
    /// [`NetworkError`] if the drive's objects cannot hold what the description says.
    pub fn network_configuration_of(&self, joint: &Joint) -> Result<NetworkConfiguration<1>, NetworkError> {
        self.bus.network_configuration([joint.drive.clone()], self.period)
    }
}

fn read<const J: usize, const N: usize>(text: &RobotText) -> anyhow::Result<JointsOnBus> {
    Ok(JointsOnBus::of(&Robot::<J, N>::of_text(&text.name, &text.text, &Overrides::default())?))
}
