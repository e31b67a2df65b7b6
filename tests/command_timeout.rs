//! Drives whose watchdog is the timeout of their commands: it is tried at each start, and the task is run.

mod support;

use std::process::Command;

use support::text;

/// Emergency 8250h (RPDO timeout, CiA 301) of node 2, as a candump line ends: identifier 080h and the node, code with its low byte
/// first.
const TIMEOUT_OF_NODE_2: &str = "082#5082";

#[test]
fn the_timeout_of_emulated_drives_is_tried_at_start_and_the_task_is_run() {
    let folder = support::scratch("command-timeout");
    std::fs::create_dir_all(&folder).unwrap();
    let before = "drive = { ";
    let robot = uarm::robot::BUILT_IN
        .replace(before, "drive = { watchdog = \"rpdo-timeout\", rpdo_timeout_ms = 20, watchdog_test = \"at-start\", ");
    std::fs::write(folder.join("robot.toml"), robot).unwrap();
    let uarm = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_uarm")).args(arguments).current_dir(&folder).output().unwrap();
        assert!(output.status.success(), "{}", text(&output));
        String::from_utf8(output.stdout).unwrap()
    };
    uarm(&["run", "--virtual-time", "--robot", "robot.toml", "--log", "run.mcap", "--hold", "0s"]);
    let frames = uarm(&["show", "run.mcap", "--candump", "-"]);
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(frames.lines().filter(|line| line.contains(TIMEOUT_OF_NODE_2)).count(), 1, "at the start, once");
}
