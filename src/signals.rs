//! Signals that ask a run to end; it then brakes and reports as it does at any other end.

use std::io::{self, Read};
use std::os::unix::net::UnixStream;
use std::thread;

use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM};
use signal_hook::low_level::pipe;
use uarm_loop::stop_request::StopRequest;

/// Ctrl-C, `kill`, and Ctrl-\, which would otherwise leave the last torque standing until the drives' own watchdogs act.
const ENDING: [i32; 3] = [SIGINT, SIGTERM, SIGQUIT];

/// A request that SIGINT, SIGTERM and SIGQUIT make; SIGHUP too, which a closed terminal sends, unless this process was started
/// with SIGHUP ignored, as `nohup` does. The handler makes the first itself; a thread counts them, since two in one cycle are two.
///
/// # Errors
/// If the handlers cannot be installed.
pub fn stop_request() -> io::Result<StopRequest> {
    let request = StopRequest::default();
    let status = std::fs::read_to_string("/proc/self/status")?;
    let hang_up = (!is_ignored(&status, SIGHUP)).then_some(SIGHUP);
    let (mut signals, from_handlers) = UnixStream::pair()?;
    for signal in ENDING.into_iter().chain(hang_up) {
        signal_hook::flag::register(signal, request.flag())?;
        pipe::register(signal, from_handlers.try_clone()?)?;
    }
    let counted = request.clone();
    thread::Builder::new().name("signals".to_owned()).spawn(move || {
        let mut signal = [0];
        // A byte for each; the handlers' end is never closed.
        while signals.read_exact(&mut signal).is_ok() {
            counted.make();
        }
    })?;
    Ok(request)
}

/// Whether a process with this `/proc/PID/status` ignores `signal`: bit `signal - 1` of the hexadecimal mask `SigIgn` (proc(5)).
fn is_ignored(status: &str, signal: i32) -> bool {
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:")).map(str::trim);
    let mask = mask.and_then(|mask| u64::from_str_radix(mask, 16).ok()).unwrap_or(0);
    let bit = u32::try_from(signal - 1).ok().and_then(|shift| 1_u64.checked_shl(shift)).unwrap_or(0);
    mask & bit != 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_signals_one_after_the_other_are_two_requests() {
        let request = stop_request().unwrap();
        signal_hook::low_level::raise(SIGINT).unwrap();
        assert!(request.is_made(), "the handler has set it");
        signal_hook::low_level::raise(SIGINT).unwrap();
        while request.count() < 2 {
            thread::yield_now();
        }
    }

    #[test]
    fn each_signal_that_asks_for_the_end_is_a_request() {
        let status = std::fs::read_to_string("/proc/self/status").unwrap();
        // A test that was started with `nohup` ignores it, and so does the run.
        let hang_up = (!is_ignored(&status, SIGHUP)).then_some(SIGHUP);
        for signal in [SIGINT, SIGTERM, SIGQUIT].into_iter().chain(hang_up) {
            let request = stop_request().unwrap();
            signal_hook::low_level::raise(signal).unwrap();
            assert!(request.is_made(), "signal {signal}");
        }
    }

    #[test]
    fn the_mask_of_ignored_signals_is_read() {
        let status = "Name:\tuarm\nSigBlk:\t00000000ffffffff\nSigIgn:\t0000000000001001\nSigCgt:\t0000000000000000\n";
        assert!(is_ignored(status, SIGHUP), "bit 0 is signal 1");
        assert!(is_ignored(status, 13), "bit 12 is signal 13");
        assert!(!is_ignored(status, SIGINT) && !is_ignored(status, SIGTERM));
        assert!(!is_ignored("Name:\tuarm\n", SIGHUP));
    }
}
