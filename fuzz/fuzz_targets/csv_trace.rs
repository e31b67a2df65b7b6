//! A CSV file is read without a panic, whatever its bytes.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;
use uarm::commands::train::points;

fuzz_target!(|bytes: &[u8]| {
    let _ = points::from_csv::<points::PointsError, 3, 2>(Path::new("fuzzed.csv"), bytes, |_| Ok(()));
});
