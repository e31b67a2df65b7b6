//! The drives of a robot that are bought: their makers' dictionaries, and their past.

use std::path::PathBuf;

use anyhow::{Context, bail};
use uarm_eds::Dictionary;
use uarm_io::drive::NodeId;
use uarm_sim::PowerUp;
use uarm_sim::drive::CounterAtPowerUp;

use super::power_up::StartOf;
use crate::dimensions::JOINTS;
use crate::eds;
use crate::simulated_robot::BoughtDrive;

/// What is known of each joint's drive.
#[derive(Debug)]
pub struct Bought {
    dictionaries: [Option<Dictionary>; JOINTS],
    starts: [PowerUp; JOINTS],
}

impl Bought {
    /// Reads the dictionaries; the first is for the first of `nodes`, and so on. Those without a node are DCF files that name it.
    ///
    /// # Errors
    /// If a file cannot be read, or a node is none of the robot's.
    pub fn read(files: &[PathBuf], nodes: &[NodeId], starts: &[StartOf], robot: &[u8; JOINTS]) -> anyhow::Result<Self> {
        let joint = |node: u8| {
            let position = robot.iter().position(|other| *other == node);
            position.with_context(|| format!("node {node}: expected one of the robot's, {robot:?}"))
        };
        if nodes.len() > files.len() {
            bail!("--node {} times, expected as many as --eds, {}", nodes.len(), files.len());
        }
        let mut bought = Self { dictionaries: Default::default(), starts: Default::default() };
        for (position, file) in files.iter().enumerate() {
            let dictionary = eds::read(file)?;
            let node = nodes.get(position).map(|node| node.raw()).or(dictionary.node());
            let node = node.with_context(|| format!("--eds {}: expected --node with it", file.display()))?;
            bought.dictionaries[joint(node)?] = Some(dictionary);
        }
        for start in starts {
            bought.starts[joint(start.node.raw())?] = start.power_up;
        }
        Ok(bought)
    }

    /// The same, where the drives of some joints, by index, count from zero after each power-up.
    #[must_use]
    pub fn counting_from_zero(mut self, joints: &[usize]) -> Self {
        for (index, start) in self.starts.iter_mut().enumerate() {
            if joints.contains(&index) {
                start.counter = CounterAtPowerUp::Zero;
            }
        }
        self
    }

    /// True if all drives are the emulation's own, as they are by default.
    pub fn is_none(&self) -> bool {
        self.dictionaries.iter().all(Option::is_none) && self.starts == [PowerUp::default(); JOINTS]
    }

    /// What is known, joint by joint.
    pub fn drives(&self) -> [BoughtDrive<'_>; JOINTS] {
        let mut starts = self.starts.iter();
        self.dictionaries.each_ref().map(|dictionary| BoughtDrive {
            dictionary: dictionary.as_ref(),
            power_up: starts.next().copied().unwrap_or_default(),
        })
    }
}
