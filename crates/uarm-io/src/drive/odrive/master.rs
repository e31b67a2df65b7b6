//! The master: what it holds, sending, and the one place where frames from the axes are read.

use super::configuration::OdriveConfiguration;
use super::error::ForeignCommand;
use super::watched::{Inquiry, Watched};
use super::wire::{self, AxisNode, AxisState, EncoderEstimates, Heartbeat, Message, Supply, Temperature, Version};
use crate::drive::cia402::{PowerState, Statusword};
use crate::drive::identity::DriveIdentity;
use crate::drive::network::{LastDefence, NetworkHealth, NodeHealth};
use crate::drive::readings::{QUANTITIES, Quantity};
use crate::frame::Frame;
use crate::link::{Link, Received};
use crate::time::{Duration, Instant};
use canopen_rs::{EmergencyMessage, ErrorRegister, NmtState};

/// The master of `JOINTS` ODrive axes on the link `L`.
#[derive(Debug)]
pub struct OdriveNetwork<L: Link, const JOINTS: usize> {
    pub(super) link: L,
    pub(super) configuration: OdriveConfiguration<JOINTS>,
    pub(super) axes: [Axis; JOINTS],
    pub(super) sync_at: Instant,
    /// What comes after it does not answer the last request.
    pub(super) deadline: Instant,
    pub(super) next_feed: Instant,
    pub(super) traffic: Traffic,
    /// The first frame of another master that was heard.
    pub(super) foreign: Option<ForeignCommand>,
    /// The bus is another master's: nothing is sent, not even a stop.
    pub(super) is_withheld: bool,
    pub(super) inquiry: Inquiry,
    pub(super) identified: Identified,
}

/// Is told what an axis says of itself: its node id, and what it is.
pub type Identified = fn(u8, &DriveIdentity);

/// Before an answer is waited for, none is late.
pub(super) const NO_DEADLINE: Instant = Instant::from_nanoseconds(u64::MAX);

/// One axis as the master sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    pub(super) node: AxisNode,
    /// The last position and when it came.
    pub(super) estimate: Option<(EncoderEstimates, Instant)>,
    /// A position came since the cycle began.
    pub(super) fresh: bool,
    /// The deadline for the answer to a request has passed without it.
    pub(super) missed: bool,
    /// The answer to the request before may still come.
    pub(super) late: bool,
    /// Requests for its position, and positions that came: of one axis not more than those.
    pub(super) asked: u64,
    pub(super) answered: u64,
    pub(super) heartbeat: Heartbeat,
    /// [`LastDefence::RpdoTimeout`] once its watchdog was seen to disarm it.
    pub(super) last_defence: LastDefence,
    pub(super) health: NodeHealth,
    /// What it is, once it has told.
    pub(super) version: Option<Version>,
    /// What it is asked for, by [`Quantity`].
    pub(super) watched: [Option<Watched>; QUANTITIES],
}

/// Frames counted for the whole network.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Traffic {
    received: u64,
    sent: u64,
    pub(super) cycles: u64,
    unexpected: u64,
}

impl<L: Link, const JOINTS: usize> OdriveNetwork<L, JOINTS> {
    /// A master that has sent nothing yet.
    pub fn new(link: L, configuration: OdriveConfiguration<JOINTS>) -> Self {
        let axes = configuration.axes.map(|axis| Axis {
            node: axis.node,
            estimate: None,
            fresh: false,
            missed: false,
            late: false,
            asked: 0,
            answered: 0,
            heartbeat: Heartbeat::default(),
            last_defence: LastDefence::None,
            health: NodeHealth { node: axis.node.raw(), ..NodeHealth::default() },
            version: None,
            watched: axis.readings.map(|limits| limits.map(Watched::new)),
        });
        let (sync_at, next_feed) = (Instant::default(), Instant::default());
        Self {
            link,
            configuration,
            axes,
            sync_at,
            deadline: NO_DEADLINE,
            next_feed,
            traffic: Traffic::default(),
            foreign: None,
            is_withheld: false,
            inquiry: Inquiry::default(),
            identified: |_, _| {},
        }
    }

    /// Whom each start tells what the axes say of themselves.
    pub const fn on_identified(&mut self, identified: Identified) {
        self.identified = identified;
    }

    /// The link to the bus.
    pub const fn link(&self) -> &L {
        &self.link
    }

    /// The link, to change its settings; frames taken from it here are lost to the master.
    pub const fn link_mut(&mut self) -> &mut L {
        &mut self.link
    }

    pub(super) fn seen(&self) -> NetworkHealth<JOINTS> {
        NetworkHealth {
            nodes: self.axes.map(|axis| axis.health),
            frames_received: self.traffic.received,
            frames_sent: self.traffic.sent,
            syncs: self.traffic.cycles,
            unexpected_frames: self.traffic.unexpected,
        }
    }

    pub(super) fn nodes(&self) -> [AxisNode; JOINTS] {
        self.configuration.axes.map(|axis| axis.node)
    }

    pub(super) fn send(&mut self, frame: &Frame) -> Result<Instant, L::Error> {
        let at = self.link.send(frame)?;
        self.traffic.sent += 1;
        Ok(at)
    }

    /// Sends each axis its torque, N·m. An axis whose frame was not taken does not keep the others from theirs; the error
    /// is the first.
    pub(super) fn torques(&mut self, newton_metres: [f32; JOINTS]) -> Result<Instant, L::Error> {
        let mut outcome = Ok(self.sync_at);
        for (joint, (node, torque)) in self.nodes().into_iter().zip(newton_metres).enumerate() {
            let sent = self.send(&wire::torque_frame(node, torque));
            if let (Ok(_), Some(axis)) = (&sent, self.axes.get_mut(joint)) {
                axis.health.commands += 1;
            }
            outcome = outcome.and(sent);
        }
        outcome
    }

    /// Reads a frame into what is known of its axis.
    pub(super) fn absorb(&mut self, received: &Received) {
        self.traffic.received += 1;
        let sender = Message::of(received.frame.id())
            .and_then(|(message, node)| Some((message, self.axes.iter_mut().find(|axis| axis.node == node)?)));
        let (data, deadline) = (received.frame.data(), self.deadline);
        // Its own frames do not come back to a master.
        if let Some((message, axis)) = &sender
            && message.is_of_master(data)
        {
            self.foreign.get_or_insert(ForeignCommand { axis: axis.node, message: *message });
            self.traffic.unexpected += 1;
            return;
        }
        let read = match sender {
            Some((Message::Heartbeat, axis)) => {
                Heartbeat::decode(data).map(|heartbeat| axis.alive(heartbeat, received.at)).is_ok().then_some(axis)
            }
            Some((Message::EncoderEstimates, axis)) => EncoderEstimates::decode(data)
                .map(|estimates| axis.position(estimates, received.at, deadline))
                .is_ok()
                .then_some(axis),
            Some((Message::Version, axis)) => {
                Version::decode(data).map(|version| axis.version = Some(version)).is_ok().then_some(axis)
            }
            Some((Message::Temperature, axis)) => Temperature::decode(data)
                .map(|found| axis.reading(Quantity::Temperature, found.highest()))
                .is_ok()
                .then_some(axis),
            Some((Message::BusVoltageCurrent, axis)) => Supply::decode(data)
                .map(|found| axis.reading(Quantity::SupplyVoltage, found.voltage))
                .is_ok()
                .then_some(axis),
            Some(_) | None => {
                self.traffic.unexpected += 1;
                return;
            }
        };
        if read.is_none() {
            self.malformed(received);
        }
    }

    fn malformed(&mut self, received: &Received) {
        if let Some((_, node)) = Message::of(received.frame.id())
            && let Some(axis) = self.axes.iter_mut().find(|axis| axis.node == node)
        {
            axis.health.malformed += 1;
        }
    }

    /// Reads what has come already, without waiting; at most so many frames that a bus full of noise cannot hold the
    /// loop.
    pub(super) fn drain(&mut self) -> Result<(), L::Error> {
        /// Ten frames of every axis, more than a bus of 1 Mbit/s carries in 3 ms from three.
        const FRAMES_PER_AXIS: usize = 10;
        for _ in 0..JOINTS.saturating_mul(FRAMES_PER_AXIS) {
            match self.link.receive(Instant::default())? {
                Some(received) => self.absorb(&received),
                None => break,
            }
        }
        Ok(())
    }
}

impl Axis {
    /// What it has said of itself.
    pub(super) fn identity(&self) -> DriveIdentity {
        self.version.map(|version| version.identity()).unwrap_or_default()
    }

    fn alive(&mut self, heartbeat: Heartbeat, at: Instant) {
        let health = &mut self.health;
        health.heartbeats += 1;
        gap(&mut health.last_heartbeat_at, &mut health.longest_heartbeat_gap, at);
        if !heartbeat.error.is_none() && heartbeat.error != self.heartbeat.error {
            health.emergencies += 1;
            health.last_emergency = Some(as_emergency(&heartbeat));
        }
        health.statusword = as_statusword(&heartbeat);
        // An axis has no NMT states: one that is heard takes part.
        health.nmt_state = Some(NmtState::Operational);
        self.heartbeat = heartbeat;
    }

    fn position(&mut self, estimates: EncoderEstimates, at: Instant, deadline: Instant) {
        self.answered += 1;
        let health = &mut self.health;
        if self.missed || at > deadline {
            // The answer to a request whose cycle is over.
            self.late = false;
            health.stale_feedbacks += 1;
            return;
        }
        if !self.fresh {
            health.feedbacks += 1;
        } else if core::mem::take(&mut self.late) {
            // The one before it was the answer to the request before.
            health.stale_feedbacks += 1;
        } else {
            health.surplus_feedbacks += 1;
        }
        self.fresh = true;
        self.estimate = Some((estimates, at));
        gap(&mut health.last_feedback_at, &mut health.longest_feedback_gap, at);
    }

    /// True if more positions came than were asked for; one may be a stray one.
    pub(super) const fn is_twin(&self) -> bool {
        const STRAY: u64 = 1;
        self.answered > self.asked + STRAY
    }

    /// True if a heartbeat that came at `since` or later told that the motor has no current.
    pub(super) fn is_idle_since(&self, since: Instant) -> bool {
        self.heartbeat.state == AxisState::IDLE && self.health.last_heartbeat_at.is_some_and(|at| at >= since)
    }

    /// Notes how far a position is from the instant of its cycle.
    pub(super) fn latency(&mut self, latency: Duration) {
        self.health.latency = latency;
        self.health.longest_latency = self.health.longest_latency.max(latency);
    }
}

fn gap(last: &mut Option<Instant>, longest: &mut Duration, at: Instant) {
    if let Some(previous) = last.replace(at) {
        *longest = (*longest).max(at.since(previous));
    }
}

/// What logs and monitors show as the statusword of an axis, which has none: the state of CiA 402 with the same meaning.
fn as_statusword(heartbeat: &Heartbeat) -> Statusword {
    Statusword::of(match heartbeat.state {
        _ if !heartbeat.error.is_none() => PowerState::Fault,
        AxisState::CLOSED_LOOP_CONTROL => PowerState::OperationEnabled,
        AxisState::IDLE => PowerState::SwitchOnDisabled,
        _ => PowerState::NotReadyToSwitchOn,
    })
}

/// What logs show as the emergency message of an axis, which has none: "device specific", the axis error and the state in the
/// maker's bytes.
fn as_emergency(heartbeat: &Heartbeat) -> EmergencyMessage {
    const DEVICE_SPECIFIC: u16 = 0xFF00;
    let [e0, e1, e2, e3] = heartbeat.error.0.to_le_bytes();
    EmergencyMessage {
        error_code: DEVICE_SPECIFIC,
        error_register: ErrorRegister(ErrorRegister::GENERIC),
        vendor_specific: [e0, e1, e2, e3, heartbeat.state.0],
    }
}
