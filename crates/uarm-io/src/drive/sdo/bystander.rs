//! Reading drives without being their master.

use super::{Patience, SdoError, SdoPort};
use crate::drive::objects::Object;
use crate::drive::wire::{self, Channel};
use crate::frame::Frame;
use crate::link::{Link, Received};
use crate::time::{Clock, Duration};
use canopen_rs::sdo::SdoPayload;
use canopen_rs::{Address, NodeId, Value};

/// A node without a heartbeat that sends SDO requests and nothing else; what else it hears goes to an observer.
#[derive(Debug)]
pub struct Bystander<'a, L, C, O> {
    link: &'a mut L,
    clock: &'a C,
    patience: Patience,
    observer: O,
}

impl<'a, L: Link, C: Clock, O: FnMut(&Received)> Bystander<'a, L, C, O> {
    /// A bystander on `link` that shows each frame it hears to `observer`.
    pub const fn new(link: &'a mut L, clock: &'a C, patience: Patience, observer: O) -> Self {
        Self { link, clock, patience, observer }
    }

    /// Reads an object.
    ///
    /// # Errors
    /// [`SdoError`].
    pub fn read(&mut self, node: NodeId, object: &Object) -> Result<Value, SdoError<L::Error>> {
        let patience = self.patience;
        super::read(self, patience, node, object.address(), object.data_type)
    }

    /// Reads an object that a drive need not have; `None` if it refuses, or answers with something else than a value of the
    /// object's type.
    ///
    /// # Errors
    /// [`SdoError::Link`], [`SdoError::Timeout`].
    pub fn read_optional(&mut self, node: NodeId, object: &Object) -> Result<Option<Value>, SdoError<L::Error>> {
        match self.read(node, object) {
            Ok(value) => Ok(Some(value)),
            Err(SdoError::Abort { .. } | SdoError::Response { .. }) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Writes an object.
    ///
    /// # Errors
    /// [`SdoError`].
    pub fn write(&mut self, node: NodeId, object: Address, value: Value) -> Result<(), SdoError<L::Error>> {
        let patience = self.patience;
        super::write(self, patience, node, object, value)
    }

    /// Sends one frame; for requests whose answers the observer takes.
    ///
    /// # Errors
    /// If the link did not take it.
    pub fn send(&mut self, frame: &Frame) -> Result<(), L::Error> {
        self.link.send(frame).map(|_| ())
    }

    /// Listens for `duration`.
    ///
    /// # Errors
    /// If the link failed.
    pub fn listen(&mut self, duration: Duration) -> Result<(), L::Error> {
        let deadline = self.clock.now() + duration;
        while let Some(received) = self.link.receive(deadline)? {
            (self.observer)(&received);
            if received.at > deadline {
                break;
            }
        }
        Ok(())
    }
}

impl<L: Link, C: Clock, O: FnMut(&Received)> SdoPort for Bystander<'_, L, C, O> {
    type Error = L::Error;

    fn send_request(&mut self, frame: &Frame) -> Result<(), L::Error> {
        self.send(frame)
    }

    fn await_answer(
        &mut self,
        node: NodeId,
        timeout: Duration,
        wanted: impl Fn(&SdoPayload) -> bool,
    ) -> Result<Option<SdoPayload>, L::Error> {
        let deadline = self.clock.now() + timeout;
        while let Some(received) = self.link.receive(deadline)? {
            (self.observer)(&received);
            let answer = match Channel::of(received.frame.id()) {
                Some(Channel::SdoResponse(from)) if from == node => wire::decode_sdo(received.frame.data()).ok(),
                _ => None,
            };
            if let Some(payload) = answer.filter(&wanted) {
                return Ok(Some(payload));
            }
            // A bus full of other traffic must not hold the caller for ever.
            if received.at > deadline {
                break;
            }
        }
        Ok(None)
    }
}
