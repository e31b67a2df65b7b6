//! What a protocol needs of a wire: sending, receiving, errors.

use super::health::LinkHealth;
use crate::frame::Frame;
use crate::time::Instant;

/// A frame and when it came.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Received {
    /// The frame.
    pub frame: Frame,
    /// When the link saw it, on the clock of the loop.
    pub at: Instant,
}

/// What went wrong on a link, coarse enough to act on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LinkErrorKind {
    /// The interface is down.
    Down,
    /// The interface is gone.
    Gone,
    /// The transmit queue is full.
    QueueFull,
    /// The controller left the bus (bus-off).
    BusOff,
    /// The controller reports trouble short of bus-off.
    Controller,
    /// Anything else.
    Other,
}

/// An error of a link.
pub trait LinkError: core::error::Error {
    /// What kind of error it is.
    fn kind(&self) -> LinkErrorKind;
}

impl LinkError for core::convert::Infallible {
    fn kind(&self) -> LinkErrorKind {
        match *self {}
    }
}

/// A way to send and receive frames.
pub trait Link {
    /// What can go wrong.
    type Error: LinkError;

    /// Hands a frame to the wire; never waits. Returns the instant of the hand-over.
    ///
    /// # Errors
    /// If the wire did not take the frame.
    fn send(&mut self, frame: &Frame) -> Result<Instant, Self::Error>;

    /// The next frame, waiting for it until `deadline` at the latest; `None` if none came.
    ///
    /// # Errors
    /// If the wire failed.
    fn receive(&mut self, deadline: Instant) -> Result<Option<Received>, Self::Error>;

    /// What the link has seen of its wire so far.
    fn health(&self) -> LinkHealth {
        LinkHealth::default()
    }
}
