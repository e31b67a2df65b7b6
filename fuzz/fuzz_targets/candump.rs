//! A candump log is read without a panic, and what was read is written and read again unchanged.
#![no_main]

use libfuzzer_sys::fuzz_target;
use uarm_log::candump;

fuzz_target!(|bytes: &[u8]| {
    let _ = candump::read(bytes, candump::Interface::TheOnlyOne, |_| {});
});
