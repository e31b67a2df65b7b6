//! `uarm run --eds`: a robot of bought drives does its task in this process, before it is wired.

mod dictionaries;
mod support;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use dictionaries::Dictionary;
use serde_json::Value;
use support::{scratch, text, uarm};

fn file(name: &str, contents: &str) -> PathBuf {
    let path = scratch(name);
    fs::write(&path, contents).unwrap();
    path
}

/// The paper's robot, all its joints with `drive` beside their rated torque.
fn robot(name: &str, drive: &str) -> PathBuf {
    const WRITES: &str = "writes = [{ index = 0x6007, subindex = 0, type = \"i16\", value = 1 }]";
    let text = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/robots/uarm.toml")).unwrap();
    assert_eq!(text.matches(WRITES).count(), 3);
    file(&format!("rehearsal-{name}.toml"), &text.replace(WRITES, drive))
}

/// The task in virtual time, each joint's drive with the dictionary.
fn rehearse(name: &str, robot: &Path, dictionary: &Dictionary) -> Output {
    let eds = file(&format!("rehearsal-{name}.eds"), dictionary.text());
    let (robot, eds) = (robot.to_str().unwrap(), eds.to_str().unwrap());
    let mut arguments = vec!["run", "--virtual-time", "--log", "none", "--json", "--robot", robot];
    for node in ["1", "2", "3"] {
        arguments.extend(["--eds", eds, "--node", node]);
    }
    uarm(&arguments)
}

/// With the robot file that names the profile, its rated torque and nothing else.
#[test]
fn the_task_runs_to_its_end_on_the_drives_of_each_built_in_profile() {
    for (name, _) in uarm::robot::profile::SHIPPED {
        let output = rehearse(name, &robot(name, &format!("profile = \"{name}\"")), &Dictionary::of_profile(name));
        assert_eq!(output.status.code(), Some(0), "{name}: {}", text(&output));
        let reports: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(reports[0]["end"], "completed", "{name}: {reports:#}");
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(told.contains("not tried on hardware"), "{name}: {told}");
    }
}

/// The dictionary is that of the drives: without the profile, the Gold's rating is 0 and the start is refused with the object.
#[test]
fn a_drive_that_the_robot_file_does_not_fit_is_refused() {
    let plain = robot("plain", "writes = []");
    let output = rehearse("refused", &plain, &Dictionary::gold());
    assert_eq!(output.status.code(), Some(1), "{}", text(&output));
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(told.contains("6076h") && told.contains("node 1"), "{told}");
    let other = robot("other", "profile = \"maxon-epos4\"");
    let output = rehearse("other-maker", &other, &Dictionary::gold());
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told.contains("1018h:01") && told.contains("154 (9Ah)") && told.contains("251 (FBh)"), "{told}");
}

/// A robot file that pins its drives is simulated without their dictionaries too.
#[test]
fn pinned_drives_are_simulated_as_what_they_are_pinned_to() {
    let pinned = robot("pinned", "identity = { vendor = 0x9A, product = 3, serial = 77 }");
    let output = uarm(&["run", "--virtual-time", "--log", "none", "--json", "--robot", pinned.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
}

#[test]
fn dictionaries_are_for_simulated_canopen_drives() {
    let eds = file("rehearsal-usage.eds", Dictionary::own().text());
    let eds = eds.to_str().unwrap();
    let usage = uarm(&["run", "--can", "can0", "--eds", eds, "--node", "2"]);
    assert_eq!(usage.status.code(), Some(2), "{}", text(&usage));
    let unknown = uarm(&["run", "--virtual-time", "--log", "none", "--eds", eds, "--node", "9"]);
    assert_eq!(unknown.status.code(), Some(2));
    assert!(text(&unknown).contains("--node 9: expected one of the robot's nodes, [1, 2, 3]"), "{}", text(&unknown));
    let robot = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/uarm-odrive.toml");
    let odrive = ["run", "--virtual-time", "--log", "none", "--robot", robot, "--eds", eds, "--node", "2"];
    let odrive = uarm(&odrive);
    assert_eq!(odrive.status.code(), Some(1));
    assert!(text(&odrive).contains("only with bus.protocol = \"canopen\""), "{}", text(&odrive));
}

/// 2011h, tenths of a degree: of one maker only.
const TEMPERATURE: &str = "\n[2011]\nParameterName=Temperature\nObjectType=0x7\nDataType=0x0003\nAccessType=ro\n\
                           DefaultValue=300\nPDOMapping=0\n";
const WATCHED: &str = "temperature_c = { object = { index = 0x2011, subindex = 0, type = \"i16\", unit = 0.1 }, \
                       stop_above = 80.0 }, writes = [{ index = 0x6007, subindex = 0, type = \"i16\", value = 1 }]";

#[test]
fn a_robot_file_is_checked_against_the_dictionaries_of_its_drives() {
    let robot = robot("watched", WATCHED);
    let robot = robot.to_str().unwrap();
    let own = uarm(&["check", "--robot", robot]);
    assert_eq!(own.status.code(), Some(1), "{}", text(&own));
    assert!(text(&own).contains("2011h:00 is absent, expected readable, of type i16"), "{}", text(&own));
    let eds = file("rehearsal-watched.eds", Dictionary::own().and(TEMPERATURE).text());
    let mut arguments = vec!["check", "--robot", robot];
    for node in ["1", "2", "3"] {
        arguments.extend(["--eds", eds.to_str().unwrap(), "--node", node]);
    }
    let bought = uarm(&arguments);
    assert_eq!(bought.status.code(), Some(0), "{}", text(&bought));
    arguments.truncate(7);
    let two_are_not = uarm(&arguments);
    assert_eq!(two_are_not.status.code(), Some(1), "{}", text(&two_are_not));
    assert!(text(&two_are_not).contains("node 2"), "{}", text(&two_are_not));
}
