//! The joint's entry of the robot file, and what a remedy changes in it.

use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::Context;
use toml::{Table, Value};
use uarm_io::drive::network::NetworkConfiguration;
use uarm_io::drive::pdo_objects::PdoKind;
use uarm_io::drive::plan::{Remedy, WriteEntry};
use uarm_io::drive::sdo::Patience;
use uarm_io::drive::wishes::{DriveConfiguration, TorqueApplies};
use uarm_io::drive::{Address, NodeId};

use crate::robot::RobotText;
use crate::robot::file::Role;
use crate::robot::on_bus::JointsOnBus;
use crate::usage::UsageError;

/// A robot file of which one joint is to get the drive.
pub struct Candidate {
    file: PathBuf,
    robot: Table,
    joint: usize,
    /// What was changed beside the joint's entry.
    shared: Vec<String>,
}

impl Candidate {
    /// The joint with that node in a robot file, else in the built-in robot; there, a joint takes any node.
    pub fn new(file: Option<&Path>, node: Option<u8>) -> anyhow::Result<Self> {
        let text = RobotText::read(file)?;
        // Whatever is wrong with it is told as everywhere else.
        let joints = JointsOnBus::of_text(&text)?;
        let nodes = joints.nodes();
        let first_driven = joints.written.iter().position(|joint| joint.role == Role::Active);
        let RobotText { name, text } = text;
        let position = node.and_then(|node| nodes.iter().position(|other| *other == node));
        let mut candidate = Self {
            file: name,
            robot: text.parse().context("robot file")?,
            joint: position.or(first_driven).unwrap_or_default(),
            shared: Vec::new(),
        };
        if let (None, Some(node)) = (position, node) {
            if file.is_some() {
                return Err(UsageError::no_such_node(&format!("--node {node}"), &nodes).into());
            }
            candidate.joint_table()?.insert("node".into(), Value::Integer(node.into()));
        }
        Ok(candidate)
    }

    /// What the master would want of the drive, and how it would be its master.
    pub fn wishes(&self) -> anyhow::Result<(DriveConfiguration, NetworkConfiguration<1>)> {
        let robot = self.parsed()?;
        let joint = robot.joints.get(self.joint).context("the joint")?;
        Ok((joint.drive.clone(), robot.network_configuration_of(joint)?))
    }

    fn parsed(&self) -> anyhow::Result<JointsOnBus> {
        JointsOnBus::of_text(&RobotText { name: self.file.clone(), text: toml::to_string(&self.robot)? })
    }

    /// What is to be said of the joint's drive profile, if it has one.
    ///
    /// # Errors
    /// If the entry has become one that is refused.
    pub fn profile(&self) -> anyhow::Result<Option<String>> {
        let robot = self.parsed()?;
        let joint = robot.joints.get(self.joint).context("the joint")?;
        Ok(robot.profiles.iter().find(|used| used.joint == joint.name).map(ToString::to_string))
    }

    /// The node of the drive.
    ///
    /// # Errors
    /// If the entry has become one that is refused.
    pub fn node(&self) -> anyhow::Result<NodeId> {
        Ok(self.wishes()?.0.node)
    }

    /// How long the drive's answers are waited for.
    ///
    /// # Errors
    /// If the entry has become one that is refused.
    pub fn patience(&self) -> anyhow::Result<Patience> {
        let timeouts = self.wishes()?.1.timeouts;
        Ok(Patience { timeout: timeouts.sdo, attempts: timeouts.sdo_attempts })
    }

    /// The joint's entry.
    pub fn joint(&self) -> Option<&Table> {
        self.robot.get("joints")?.get(self.joint)?.as_table()
    }

    /// Changes the joint's entry as a remedy says. False if the remedy is nothing that an entry can say.
    pub fn apply(&mut self, remedy: &Remedy) -> anyhow::Result<bool> {
        match remedy {
            Remedy::Write(setting) => self.write(&WriteEntry(setting).to_string())?,
            Remedy::CountsPerRevolution(counts) => self.set("encoder", "counts_per_revolution", i64::from(*counts))?,
            Remedy::ResolutionStated => self.set("encoder", "resolution_object", "absent")?,
            Remedy::MicronewtonMetres => self.set("drive", "rated_torque_unit", "uNm")?,
            Remedy::TorqueStated => self.set("drive", "target_torque_of", "stated-torque")?,
            Remedy::RatedTorque(raw) => {
                let (drive, _) = self.wishes()?;
                let newton_metres = drive.rated_torque.unit().in_newton_metres(*raw);
                self.set("drive", "rated_torque_nm", newton_metres)?;
            }
            Remedy::RatedCurrent(milliamperes) => self.set("drive", "rated_current_ma", i64::from(*milliamperes))?,
            Remedy::PdoNumber(PdoKind::Receive, number) => self.pdo("rpdo", i64::from(number.get()))?,
            Remedy::PdoNumber(PdoKind::Transmit, number) => self.pdo("tpdo", i64::from(number.get()))?,
            Remedy::CommandTransmission(transmission) => self.command_transmission(*transmission)?,
            Remedy::KeepPdo(PdoKind::Receive, number) => self.keep("keep_rpdos", number.get())?,
            Remedy::KeepPdo(PdoKind::Transmit, number) => self.keep("keep_tpdos", number.get())?,
            Remedy::RpdoTimeout => {
                // The patience that the drive would have with the master's heartbeat.
                let milliseconds = self.wishes()?.1.heartbeats.master_timeout_milliseconds();
                self.set("drive", "watchdog", "rpdo-timeout")?;
                self.set("drive", "rpdo_timeout_ms", i64::from(milliseconds))?;
            }
            Remedy::DriveHeartbeat(milliseconds) => {
                let milliseconds = i64::from(*milliseconds);
                let timeout = self.shared_number("bus", "drive_timeout_ms").unwrap_or_default();
                let mut keys =
                    vec![("drive_heartbeat_ms", milliseconds), ("drive_timeout_ms", timeout.max(2 * milliseconds))];
                let nmt_timeout = self.wishes()?.1.timeouts.nmt;
                if nmt_timeout <= Duration::from_millis(milliseconds.unsigned_abs()) {
                    keys.push(("nmt_timeout_ms", 2 * milliseconds));
                }
                return self.share("bus", &keys);
            }
            Remedy::Period(microseconds) => return self.share("control", &[("period_us", i64::from(*microseconds))]),
            Remedy::ExplainAbortOption => self.set("drive", "without_6007h", WITHOUT_6007H)?,
            Remedy::None | Remedy::Note(_) | Remedy::Outside(_) | Remedy::RobotFile(_) | Remedy::SyncWithoutCounter => {
                return Ok(false);
            }
        }
        Ok(true)
    }

    fn joint_table(&mut self) -> anyhow::Result<&mut Table> {
        let joint = self.robot.get_mut("joints").and_then(|joints| joints.get_mut(self.joint));
        joint.and_then(Value::as_table_mut).context("the joint's entry")
    }

    fn part(&mut self, part: &str) -> anyhow::Result<&mut Table> {
        let part = self.joint_table()?.entry(part).or_insert_with(|| Value::Table(Table::new()));
        part.as_table_mut().context("a table")
    }

    fn set(&mut self, part: &str, key: &str, value: impl Into<Value>) -> anyhow::Result<()> {
        self.part(part)?.insert(key.to_owned(), value.into());
        Ok(())
    }

    fn shared_number(&self, table: &str, key: &str) -> Option<i64> {
        self.robot.get(table)?.get(key)?.as_integer()
    }

    /// Changes what all joints share. False, and nothing is changed, if the robot file is then refused.
    fn share(&mut self, table: &'static str, keys: &[(&'static str, i64)]) -> anyhow::Result<bool> {
        let before = self.robot.clone();
        for (key, value) in keys {
            let part = self.robot.get_mut(table).and_then(Value::as_table_mut).context("a table")?;
            part.insert((*key).to_owned(), Value::Integer(*value));
        }
        if self.wishes().is_err() {
            self.robot = before;
            return Ok(false);
        }
        let lines = keys.iter().map(|(key, value)| format!("{key} = {value}\n"));
        self.shared.push(format!("[{table}]\n{}", lines.collect::<String>()));
        Ok(true)
    }

    /// What was changed beside the joint's entry, as TOML.
    pub fn shared(&self) -> &[String] {
        &self.shared
    }

    fn pdos(&mut self) -> anyhow::Result<&mut Table> {
        let pdos = self.part("drive")?.entry("pdo").or_insert_with(|| Value::Table(Table::new()));
        pdos.as_table_mut().context("a table")
    }

    fn pdo(&mut self, key: &str, number: i64) -> anyhow::Result<()> {
        self.pdos()?.insert(key.to_owned(), number.into());
        Ok(())
    }

    fn command_transmission(&mut self, transmission: u8) -> anyhow::Result<()> {
        let applies = TorqueApplies::of_transmission_type(transmission).context("a transmission type")?;
        self.set("drive", "torque_applies", Value::try_from(applies)?)?;
        if applies.transmission_type() != transmission {
            return self.pdo("rpdo_transmission", transmission.into());
        }
        if let Some(pdo) = self.part("drive")?.get_mut("pdo").and_then(Value::as_table_mut) {
            pdo.remove("rpdo_transmission");
        }
        Ok(())
    }

    fn keep(&mut self, key: &str, number: u16) -> anyhow::Result<()> {
        let kept = self.pdos()?.entry(key).or_insert_with(|| Value::Array(Vec::new()));
        kept.as_array_mut().context("a list")?.push(Value::Integer(number.into()));
        Ok(())
    }

    /// Takes an object out of `writes`. False if it is not there.
    pub fn leave_out(&mut self, object: Address) -> anyhow::Result<bool> {
        let Some(writes) = self.part("drive")?.get_mut("writes").and_then(Value::as_array_mut) else {
            return Ok(false);
        };
        let before = writes.len();
        let number = |entry: &Value, key: &str| entry.get(key).and_then(Value::as_integer);
        writes.retain(|entry| {
            number(entry, "index") != Some(object.index.into())
                || number(entry, "subindex") != Some(object.subindex.into())
        });
        Ok(writes.len() < before)
    }

    /// Adds an entry of `writes`, in place of one for the same object.
    fn write(&mut self, entry: &str) -> anyhow::Result<()> {
        let mut parsed: Table = format!("write = {entry}").parse()?;
        let write = parsed.remove("write").context("an entry")?;
        let writes = self.part("drive")?.entry("writes").or_insert_with(|| Value::Array(Vec::new()));
        let writes = writes.as_array_mut().context("a list")?;
        let is_same = |other: &Value| ["index", "subindex"].iter().all(|key| other.get(key) == write.get(key));
        writes.retain(|other| !is_same(other));
        writes.push(write);
        Ok(())
    }
}

/// What the operator has to find out and put into words.
const WITHOUT_6007H: &str = "not in its dictionary: try kill -9 with the arm supported, and say here what it does";
