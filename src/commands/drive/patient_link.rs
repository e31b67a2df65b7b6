//! A link that bears errors on the wire: who looks at a bus wants to see them, not to end by them.

use uarm_io::frame::Frame;
use uarm_io::link::{Link, LinkError, LinkErrorKind, LinkHealth, Received};
use uarm_io::time::Instant;

/// A link whose reception goes on after bus-off and the controller's reports; [`Link::health`] counts them.
#[derive(Debug)]
pub struct PatientLink<L>(pub L);

impl<L: Link> Link for PatientLink<L> {
    type Error = L::Error;

    fn send(&mut self, frame: &Frame) -> Result<Instant, L::Error> {
        self.0.send(frame)
    }

    fn receive(&mut self, deadline: Instant) -> Result<Option<Received>, L::Error> {
        loop {
            match self.0.receive(deadline) {
                Err(error) if matches!(error.kind(), LinkErrorKind::Controller | LinkErrorKind::BusOff) => {}
                outcome => return outcome,
            }
        }
    }

    fn health(&self) -> LinkHealth {
        self.0.health()
    }
}
