//! The one place where frames from the drives are read.

use super::disturbance::Disturbance;
use super::health::arrived;
use super::master::{DriveNetwork, LastDefence, Node, Stage};
use crate::drive::sdo;
use crate::drive::wire::{self, Channel, DriveFeedback, EmergencyMessage};
use crate::link::{Link, Received};
use crate::time::Instant;
use canopen_rs::{NmtState, NodeId};
use core::time::Duration;

/// What a frame said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Event {
    /// A drive's feedback for the last SYNC.
    Feedback,
    /// A drive's heartbeat or boot-up.
    Heartbeat(NodeId, NmtState),
    /// A drive's emergency message.
    Emergency,
    /// A drive's SDO answer.
    Sdo(NodeId, [u8; 8]),
    /// Nothing that could be used; it is counted.
    Nothing,
}

impl<L: Link, const JOINTS: usize> DriveNetwork<L, JOINTS> {
    /// Reads a frame into the health record and says what it was.
    pub(super) fn absorb(&mut self, received: &Received) -> Event {
        self.traffic.received += 1;
        let earliest_feedback = self.sync_at + self.configuration.earliest_feedback;
        let (sync_at, deadline) = (self.sync_at, self.deadline);
        if self.torque_feedback(received) {
            return Event::Nothing;
        }
        let Some((channel, node)) = self.sender(received) else {
            self.traffic.unexpected += 1;
            self.overhear(received);
            return Event::Nothing;
        };
        let id = node.health.node;
        let twins = match channel {
            Channel::Tpdo1(_) if !node.answers() => Some(Disturbance::Twins { node: id }),
            Channel::SdoResponse(_) if !node.answers_sdo(received.frame.data()) => {
                Some(Disturbance::SdoTwins { node: id })
            }
            _ => None,
        };
        let read = match channel {
            Channel::Tpdo1(_) if node.missed || received.at < earliest_feedback || received.at > deadline => {
                node.late = false;
                node.health.stale_feedbacks += 1;
                Ok(Event::Nothing)
            }
            Channel::Tpdo1(_) => DriveFeedback::decode(received.frame.data())
                .map(|feedback| node.feedback(feedback, received.at, received.at.since(sync_at))),
            Channel::Heartbeat(_) => {
                wire::decode_heartbeat(received.frame.data()).map(|state| node.heartbeat(state, received.at))
            }
            Channel::Emergency(_) => Ok(node.emergency(wire::decode_emergency(received.frame.data()))),
            Channel::SdoResponse(id) => wire::decode_sdo(received.frame.data()).map(|payload| Event::Sdo(id, payload)),
            Channel::NmtCommand | Channel::Sync | Channel::Rpdo1(_) | Channel::SdoRequest(_) => Ok(Event::Nothing),
        };
        let event = read.unwrap_or_else(|_| {
            node.health.malformed += 1;
            Event::Nothing
        });
        if let Event::Heartbeat(_, NmtState::Initialising) = event
            && let Some(rebooted) = node.boot_up()
        {
            self.disturb(rebooted);
        }
        if let Some(twins) = twins {
            self.disturb(twins);
        }
        if let Event::Sdo(from, payload) = event {
            self.take_answer(from, &payload);
        }
        event
    }

    /// Looks at a frame that no drive sent: was it another master?
    fn overhear(&mut self, received: &Received) {
        let id = received.frame.id();
        let foreign = self.configuration.foreign().find_map(|(identifier, frame)| (identifier == id).then_some(frame));
        if let Some(frame) = foreign {
            self.disturb(frame.into());
        }
    }

    /// Takes the torque that a drive reports beside its feedback; false if the frame is none of that.
    fn torque_feedback(&mut self, received: &Received) -> bool {
        let identifier = Some(received.frame.id());
        let Some(node) = self.nodes.iter_mut().find(|node| node.torque_identifier == identifier) else { return false };
        match wire::decode_torque_feedback(received.frame.data()) {
            Ok(torque) => {
                node.health.torque = Some(torque);
                node.torque_is_fresh = true;
            }
            Err(_) => node.health.malformed += 1,
        }
        true
    }

    /// The channel of a frame and the drive that sent it; `None` if none of ours can have.
    fn sender(&mut self, received: &Received) -> Option<(Channel, &mut Node)> {
        let identifier = received.frame.id();
        if let Some(position) = self.nodes.iter().position(|node| node.feedback_identifier == identifier) {
            let node = self.nodes.get_mut(position)?;
            return Some((Channel::Tpdo1(node.id), node));
        }
        let channel = Channel::of(identifier)?;
        let id = match channel {
            Channel::Emergency(id) | Channel::SdoResponse(id) | Channel::Heartbeat(id) => id,
            Channel::NmtCommand | Channel::Sync | Channel::Tpdo1(_) | Channel::Rpdo1(_) | Channel::SdoRequest(_) => {
                return None;
            }
        };
        Some((channel, self.node_mut(id)?))
    }

    /// Reads what has come already, without waiting; at most so many frames that a bus full of noise cannot hold the
    /// loop.
    pub(super) fn drain(&mut self) -> Result<(), L::Error> {
        /// Ten frames of every drive, more than a bus of 1 Mbit/s carries in 3 ms from three.
        const FRAMES_PER_NODE: usize = 10;
        for _ in 0..JOINTS.saturating_mul(FRAMES_PER_NODE) {
            match self.link.receive(Instant::default())? {
                Some(received) => self.absorb(&received),
                None => break,
            };
        }
        Ok(())
    }
}

impl Node {
    /// True while there is feedback of it to wait for.
    pub(super) fn is_awaited(&self) -> bool {
        self.fresh.is_none() || self.late
    }

    /// Takes one answer off those that are owed; false if none was. An answer that comes late is owed like any other.
    fn answers(&mut self) -> bool {
        let Some(owed) = &mut self.owed else { return true };
        let answers = *owed > 0;
        *owed = owed.saturating_sub(1);
        answers
    }

    /// Takes one answer off the SDO requests that were made; false if none was open. A drive may abort a transfer by itself.
    fn answers_sdo(&mut self, data: &[u8]) -> bool {
        if self.stage != Stage::Addressed || data.first() == Some(&sdo::ABORT) {
            return true;
        }
        let answers = self.sdo_owed > 0;
        self.sdo_owed = self.sdo_owed.saturating_sub(1);
        answers
    }

    fn feedback(&mut self, feedback: DriveFeedback, at: Instant, latency: Duration) -> Event {
        let is_first = self.fresh.replace(feedback).is_none();
        let health = &mut self.health;
        if is_first {
            health.feedbacks += 1;
        } else if core::mem::take(&mut self.late) {
            // The one before it was the answer to the SYNC before.
            health.stale_feedbacks += 1;
        } else {
            health.surplus_feedbacks += 1;
        }
        health.statusword = feedback.statusword;
        health.latency = latency;
        health.longest_latency = health.longest_latency.max(latency);
        arrived(&mut health.last_feedback_at, &mut health.longest_feedback_gap, at);
        Event::Feedback
    }

    fn heartbeat(&mut self, state: NmtState, at: Instant) -> Event {
        if state == NmtState::Initialising {
            // Whatever was set in it is gone.
            self.last_defence = LastDefence::None;
        }
        let health = &mut self.health;
        health.heartbeats += 1;
        health.nmt_state = Some(state);
        arrived(&mut health.last_heartbeat_at, &mut health.longest_heartbeat_gap, at);
        Event::Heartbeat(self.id, state)
    }

    /// Takes note of a boot-up message, which is a disturbance once the drive has got settings.
    fn boot_up(&mut self) -> Option<Disturbance> {
        if self.stage == Stage::Addressed {
            return Some(Disturbance::Rebooted { node: self.health.node });
        }
        self.stage = Stage::Booted;
        None
    }

    /// An error that is over before the drive is enabled was part of its start; after that each one counts.
    fn emergency(&mut self, message: EmergencyMessage) -> Event {
        self.health.emergencies += 1;
        if !message.is_error_reset() {
            self.health.last_emergency = Some(message);
            self.alarm = Some(message);
        } else if !self.controlword.enables() {
            self.alarm = None;
        }
        Event::Emergency
    }
}
