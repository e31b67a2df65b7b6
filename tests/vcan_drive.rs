//! `uarm drive` on a real `vcan0`, with `uarm plant` as the bus. What it sends is seen by an observer that shares no code with
//! it.

mod vcan_support;

use serde_json::Value;
use std::process::Output;
use vcan_support::bus::{Bus, Seen};
use vcan_support::process::{Robot, Running, Scheduling, controller, describe, succeed};
use vcan_support::{INTERFACE, Workshop};

/// SDO requests: base, plus node (CiA 301).
const SDO_REQUEST: u16 = 0x600;
/// The command specifiers *initiate upload* and *upload segment*, upper three bits of the first byte (CiA 301, 7.2.4.3).
const UPLOADS: [u8; 2] = [2, 3];

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
    bus.wait_for_motion();
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
