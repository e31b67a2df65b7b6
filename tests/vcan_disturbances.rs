//! What must not pass for the robot's own drives or master, on a real `vcan0`: another master, drives that boot anew, two
//! drives with one node id.
//!
//! Run by `tools/test vcan`, or one test by hand as docs/testing.md tells.

mod vcan_support;

use rustix::process::Signal;
use std::process::{Command, Output};
use std::time::Duration;
use vcan_support::bus::{Bus, HEARTBEAT, NMT, RPDO1, SDO_REQUEST, Seen, TPDO1};
use vcan_support::process::{Robot, Running, Scheduling, controller, describe, finish};
use vcan_support::{NODES, Workshop};

/// Longer than any run of this file.
const LONG: Duration = Duration::from_secs(60);

/// Longer than a start, and shorter than start and motion together.
const IN_MOTION: Duration = Duration::from_millis(1_500);

/// From the first torque: a third of the motion of 3 s, so that a second run has time to be refused.
const FAST: Duration = Duration::from_millis(1_000);

/// The heartbeat of a node that has just booted (CiA 301).
const BOOT_UP: u8 = 0;

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

/// A run that is in full motion.
fn start_moving(workshop: &Workshop, bus: &Bus) -> Running {
    bus.drain();
    let running = Running::start(&mut controller(workshop, &["--log", "none"]));
    bus.wait_for("torque command", LONG, |seen| seen.id == RPDO1 + u16::from(LAST) && seen.u16(2) != 0);
    std::thread::sleep(FAST);
    running
}

#[test]
fn a_drive_that_is_reset_between_its_settings_and_the_start_fails_the_start() {
    let workshop = Workshop::new("reset");
    let bus = Bus::open();
    let _robot = Robot::start(&workshop, &bus, Scheduling::Ordinary, &["--pacing", "wall-clock"]);
    let running = start_up_to_the_last_drive(&workshop, &bus);
    bus.reset(FIRST);
    // The reset itself is heard before the boot-up message that follows it.
    assert_fails(&running.end(), "another master is on this bus: it sent an NMT command (000h)");
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

/// A drive that resets itself, or whose supply was cut.
#[test]
fn a_drive_that_boots_between_its_settings_and_the_start_fails_the_start() {
    let workshop = Workshop::new("boots");
    let bus = Bus::open();
    let _robot = Robot::start(&workshop, &bus, Scheduling::Ordinary, &["--pacing", "wall-clock"]);
    let running = start_up_to_the_last_drive(&workshop, &bus);
    bus.send(HEARTBEAT + u16::from(FIRST), &[BOOT_UP]);
    assert_fails(&running.end(), "node 1 booted anew");
    assert!(bus.all_have_braked());
}

#[test]
fn a_drive_that_boots_in_the_motion_ends_the_run() {
    let workshop = Workshop::new("boots-moving");
    let bus = Bus::open();
    let _robot = Robot::start(&workshop, &bus, Scheduling::Ordinary, &["--pacing", "wall-clock"]);
    let running = start_moving(&workshop, &bus);
    bus.send(HEARTBEAT + u16::from(LAST), &[BOOT_UP]);
    assert_fails(&running.end(), "node 3 booted anew");
    assert!(bus.all_have_braked());
}

/// What another master may send: to drives of the robot, or to all; and what the controller says of it.
const FOREIGN: [(u16, &[u8], &str); 5] = [
    (NMT, &[0x01, 99], "an NMT command (000h)"),
    (0x080, &[7], "a SYNC (080h)"),
    (HEARTBEAT + 127, &[0x05], "a heartbeat of node 127, this master's own (77Fh)"),
    (0x300 + LAST as u16, &[0; 8], "an RPDO to node 3 (303h)"),
    (SDO_REQUEST + FIRST as u16, &[0x40, 0x00, 0x10, 0, 0, 0, 0, 0], "an SDO request to node 1 (601h)"),
];

fn is_of_a_master(seen: &Seen) -> bool {
    let to_drives =
        NODES.iter().any(|node| [RPDO1, SDO_REQUEST].map(|base| base + u16::from(*node)).contains(&seen.id));
    to_drives || [NMT, 0x080, HEARTBEAT + 127].contains(&seen.id)
}

#[test]
fn a_controller_that_hears_another_master_sends_nothing() {
    let workshop = Workshop::new("refused");
    let bus = Bus::open();
    let _robot = Robot::start(&workshop, &bus, Scheduling::Ordinary, &[]);
    for (id, data, words) in FOREIGN {
        bus.drain();
        let mut running = Running::start(&mut controller(&workshop, &["--log", "none"]));
        while running.is_alive() {
            bus.send(id, data);
            std::thread::sleep(Duration::from_millis(10));
        }
        assert_fails(&running.end(), words);
        let sent: Vec<Seen> = bus.drain().into_iter().filter(is_of_a_master).collect();
        assert!(sent.is_empty(), "{words}: {sent:02X?}");
    }
}

#[test]
fn another_master_ends_a_run_with_brakes() {
    let workshop = Workshop::new("another-master");
    let bus = Bus::open();
    let _robot = Robot::start(&workshop, &bus, Scheduling::Ordinary, &["--pacing", "wall-clock"]);
    for (id, data, words) in FOREIGN {
        let running = start_moving(&workshop, &bus);
        bus.send(id, data);
        assert_fails(&running.end(), &format!("another master is on this bus: it sent {words}"));
        assert!(bus.all_have_braked(), "{words}");
    }
}

#[test]
fn two_drives_with_one_node_id_fail_the_start() {
    let workshop = Workshop::new("one-id");
    let bus = Bus::open();
    let other = workshop.write_robot_as("other.toml", &[("node = 1", "node = 41"), ("node = 3", "node = 43")]);
    let _robot = Robot::start(&workshop, &bus, Scheduling::Ordinary, &[]);
    let _other = Robot::start_beside(&workshop, &bus, &other, 43);
    let output = controller(&workshop, &["--log", "none"]).output().unwrap();
    assert_fails(&output, "are there two drives with node id 2?");
    assert!(bus.all_have_braked());
}

#[test]
fn two_answers_to_one_sync_end_a_run_with_brakes() {
    let workshop = Workshop::new("twins");
    let bus = Bus::open();
    let _robot = Robot::start(&workshop, &bus, Scheduling::Ordinary, &["--pacing", "wall-clock"]);
    let running = start_moving(&workshop, &bus);
    bus.drain();
    // A second drive in the same place, so that nothing else is wrong with its answer.
    let answer = bus.wait_for("feedback", LONG, |seen| seen.id == TPDO1 + u16::from(LAST));
    bus.send(answer.id, &answer.data);
    assert_fails(&running.end(), "are there two drives with node id 3?");
    assert!(bus.all_have_braked());
}

#[test]
fn a_second_run_on_the_same_bus_is_refused_and_the_first_goes_on() {
    let workshop = Workshop::new("two-runs");
    let bus = Bus::open();
    let _robot = Robot::start(&workshop, &bus, Scheduling::Ordinary, &["--pacing", "wall-clock"]);
    let first = start_moving(&workshop, &bus);
    // It must not take the only CPU of a guest from the first, nor from the drives.
    let second = controller(&workshop, &["--log", "none", "--rt", "off"]);
    let second =
        Command::new("nice").args(["-n", "19"]).arg(second.get_program()).args(second.get_args()).output().unwrap();
    assert_fails(&second, "another master is on this bus: it sent ");
    assert!(
        String::from_utf8_lossy(&second.stderr).contains("nothing was sent to the drives"),
        "{}",
        describe(&second)
    );
    let output = first.end();
    // A deadline may be missed on a loaded machine.
    assert!(matches!(output.status.code(), Some(0 | 3)), "{}", describe(&output));
    // And the bus is free again.
    finish(&mut controller(&workshop, &["--log", "none"]));
}
