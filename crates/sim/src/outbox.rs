//! Frames on their way out of the emulated robot.

use heapless::Deque;
use uarm_io::frame::Frame;
use uarm_io::link::Received;
use uarm_io::time::Instant;

/// How many frames an [`Outbox`] holds: eight seconds of three drives' heartbeats at 100 ms.
pub const OUTBOX_CAPACITY: usize = 256;

/// A bounded queue of frames, each with the instant at which it was sent. It never allocates: what does not fit is lost and
/// counted, as in a CAN controller's receive buffer.
#[derive(Debug, Default)]
pub struct Outbox {
    frames: Deque<Received, OUTBOX_CAPACITY>,
    lost: u64,
}

impl Outbox {
    /// An empty queue.
    pub const fn new() -> Self {
        Self { frames: Deque::new(), lost: 0 }
    }

    /// Appends a frame sent at `at`.
    pub fn push(&mut self, frame: Frame, at: Instant) {
        if self.frames.push_back(Received { frame, at }).is_err() {
            self.lost = self.lost.saturating_add(1);
        }
    }

    /// The oldest frame.
    pub fn pop(&mut self) -> Option<Received> {
        self.frames.pop_front()
    }

    /// True if no frame waits.
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// How many frames did not fit, since the beginning.
    pub const fn lost(&self) -> u64 {
        self.lost
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use uarm_io::drive::wire::sync_frame;

    #[test]
    fn keeps_the_order_and_counts_what_does_not_fit() {
        let mut outbox = Outbox::new();
        for count in 0..OUTBOX_CAPACITY + 3 {
            outbox.push(sync_frame(u8::try_from(count % 240).unwrap()), Instant::default());
        }
        assert_eq!(outbox.lost(), 3);
        assert_eq!(outbox.pop().unwrap().frame, sync_frame(0));
        assert_eq!(outbox.pop().unwrap().frame, sync_frame(1));
    }
}
