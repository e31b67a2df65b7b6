//! Signals that ask a run to end; it then brakes and reports as it does at any other end.

use std::io;

use signal_hook::consts::{SIGINT, SIGTERM};
use uarm_loop::stop_request::StopRequest;

/// A request that SIGINT and SIGTERM make.
///
/// # Errors
/// If the handlers cannot be installed.
pub fn stop_request() -> io::Result<StopRequest> {
    let request = StopRequest::default();
    for signal in [SIGINT, SIGTERM] {
        signal_hook::flag::register(signal, request.flag())?;
    }
    Ok(request)
}
