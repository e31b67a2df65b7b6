//! `uarm identify`: the simulated robot's imperfections are found in its logs.

mod support;

use std::path::PathBuf;

use serde_json::Value;
use support::{scratch, uarm};

/// `[plant]` of robots/uarm.toml: the plant fitted to the paper's Table 4.
const TRUTH: [(&str, f64); 11] = [
    ("viscous_friction_nm_s[0]", 0.0402),
    ("viscous_friction_nm_s[1]", 0.01192),
    ("viscous_friction_nm_s[2]", 0.01192),
    ("coulomb_friction_nm[0]", 0.02802),
    ("coulomb_friction_nm[1]", 0.04985),
    ("coulomb_friction_nm[2]", 0.0305),
    ("base_inertia_scale", 1.10368),
    ("link_scale", 1.36835),
    ("tilt_m_per_s2[0]", -0.24691),
    ("tilt_m_per_s2[1]", -0.11777),
    ("torque_gain", 1.0022),
];

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A log of the built-in robot with `arguments`.
fn log(name: &str, arguments: &[&str]) -> String {
    let path = scratch(&format!("identify-{name}.mcap"));
    let _ = std::fs::remove_file(&path);
    let path = path.to_str().unwrap().to_owned();
    let output = uarm(&[&["run", "--virtual-time", "--log", &path], arguments].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    path
}

fn identified(arguments: &[&str]) -> (Option<i32>, Value) {
    let output = uarm(&[&["identify", "--json"], arguments].concat());
    let report = serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{}", text(&output.stderr)));
    (output.status.code(), report)
}

/// Numbers that are told are within five standard errors; how many are told.
fn told(report: &Value) -> usize {
    let mut told = 0;
    for row in report["parameters"].as_array().unwrap() {
        let name = row["parameter"].as_str().unwrap();
        let (_, truth) = TRUTH.iter().find(|(known, _)| *known == name).unwrap();
        if row["told"] == "well" {
            let (value, error) = (row["value"].as_f64().unwrap(), row["standard_error"].as_f64().unwrap());
            assert!((value - truth).abs() <= 5.0 * error, "{name} = {value} +- {error}, truly {truth}");
            told += 1;
        }
    }
    told
}

/// The paper's motion with its disturbance, under two laws that do not move alike.
#[test]
fn the_papers_robot_is_found_in_the_logs_of_its_task() {
    let runs = [log("neural", &["--controller", "neural"]), log("nonlinear", &["--controller", "nonlinear"])];
    let (code, report) = identified(&[&runs[0], &runs[1]]);
    assert_eq!(report["explains"], true, "{report}");
    assert_eq!(report["runs"], 2);
    assert!(report["known_gain"].is_null(), "the disturbance tells it");
    let told = told(&report);
    assert!(told >= 9, "{report}");
    assert_eq!(code, Some(if told == TRUTH.len() { 0 } else { 3 }));
}

/// A torque that acts one SYNC later, and later still in the drive, is laid to the time at which it acts.
#[test]
fn drives_that_apply_their_torque_late_are_no_friction() {
    let robot = scratch("identify-late.toml");
    let original = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/robots/uarm.toml")).unwrap();
    let late = "rated_torque_nm = 0.2, torque_applies = \"at-sync\", torque_delay_us = 700,";
    let text = original.replace("rated_torque_nm = 0.2,", late);
    assert_ne!(text, original);
    std::fs::write(&robot, text).unwrap();
    let run = log("late", &["--robot", robot.to_str().unwrap(), "--controller", "neural"]);
    let (_, report) = identified(&[&run]);
    assert_eq!(report["explains"], true, "{report}");
    assert!(told(&report) >= 9, "{report}");
}

/// Numbers that the run does not tell stay what they were.
#[test]
fn the_robot_file_has_what_was_found() {
    let robot = scratch("identify-stiff.toml");
    let original = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/robots/uarm.toml")).unwrap();
    let stiff = original.replace("[0.0402, 0.01192, 0.01192]", "[0.0402, 0.03, 0.01192]");
    assert_ne!(stiff, original);
    std::fs::write(&robot, stiff).unwrap();
    let run = log("stiff", &["--robot", robot.to_str().unwrap(), "--disturbance", "none"]);
    let out: PathBuf = scratch("identify-found.toml");
    let output = uarm(&["identify", &run, "--out", out.to_str().unwrap(), "--force"]);
    let printed = text(&output.stdout);
    assert!(printed.contains("taken as known") && printed.contains("the model explains the motion"), "{printed}");
    let found: toml::Table = std::fs::read_to_string(&out).unwrap().parse().unwrap();
    let plant = found["plant"].as_table().unwrap();
    let viscous = plant["viscous_friction_nm_s"].as_array().unwrap()[1].as_float().unwrap();
    assert!((viscous - 0.03).abs() < 0.003, "{viscous}");
    assert_eq!(plant["torque_gain"].as_float(), Some(1.0022));
    let again = uarm(&["run", "--virtual-time", "--log", "none", "--robot", out.to_str().unwrap()]);
    assert!(again.status.success(), "{}", text(&again.stderr));
    let refused = uarm(&["identify", &run, "--out", out.to_str().unwrap()]);
    assert_eq!(refused.status.code(), Some(1), "{}", text(&refused.stderr));
}

/// The case of a real robot. A friction that the search takes to its least value on its way comes up again.
#[test]
fn a_run_without_a_disturbance_is_found_under_every_law() {
    for law in ["nonlinear", "adaptive", "neural-model", "fuzzy-model", "computed-torque"] {
        let run = log(&format!("undisturbed-{law}"), &["--controller", law, "--disturbance", "none"]);
        let (_, report) = identified(&[&run]);
        assert_eq!(report["converged"], true, "{law}: {report}");
        assert_eq!(report["explains"], true, "{law}: {report}");
        assert!(told(&report) >= 7, "{law}: {report}");
    }
}

#[test]
fn what_cannot_be_identified_is_refused() {
    let ideal = log("seven", &["--robot", concat!(env!("CARGO_MANIFEST_DIR"), "/robots/ets-vii.toml")]);
    let run = log("short", &["--controller", "nonlinear"]);
    let period = log("period", &["--controller", "nonlinear", "--period", "2ms"]);
    let approached = log("approached", &["--controller", "nonlinear", "--approach", "1s"]);
    for (arguments, code, expected) in [
        (vec![approached.as_str()], 1, "an approach with a disturbance of the plant"),
        (vec![ideal.as_str()], 1, "3 active joints: expected the paper's arm"),
        (vec![&run, &period], 1, "another robot file than the first run's"),
        (vec![&run, "--torque", "reported"], 1, "joint 2 reported no torque, expected reports of all active joints"),
        (vec!["absent.mcap"], 1, "absent.mcap"),
        (vec![], 2, "FILE.mcap"),
    ] {
        let output = uarm(&[&["identify"], arguments.as_slice()].concat());
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{message}");
        assert!(message.contains(expected), "{expected}: {message}");
    }
}
