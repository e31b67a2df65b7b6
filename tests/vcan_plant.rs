//! `uarm plant` as a bench on a real `vcan0`: drives of makers' dictionaries, faults, the truth, and when it is ready.

mod dictionaries;
mod vcan_support;

use dictionaries::Dictionary;
use serde_json::Value;
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, Stdio};
use std::time::Duration;
use vcan_support::bus::{Bus, Seen};
use vcan_support::process::{controller, describe, finish};
use vcan_support::{INTERFACE, Workshop};

/// How long something that must come is waited for.
const PATIENCE: Duration = Duration::from_secs(20);

/// The emulated robot with its pipes; killed when dropped.
struct Plant {
    child: Child,
    input: ChildStdin,
}

impl Plant {
    /// Starts it, and waits for the line that says that it is ready.
    fn start(workshop: &Workshop, arguments: &[&str]) -> Self {
        let mut command = workshop.command();
        command.args(["plant", "--can", INTERFACE, "--robot"]).arg(workshop.robot()).args(arguments);
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        assert_eq!(line, "ready: nodes 1 2 3 on vcan0\n");
        let input = child.stdin.take().unwrap();
        Self { child, input }
    }
}

impl Drop for Plant {
    fn drop(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }
}

/// The entry that `uarm drive check` prints for a dictionary as joint `node`.
fn entry(workshop: &Workshop, dictionary: &str, node: &str) -> String {
    let robot = workshop.robot();
    let mut command = workshop.command();
    command.args(["drive", "check", "--json", "--eds", dictionary, "--node", node, "--robot"]).arg(robot);
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(3), "{}", describe(&output));
    let findings: Value = serde_json::from_slice(&output.stdout).unwrap();
    findings["joint"].as_str().unwrap().to_owned()
}

/// Puts an entry in the place of that of joint `node`.
fn replace_entry(workshop: &Workshop, node: &str, entry: &str) {
    let text = fs::read_to_string(workshop.robot()).unwrap();
    let begin = text.find(&format!("[[joints]]\nname = \"joint {node}\"")).unwrap();
    let length = text[begin + 1..].find("\n[[").or_else(|| text[begin + 1..].find("\n# ---")).unwrap() + 1;
    fs::write(workshop.robot(), format!("{}{entry}{}", &text[..begin], &text[begin + length..])).unwrap();
}

/// Drives of two makers, checked by their dictionaries, run the task with the entries that were printed and nothing else.
#[test]
fn bought_drives_run_the_task_with_the_printed_entries() {
    let workshop = Workshop::new("bought");
    fs::write(workshop.file("servo.eds"), Dictionary::servo().text()).unwrap();
    fs::write(workshop.file("bare.eds"), Dictionary::bare().text()).unwrap();
    for (node, dictionary) in [("2", "servo.eds"), ("3", "bare.eds")] {
        let entry = entry(&workshop, dictionary, node);
        replace_entry(&workshop, node, &entry);
    }
    let _bus = Bus::open();
    let _plant = Plant::start(&workshop, &["--eds", "servo.eds", "--node", "2", "--eds", "bare.eds", "--node", "3"]);
    let arguments = ["--overrun", "catch-up", "--log", "none", "--json"];
    let output = finish(&mut controller(&workshop, &arguments));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report[0]["completed"], true, "{}", describe(&output));
}

#[test]
fn a_drive_with_another_dictionary_than_the_robot_files_is_refused() {
    let workshop = Workshop::new("other-drive");
    fs::write(workshop.file("servo.eds"), Dictionary::servo().text()).unwrap();
    let _bus = Bus::open();
    let _plant = Plant::start(&workshop, &["--eds", "servo.eds", "--node", "2"]);
    let output = controller(&workshop, &["--log", "none"]).output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", describe(&output));
    assert!(describe(&output).contains("6076h"), "{}", describe(&output));
}

/// Plant time is that of SYNCs, so that the fault comes at the same cycle on every machine.
#[test]
fn a_fault_comes_at_its_time_and_the_truth_tells_so() {
    let workshop = Workshop::new("fault");
    let _bus = Bus::open();
    let plant = Plant::start(&workshop, &["--fault", "2@0.6s:over-temperature", "--truth", "truth.csv"]);
    let output = controller(&workshop, &["--overrun", "catch-up", "--log", "none"]).output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", describe(&output));
    assert!(describe(&output).contains("4210h"), "{}", describe(&output));
    rustix::process::kill_process(rustix::process::Pid::from_child(&plant.child), rustix::process::Signal::TERM)
        .unwrap();
    let mut plant = plant;
    assert!(plant.child.wait().unwrap().success());
    let truth = fs::read_to_string(workshop.file("truth.csv")).unwrap();
    let times: Vec<f64> = truth.lines().skip(1).map(|line| line.split(',').nth(1).unwrap().parse().unwrap()).collect();
    assert_eq!(times[0], 0.0);
    assert_eq!(times[1], 0.003, "a line for each SYNC");
    let brakes_2: Vec<&str> = truth.lines().skip(1).map(|line| line.split(',').nth(12).unwrap()).collect();
    let closed = brakes_2.iter().position(|brake| *brake == "1").expect("the brake closes");
    assert!((0.6..0.61).contains(&times[closed]), "{}", times[closed]);
}

/// In motion. Each ends the run, by name, with its exit code.
#[test]
fn faults_of_encoders_and_answers_end_the_run() {
    for (fault, code) in [
        ("2@0.9s:encoder-jump=5000", "encoder-implausible"),
        ("2@1.5s:encoder-reversed", "encoder-implausible"),
        ("2@0.9s:feedback-replayed", "two-drives-one-node"),
        ("2@0.9s:feedback-lost=100", "feedback-missing"),
        ("2@0.9s:target-ignored", "target-ignored"),
    ] {
        assert!(braked_after(fault, code), "{fault}");
    }
    // Their counters go on: nothing is to be seen of joints that stand.
    for (fault, code) in [
        ("2@0.9s:encoder-drift=20", "encoder-implausible"),
        ("2@0.9s:encoder-glitch=48", "encoder-implausible"),
        ("2:encoder-drift=20", "joint-turning"),
    ] {
        braked_after(fault, code);
    }
}

/// A run that ends with `code` on a robot with `fault`; whether its joints stand then.
fn braked_after(fault: &str, code: &str) -> bool {
    let workshop = Workshop::new("encoder-fault");
    let bus = Bus::open();
    let _plant = Plant::start(&workshop, &["--fault", fault]);
    let output = controller(&workshop, &["--overrun", "catch-up", "--log", "none", "--json"]).output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{fault}: {}", describe(&output));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report[0]["fault_code"], code, "{fault}: {}", describe(&output));
    bus.all_have_braked()
}

/// TPDO2 is on at power-up, which the drive's dictionary does not say.
#[test]
fn a_drive_has_what_it_has_stored() {
    let workshop = Workshop::new("stored");
    for (start, is_on) in [("2:boot-time=20ms", false), ("2:1801.1=0x282", true)] {
        let _plant = Plant::start(&workshop, &["--start", start]);
        let check = ["drive", "check", "--can", INTERFACE, "--node", "2", "--json"];
        let output = workshop.command().args(check).output().unwrap();
        let report: Value = serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{}", describe(&output)));
        let rows = report["rows"].as_array().unwrap();
        let others = rows.iter().find(|row| row["object"].as_str().unwrap().starts_with("1801h:01")).unwrap();
        assert_eq!(others["found"] == "642 (282h)", is_on, "{others:#}");
    }
}

#[test]
fn faults_come_on_command_too() {
    let workshop = Workshop::new("command");
    let bus = Bus::open();
    let mut plant = Plant::start(&workshop, &["--fault", "-", "--start", "3:emergency=8140"]);
    bus.drain();
    writeln!(plant.input, "2:over-temperature").unwrap();
    // Code 4210h, little-endian, of node 2.
    let is_hot = |seen: &Seen| seen.id == 0x082 && seen.data.starts_with(&[0x10, 0x42]);
    bus.wait_for("emergency 4210h of node 2", PATIENCE, is_hot);
}
