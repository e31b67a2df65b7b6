//! What a link, or a program that serves a bus, needs of an emulated robot, whatever protocol its drives speak.

use crate::outbox::Outbox;
use uarm_io::frame::Frame;
use uarm_io::time::Instant;

/// A robot at the other end of a bus, without I/O: frames and instants in, frames out.
pub trait RobotOnBus {
    /// Switches the supply on.
    fn power_on(&mut self, now: Instant, outbox: &mut Outbox);

    /// The next instant at which a drive does something by itself: [`on_time`](Self::on_time) wants to be called then.
    fn next_deadline(&self) -> Option<Instant>;

    /// Does all that is due by `now`, in the order in which it falls due.
    fn on_time(&mut self, now: Instant, outbox: &mut Outbox);

    /// Handles a frame that came at `now`, after all that was due before.
    fn on_frame(&mut self, frame: &Frame, now: Instant, outbox: &mut Outbox);
}
