//! The master: what it holds, and the sending that all its parts share.

use super::configuration::NetworkConfiguration;
use super::disturbance::Disturbance;
use super::health::{NetworkHealth, NodeHealth};
use crate::drive::cia402::Controlword;
use crate::drive::identity::DriveIdentity;
use crate::drive::plan::Findings;
use crate::drive::readings::{Quantity, Reading};
use crate::drive::survey::Survey;
use crate::drive::wire::{self, Channel, DriveCommand, DriveFeedback, EmergencyMessage, SyncCounter};
use crate::drive::wishes::{DriveConfiguration, Watchdog};
use crate::frame::Frame;
use crate::link::Link;
use crate::time::Instant;
use canopen_rs::NodeId;
use core::time::Duration;
use embedded_can::StandardId;

/// The master of `JOINTS` drives on the link `L`.
#[derive(Debug)]
pub struct DriveNetwork<L: Link, const JOINTS: usize> {
    pub(super) link: L,
    pub(super) configuration: NetworkConfiguration<JOINTS>,
    pub(super) nodes: [Node; JOINTS],
    /// `None` for a SYNC without counter.
    pub(super) sync_counter: Option<SyncCounter>,
    pub(super) sync_at: Instant,
    /// What comes after it does not belong to the last SYNC.
    pub(super) deadline: Instant,
    pub(super) next_heartbeat: Instant,
    pub(super) traffic: Traffic,
    /// Is told what was learned of each drive, before any has power.
    pub(super) learned: Learned,
    /// The first since the last start.
    pub(super) disturbance: Option<Disturbance>,
    pub(super) claim: BusClaim,
    pub(super) inquiry: Inquiry,
}

/// Before feedback is waited for, none of it is late.
pub(super) const NO_DEADLINE: Instant = Instant::from_nanoseconds(u64::MAX);

/// One drive as the master sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub(super) id: NodeId,
    pub(super) stage: Stage,
    /// The identifier of its commands.
    pub(super) command_identifier: StandardId,
    /// The identifier of its feedback.
    pub(super) feedback_identifier: StandardId,
    /// The identifier of its torque feedback, where it sends one.
    pub(super) torque_identifier: Option<StandardId>,
    /// How often it must get a command, where it watches that.
    pub(super) command_period: Option<Duration>,
    /// When the last command was sent; `None` while it gets none.
    pub(super) commanded_at: Option<Instant>,
    /// What makes it brake by itself, as far as it was read back.
    pub(super) last_defence: LastDefence,
    /// How many SYNCs of this run it may still answer; `None` before the first.
    pub(super) owed: Option<u8>,
    /// How many SDO requests it may still answer.
    pub(super) sdo_owed: u8,
    /// How many of its SDO answers were given up in this start.
    pub(super) sdo_late: u8,
    /// What it said of itself when it was set up.
    pub(super) identity: DriveIdentity,
    /// Its feedback for the last SYNC.
    pub(super) fresh: Option<DriveFeedback>,
    /// It has said in this run that it follows its target torque.
    pub(super) has_followed: bool,
    /// Its torque actual value came after the last SYNC.
    pub(super) torque_is_fresh: bool,
    /// The deadline for that feedback has passed without it.
    pub(super) missed: bool,
    /// Its feedback for the SYNC before may still come.
    pub(super) late: bool,
    /// Requests for readings in a row that it has not answered.
    pub(super) unanswered: u8,
    /// An emergency that was not reported yet.
    pub(super) alarm: Option<EmergencyMessage>,
    /// The last controlword sent.
    pub(super) controlword: Controlword,
    pub(super) health: NodeHealth,
}

/// The state of asking for readings.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Inquiry {
    pub(super) next_at: Instant,
    /// Which one of all that may be asked for is next.
    pub(super) next: usize,
    pub(super) open: Option<Request>,
}

/// A request for a reading that is not answered yet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Request {
    pub(super) node: NodeId,
    pub(super) quantity: Quantity,
    pub(super) reading: Reading,
    pub(super) at: Instant,
}

/// Whose bus it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BusClaim {
    /// Nobody else was heard before the start.
    Free,
    /// Another master was: nothing is sent, not even a stop.
    AnotherMasters,
}

/// How far a start has come with a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    /// No boot-up message came since the reset, or there was no reset yet.
    Unknown,
    /// It has booted and waits for its settings.
    Booted,
    /// The first SDO request was sent to it: from here on a boot-up message means that settings are lost.
    Addressed,
}

/// Is told of a drive's node, its survey and its findings.
pub type Learned = fn(u8, &Survey, &Findings);

/// What makes a drive brake by itself when its master is gone, read back from the drive since it last booted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LastDefence {
    /// Nothing that was read back.
    #[default]
    None,
    /// The master's heartbeat: 1016h, and 6007h or what the robot file says in its place.
    Heartbeat,
    /// The timeout of its commands: 1400h:05, or an ODrive axis's watchdog that was seen to act.
    RpdoTimeout,
}

/// A drive that watches its commands gets one so many times within its timeout while the master waits.
const COMMANDS_PER_TIMEOUT: u32 = 3;

impl Node {
    fn new(drive: &DriveConfiguration) -> Self {
        let command_period = match drive.watchdog {
            Watchdog::Heartbeat => None,
            Watchdog::RpdoTimeout { milliseconds, .. } => {
                Some(Duration::from_millis(milliseconds.into()) / COMMANDS_PER_TIMEOUT)
            }
        };
        Self {
            id: drive.node,
            stage: Stage::Unknown,
            command_identifier: drive.pdos.command.identifier,
            feedback_identifier: drive.pdos.feedback.identifier,
            torque_identifier: drive.pdos.torque_feedback.map(|pdo| pdo.identifier),
            command_period,
            commanded_at: None,
            last_defence: LastDefence::None,
            owed: None,
            sdo_owed: 0,
            sdo_late: 0,
            identity: DriveIdentity::default(),
            fresh: None,
            has_followed: false,
            torque_is_fresh: false,
            missed: false,
            late: false,
            unanswered: 0,
            alarm: None,
            controlword: Controlword::default(),
            health: NodeHealth { node: drive.node.raw(), ..NodeHealth::default() },
        }
    }
}

/// Frames counted for the whole network.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Traffic {
    pub(super) received: u64,
    pub(super) sent: u64,
    pub(super) syncs: u64,
    pub(super) unexpected: u64,
}

impl<L: Link, const JOINTS: usize> DriveNetwork<L, JOINTS> {
    /// A master that has sent nothing yet.
    pub fn new(link: L, configuration: NetworkConfiguration<JOINTS>) -> Self {
        let nodes = configuration.drives().each_ref().map(Node::new);
        Self {
            link,
            sync_counter: SyncCounter::new(configuration.sync_counter.payload(true).overflow()).ok(),
            configuration,
            nodes,
            sync_at: Instant::default(),
            deadline: NO_DEADLINE,
            next_heartbeat: Instant::default(),
            traffic: Traffic::default(),
            learned: |_, _, _| {},
            disturbance: None,
            claim: BusClaim::Free,
            inquiry: Inquiry::default(),
        }
    }

    /// Lets `learned` be told, at each start, what was learned of each drive: node, survey and findings. It is called after
    /// the drive was set up, and before any drive has power.
    pub const fn on_learned(&mut self, learned: Learned) {
        self.learned = learned;
    }

    /// The configuration that it was built with.
    pub const fn configuration(&self) -> &NetworkConfiguration<JOINTS> {
        &self.configuration
    }

    /// The link to the bus.
    pub const fn link(&self) -> &L {
        &self.link
    }

    /// The link, to change its settings; frames taken from it here are lost to the master.
    pub const fn link_mut(&mut self) -> &mut L {
        &mut self.link
    }

    /// Gives the link back.
    pub fn into_link(self) -> L {
        self.link
    }

    /// What the drives said of themselves when they were set up.
    pub fn identities(&self) -> [DriveIdentity; JOINTS] {
        self.nodes.map(|node| node.identity)
    }

    /// What was seen of the drives so far.
    pub fn health(&self) -> NetworkHealth<JOINTS> {
        NetworkHealth {
            nodes: self.nodes.map(|node| node.health),
            frames_received: self.traffic.received,
            frames_sent: self.traffic.sent,
            syncs: self.traffic.syncs,
            unexpected_frames: self.traffic.unexpected,
        }
    }

    pub(super) fn send(&mut self, frame: &Frame) -> Result<Instant, L::Error> {
        let at = self.link.send(frame)?;
        self.traffic.sent += 1;
        Ok(at)
    }

    /// Sends a command to the drive of `id`.
    pub(super) fn command(&mut self, id: NodeId, command: &DriveCommand) -> Result<Instant, L::Error> {
        let predefined = Channel::Rpdo1(id).identifier();
        let identifier = self.node_mut(id).map_or(predefined, |node| node.command_identifier);
        let at = self.send(&Frame::with(identifier, command.encode()))?;
        if let Some(node) = self.node_mut(id) {
            node.health.commands += 1;
            node.controlword = command.controlword;
            node.commanded_at = Some(at);
        }
        Ok(at)
    }

    /// When a drive that watches its commands is due for the next.
    pub(super) fn next_command(&self) -> Instant {
        let due = |node: &Node| Some(node.commanded_at? + node.command_period?);
        self.nodes.iter().filter_map(due).min().unwrap_or(Instant::from_nanoseconds(u64::MAX))
    }

    /// Repeats the last command, with no torque, to each drive that watches its commands and is due for one.
    pub(super) fn repeat_commands(&mut self, now: Instant) -> Result<(), L::Error> {
        for position in 0..JOINTS {
            let Some(node) = self.nodes.get(position).copied() else { break };
            let due = node.command_period.zip(node.commanded_at).is_some_and(|(period, at)| now >= at + period);
            if due {
                self.command(node.id, &DriveCommand { controlword: node.controlword, target_torque: 0 })?;
            }
        }
        Ok(())
    }

    pub(super) fn node_mut(&mut self, id: NodeId) -> Option<&mut Node> {
        self.nodes.iter_mut().find(|node| node.id == id)
    }

    /// Takes note of something that must not happen; what came first is kept.
    pub(super) fn disturb(&mut self, disturbance: Disturbance) {
        self.disturbance.get_or_insert(disturbance);
    }

    /// An error if something happened that must not.
    pub(super) fn undisturbed(&self) -> Result<(), Disturbance> {
        self.disturbance.map_or(Ok(()), Err)
    }

    /// Sends the master's heartbeat if it is due.
    pub(super) fn produce_heartbeat(&mut self, now: Instant) -> Result<(), L::Error> {
        if now >= self.next_heartbeat {
            self.next_heartbeat = now + self.configuration.heartbeats.master_period();
            self.send(&wire::master_heartbeat_frame())?;
        }
        Ok(())
    }
}
