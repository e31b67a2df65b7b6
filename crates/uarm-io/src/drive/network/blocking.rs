//! Waiting and SDO transfers, for start and stop.

use super::disturbance::Disturbance;
use super::master::{DriveNetwork, Stage};
use super::receive::Event;
use crate::drive::cia402::{Controlword, Statusword};
use crate::drive::objects::{CONTROLWORD, Object, STATUSWORD};
use crate::drive::sdo::{self, Expected, Patience, SdoError, SdoPort};
use crate::drive::wire::Channel;
use crate::drive::wishes::{DriveConfiguration, Setting, TorqueApplies};
use crate::frame::Frame;
use crate::link::Link;
use crate::time::{Clock, Duration, Instant};
use canopen_rs::sdo::SdoPayload;
use canopen_rs::{Address, DataType, NmtState, NodeId, Value};

/// Late SDO answers of one drive, to attempts that were given up. More are not remembered.
const MOST_LATE_SDO_ANSWERS: u8 = 3;

/// A network and the clock by which it waits.
pub(super) struct Blocking<'a, L: Link, C, const JOINTS: usize> {
    pub(super) network: &'a mut DriveNetwork<L, JOINTS>,
    pub(super) clock: &'a C,
    /// How often an SDO request is made before silence is an error.
    pub(super) sdo_attempts: u8,
    pub(super) heed: Heed,
    pub(super) voice: Voice,
}

/// What a [`Disturbance`](super::Disturbance) does to waiting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Heed {
    /// It ends it: there is no point in going on with a start.
    Disturbance,
    /// Nothing: a stop goes on whatever happens.
    Nothing,
}

/// Whether the master's heartbeats are sent while it waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Voice {
    /// They are.
    Heartbeats,
    /// They are, until then.
    HeartbeatsUntil(Instant),
    /// They are not: somebody else's drives must not hear them, or ours shall miss them.
    Silent,
}

impl Voice {
    fn speaks(self, now: Instant) -> bool {
        match self {
            Self::Heartbeats => true,
            Self::HeartbeatsUntil(end) => now < end,
            Self::Silent => false,
        }
    }
}

impl<'a, L: Link, C: Clock, const JOINTS: usize> Blocking<'a, L, C, JOINTS> {
    pub(super) fn new(network: &'a mut DriveNetwork<L, JOINTS>, clock: &'a C) -> Self {
        let sdo_attempts = network.configuration.timeouts.sdo_attempts.max(1);
        Self { network, clock, sdo_attempts, heed: Heed::Disturbance, voice: Voice::Heartbeats }
    }

    /// Reads frames until one is `wanted`, `deadline` passes or the bus is disturbed; sends the master's heartbeats
    /// meanwhile.
    pub(super) fn wait<R>(
        &mut self,
        deadline: Instant,
        mut wanted: impl FnMut(&Event) -> Option<R>,
    ) -> Result<Option<R>, L::Error> {
        /// Frames that may have queued up behind the deadline: a process that was not scheduled in time must still find
        /// the response that came in time, and a bus full of noise must not hold it for ever.
        const OVERTIME_FRAMES: u32 = 256;
        let mut overtime = 0;
        loop {
            let now = self.clock.now();
            let mut wake = deadline;
            if self.voice.speaks(now) {
                self.network.produce_heartbeat(now)?;
                self.network.repeat_commands(now)?;
                wake = deadline.min(self.network.next_heartbeat).min(self.network.next_command());
            }
            match self.network.link.receive(wake)? {
                Some(received) => {
                    let event = self.network.absorb(&received);
                    if let Some(result) = wanted(&event) {
                        return Ok(Some(result));
                    }
                    if self.undisturbed().is_err() {
                        return Ok(None);
                    }
                    overtime += u32::from(now > deadline);
                    if overtime > OVERTIME_FRAMES {
                        return Ok(None);
                    }
                }
                None if wake >= deadline => return Ok(None),
                None => {}
            }
        }
    }

    /// An error if the bus was disturbed and that matters here.
    pub(super) fn undisturbed(&self) -> Result<(), Disturbance> {
        match self.heed {
            Heed::Disturbance => self.network.undisturbed(),
            Heed::Nothing => Ok(()),
        }
    }

    /// The drives' nodes, joint 1 first.
    pub(super) fn nodes(&self) -> [NodeId; JOINTS] {
        self.network.nodes.map(|node| node.id)
    }

    /// Waits until the last heartbeat of `node` is `wanted`; false if `deadline` passes first.
    pub(super) fn reports(
        &mut self,
        node: NodeId,
        deadline: Instant,
        wanted: impl Fn(NmtState) -> bool,
    ) -> Result<bool, L::Error> {
        if self.nmt_state(node).is_some_and(&wanted) {
            return Ok(true);
        }
        let seen = self.wait(deadline, |event| match event {
            Event::Heartbeat(from, state) if *from == node && wanted(*state) => Some(()),
            _ => None,
        })?;
        Ok(seen.is_some())
    }

    /// The NMT state in the last heartbeat of `node`; `None` before the first.
    pub(super) fn nmt_state(&self, node: NodeId) -> Option<NmtState> {
        self.network.nodes.iter().find(|other| other.id == node)?.health.nmt_state
    }

    /// Lets `duration` pass.
    pub(super) fn pause(&mut self, duration: Duration) -> Result<(), L::Error> {
        let deadline = self.clock.now() + duration;
        self.wait(deadline, |_| None::<()>).map(|_| ())
    }

    /// Reads an object.
    pub(super) fn read(&mut self, node: NodeId, object: &Object) -> Result<Value, SdoError<L::Error>> {
        self.read_at(node, object.address(), object.data_type)
    }

    pub(super) fn read_at(
        &mut self,
        node: NodeId,
        object: Address,
        data_type: DataType,
    ) -> Result<Value, SdoError<L::Error>> {
        self.address(node);
        let patience = self.patience();
        let read = sdo::read(self, patience, node, object, data_type);
        self.unless_twins(read)
    }

    /// What came of a transfer, unless its answer was one to another request: then the one to this request is still to come, and
    /// two drives have this node id.
    fn unless_twins<T>(&mut self, outcome: Result<T, SdoError<L::Error>>) -> Result<T, SdoError<L::Error>> {
        if let Err(SdoError::Response { command, expected, .. }) = &outcome
            && expected.is_of_another(*command)
        {
            self.pause(self.network.configuration.timeouts.sdo)?;
            self.undisturbed().map_err(SdoError::Disturbed)?;
        }
        outcome
    }

    /// Writes an object.
    pub(super) fn write(&mut self, node: NodeId, setting: &Setting) -> Result<(), SdoError<L::Error>> {
        self.address(node);
        let patience = self.patience();
        let written = sdo::write(self, patience, node, setting.address, setting.value);
        self.unless_twins(written)
    }

    /// Sends a controlword to a drive that takes no PDO.
    pub(super) fn command_by_sdo(&mut self, node: NodeId, word: Controlword) -> Result<(), SdoError<L::Error>> {
        self.write(node, &Setting::of(&CONTROLWORD, Value::Unsigned16(word.bits())))
    }

    /// True if an RPDO acts in the drive when it comes: in NMT *Operational*, and not only at the next SYNC, of which there is
    /// none outside the cycle.
    pub(super) fn obeys_pdos(&self, node: NodeId) -> bool {
        let waits = |drive: &&DriveConfiguration| drive.torque_applies == TorqueApplies::AtSync;
        let synchronous = self.network.configuration.drives().iter().filter(waits).any(|drive| drive.node == node);
        !synchronous && self.nmt_state(node) == Some(NmtState::Operational)
    }

    /// Emergencies from before the first SDO to a drive were about its past, such as a heartbeat lost in the last run.
    pub(super) fn address(&mut self, node: NodeId) {
        if let Some(node) = self.network.node_mut(node).filter(|node| node.stage != Stage::Addressed) {
            node.stage = Stage::Addressed;
            node.alarm = None;
        }
    }

    pub(super) fn patience(&self) -> Patience {
        Patience { timeout: self.network.configuration.timeouts.sdo, attempts: self.sdo_attempts }
    }

    /// Reads the statusword.
    pub(super) fn statusword(&mut self, node: NodeId) -> Result<Statusword, SdoError<L::Error>> {
        match self.read(node, &STATUSWORD)? {
            Value::Unsigned16(bits) => Ok(Statusword::from_bits(bits)),
            _ => Err(SdoError::Response {
                node: node.raw(),
                object: STATUSWORD.address(),
                command: sdo::UPLOAD_RESPONSE,
                expected: Expected::Value(STATUSWORD.data_type),
            }),
        }
    }
}

impl<L: Link, C: Clock, const JOINTS: usize> SdoPort for Blocking<'_, L, C, JOINTS> {
    type Error = L::Error;

    fn bus_is_sound(&self) -> Result<(), Disturbance> {
        self.undisturbed()
    }

    fn send_request(&mut self, frame: &Frame) -> Result<(), L::Error> {
        self.network.send(frame)?;
        // An abort is not answered; it ends an attempt whose answer may still come.
        if let Some(Channel::SdoRequest(node)) = Channel::of(frame.id())
            && let Some(node) = self.network.node_mut(node)
        {
            if frame.data().first() == Some(&sdo::ABORT) {
                node.sdo_late = node.sdo_late.saturating_add(1).min(MOST_LATE_SDO_ANSWERS);
            } else {
                node.sdo_owed = node.sdo_late.saturating_add(1);
            }
        }
        Ok(())
    }

    /// Sends the master's heartbeats meanwhile.
    fn await_answer(
        &mut self,
        node: NodeId,
        timeout: Duration,
        wanted: impl Fn(&SdoPayload) -> bool,
    ) -> Result<Option<SdoPayload>, L::Error> {
        let deadline = self.clock.now() + timeout;
        self.wait(deadline, |event| match event {
            Event::Sdo(from, payload) if *from == node && wanted(payload) => Some(*payload),
            _ => None,
        })
    }
}
