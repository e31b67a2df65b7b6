//! SIGINT and SIGTERM ask the loop to end; it then brakes and reports as it does at any other end.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use signal_hook::consts::{SIGINT, SIGTERM};

/// Set once somebody asked for the end. Reading it never waits.
#[derive(Clone, Debug, Default)]
pub struct StopRequest(Arc<AtomicBool>);

impl StopRequest {
    /// A request that SIGINT and SIGTERM make.
    ///
    /// # Errors
    /// If the handlers cannot be installed.
    pub fn on_signals() -> io::Result<Self> {
        let request = Self::default();
        for signal in [SIGINT, SIGTERM] {
            signal_hook::flag::register(signal, Arc::clone(&request.0))?;
        }
        Ok(request)
    }

    /// Makes the request.
    pub fn make(&self) {
        self.0.store(true, Ordering::Release);
    }

    /// Was it made?
    pub fn is_made(&self) -> bool {
        self.0.load(Ordering::Acquire)
    }
}
