//! How others ask a running loop to end.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};

/// Asks a loop to end; it then brakes and reports as it does at any other end. Reading it never waits.
///
/// The flag may be shared with a signal handler: see [`StopRequest::flag`].
#[derive(Clone, Debug, Default)]
pub struct StopRequest {
    flag: Arc<AtomicBool>,
    /// How often the flag was found set.
    heard: Arc<AtomicU8>,
}

impl StopRequest {
    /// Asks for the end. It cannot be taken back.
    pub fn make(&self) {
        self.flag.store(true, Ordering::Release);
    }

    /// Whether somebody has asked for the end.
    pub fn is_made(&self) -> bool {
        self.flag.load(Ordering::Acquire) || self.heard.load(Ordering::Acquire) > 0
    }

    /// How often somebody has asked: requests between two looks are one. For whoever ends what is asked to end, and for nobody
    /// beside it.
    pub fn count(&self) -> u8 {
        let heard = self.heard.load(Ordering::Acquire);
        if !self.flag.swap(false, Ordering::AcqRel) {
            return heard;
        }
        let heard = heard.saturating_add(1);
        self.heard.store(heard, Ordering::Release);
        heard
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
    fn each_request_counts_once_and_none_is_forgotten() {
        let request = StopRequest::default();
        assert_eq!((request.is_made(), request.count()), (false, 0));
        request.flag().store(true, Ordering::Release);
        assert!(request.is_made());
        assert_eq!((request.count(), request.count()), (1, 1));
        assert!(request.is_made(), "it cannot be taken back");
        request.make();
        assert_eq!(request.count(), 2);
    }
}
