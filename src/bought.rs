//! The drives of a robot that are bought: their makers' dictionaries, and their past.

use std::convert::Infallible;
use std::path::PathBuf;

use uarm_eds::Dictionary;
use uarm_io::drive::network::StartError;
use uarm_io::drive::plan::survey_of;
use uarm_io::drive::words::Named;
use uarm_io::drive::{Address, NodeId};
use uarm_loop::robot::{Joint, Protocol};
use uarm_sim::PowerUp;
use uarm_sim::drive::CounterAtPowerUp;

use crate::eds::{self, DictionaryObjects};
use crate::options::node_id;
use crate::robot::Robot;
use crate::usage::UsageError;

/// Which drives of a simulated robot have a maker's dictionary.
#[derive(Debug, clap::Args)]
pub struct DictionaryArguments {
    /// A maker's dictionary (EDS or DCF): the drive of the --node that follows has its objects
    #[arg(long, value_name = "FILE")]
    pub eds: Vec<PathBuf>,
    /// The drive that has the dictionary of --eds; may be left out for a DCF that names its node
    #[arg(long, value_parser = node_id, value_name = "1..126", requires = "eds")]
    pub node: Vec<NodeId>,
}

/// An object that a drive has at power-up with another value than its dictionary says, since somebody stored it there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StoredObject {
    /// Where it is.
    pub address: Address,
    /// Its value, of whatever type the object is.
    pub number: i64,
}

/// What a drive was before this power-up.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Past {
    /// How it starts.
    pub power_up: PowerUp,
    /// What it has stored.
    pub stored: Vec<StoredObject>,
}

/// A drive that somebody else made.
#[derive(Clone, Copy, Debug)]
pub struct BoughtDrive<'a> {
    /// Its maker's dictionary; without it the emulation's own.
    pub dictionary: Option<&'a Dictionary>,
    /// Its past.
    pub past: &'a Past,
}

/// What is known of each joint's drive.
#[derive(Debug)]
pub struct Bought<const J: usize = 3> {
    dictionaries: [Option<Dictionary>; J],
    pasts: [Past; J],
}

impl<const J: usize> Default for Bought<J> {
    fn default() -> Self {
        Self { dictionaries: [const { None }; J], pasts: std::array::from_fn(|_| Past::default()) }
    }
}

impl<const J: usize> Bought<J> {
    /// Reads the dictionaries; the first is for the first node, and so on. Those without a node are DCF files that name it.
    ///
    /// # Errors
    /// If a file cannot be read, or a node is none of the robot's.
    pub fn read(arguments: &DictionaryArguments, robot: &[u8; J]) -> anyhow::Result<Self> {
        let DictionaryArguments { eds: files, node: nodes } = arguments;
        if nodes.len() > files.len() {
            return Err(usage(format!("--node {} times, expected as many as --eds, {}", nodes.len(), files.len())));
        }
        let mut bought = Self::default();
        for (position, file) in files.iter().enumerate() {
            let dictionary = eds::read(file)?;
            let node = nodes.get(position).map(|node| node.raw()).or(dictionary.node());
            let node = node.ok_or_else(|| usage(format!("--eds {}: expected --node with it", file.display())))?;
            let place = &mut bought.dictionaries[joint("--node", node, robot)?];
            if place.replace(dictionary).is_some() {
                return Err(usage(format!(
                    "--eds {}: a second dictionary for node {node}, expected one",
                    file.display()
                )));
            }
        }
        Ok(bought)
    }

    /// The same, where drives have a past.
    ///
    /// # Errors
    /// If a node is none of the robot's.
    pub fn starting(
        mut self,
        pasts: impl IntoIterator<Item = (NodeId, Past)>,
        robot: &[u8; J],
    ) -> anyhow::Result<Self> {
        for (node, past) in pasts {
            self.pasts[joint("--start", node.raw(), robot)?] = past;
        }
        Ok(self)
    }

    /// The same, where the drives of some joints, by index, count from zero after each power-up.
    #[must_use]
    pub fn counting_from_zero(mut self, joints: &[usize]) -> Self {
        for (index, past) in self.pasts.iter_mut().enumerate() {
            if joints.contains(&index) {
                past.power_up.counter = CounterAtPowerUp::Zero;
            }
        }
        self
    }

    /// Why the first drive that has a dictionary could not be started, if one could not: as `uarm drive check` judges it. A
    /// start on the simulated drive sees no types, and not what a drive has at power-up.
    ///
    /// # Errors
    /// If the drives cannot be described to their master.
    pub fn refusal<const N: usize>(&self, robot: &Robot<J, N>) -> anyhow::Result<Option<StartError<Infallible>>> {
        if robot.description.bus.protocol != Protocol::Canopen {
            return Ok(None);
        }
        let network = robot.description.network_configuration()?;
        let refused = self.with_dictionaries(robot).find_map(|(joint, dictionary)| {
            let node = joint.node.raw();
            let Ok(survey) = survey_of(&mut DictionaryObjects::new(dictionary, node), &joint.drive);
            let finding = *network.plan(&survey, &joint.drive).refusal()?;
            Some(StartError::Refused { node, finding })
        });
        Ok(refused)
    }

    /// What `robot` watches and cannot be judged, since a dictionary has the object without a value; a line of text for each.
    pub fn unjudged<const N: usize>(&self, robot: &Robot<J, N>) -> Vec<String> {
        let lines = self.with_dictionaries(robot).flat_map(|(joint, dictionary)| {
            let node = joint.node.raw();
            eds::unstated(dictionary, node, &joint.drive.readings).map(move |(quantity, reading)| {
                format!(
                    "{}: {} of node {node} is not judged: its dictionary has no value for {}",
                    joint.name,
                    quantity.name(),
                    Named(reading.object)
                )
            })
        });
        lines.collect()
    }

    fn with_dictionaries<'a, const N: usize>(
        &'a self,
        robot: &'a Robot<J, N>,
    ) -> impl Iterator<Item = (&'a Joint, &'a Dictionary)> {
        let joints = robot.description.joints.iter().zip(&self.dictionaries);
        joints.filter_map(|(joint, dictionary)| Some((joint, dictionary.as_ref()?)))
    }

    /// True if all drives are the emulation's own, as they are by default.
    pub fn is_none(&self) -> bool {
        self.dictionaries.iter().all(Option::is_none) && self.pasts.iter().all(|past| *past == Past::default())
    }

    /// What is known, joint by joint.
    pub fn drives(&self) -> [BoughtDrive<'_>; J] {
        std::array::from_fn(|joint| BoughtDrive {
            dictionary: self.dictionaries[joint].as_ref(),
            past: &self.pasts[joint],
        })
    }
}

fn usage(message: String) -> anyhow::Error {
    UsageError::new(message).into()
}

fn joint(option: &str, node: u8, robot: &[u8]) -> anyhow::Result<usize> {
    let position = robot.iter().position(|other| *other == node);
    position.ok_or_else(|| UsageError::no_such_node(&format!("{option} {node}"), robot).into())
}
