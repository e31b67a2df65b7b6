//! How others ask a running loop to end.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Asks a loop to end; it then brakes and reports as it does at any other end. Reading it never waits.
///
/// The flag may be shared with a signal handler: see [`StopRequest::flag`].
#[derive(Clone, Debug, Default)]
pub struct StopRequest(Arc<AtomicBool>);

impl StopRequest {
    /// Asks for the end. It cannot be taken back.
    pub fn make(&self) {
        self.0.store(true, Ordering::Release);
    }

    /// Whether somebody has asked for the end.
    pub fn is_made(&self) -> bool {
        self.0.load(Ordering::Acquire)
    }

    /// The flag itself: setting it asks for the end.
    pub fn flag(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.0)
    }
}
