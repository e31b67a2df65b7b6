//! `uarm plant` and `uarm run` with ODrive axes as two processes on a real `vcan0`: what the axes do when the controller is
//! killed. That the motion is the one in process is asserted in `vcan_motion.rs`. The observer knows the frames from the maker's documentation alone.
//!
//! Run by `tools/test vcan`, or one test by hand as docs/testing.md tells.

mod vcan_support;

use std::time::Duration;

use rustix::process::Signal;
use vcan_support::bus::{Bus, Seen};
use vcan_support::odrive::{HEARTBEAT, command, id, plant, robot_file};
use vcan_support::process::{Running, finish};
use vcan_support::{INTERFACE, NODES, Workshop};

/// Command id (ODrive CAN protocol).
const SET_INPUT_TORQUE: u16 = 0x0E;
/// Axis states.
const IDLE: u8 = 1;
const CLOSED_LOOP_CONTROL: u8 = 8;
/// Axis error WATCHDOG_TIMER_EXPIRED.
const WATCHDOG_TIMER_EXPIRED: u32 = 0x0100_0000;

/// `controller_timeout_ms` and `drive_heartbeat_ms` in robots/uarm-odrive.toml.
const WATCHDOG: Duration = Duration::from_millis(50);
const HEARTBEAT_PERIOD: Duration = Duration::from_millis(50);
/// How much later an emulated axis may act on a machine that is not a real-time one.
const SCHEDULING_SLACK: Duration = Duration::from_millis(100);
/// Longer than any run of this file.
const LONG: Duration = Duration::from_secs(60);

fn heartbeat(seen: &Seen) -> (u32, u8) {
    (u32::from_le_bytes(seen.data[..4].try_into().unwrap()), seen.data[4])
}

#[test]
fn the_watchdogs_disarm_the_axes_when_the_controller_is_killed() {
    let workshop = Workshop::new("odrive-sigkill");
    let robot = robot_file(&workshop);
    let bus = Bus::open();
    let _plant = plant(&workshop, &bus, &robot, &["--pacing", "wall-clock"]);
    let running = Running::start(&mut command(
        &workshop,
        &["run", "--can", INTERFACE, "--rt", "prefer", "--log", "none"],
        &robot,
    ));
    let torque = |seen: &Seen| seen.id == id(2, SET_INPUT_TORQUE);
    bus.wait_for("torque", LONG, |seen| torque(seen) && seen.data != [0; 4]);
    for node in NODES {
        let armed = |seen: &Seen| seen.id == id(node, HEARTBEAT) && heartbeat(seen) == (0, CLOSED_LOOP_CONTROL);
        bus.wait_for("heartbeat of an armed axis", LONG, armed);
    }

    bus.drain();
    let mut last_torque = bus.wait_for("torque", LONG, torque).at;
    running.signal(Signal::KILL);
    let mut waiting = NODES.to_vec();
    while !waiting.is_empty() {
        let disarmed = |seen: &Seen| waiting.iter().any(|node| seen.id == id(*node, HEARTBEAT)) && seen.data[4] == IDLE;
        let seen = bus.wait_for("disarmed axis", LONG, |seen| torque(seen) || disarmed(seen));
        if torque(&seen) {
            last_torque = seen.at;
            continue;
        }
        assert_eq!(heartbeat(&seen), (WATCHDOG_TIMER_EXPIRED, IDLE), "{seen:02X?}");
        let silence = seen.at.duration_since(last_torque).unwrap();
        println!("axis {}: told {silence:?} after the last torque that its watchdog has disarmed it", seen.id / 32);
        assert!(silence >= WATCHDOG, "too early: {silence:?}");
        assert!(silence <= WATCHDOG + HEARTBEAT_PERIOD + SCHEDULING_SLACK, "too late: {silence:?}");
        waiting.retain(|node| seen.id != id(*node, HEARTBEAT));
    }

    // The next run starts in spite of the errors that the axes are left with.
    let again = ["run", "--can", INTERFACE, "--rt", "prefer", "--overrun", "catch-up", "--log", "none"];
    finish(&mut command(&workshop, &again, &robot));
}
