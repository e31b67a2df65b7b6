//! A wrapper that shows each frame that passes.

use super::health::LinkHealth;
use super::transport::{Link, Received};
use crate::frame::Frame;
use crate::time::Instant;

/// Which way a frame goes, seen from the master.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameDirection {
    /// From the master.
    Sent,
    /// To the master.
    Received,
}

/// A link that hands every frame to an observer once the inner link has taken or delivered it.
#[derive(Debug)]
pub struct ObservedLink<L, O> {
    inner: L,
    observer: O,
}

impl<L: Link, O: FnMut(FrameDirection, &Frame, Instant)> ObservedLink<L, O> {
    /// Wraps `inner`.
    pub const fn new(inner: L, observer: O) -> Self {
        Self { inner, observer }
    }

    /// The link inside.
    pub const fn inner_mut(&mut self) -> &mut L {
        &mut self.inner
    }
}

impl<L: Link, O: FnMut(FrameDirection, &Frame, Instant)> Link for ObservedLink<L, O> {
    type Error = L::Error;

    fn send(&mut self, frame: &Frame) -> Result<Instant, L::Error> {
        let at = self.inner.send(frame)?;
        (self.observer)(FrameDirection::Sent, frame, at);
        Ok(at)
    }

    fn health(&self) -> LinkHealth {
        self.inner.health()
    }

    fn receive(&mut self, deadline: Instant) -> Result<Option<Received>, L::Error> {
        let received = self.inner.receive(deadline)?;
        if let Some(Received { frame, at }) = &received {
            (self.observer)(FrameDirection::Received, frame, *at);
        }
        Ok(received)
    }
}
