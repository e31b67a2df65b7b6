//! `uarm campaign`: parts become the whole, a seed stands for itself, and the runs of the built-in robot are as they must be.

mod support;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use support::{scratch, text};

/// Seeds of the campaign in which everything must be as it must be.
const SEEDS: &str = "60";

fn uarm(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_uarm")).args(arguments).current_dir(folder).output().unwrap()
}

fn folder(name: &str) -> PathBuf {
    let folder = scratch(&format!("campaign-{name}"));
    // Of an earlier test run; outputs are never replaced.
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

#[track_caller]
fn succeeds(folder: &Path, arguments: &[&str]) -> String {
    let output = uarm(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", text(&output));
    String::from_utf8(output.stdout).unwrap()
}

/// It stops in slow motion, under a torque that friction may hold. If its counter might stop as suddenly as it likes, the run would end after
/// 1047 ms.
#[test]
fn an_encoder_that_stops_suddenly_ends_its_run_within_five_cycles() {
    let folder = folder("sudden-stop");
    succeeds(&folder, &["campaign", "--first", "7904", "--seeds", "1", "--output", "one.jsonl"]);
    let trials = std::fs::read_to_string(folder.join("one.jsonl")).unwrap();
    let trial: serde_json::Value = serde_json::from_str(trials.lines().nth(1).unwrap()).unwrap();
    assert_eq!((&trial["fault"], &trial["end"]), (&"encoder-stuck".into(), &"encoder-stuck".into()), "{trial}");
    assert!(trial["reaction_ms"].as_f64().unwrap() <= 15.0, "{trial}");
}

#[test]
fn parts_run_on_any_number_of_threads_merge_to_the_bytes_of_the_whole() {
    let folder = folder("parts");
    let told = succeeds(&folder, &["campaign", "--seeds", "10", "--threads", "2", "--output", "whole.jsonl"]);
    for (part, threads) in [("1/3", "1"), ("2/3", "3"), ("3/3", "1")] {
        let name = format!("{}.jsonl", &part[..1]);
        let arguments = ["campaign", "--seeds", "10", "--shard", part, "--threads", threads, "--output", &name];
        succeeds(&folder, &arguments);
    }
    let merge = ["campaign", "merge", "3.jsonl", "1.jsonl", "2.jsonl", "--output", "merged.jsonl"];
    assert_eq!(succeeds(&folder, &merge), told);
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    assert_eq!(read("merged.jsonl"), read("whole.jsonl"));

    // One seed alone gives its line of the whole.
    succeeds(&folder, &["campaign", "--first", "7", "--seeds", "1", "--output", "seven.jsonl"]);
    let line = |name: &str, number| read(name).lines().nth(number).unwrap().to_owned();
    assert!(line("seven.jsonl", 1).contains("\"seed\":7"));
    assert_eq!(line("seven.jsonl", 1), line("whole.jsonl", 7));

    let incomplete = uarm(&folder, &["campaign", "merge", "1.jsonl", "3.jsonl"]);
    assert_eq!(incomplete.status.code(), Some(1));
    assert!(text(&incomplete).contains("experiment 2 stands in no file"), "{}", text(&incomplete));
    let foreign = uarm(&folder, &["campaign", "merge", "1.jsonl", "seven.jsonl"]);
    assert!(
        text(&foreign).contains("seven.jsonl: line 1: first_seed = 7: expected 1, as in 1.jsonl"),
        "{}",
        text(&foreign)
    );
    let replaced = uarm(&folder, &["campaign", "--seeds", "1", "--output", "whole.jsonl"]);
    assert!(text(&replaced).contains("--force"), "{}", text(&replaced));
}

#[test]
fn whatever_happens_is_answered_as_it_must_be() {
    let folder = folder("all");
    let output = uarm(&folder, &["campaign", "--seeds", SEEDS, "--json"]);
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(summary["failed"], serde_json::json!([]), "{}", text(&output));
    assert_eq!(summary["trials"].to_string(), SEEDS);
    let faults = summary["faults"].as_object().unwrap();
    assert!(faults.len() > 15, "{:?}", faults.keys());
}

#[test]
fn a_fault_that_the_robot_file_forbids_to_be_answered_fails_the_campaign() {
    // Drives that report errors and a master that only records them.
    let folder = folder("recorded");
    let robot = uarm::robot::BUILT_IN.replacen("[bus]", "[bus]\nemergency = \"record\"", 1);
    std::fs::write(folder.join("robot.toml"), robot).unwrap();
    let output = uarm(&folder, &["campaign", "--robot", "robot.toml", "--seeds", "30"]);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output));
    let told = text(&output);
    assert!(told.contains("emergency") && told.contains(": uarm campaign --first"), "{told}");
}

/// With this limit the laws' own errors end the run.
#[test]
fn a_robot_that_cannot_do_its_task_is_told_so_before_any_fault() {
    let folder = folder("unable");
    let robot = uarm::robot::BUILT_IN.replacen("tracking_error_limit_deg = 30.0", "tracking_error_limit_deg = 0.5", 1);
    std::fs::write(folder.join("robot.toml"), robot).unwrap();
    let campaign = uarm(&folder, &["campaign", "--robot", "robot.toml", "--seeds", "1"]);
    assert_eq!(campaign.status.code(), Some(1));
    let told = text(&campaign);
    assert!(told.contains("cannot do its task, even without a fault") && told.contains("tracking error"), "{told}");
    let check = uarm(&folder, &["check", "--robot", "robot.toml"]);
    assert_eq!(check.status.code(), Some(1));
    assert!(text(&check).contains("STOPPED: joint 2 at "), "{}", text(&check));
}

#[test]
fn a_part_without_a_seed_says_that_nothing_was_tried() {
    let told = succeeds(&folder("empty"), &["campaign", "--seeds", "1", "--shard", "2/2"]);
    assert!(told.contains("nothing was tried") && !told.contains("as it must be"), "{told}");
}

#[test]
fn what_is_no_part_or_no_robot_for_it_is_refused() {
    let folder = folder("usage");
    let output = uarm(&folder, &["campaign", "--shard", "4/3"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output).contains("2/8"), "{}", text(&output));
    let odrive = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/uarm-odrive.toml");
    let output = uarm(&folder, &["campaign", "--robot", odrive, "--seeds", "1"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output).contains("protocol"), "{}", text(&output));
}
