//! A robot file is read, and refused if it makes no robot, without a panic.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;
use uarm::robot::Robot;

fuzz_target!(|text: &str| {
    let name = Path::new("fuzzed.toml");
    let _ = Robot::parse(name, text, &Default::default());
    let _ = Robot::<3, 3>::of_text(name, text, &Default::default());
});
