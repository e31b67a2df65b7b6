//! What `uarm run --json` says, and what it must say of a loop that keeps time.

use serde_json::Value;
use std::process::Output;

use super::process::describe;

/// The report of a single run.
pub fn report(output: &Output) -> Value {
    let reports: Value =
        serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {}", describe(output)));
    reports[0].clone()
}

/// No cycle was late and none was left out.
pub fn assert_every_deadline_met(timing: &Value) {
    assert_eq!(timing["missed_deadlines"].as_u64(), Some(0), "{timing}");
    assert_eq!(timing["skipped_ticks"].as_u64(), Some(0), "{timing}");
}

/// Timing is measured in guest time, or not at all.
pub fn need_guest_time() {
    let mode = std::env::var("CAN_GUEST").unwrap_or_default();
    assert_eq!(mode, "icount", "timing is measured in guest time: tools/can-guest run --guest --mode icount");
}
