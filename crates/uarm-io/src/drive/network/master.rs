//! The master: what it holds, and the sending that all its parts share.

use super::configuration::NetworkConfiguration;
use super::disturbance::Disturbance;
use super::health::{NetworkHealth, NodeHealth};
use crate::drive::cia402::Controlword;
use crate::drive::wire::{self, DriveCommand, DriveFeedback, EmergencyMessage, SyncCounter};
use crate::frame::Frame;
use crate::link::Link;
use crate::time::Instant;
use canopen_rs::NodeId;

/// The master of `JOINTS` drives on the link `L`.
#[derive(Debug)]
pub struct DriveNetwork<L: Link, const JOINTS: usize> {
    pub(super) link: L,
    pub(super) configuration: NetworkConfiguration<JOINTS>,
    pub(super) nodes: [Node; JOINTS],
    pub(super) sync_counter: Option<SyncCounter>,
    pub(super) sync_at: Instant,
    pub(super) next_heartbeat: Instant,
    pub(super) traffic: Traffic,
    /// The first since the last start.
    pub(super) disturbance: Option<Disturbance>,
}

/// One drive as the master sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub(super) id: NodeId,
    pub(super) stage: Stage,
    /// Its feedback for the last SYNC.
    pub(super) fresh: Option<DriveFeedback>,
    /// The deadline for that feedback has passed without it.
    pub(super) missed: bool,
    /// An emergency that was not reported yet.
    pub(super) alarm: Option<EmergencyMessage>,
    /// The last controlword sent.
    pub(super) controlword: Controlword,
    pub(super) health: NodeHealth,
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
        let nodes = configuration.drives().each_ref().map(|drive| Node {
            id: drive.node,
            stage: Stage::Unknown,
            fresh: None,
            missed: false,
            alarm: None,
            controlword: Controlword::default(),
            health: NodeHealth { node: drive.node.raw(), ..NodeHealth::default() },
        });
        Self {
            link,
            sync_counter: new_counter(&configuration),
            configuration,
            nodes,
            sync_at: Instant::default(),
            next_heartbeat: Instant::default(),
            traffic: Traffic::default(),
            disturbance: None,
        }
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
        let at = self.send(&command.frame(id))?;
        if let Some(node) = self.node_mut(id) {
            node.health.commands += 1;
            node.controlword = command.controlword;
        }
        Ok(at)
    }

    pub(super) fn node_mut(&mut self, id: NodeId) -> Option<&mut Node> {
        self.nodes.iter_mut().find(|node| node.id == id)
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

/// A counter that starts again at 1; `None`, like an overflow of 0, stands for SYNCs without one.
pub(super) fn new_counter<const JOINTS: usize>(configuration: &NetworkConfiguration<JOINTS>) -> Option<SyncCounter> {
    SyncCounter::new(configuration.sync_payload.overflow()).ok()
}
