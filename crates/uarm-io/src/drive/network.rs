//! The CANopen master of the robot's drives.
//!
//! [`DriveNetwork::start`] and [`DriveNetwork::stop`] block, with timeouts. In the cycle there are only
//! [`DriveNetwork::sync`], [`DriveNetwork::collect`], [`DriveNetwork::send_torques`] and
//! [`DriveNetwork::housekeeping`]: they read no clock, allocate nothing, and wait nowhere but in `collect`, for its
//! deadline.

mod blocking;
mod configuration;
mod cycle;
mod error;
mod health;
mod receive;
mod start;
mod stop;

pub use configuration::{
    ConfigurationError, DriveConfiguration, EmergencyReaction, Heartbeats, MAX_SETTINGS, NetworkConfiguration,
    ReadBack, Setting, Settings, SyncPayload, Timeouts,
};
pub use cycle::Feedback;
pub use error::{CycleError, Emergency, Expected, NodeSet, SdoError, StartError};
pub use health::{NetworkHealth, NodeHealth};
pub use start::{DriveIdentity, Started};
pub use stop::{Confirmation, DriveStop, StopReport};

use super::cia402::Controlword;
use super::wire::{self, DriveCommand, DriveFeedback, EmergencyMessage, SyncCounter};
use crate::frame::Frame;
use crate::link::Link;
use crate::time::{Clock, Instant};
use blocking::Blocking;
use canopen_rs::NodeId;

/// The master of `JOINTS` drives on the link `L`.
#[derive(Debug)]
pub struct DriveNetwork<L: Link, const JOINTS: usize> {
    link: L,
    configuration: NetworkConfiguration<JOINTS>,
    nodes: [Node; JOINTS],
    sync_counter: Option<SyncCounter>,
    sync_at: Instant,
    next_heartbeat: Instant,
    traffic: Traffic,
}

/// One drive as the master sees it.
#[derive(Clone, Copy, Debug)]
struct Node {
    id: NodeId,
    /// Its answer to the last SYNC.
    fresh: Option<DriveFeedback>,
    /// The deadline for that answer has passed without it.
    missed: bool,
    /// An emergency that was not reported yet.
    alarm: Option<EmergencyMessage>,
    /// The last controlword sent.
    controlword: Controlword,
    health: NodeHealth,
}

/// Frames counted for the whole network.
#[derive(Clone, Copy, Debug, Default)]
struct Traffic {
    received: u64,
    sent: u64,
    syncs: u64,
    unexpected: u64,
}

impl<L: Link, const JOINTS: usize> DriveNetwork<L, JOINTS> {
    /// A master that has sent nothing yet.
    pub fn new(link: L, configuration: NetworkConfiguration<JOINTS>) -> Self {
        let nodes = configuration.drives().each_ref().map(|drive| Node {
            id: drive.node,
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
        }
    }

    /// Its configuration.
    pub const fn configuration(&self) -> &NetworkConfiguration<JOINTS> {
        &self.configuration
    }

    /// The link.
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

    /// Resets, configures and enables all drives; blocks.
    ///
    /// NMT reset communication and boot-up; per drive: device type, the settings of its configuration, those of the
    /// protocol, each read back, then 608Fh and 6076h compared; NMT start; CiA 402 to *Switched on*, and when all are
    /// there, to *Operation enabled*, where brakes open; mode of operation 6061h. All torques are zero, and no SYNC is
    /// sent: the first belongs to the loop. From here on the caller owes a [`DriveNetwork::housekeeping`] at least once
    /// per master heartbeat.
    ///
    /// # Errors
    /// [`StartError`]; call [`DriveNetwork::stop`] then, since some drives may be enabled.
    pub fn start<C: Clock>(&mut self, clock: &C) -> Result<Started<JOINTS>, StartError<L::Error>> {
        self.sync_counter = new_counter(&self.configuration);
        Blocking::new(self, clock).start()
    }

    /// Stops all drives as well as it can be done: torque 0, quick stop, power off and brakes, NMT stop; blocks.
    ///
    /// Never fails: what a drive did not confirm is told in the report.
    pub fn stop<C: Clock>(&mut self, clock: &C) -> StopReport<JOINTS> {
        Blocking::new(self, clock).stop()
    }

    fn send(&mut self, frame: &Frame) -> Result<Instant, L::Error> {
        let at = self.link.send(frame)?;
        self.traffic.sent += 1;
        Ok(at)
    }

    /// Sends a command to the drive of `id`.
    fn command(&mut self, id: NodeId, command: &DriveCommand) -> Result<Instant, L::Error> {
        let at = self.send(&command.frame(id))?;
        if let Some(node) = self.node_mut(id) {
            node.health.commands += 1;
            node.controlword = command.controlword;
        }
        Ok(at)
    }

    fn node_mut(&mut self, id: NodeId) -> Option<&mut Node> {
        self.nodes.iter_mut().find(|node| node.id == id)
    }

    /// Sends the master's heartbeat if it is due.
    fn produce_heartbeat(&mut self, now: Instant) -> Result<(), L::Error> {
        if now >= self.next_heartbeat {
            self.next_heartbeat = now + self.configuration.heartbeats.master_period();
            self.send(&wire::master_heartbeat_frame())?;
        }
        Ok(())
    }
}

/// A counter that starts again at 1; `None`, like an overflow of 0, stands for SYNCs without one.
fn new_counter<const JOINTS: usize>(configuration: &NetworkConfiguration<JOINTS>) -> Option<SyncCounter> {
    SyncCounter::new(configuration.sync_payload.overflow()).ok()
}

#[cfg(test)]
mod tests;
