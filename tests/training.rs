//! `uarm train`, from a recorded run to sets that the fuzzy laws run with.

mod support;

use std::path::{Path, PathBuf};
use std::process::Command;

use hinf_control::{FuzzySets, Law};
use uarm::robot::Robot;
use uarm::robot::fuzzy_sets::{BUILT_IN, TrainedSets};

use support::{text, uarm};

/// A directory of one test.
fn scratch(name: &str) -> PathBuf {
    let directory = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("training").join(name);
    let _ = std::fs::remove_dir_all(&directory);
    std::fs::create_dir_all(&directory).unwrap();
    directory
}

/// The log of a run.
fn record(directory: &Path, law: Law) -> PathBuf {
    let file = directory.join(format!("{}.mcap", law.name()));
    let _ = std::fs::remove_file(&file);
    let output = uarm(&["run", "--virtual-time", "--controller", law.name(), "--log", file.to_str().unwrap()]);
    assert!(output.status.success(), "{}", text(&output));
    file
}

/// The commands in the head comment of a sets file: what follows `uarm`, word by word.
fn commands_in(text: &str) -> Vec<Vec<&str>> {
    let commands = text.lines().filter_map(|line| line.trim_start_matches('#').trim().strip_prefix("uarm "));
    commands.map(|command| command.split(' ').collect()).collect()
}

#[test]
fn the_shipped_sets_come_from_the_commands_above_them() {
    let directory = scratch("shipped");
    let commands = commands_in(BUILT_IN);
    let firsts: Vec<_> = commands.iter().map(|command| command[0]).collect();
    assert_eq!(firsts, ["run", "run", "train"]);
    for log in ["neural.mcap", "neural-undisturbed.mcap"] {
        let _ = std::fs::remove_file(directory.join(log));
    }
    for command in &commands {
        let out: &[&str] = if command[0] == "train" { &["--out", "sets.toml"] } else { &[] };
        let output =
            Command::new(env!("CARGO_BIN_EXE_uarm")).args(command).args(out).current_dir(&directory).output().unwrap();
        assert!(output.status.success(), "{}", text(&output));
    }
    let trained = std::fs::read_to_string(directory.join("sets.toml")).unwrap();
    assert!(BUILT_IN.ends_with(&trained), "{trained}");
    assert_ne!(TrainedSets::built_in().unwrap().sets, FuzzySets::untrained());
}

#[test]
fn trained_sets_change_what_the_fuzzy_law_does_and_are_drawn() {
    let directory = scratch("use");
    let log = record(&directory, Law::Neural);
    let sets = directory.join("sets.toml");
    let (log, sets) = (log.to_str().unwrap(), sets.to_str().unwrap());
    let figures = directory.join("figures");
    let figures_argument = figures.to_str().unwrap();
    let train = ["train", log, "--epochs", "5", "--out", sets, "--figures", figures_argument, "--format", "svg"];
    let output = uarm(&train);
    assert!(output.status.success(), "{}", text(&output));
    let first = std::fs::read(sets).unwrap();
    // A CSV file of the same run teaches the same.
    let table = directory.join("neural.csv");
    let table = table.to_str().unwrap();
    assert!(uarm(&["show", log, "--csv", table]).status.success());
    let from_table = directory.join("from-table.toml");
    assert!(uarm(&["train", table, "--epochs", "5", "--out", from_table.to_str().unwrap()]).status.success());
    let sets_of = |text: Vec<u8>| {
        String::from_utf8(text).unwrap().lines().filter(|line| !line.starts_with('#')).collect::<Vec<_>>().join("\n")
    };
    assert_eq!(sets_of(std::fs::read(from_table).unwrap()), sets_of(first.clone()));
    assert!(uarm(&[&train[..], &["--force"]].concat()).status.success());
    assert_eq!(std::fs::read(sets).unwrap(), first);
    for name in ["fuzzy-sets.svg", "learning-curve.svg"] {
        roxmltree::Document::parse(&std::fs::read_to_string(figures.join(name)).unwrap()).unwrap();
    }
    let index = |arguments: &[&str]| {
        let output = uarm(&[&["run", "--virtual-time", "--json", "--controller", "fuzzy"], arguments].concat());
        assert!(output.status.success(), "{}", text(&output));
        let reports: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        reports[0]["indices"]["l2"].as_f64().unwrap()
    };
    let (untrained, trained) = (index(&[]), index(&["--fuzzy-sets", sets]));
    assert_ne!(untrained, trained);
    assert!((trained / untrained - 1.0).abs() < 0.3, "{untrained} {trained}");
}

#[test]
fn what_cannot_be_learned_from_is_named() {
    let directory = scratch("errors");
    let log = record(&directory, Law::Neural);
    let log = log.to_str().unwrap();
    let no_run = directory.join("no-run.csv");
    std::fs::write(&no_run, "a,b\n1,2\n").unwrap();
    let out = directory.join("sets.toml");
    let _ = std::fs::remove_file(&out);
    let out = out.to_str().unwrap();
    for (arguments, message) in [
        (vec![log, "--controller", "fuzzy"], "control_input_"),
        (vec![log, "--controller", "computed-torque"], "expected one of the paper's laws"),
        (vec![no_run.to_str().unwrap()], "no-run.csv, line 1: no column velocity_2_rad_per_s"),
        (vec!["missing.csv"], "missing.csv: cannot be read"),
    ] {
        let output = uarm(&[&["train", "--out", out], arguments.as_slice()].concat());
        assert_eq!(output.status.code(), Some(1));
        let found = text(&output);
        assert!(found.contains(message), "{found}");
    }
    assert!(!Path::new(out).exists());
    assert!(Robot::load(None).unwrap().fuzzy_sets.is_none());
}
