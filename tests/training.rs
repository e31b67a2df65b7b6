//! `uarm train`, from the trace of a run to sets that the fuzzy laws run with.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use hinf_control::{FuzzySets, Law};
use uarm::robot::Robot;
use uarm::robot::fuzzy_sets::{BUILT_IN, TrainedSets};

fn uarm(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_uarm"))
        .args(arguments)
        .current_dir(env!("CARGO_TARGET_TMPDIR")) // where the logs go
        .output()
        .unwrap()
}

fn standard_error(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// A directory of one test.
fn scratch(name: &str) -> PathBuf {
    let directory = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("training").join(name);
    std::fs::create_dir_all(&directory).unwrap();
    directory
}

fn trace(directory: &Path, law: Law) -> PathBuf {
    let file = directory.join(format!("{}.csv", law.name()));
    let output = uarm(&["run", "--virtual-time", "--controller", law.name(), "--trace", file.to_str().unwrap()]);
    assert!(output.status.success(), "{}", standard_error(&output));
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
    for command in &commands {
        let out: &[&str] = if command[0] == "train" { &["--out", "sets.toml"] } else { &[] };
        let output =
            Command::new(env!("CARGO_BIN_EXE_uarm")).args(command).args(out).current_dir(&directory).output().unwrap();
        assert!(output.status.success(), "{}", standard_error(&output));
    }
    let trained = std::fs::read_to_string(directory.join("sets.toml")).unwrap();
    assert!(BUILT_IN.ends_with(&trained), "{trained}");
    assert_ne!(TrainedSets::embedded().unwrap().sets, FuzzySets::untrained());
}

#[test]
fn trained_sets_change_what_the_fuzzy_law_does_and_are_drawn() {
    let directory = scratch("use");
    let trace = trace(&directory, Law::Neural);
    let sets = directory.join("sets.toml");
    let (trace, sets) = (trace.to_str().unwrap(), sets.to_str().unwrap());
    let figures = directory.join("figures");
    let figures_argument = figures.to_str().unwrap();
    let train = ["train", trace, "--epochs", "5", "--out", sets, "--figures", figures_argument, "--format", "svg"];
    let output = uarm(&train);
    assert!(output.status.success(), "{}", standard_error(&output));
    let first = std::fs::read(sets).unwrap();
    uarm(&train);
    assert_eq!(std::fs::read(sets).unwrap(), first);
    for name in ["fuzzy-sets.svg", "learning-curve.svg"] {
        roxmltree::Document::parse(&std::fs::read_to_string(figures.join(name)).unwrap()).unwrap();
    }
    let index = |arguments: &[&str]| {
        let output = uarm(&[&["run", "--virtual-time", "--json", "--controller", "fuzzy"], arguments].concat());
        assert!(output.status.success(), "{}", standard_error(&output));
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
    let trace = trace(&directory, Law::Neural);
    let trace = trace.to_str().unwrap();
    let no_trace = directory.join("no-trace.csv");
    std::fs::write(&no_trace, "a,b\n1,2\n").unwrap();
    let out = directory.join("sets.toml");
    let _ = std::fs::remove_file(&out);
    let out = out.to_str().unwrap();
    for (arguments, message) in [
        (vec![trace, "--controller", "fuzzy"], "control_input_"),
        (vec![trace, "--controller", "computed-torque"], "expected one of the paper's laws"),
        (vec![no_trace.to_str().unwrap()], "no-trace.csv, line 1: no column rate_2_rad_per_s"),
        (vec!["missing.csv"], "missing.csv: cannot be read"),
        (vec![trace, "--step=-1"], "initial step size is -1: expected within"),
    ] {
        let output = uarm(&[&["train", "--out", out], arguments.as_slice()].concat());
        assert_eq!(output.status.code(), Some(1));
        let found = standard_error(&output);
        assert!(found.contains(message), "{found}");
    }
    assert!(!Path::new(out).exists());
    assert!(Robot::load(None).unwrap().fuzzy_sets.is_none());
}
