//! Comparison, figures, stability and training.

use std::path::Path;

use serde_json::Value;

use crate::robots::{file, folder_of, run_of};
use crate::support::{scratch, uarm};

/// A panel for each joint's error and torque, and for L2; no base, no disturbance, no number of the paper.
#[test]
fn the_controllers_are_drawn_side_by_side() {
    let folder = folder_of("any_arm_figures");
    let robot = file("ets-vii");
    let output =
        uarm(&["figures", "--robot", robot.to_str().unwrap(), "--out", folder.to_str().unwrap(), "--format", "svg"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let files: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(files, ["overview.svg"]);
    let drawn = std::fs::read_to_string(folder.join("overview.svg")).unwrap();
    for joint in 1..=3 {
        for panel in ["position error", "torque"] {
            assert!(drawn.contains(&format!("Joint {joint}: {panel}")), "{joint}: {panel}");
        }
    }
    for absent in ["Base:", "disturb", "Table 4", "Joint 4"] {
        assert!(!drawn.contains(absent), "{absent}");
    }
    assert!(drawn.contains("ETS-VII with the imperfections in its robot file"));
}

/// What `uarm compare` says of `arguments`, as JSON.
fn comparison(robot: &Path, arguments: &[&str]) -> Value {
    let common = ["compare", "--json", "--robot", robot.to_str().unwrap()];
    let output = uarm(&[common.as_slice(), arguments].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn a_comparison_is_of_the_runs_of_any_arm() {
    for (name, form) in [("planar-four-link", "nonlinear-measured"), ("seven-joint", "nonlinear-reduced")] {
        let robot = file(name);
        let base_acceleration = form.trim_start_matches("nonlinear-");
        let run = run_of(&robot, &["--log", "none", "--base-acceleration", base_acceleration]);
        let study = comparison(&robot, &["--controllers", form, "--variation", "none", "--repeat", "1"]);
        let experiment = &study["controllers"][0]["experiments"][0];
        assert_eq!(study["plant"], "imperfect robot");
        assert_eq!(experiment["l2"], run["indices"]["l2"], "{name}");
        for field in ["peak_torque_nm", "final_error_deg", "base_drift_deg"] {
            assert_eq!(experiment[field], run[field], "{name}: {field}");
        }
    }
}

/// By the names of docs/theory.md: what is measured on the base, eliminated with it, or of a momentum that it has.
#[test]
fn all_controllers_are_those_for_which_the_robot_has_the_sensors() {
    let csv = scratch("any_arm_all.csv");
    let arguments = ["--controllers", "all", "--repeat", "2", "--force", "--csv", csv.to_str().unwrap()];
    let study = comparison(&file("ets-vii"), &arguments);
    let names = |rows: &Value| -> Vec<String> {
        rows.as_array().unwrap().iter().map(|row| row["controller"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(names(&study["left_out"]), ["nonlinear-measured", "nonlinear-reduced-momentum"]);
    assert_eq!(names(&study["controllers"]).len(), 11);
    let row = &study["controllers"][0];
    assert_eq!(row["peak_torque_nm"].as_array().unwrap().len(), 3);
    assert!(row["base_drift_deg"].is_null() && row["l2"]["deviation"].as_f64().unwrap() > 0.0, "{row}");
    let text = std::fs::read_to_string(&csv).unwrap();
    let header = "controller,origin,experiment,start_offset_1_deg,start_offset_2_deg,start_offset_3_deg,l2,e_nms,\
                  peak_torque_1_nm,peak_torque_2_nm,peak_torque_3_nm,final_error_1_deg,final_error_2_deg,final_error_3_deg,\
                  base_drift_deg,failure";
    assert_eq!(text.lines().next().unwrap(), header);
    assert!(text.lines().all(|line| line.split(',').count() == header.split(',').count()), "{text}");
    assert_eq!(text.lines().count(), 1 + 11 * 2);

    let output =
        uarm(&["compare", "--robot", file("ets-vii").to_str().unwrap(), "--controllers", "nonlinear-measured"]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{message}");
    let expected =
        "--controllers nonlinear-measured: it reads the motion of the base, on which the robot has no sensor";
    assert!(message.contains(expected), "{message}");
}

/// The radius is what the start of a run is judged by, and a long delay is told for any arm.
#[test]
fn the_loop_of_any_arm_is_judged() {
    let robot = file("ets-vii");
    let common = ["stability", "--robot", robot.to_str().unwrap(), "--json"];
    let of = |arguments: &[&str]| {
        let output = uarm(&[common.as_slice(), arguments].concat());
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        (output.status.code(), report)
    };
    let (code, own) = of(&[]);
    assert_eq!(code, Some(0), "{own}");
    assert_eq!(own["task"]["joints_deg"].as_array().unwrap().len(), 3);
    let radius = own["task"]["spectral_radius"].as_f64().unwrap();
    assert!(radius > 0.5 && radius < 1.0, "{radius}");
    let limit = own["delay_limit_cycles"].as_f64().unwrap_or(3.0);
    let (code, late) = of(&["--delay", &limit.to_string()]);
    assert_eq!(code == Some(1), own["delay_limit_cycles"].is_number(), "{late}");
    let figure = scratch("any_arm_stability.svg");
    let paper = file("uarm");
    let beside = ["--robot", robot.to_str().unwrap(), "--beside", paper.to_str().unwrap(), "--figure"];
    let output = uarm(&[&["stability", "--force"], beside.as_slice(), &[figure.to_str().unwrap()]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.contains("(joint 1)") && text.contains("at q1, q2, q3 (deg)"), "{text}");
    let drawn = std::fs::read_to_string(&figure).unwrap();
    assert!(drawn.contains("ETS-VII") && drawn.contains("UARM"), "{drawn}");
}

/// As docs say for the paper's robot: recorded, trained, used.
#[test]
fn fuzzy_sets_are_trained_on_runs_of_any_arm() {
    let folder = folder_of("any_arm_train");
    let robot = file("ets-vii");
    let path = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let (log, csv, sets) = (path("neural.mcap"), path("neural.csv"), path("sets.toml"));
    run_of(&robot, &["--controller", "neural", "--log", &log]);
    assert!(uarm(&["show", &log, "--csv", &csv]).status.success());
    let train = |recorded: &str, robot: &str| {
        uarm(&["train", recorded, "--robot", robot, "--epochs", "2", "--out", &sets, "--force"])
    };
    let mut trained = Vec::new();
    for recorded in [&log, &csv] {
        let output = train(recorded, robot.to_str().unwrap());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        trained.push(std::fs::read_to_string(&sets).unwrap().replace(".csv", ".mcap"));
    }
    assert_eq!(trained[0], trained[1]);
    let of_sets = run_of(&robot, &["--controller", "fuzzy", "--fuzzy-sets", &sets, "--log", "none"]);
    let untrained = run_of(&robot, &["--controller", "fuzzy", "--log", "none"]);
    assert_ne!(of_sets["indices"], untrained["indices"]);

    let other = train(&csv, file("uarm").to_str().unwrap());
    let message = String::from_utf8_lossy(&other.stderr).into_owned();
    assert_eq!(other.status.code(), Some(1));
    assert!(
        message.contains("neural.csv, tick") || message.contains("neural.csv, line 2: control_input_2 ="),
        "{message}"
    );
}
