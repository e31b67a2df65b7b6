//! A run log is read without a panic, whatever its bytes.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;
use uarm::dimensions::RunLog;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(log) = RunLog::<3, 2>::read_from(bytes, Path::new("fuzzed.mcap")) {
        assert!(log.gaps() < log.cycles.len().max(1), "a gap lies between two cycles");
    }
});
