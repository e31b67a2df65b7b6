//! `uarm drive` on a real `vcan0`, with `uarm plant` as the bus. What it sends is seen by an observer that shares no code with
//! it.

mod vcan_support;

use rustix::process::Signal;
use serde_json::Value;
use std::process::Output;
use std::time::Duration;
use vcan_support::bus::{Bus, NMT, NMT_START, Seen};
use vcan_support::process::{Robot, Running, Scheduling, controller, describe, finish, succeed};
use vcan_support::{DRIVEN_NODE, INTERFACE, Workshop};

/// SDO requests: base, plus node (CiA 301).
const SDO_REQUEST: u16 = 0x600;
/// The command specifiers *initiate upload* and *upload segment*, upper three bits of the first byte (CiA 301, 7.2.4.3).
const UPLOADS: [u8; 2] = [2, 3];

/// NMT *stop remote node* to node 2 (CiA 301, 7.2.8.3.1).
const NMT_STOP_NODE_2: [u8; 2] = [2, 2];
/// RPDO1 of node 2, the first driven joint.
const COMMAND: u16 = 0x202;
/// Bit 4 of the controlword in homing mode (CiA 402-2).
const HOMING_START: u16 = 0x10;
/// Longer than anything here takes, in a guest that computes what is stable too.
const LONG: Duration = Duration::from_secs(120);

/// Runs `uarm drive` to its end, which must be a success.
fn drive(workshop: &Workshop, arguments: &[&str]) -> Output {
    succeed(workshop.command().args(["drive"]).args(arguments))
}

fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {}", describe(output)))
}

/// Nothing but SDO uploads, and the drives' own frames.
fn only_reads(seen: &[Seen]) -> bool {
    let answers = |id: u16| matches!(id & 0x780, 0x580 | 0x700 | 0x080) && id & 0x7F != 0;
    let reads = |seen: &Seen| seen.id & 0x780 == SDO_REQUEST && UPLOADS.contains(&(seen.data[0] >> 5));
    seen.iter().all(|seen| answers(seen.id) || reads(seen))
}

#[test]
fn a_scan_finds_each_drive_and_changes_nothing() {
    let workshop = Workshop::new("scan");
    let bus = Bus::open();
    let _robot = Robot::start(&workshop, &bus, Scheduling::Ordinary, &[]);
    bus.drain();
    let found = json(&drive(&workshop, &["scan", "--can", INTERFACE, "--seconds", "1", "--json"]));
    let identities = found["identities"].as_object().unwrap();
    assert_eq!(identities.keys().collect::<Vec<_>>(), ["1", "2", "3"]);
    assert_eq!(identities["2"]["serial"], 2);
    assert_eq!(identities["2"]["power_state"], "Switch on disabled");
    let seen = bus.drain();
    assert!(only_reads(&seen), "{seen:02X?}");
    assert!(seen.iter().any(|seen| seen.id == SDO_REQUEST + 126), "every node id is asked");
}

#[test]
fn a_passive_scan_sends_nothing_and_says_that_nobody_was_heard() {
    let workshop = Workshop::new("passive");
    let bus = Bus::open();
    let _robot = Robot::start(&workshop, &bus, Scheduling::Ordinary, &[]);
    bus.drain();
    let arguments = ["drive", "scan", "--can", INTERFACE, "--seconds", "1", "--passive"];
    let output = workshop.command().args(arguments).output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", describe(&output));
    assert!(describe(&output).contains("no node found"), "{}", describe(&output));
    assert_eq!(bus.drain().len(), 0);
}

#[test]
fn a_scan_beside_a_run_tells_of_its_master_and_leaves_it_alone() {
    let workshop = Workshop::new("beside");
    let bus = Bus::open();
    let _robot = Robot::start(&workshop, &bus, Scheduling::Ordinary, &[]);
    let running = Running::start(&mut controller(&workshop, &["--hold", "5s"]));
    bus.wait_for("torque", LONG, |seen| seen.id == COMMAND && seen.u16(2) != 0);
    let found = json(&drive(&workshop, &["scan", "--can", INTERFACE, "--seconds", "1", "--json"]));
    let master = found["master"].as_array().unwrap();
    assert!(master.iter().any(|sign| sign == "SYNC"), "{found}");
    assert!(found["not_asked"].is_string(), "{found}");
    // 3 ms, the paper's period; a guest's tick may be late.
    let period = found["heard"]["sync"]["period_ms"].as_f64().unwrap();
    assert!((2.9..3.5).contains(&period), "{period}");
    assert_eq!(found["heard"]["nodes"]["2"]["nmt_state"], "Operational");
    let is_request = |seen: &Seen| seen.id & 0x780 == SDO_REQUEST;
    assert!(!bus.drain().iter().rev().take(100).any(is_request), "no SDO request in the cycle");
    let output = running.end();
    assert!(matches!(output.status.code(), Some(0 | 3)), "{}", describe(&output));
}

#[test]
fn the_direction_of_a_joint_that_nobody_turns_is_not_told() {
    let workshop = Workshop::new("direction");
    let bus = Bus::open();
    let _robot = Robot::start(&workshop, &bus, Scheduling::Ordinary, &[]);
    bus.drain();
    let arguments = ["drive", "direction", "--can", INTERFACE, "--node", "2", "--seconds", "1"];
    let output = workshop.command().args(arguments).output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", describe(&output));
    assert!(describe(&output).contains("was not turned"), "{}", describe(&output));
    let seen = bus.drain();
    assert!(seen.len() > 20 && only_reads(&seen), "{seen:02X?}");
}

/// The robot file of both, controller and plant: joint 2 is incremental, and 6081h of its drive, volatile and used by nobody, is the marker.
const INCREMENTAL: (&str, &str) = (
    "node = 2\nencoder = { counts_per_revolution = 33739, counter_bits = 32, direction = \"positive\", zero_counts = 0",
    "node = 2\nencoder = { counts_per_revolution = 33739, counter_bits = 32, direction = \"positive\", zero_counts = 0, \
     reference = \"incremental\", power_marker = { index = 0x6081, subindex = 0, type = \"u32\", value = 77 }",
);
#[test]
fn an_incremental_robot_runs_with_a_reference_only_and_not_after_its_power_was_lost() {
    let workshop = Workshop::new("reference");
    let bus = Bus::open();
    workshop.write_robot(&[INCREMENTAL]);
    let robot = Robot::start(&workshop, &bus, Scheduling::Ordinary, &[]);
    let refused = |reason: &str| {
        let output = controller(&workshop, &["--log", "none"]).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{}", describe(&output));
        let message = describe(&output);
        assert!(message.contains(reason) && message.contains("uarm drive reference --robot"), "{message}");
    };
    bus.drain();
    refused("is not referenced");
    assert!(only_reads(&bus.drain()), "a robot that is not referenced gets no command");

    let robot_file = workshop.robot();
    let set =
        ["reference", "--robot", robot_file.to_str().unwrap(), "--can", INTERFACE, "--angles", "0,20,20", "--yes"];
    let stored = json(&drive(&workshop, &[set.as_slice(), &["--json"]].concat()));
    // The counter began at zero where the joint stands, at 20 of 360 degrees, of 33739 counts: 1874.4.
    assert_eq!(stored["references"]["joints"][0]["position_counts"], 0);
    assert_eq!(stored["references"]["joints"][0]["zero_counts"], -1874);
    assert_eq!(stored["references"]["joints"][0]["serial"], 2);
    // Twice: the run's own reset of the communication is no loss of power.
    for _ in 0..2 {
        let output = finish(&mut controller(&workshop, &["--log", "none"]));
        assert!(describe(&output).contains("joint 2: reference of "), "{}", describe(&output));
    }

    drop(robot);
    let _robot = Robot::start(&workshop, &bus, Scheduling::Ordinary, &[]);
    refused("has lost its power");
}

/// As [`INCREMENTAL`], and the drive homes: to the index at 0 degrees, from 20, at 937 counts or 10 degrees per second.
const HOMES: (&str, &str) = (
    INCREMENTAL.0,
    "node = 2\nencoder = { counts_per_revolution = 33739, counter_bits = 32, direction = \"positive\", zero_counts = 0, \
     reference = \"incremental\", power_marker = { index = 0x6081, subindex = 0, type = \"u32\", value = 77 }, \
     homing = { method = 33, speeds = [2812, 937], acceleration = 20000, angle_deg = 0.0, travel_deg = 40.0 }",
);

#[test]
fn a_drive_homes_and_its_reference_is_stored() {
    let workshop = Workshop::new("homing");
    let bus = Bus::open();
    workshop.write_robot(&[HOMES]);
    let _robot = Robot::start(&workshop, &bus, Scheduling::Ordinary, &[]);
    // The counter began at zero where the joint stood.
    assert_eq!(bus.position(DRIVEN_NODE), 0);
    bus.drain();
    let homing = ["reference", "--can", INTERFACE, "--homing", "--node", "2", "--yes", "--rt", "prefer", "--json"];
    let mut command = workshop.command();
    let mut running = Running::start(command.arg("drive").args(homing).arg("--robot").arg(workshop.robot()));
    // A socket holds no more than a second of this.
    let mut seen = Vec::new();
    while running.is_alive() {
        seen.extend(bus.next(Duration::from_millis(1)));
        seen.extend(bus.drain());
    }
    seen.extend(bus.drain());
    let stored = json(&running.end());
    let reference = &stored["references"]["joints"][0];
    assert_eq!((&reference["node"], &reference["serial"]), (&Value::from(2), &Value::from(2)));
    assert_eq!((&reference["homing_method"], &reference["position_counts"]), (&Value::from(33), &Value::from(0)));
    let commands = || seen.iter().filter(|seen| seen.id == COMMAND);
    assert!(commands().any(|seen| seen.u16(0) & HOMING_START != 0), "homing was started");
    assert!(commands().all(|seen| seen.u16(2) == 0), "the drive turns its motor by itself");
    assert!(!seen.iter().any(|seen| matches!(seen.id, 0x201 | 0x203)), "the other drives get no command");
    assert!(seen.iter().any(|seen| seen.id == 0 && seen.data == NMT_STOP_NODE_2), "NMT stop");
    // 6064h is zero at the index now. How far behind it the motor stopped depends on when this machine let the master stop it; the travel
    // of 40 degrees ends 20 behind it, at 1874 counts.
    bus.send(NMT, &[NMT_START, DRIVEN_NODE]);
    assert!(!bus.is_enabled(DRIVEN_NODE), "its brake is closed");
    let counts = bus.position(DRIVEN_NODE);
    assert!((-1_874..=0).contains(&counts), "{counts} counts from home");
}

/// What is wanted of joint 2's drive is not what the emulated drive has.
const OTHER_RESOLUTION: (&str, &str) =
    ("node = 2\nencoder = { counts_per_revolution = 33739,", "node = 2\nencoder = { counts_per_revolution = 8192,");

/// From the drive itself: as a dictionary is judged, read and not written to.
#[test]
fn a_drive_on_the_bus_is_judged_and_only_read() {
    let workshop = Workshop::new("check");
    let bus = Bus::open();
    let _robot = Robot::start(&workshop, &bus, Scheduling::Ordinary, &[]);
    let check = |node: &str, robot_file: &std::path::Path, more: &[&str]| {
        let arguments = ["drive", "check", "--can", INTERFACE, "--node", node, "--robot"];
        let output = workshop.command().args(arguments).arg(robot_file).args(more).output().unwrap();
        (output.status.code(), output)
    };
    bus.drain();
    let (code, works) = check("2", &workshop.robot(), &["--json"]);
    assert_eq!(code, Some(0), "{}", describe(&works));
    let seen = bus.drain();
    assert!(seen.len() > 20 && only_reads(&seen), "{seen:02X?}");
    let found = json(&works);
    assert_eq!((&found["node"], &found["verdict"]), (&Value::from(2), &Value::from("works")));
    assert!(found["rows"].as_array().unwrap().iter().all(|row| row["verdict"] != "no"), "{found:#}");

    let other = workshop.write_robot_as("other.toml", &[OTHER_RESOLUTION]);
    let (code, works_with) = check("2", &other, &["--json"]);
    assert_eq!(code, Some(3), "{}", describe(&works_with));
    let found = json(&works_with);
    let joint = found["joint"].as_str().unwrap();
    assert!(joint.contains("counts_per_revolution = 33739"), "{joint}");
    let (_, printed) = check("2", &other, &[]);
    assert!(describe(&printed).contains(joint), "the entry is printed as TOML too: {}", describe(&printed));

    // The drive of node 2 is asked for by node 9: nobody answers.
    let (code, silent) = check("9", &workshop.write_robot_as("nine.toml", &[("node = 2\n", "node = 9\n")]), &[]);
    assert_eq!(code, Some(1), "{}", describe(&silent));
    assert!(describe(&silent).contains("node 9 did not answer"), "{}", describe(&silent));
}

#[test]
fn a_torque_test_that_is_interrupted_brakes_and_nobody_else_gets_a_torque() {
    let workshop = Workshop::new("torque");
    let bus = Bus::open();
    let _robot = Robot::start(&workshop, &bus, Scheduling::Ordinary, &[]);
    let robot_file = workshop.robot();
    let test =
        ["drive", "torque-test", "--can", INTERFACE, "--node", "2", "--per-mille", "20", "--rt", "prefer", "--robot"];
    let refused = workshop.command().args(test).arg(&robot_file).output().unwrap();
    assert_eq!(refused.status.code(), Some(1));
    assert!(describe(&refused).contains("no terminal"), "{}", describe(&refused));
    bus.drain();

    let running = Running::start(workshop.command().args(test).arg(&robot_file).arg("--yes"));
    bus.wait_for("torque", LONG, |seen| seen.id == COMMAND && seen.u16(2) != 0);
    running.signal(Signal::INT);
    let output = running.end();
    assert_eq!(output.status.code(), Some(1), "{}", describe(&output));
    assert!(
        describe(&output).contains("Interrupted") && describe(&output).contains("brake closed"),
        "{}",
        describe(&output)
    );
    let seen = bus.drain();
    let last = seen.iter().rev().find(|seen| seen.id == COMMAND).expect("commands");
    assert_eq!(last.u16(2), 0, "torque in the last command");
    // CiA 402: quick stop is bit 2 cleared with bit 1 set.
    assert!(seen.iter().any(|seen| seen.id == COMMAND && seen.u16(0) & 0b110 == 0b010), "quick stop");
    assert!(seen.iter().any(|seen| seen.id == 0 && seen.data == NMT_STOP_NODE_2), "NMT stop");
    assert!(!seen.iter().any(|seen| matches!(seen.id, 0x201 | 0x203)), "the other drives get no command");
}
