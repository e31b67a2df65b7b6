//! The controller and the simulated robot as two processes on a real `vcan0`: what the drives do when the controller or the
//! bus goes away. No timing is measured here; see `vcan_timing.rs`, and `vcan_motion.rs` for the motion.
//!
//! Run by `tools/test vcan`, or one test by hand as docs/testing.md tells.

mod vcan_support;

use rustix::process::Signal;
use std::time::Duration;
use vcan_support::bus::{Bus, EMERGENCY, HEARTBEAT, HEARTBEAT_ERROR, NMT, NMT_STOP, RPDO1, Seen};
use vcan_support::process::{Robot, Running, Scheduling, controller, describe, finish, set_interface};
use vcan_support::{NODES, Workshop};

/// `controller_timeout_ms` and `controller_node` in robots/uarm.toml.
const CONTROLLER_TIMEOUT: Duration = Duration::from_millis(50);
const CONTROLLER_NODE: u8 = 127;

/// How much later than its deadline an emulated drive may notice on a machine that is not a real-time one.
const SCHEDULING_SLACK: Duration = Duration::from_millis(100);

/// Far into the motion: the paper's task lasts 3 s, and its joints are fastest in the middle.
const IN_MOTION: Duration = Duration::from_millis(1_500);

/// Longer than any run of this file.
const LONG: Duration = Duration::from_secs(60);

fn drives_have_braked(bus: &Bus) -> bool {
    let before = NODES.map(|node| bus.position(node));
    std::thread::sleep(Duration::from_millis(50));
    NODES.iter().all(|node| !bus.is_enabled(*node)) && before == NODES.map(|node| bus.position(node))
}

/// Starts a run, and returns it when the arm is in full motion.
fn start_moving(workshop: &Workshop, bus: &Bus) -> Running {
    let running = Running::start(&mut controller(workshop, &[]));
    bus.wait_for("torque command", LONG, |seen| seen.id == RPDO1 + 2 && seen.u16(2) != 0);
    std::thread::sleep(IN_MOTION);
    running
}

#[test]
fn drives_brake_within_the_heartbeat_time_when_the_controller_is_killed() {
    let workshop = Workshop::new("sigkill");
    let bus = Bus::open();
    let _robot = Robot::start(&workshop, &bus, Scheduling::Ordinary, &["--pacing", "wall-clock"]);
    let running = start_moving(&workshop, &bus);
    assert!(NODES.iter().all(|node| bus.reports_enabled(*node)), "the drives run before the controller is killed");

    bus.drain();
    let is_controller = |seen: &Seen| seen.id == HEARTBEAT + u16::from(CONTROLLER_NODE);
    let mut heard = bus.wait_for("heartbeat of the controller", LONG, is_controller).at;
    running.signal(Signal::KILL);
    let mut waiting = NODES.to_vec();
    while !waiting.is_empty() {
        let seen = bus.wait_for("emergency message", LONG, |seen| is_controller(seen) || is_emergency(seen));
        if !is_emergency(&seen) {
            heard = seen.at;
            continue;
        }
        assert_eq!(seen.u16(0), HEARTBEAT_ERROR, "{seen:02X?}");
        let silence = seen.at.duration_since(heard).unwrap();
        println!("node {}: braked {silence:?} after the last heartbeat", seen.id - EMERGENCY);
        assert!(silence >= CONTROLLER_TIMEOUT, "braked too early: {silence:?}");
        assert!(silence <= CONTROLLER_TIMEOUT + SCHEDULING_SLACK, "braked too late: {silence:?}");
        waiting.retain(|node| seen.id != EMERGENCY + u16::from(*node));
    }
    assert!(drives_have_braked(&bus));
}

fn is_emergency(seen: &Seen) -> bool {
    NODES.iter().any(|node| seen.id == EMERGENCY + u16::from(*node)) && seen.data.len() == 8
}

#[test]
fn an_interface_that_goes_down_ends_the_run_with_a_clear_error_and_brakes() {
    let workshop = Workshop::new("down");
    let bus = Bus::open();
    let mut robot = Robot::start(&workshop, &bus, Scheduling::Ordinary, &["--pacing", "wall-clock"]);
    let running = start_moving(&workshop, &bus);
    set_interface("down");
    let output = running.end();
    // Longer than the drives bear the controller's silence.
    std::thread::sleep(2 * CONTROLLER_TIMEOUT + SCHEDULING_SLACK);
    set_interface("up");

    assert_eq!(output.status.code(), Some(1), "{}", describe(&output));
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(message.contains("vcan0") && message.contains("down"), "the message says what happened: {message}");
    assert!(robot.is_alive(), "drives outlive their bus");
    assert!(drives_have_braked(&bus));
    // Nothing is left over that would hinder the next run.
    drop(robot);
    let _robot = Robot::start(&workshop, &bus, Scheduling::Ordinary, &[]);
    finish(&mut controller(&workshop, &[]));
}

#[test]
fn signals_end_a_run_with_torque_zero_quick_stop_brakes_and_nmt_stop() {
    let workshop = Workshop::new("signals");
    let bus = Bus::open();
    for terminating in [Signal::INT, Signal::TERM, Signal::HUP, Signal::QUIT] {
        let _robot = Robot::start(&workshop, &bus, Scheduling::Ordinary, &["--pacing", "wall-clock"]);
        let running = start_moving(&workshop, &bus);
        bus.drain();
        running.signal(terminating);
        let output = running.end();
        let seen = bus.drain();

        for node in NODES {
            let commands = || seen.iter().filter(|seen| seen.id == RPDO1 + u16::from(node));
            let last = commands().next_back().unwrap_or_else(|| panic!("{terminating:?}: no command to node {node}"));
            assert_eq!(last.u16(2), 0, "{terminating:?}: torque in the last command to node {node}");
            // CiA 402: quick stop is bit 2 cleared with bit 1 set.
            assert!(
                commands().any(|command| command.u16(0) & 0b110 == 0b010),
                "{terminating:?}: quick stop of node {node}"
            );
        }
        let stop = |seen: &Seen| seen.id == NMT && seen.data.first() == Some(&NMT_STOP);
        assert!(seen.iter().any(stop), "{terminating:?}: NMT stop");
        assert!(describe(&output).contains("loop"), "{terminating:?}: a summary ends the run: {}", describe(&output));
    }
}

#[test]
fn a_drive_that_is_not_what_the_robot_file_says_is_refused() {
    let workshop = Workshop::new("mismatch");
    let bus = Bus::open();
    let _robot = Robot::start(&workshop, &bus, Scheduling::Ordinary, &[]);
    workshop.write_robot(&[("counts_per_revolution = 33739", "counts_per_revolution = 8000")]);
    let output = controller(&workshop, &[]).output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", describe(&output));
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(message.contains("33739") && message.contains("8000"), "found and expected: {message}");
    // CiA 402: bit 3 of the controlword enables operation, which opens the brake.
    let enables = |seen: &Seen| NODES.iter().any(|node| seen.id == RPDO1 + u16::from(*node)) && seen.u16(0) & 0x08 != 0;
    assert!(!bus.drain().iter().any(enables), "no drive was enabled");
}
