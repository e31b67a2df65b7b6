//! A robot file is read, and refused if it makes no robot, without a panic.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;
use uarm::robot::Robot;

fuzz_target!(|text: &str| {
    let _ = Robot::parse(Path::new("fuzzed.toml"), text, &Default::default());
});
