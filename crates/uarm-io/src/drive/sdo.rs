//! SDO transfers: reading and writing a drive's objects one by one, again after silence.
//!
//! [`read()`] and [`write()`] work through an [`SdoPort`]. The master of the drives is one; [`Bystander`] is the other, for who
//! only looks: it sends nothing but SDO requests, no heartbeat and no command.

mod bystander;
mod command;
mod error;
mod objects;

pub use bystander::Bystander;
pub(super) use command::{ABORT, UPLOAD_RESPONSE};
use command::{DOWNLOAD_RESPONSE, SPECIFIER};
pub use error::{Expected, SdoError};
pub use objects::DriveObjects;

use crate::drive::network::Disturbance;
use crate::drive::survey::{Answer, Answered};
use crate::drive::wire;
use crate::frame::Frame;
use crate::time::Duration;
use canopen_rs::sdo::{SdoAbortCode, SdoClient, SdoEvent, SdoPayload, encode_abort};
use canopen_rs::{Address, DataType, NodeId, Value};

/// How SDO requests and their answers pass.
pub trait SdoPort {
    /// What can go wrong with the link.
    type Error;

    /// Whether the bus is as it should be; who is no master does not care.
    ///
    /// # Errors
    /// What disturbs it: the transfer is then not believed.
    fn bus_is_sound(&self) -> Result<(), Disturbance> {
        Ok(())
    }

    /// Sends a frame.
    ///
    /// # Errors
    /// If the link did not take it.
    fn send_request(&mut self, frame: &Frame) -> Result<(), Self::Error>;

    /// The next answer of `node` that is `wanted`; `None` if none comes within `timeout`.
    ///
    /// # Errors
    /// If the link failed.
    fn await_answer(
        &mut self,
        node: NodeId,
        timeout: Duration,
        wanted: impl Fn(&SdoPayload) -> bool,
    ) -> Result<Option<SdoPayload>, Self::Error>;
}

/// How long an answer is waited for, and how often it is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Patience {
    /// Time waited for one answer.
    pub timeout: Duration,
    /// How often a request is made before silence is an error; 0 counts as 1.
    pub attempts: u8,
}

/// An expedited upload response that does not say how many of its four bytes count.
const UPLOAD_WITHOUT_SIZE: u8 = 0x42;
/// The longest value that `canopen-rs` transfers is 32 bytes, five segments; empty segments beyond that are nonsense.
const MOST_EXCHANGES: u8 = 8;

/// SDO abort codes that say that there is no such object, and no such sub-index.
const ABSENT: [u32; 2] = [0x0602_0000, 0x0609_0011];

/// What a drive's answer to a read says of an object.
///
/// # Errors
/// If it is no answer: silence, or a link that failed.
fn answered<E>(read: Result<Value, SdoError<E>>) -> Result<Answered, SdoError<E>> {
    let answer = match read {
        Ok(value) => Answer::of(value),
        Err(SdoError::Abort { code, .. }) if ABSENT.contains(&code) => Answer::Absent,
        Err(SdoError::Abort { code, .. }) => Answer::Refused(code),
        // A text, a domain, or a number of another length.
        Err(SdoError::Response { .. }) => Answer::NotANumber,
        Err(error) => return Err(error),
    };
    Ok(Answered::by_drive(answer))
}

/// Reads an object.
///
/// # Errors
/// [`SdoError`].
pub fn read<P: SdoPort>(
    port: &mut P,
    patience: Patience,
    node: NodeId,
    object: Address,
    data_type: DataType,
) -> Result<Value, SdoError<P::Error>> {
    let expected = Expected::Value(data_type);
    let value = transfer(port, patience, node, object, expected, |client| client.read(object, data_type))?;
    value.ok_or(SdoError::Response { node: node.raw(), object, command: DOWNLOAD_RESPONSE, expected })
}

/// Writes an object.
///
/// # Errors
/// [`SdoError`].
pub fn write<P: SdoPort>(
    port: &mut P,
    patience: Patience,
    node: NodeId,
    object: Address,
    value: Value,
) -> Result<(), SdoError<P::Error>> {
    transfer(port, patience, node, object, Expected::Confirmation, |client| client.write(object, value)).map(|_| ())
}

/// Makes a transfer, again after silence as often as `patience` says.
fn transfer<P: SdoPort>(
    port: &mut P,
    patience: Patience,
    node: NodeId,
    object: Address,
    expected: Expected,
    begin: impl Fn(&mut SdoClient) -> SdoPayload,
) -> Result<Option<Value>, SdoError<P::Error>> {
    let attempts = patience.attempts.max(1);
    for _ in 0..attempts {
        let outcome = attempt(port, patience.timeout, node, object, expected, &begin)?;
        port.bus_is_sound().map_err(SdoError::Disturbed)?;
        if let Some(outcome) = outcome {
            return Ok(outcome);
        }
        // The drive may still wait for the rest of a transfer: free it.
        let abort = encode_abort(object, SdoAbortCode::ProtocolTimedOut);
        port.send_request(&wire::sdo_request_frame(node, &abort))?;
    }
    Err(SdoError::Timeout { node: node.raw(), object, waited: patience.timeout, attempts })
}

/// One transfer; `None` after silence.
fn attempt<P: SdoPort>(
    port: &mut P,
    timeout: Duration,
    node: NodeId,
    object: Address,
    expected: Expected,
    begin: &impl Fn(&mut SdoClient) -> SdoPayload,
) -> Result<Option<Option<Value>>, SdoError<P::Error>> {
    let mut client = SdoClient::new(node);
    let mut request = begin(&mut client);
    let mut command = 0;
    for _ in 0..MOST_EXCHANGES {
        port.send_request(&wire::sdo_request_frame(node, &request))?;
        let Some(response) = port.await_answer(node, timeout, |payload| concerns(payload, object))? else {
            return Ok(None);
        };
        let response = sized(response, expected);
        [command, ..] = response;
        match client.on_response(&response) {
            SdoEvent::Send(next) => request = next,
            SdoEvent::Complete(value) => return Ok(Some(value)),
            SdoEvent::Aborted(code) if command == ABORT => {
                return Err(SdoError::Abort { node: node.raw(), object, code });
            }
            // The client's own verdict on a response that it cannot use.
            SdoEvent::Aborted(_) => break,
        }
    }
    Err(SdoError::Response { node: node.raw(), object, command, expected })
}

/// False for a late response about another object. Segments carry no address.
pub(super) fn concerns(payload: &[u8; 8], object: Address) -> bool {
    let [command, low, high, subindex, ..] = *payload;
    match command & SPECIFIER {
        UPLOAD_RESPONSE | DOWNLOAD_RESPONSE | ABORT => {
            Address::new(u16::from_le_bytes([low, high]), subindex) == object
        }
        _ => true,
    }
}

/// Some drives leave the size out of an expedited response; the type says it.
pub(super) fn sized(mut payload: [u8; 8], expected: Expected) -> [u8; 8] {
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
