//! How others ask a running loop to end.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};

/// Asks a loop to end; it then brakes and reports as it does at any other end. Reading it never waits.
///
/// A signal handler, which cannot count, sets the [`flag`](StopRequest::flag): that is one request, however often it is set.
#[derive(Clone, Debug, Default)]
pub struct StopRequest {
    flag: Arc<AtomicBool>,
    made: Arc<AtomicU8>,
}

impl StopRequest {
    /// Asks for the end. It cannot be taken back.
    pub fn make(&self) {
        // The closure always has a next value.
        let _ = self.made.fetch_update(Ordering::AcqRel, Ordering::Acquire, |made| Some(made.saturating_add(1)));
    }

    /// Whether somebody has asked for the end.
    pub fn is_made(&self) -> bool {
        self.count() > 0
    }

    /// How often somebody has asked; the flag alone counts once, and not beside what was [made](StopRequest::make).
    pub fn count(&self) -> u8 {
        self.made.load(Ordering::Acquire).max(u8::from(self.flag.load(Ordering::Acquire)))
    }

    /// The flag itself: setting it asks for the end.
    pub fn flag(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.flag)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_request_counts_also_between_two_looks() {
        let request = StopRequest::default();
        assert_eq!((request.is_made(), request.count()), (false, 0));
        request.make();
        request.make();
        assert_eq!((request.is_made(), request.count()), (true, 2));
        for _ in 0..300 {
            request.make();
        }
        assert_eq!(request.count(), u8::MAX);
    }

    /// A handler sets the flag at once, and whoever counts signals follows.
    #[test]
    fn the_flag_is_the_first_request_and_no_further_one() {
        let request = StopRequest::default();
        request.flag().store(true, Ordering::Release);
        assert_eq!((request.is_made(), request.count(), request.count()), (true, 1, 1));
        request.make();
        assert_eq!(request.count(), 1);
        request.make();
        assert_eq!(request.count(), 2);
    }
}
