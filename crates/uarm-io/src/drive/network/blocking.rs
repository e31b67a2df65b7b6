//! Waiting and SDO transfers, for start and stop.

use super::configuration::Setting;
use super::disturbance::Disturbance;
use super::error::{Expected, SdoError};
use super::master::{DriveNetwork, Stage};
use super::receive::Event;
use crate::drive::cia402::Statusword;
use crate::drive::objects::{Object, STATUSWORD};
use crate::drive::wire;
use crate::link::Link;
use crate::time::{Clock, Duration, Instant};
use canopen_rs::sdo::{SdoAbortCode, SdoClient, SdoEvent, SdoPayload, encode_abort};
use canopen_rs::{Address, DataType, NmtState, NodeId, Value};

/// A network and the clock by which it waits.
pub(super) struct Blocking<'a, L: Link, C, const JOINTS: usize> {
    pub(super) network: &'a mut DriveNetwork<L, JOINTS>,
    pub(super) clock: &'a C,
    /// How often an SDO request is made before silence is an error.
    pub(super) sdo_attempts: u8,
    pub(super) heed: Heed,
}

/// What a [`Disturbance`](super::Disturbance) does to waiting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Heed {
    /// It ends it: there is no point in going on with a start.
    Disturbance,
    /// Nothing: a stop goes on whatever happens.
    Nothing,
}

/// Command specifiers of SDO responses (CiA 301): the upper three bits of the first byte.
const SPECIFIER: u8 = 0xE0;
const UPLOAD_RESPONSE: u8 = 0x40;
const DOWNLOAD_RESPONSE: u8 = 0x60;
const ABORT: u8 = 0x80;
/// An expedited upload response that does not say how many of its four bytes count.
const UPLOAD_WITHOUT_SIZE: u8 = 0x42;
/// The longest value that `canopen-rs` transfers is 32 bytes, five segments; empty segments beyond that are nonsense.
const MOST_EXCHANGES: u8 = 8;

impl<'a, L: Link, C: Clock, const JOINTS: usize> Blocking<'a, L, C, JOINTS> {
    pub(super) fn new(network: &'a mut DriveNetwork<L, JOINTS>, clock: &'a C) -> Self {
        let sdo_attempts = network.configuration.timeouts.sdo_attempts.max(1);
        Self { network, clock, sdo_attempts, heed: Heed::Disturbance }
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
            self.network.produce_heartbeat(now)?;
            let wake = deadline.min(self.network.next_heartbeat);
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
        let expected = Expected::Value(data_type);
        let value = self.transfer(node, object, expected, |client| client.read(object, data_type))?;
        value.ok_or(SdoError::Response { node: node.raw(), object, command: DOWNLOAD_RESPONSE, expected })
    }

    /// Writes an object.
    pub(super) fn write(&mut self, node: NodeId, setting: &Setting) -> Result<(), SdoError<L::Error>> {
        let Setting { address, value, .. } = *setting;
        self.transfer(node, address, Expected::Confirmation, |client| client.write(address, value)).map(|_| ())
    }

    /// Reads the statusword.
    pub(super) fn statusword(&mut self, node: NodeId) -> Result<Statusword, SdoError<L::Error>> {
        match self.read(node, &STATUSWORD)? {
            Value::Unsigned16(bits) => Ok(Statusword::from_bits(bits)),
            _ => Err(SdoError::Response {
                node: node.raw(),
                object: STATUSWORD.address(),
                command: UPLOAD_RESPONSE,
                expected: Expected::Value(STATUSWORD.data_type),
            }),
        }
    }

    /// Makes a transfer, again after silence as often as the configuration says.
    fn transfer(
        &mut self,
        node: NodeId,
        object: Address,
        expected: Expected,
        begin: impl Fn(&mut SdoClient) -> SdoPayload,
    ) -> Result<Option<Value>, SdoError<L::Error>> {
        let attempts = self.sdo_attempts;
        self.address(node);
        for _ in 0..attempts {
            let outcome = self.attempt(node, object, expected, &begin)?;
            self.undisturbed().map_err(SdoError::Disturbed)?;
            if let Some(outcome) = outcome {
                return Ok(outcome);
            }
            // The drive may still wait for the rest of a transfer: free it.
            let abort = encode_abort(object, SdoAbortCode::ProtocolTimedOut);
            self.network.send(&wire::sdo_request_frame(node, &abort))?;
        }
        let waited = self.network.configuration.timeouts.sdo;
        Err(SdoError::Timeout { node: node.raw(), object, waited, attempts })
    }

    /// Emergencies from before the first SDO to a drive were about its past, such as a heartbeat lost in the last run.
    fn address(&mut self, node: NodeId) {
        if let Some(node) = self.network.node_mut(node).filter(|node| node.stage != Stage::Addressed) {
            node.stage = Stage::Addressed;
            node.alarm = None;
        }
    }

    /// One transfer; `None` after silence.
    fn attempt(
        &mut self,
        node: NodeId,
        object: Address,
        expected: Expected,
        begin: &impl Fn(&mut SdoClient) -> SdoPayload,
    ) -> Result<Option<Option<Value>>, SdoError<L::Error>> {
        let mut client = SdoClient::new(node);
        let mut request = begin(&mut client);
        let mut command = 0;
        for _ in 0..MOST_EXCHANGES {
            self.network.send(&wire::sdo_request_frame(node, &request))?;
            let deadline = self.clock.now() + self.network.configuration.timeouts.sdo;
            let response = self.wait(deadline, |event| match event {
                Event::Sdo(from, payload) if *from == node && concerns(payload, object) => Some(*payload),
                _ => None,
            })?;
            let Some(response) = response else { return Ok(None) };
            let response = sized(response, expected);
            [command, ..] = response;
            match client.on_response(&response) {
                SdoEvent::Send(next) => request = next,
                SdoEvent::Complete(value) => return Ok(Some(value)),
                SdoEvent::Aborted(code) if command == ABORT => {
                    return Err(SdoError::Abort { node: node.raw(), object, code });
                }
                // The client's own verdict on an response that it cannot use.
                SdoEvent::Aborted(_) => break,
            }
        }
        Err(SdoError::Response { node: node.raw(), object, command, expected })
    }
}

/// False for a late response about another object. Segments carry no address.
fn concerns(payload: &[u8; 8], object: Address) -> bool {
    let [command, low, high, subindex, ..] = *payload;
    match command & SPECIFIER {
        UPLOAD_RESPONSE | DOWNLOAD_RESPONSE | ABORT => {
            Address::new(u16::from_le_bytes([low, high]), subindex) == object
        }
        _ => true,
    }
}

/// Some drives leave the size out of an expedited response; the type says it.
fn sized(mut payload: [u8; 8], expected: Expected) -> [u8; 8] {
    let size = match expected {
        Expected::Value(data_type) => data_type.fixed_size().and_then(|size| u8::try_from(size).ok()),
        Expected::Confirmation => None,
    };
    if let ([command, ..], Some(size @ 1..=4)) = (&mut payload, size)
        && *command == UPLOAD_WITHOUT_SIZE
    {
        *command |= 1 | (4 - size) << 2;
    }
    payload
}
