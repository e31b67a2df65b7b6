//! What must not pass for the robot's own drives or master, on a real `vcan0`: drives that boot anew.
//!
//! Run by `tools/test vcan`, or one test by hand as docs/testing.md tells.

mod vcan_support;

use rustix::process::Signal;
use std::process::Output;
use std::time::Duration;
use vcan_support::bus::{Bus, SDO_REQUEST};
use vcan_support::process::{Robot, Running, Scheduling, controller, describe};
use vcan_support::{NODES, Workshop};

/// Longer than any run of this file.
const LONG: Duration = Duration::from_secs(60);

/// Longer than a start, and shorter than start and motion together.
const IN_MOTION: Duration = Duration::from_millis(1_500);

/// Longer than the drives bear the controller's silence: `controller_timeout_ms` in robots/uarm.toml is 50.
const WATCHDOG: Duration = Duration::from_millis(200);

/// The first drive and the last, whose settings are written while the first has its own already.
const FIRST: u8 = NODES[0];
const LAST: u8 = NODES[NODES.len() - 1];

/// A run that failed, with these words on standard error.
fn assert_fails(output: &Output, words: &str) {
    assert_eq!(output.status.code(), Some(1), "{}", describe(output));
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(message.contains(words), "`{words}` in {message}");
}

/// A run that has begun to write the settings of the last drive.
fn start_up_to_the_last_drive(workshop: &Workshop, bus: &Bus) -> Running {
    bus.drain();
    let running = Running::start(&mut controller(workshop, &["--log", "none"]));
    bus.wait_for("SDO request", LONG, |seen| seen.id == SDO_REQUEST + u16::from(LAST));
    running
}

#[test]
fn a_drive_that_is_reset_between_its_settings_and_the_start_fails_the_start() {
    let workshop = Workshop::new("reset");
    let bus = Bus::open();
    let _robot = Robot::start(&workshop, &bus, Scheduling::Ordinary, &["--pacing", "wall-clock"]);
    let running = start_up_to_the_last_drive(&workshop, &bus);
    bus.reset(FIRST);
    assert_fails(&running.end(), "node 1 booted anew");
    assert!(bus.all_have_braked());
}

/// The drive has lost its watchdog with its settings: nothing but a start that fails keeps it from being left enabled.
#[test]
fn no_drive_stays_enabled_when_one_is_reset_before_the_start_and_the_controller_is_killed_after_it() {
    let workshop = Workshop::new("reset-kill");
    let bus = Bus::open();
    let _robot = Robot::start(&workshop, &bus, Scheduling::Ordinary, &["--pacing", "wall-clock"]);
    let running = start_up_to_the_last_drive(&workshop, &bus);
    bus.reset(FIRST);
    std::thread::sleep(IN_MOTION);
    running.signal(Signal::KILL);
    std::thread::sleep(WATCHDOG);
    assert!(bus.all_have_braked());
}
