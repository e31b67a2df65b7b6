//! Time that passes when it is told to.

use alloc::sync::Arc;
use core::sync::atomic::Ordering;
use portable_atomic::AtomicU64;
use uarm_io::time::{Clock, Instant};

/// A clock whose time passes only when somebody sleeps on it, and then at once.
///
/// Clones are handles of the same time: the loop and the link each hold one.
///
/// ```
/// use uarm_sim::VirtualClock;
/// use uarm_io::time::{Clock, Instant};
///
/// let clock = VirtualClock::new();
/// let mut handle = clock.clone();
/// handle.sleep_until(Instant::from_nanoseconds(3_000_000));
/// assert_eq!(clock.now(), Instant::from_nanoseconds(3_000_000));
/// ```
#[derive(Clone, Debug, Default)]
pub struct VirtualClock(Arc<AtomicU64>);

impl VirtualClock {
    /// A clock at instant zero.
    pub fn new() -> Self {
        Self::default()
    }
}

impl Clock for VirtualClock {
    fn now(&self) -> Instant {
        Instant::from_nanoseconds(self.0.load(Ordering::Acquire))
    }

    /// Jumps to `deadline`, or stays if it has passed.
    fn sleep_until(&mut self, deadline: Instant) {
        self.0.fetch_max(deadline.nanoseconds(), Ordering::AcqRel);
    }
}
