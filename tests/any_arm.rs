//! Robots other than the paper's: every shipped one does its task under every law, and its log tells and replays it.

mod support;

use std::path::{Path, PathBuf};

use hinf_control::Law;
use serde_json::Value;
use support::{scratch, uarm};

const SHIPPED: [(&str, usize); 3] = [("planar-four-link", 3), ("ets-vii", 3), ("seven-joint", 7)];

/// An empty folder of this test.
fn folder_of(name: &str) -> PathBuf {
    let folder = scratch(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("robots/{name}.toml"))
}

/// A run in virtual time without disturbance, and its report.
fn run_of(robot: &Path, arguments: &[&str]) -> Value {
    let robot = robot.to_str().unwrap();
    let common = ["run", "--virtual-time", "--json", "--robot", robot];
    let output = uarm(&[common.as_slice(), arguments].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice::<Value>(&output.stdout).unwrap()[0].take()
}

#[test]
fn every_shipped_robot_does_its_task_under_every_law() {
    for (name, joints) in SHIPPED {
        for law in Law::ALL {
            let report = run_of(&file(name), &["--log", "none", "--controller", law.name()]);
            assert_eq!(report["completed"], true, "{name}, {}", law.name());
            let errors = report["final_error_deg"].as_array().unwrap();
            assert_eq!(errors.len(), joints);
            assert!(
                errors.iter().all(|error| error.as_f64().unwrap().abs() < 1.0),
                "{name}, {}: {errors:?}",
                law.name()
            );
        }
    }
}

/// The theorem: the arm on its floating spacecraft moves as its equivalent does, integrated apart.
#[test]
fn the_space_manipulator_moves_as_its_equivalent() {
    for (name, _) in SHIPPED {
        let [ideal, space] = ["ideal", "space"].map(|plant| {
            let report = run_of(&file(name), &["--log", "none", "--plant", plant]);
            report["indices"]["l2"].as_f64().unwrap()
        });
        assert!((ideal - space).abs() < 1e-6 * ideal, "{name}: {ideal} and {space}");
    }
}

#[test]
fn a_log_of_seven_joints_is_shown_and_replayed_without_its_urdf() {
    let folder = folder_of("any_arm_log");
    for extension in ["toml", "urdf"] {
        std::fs::copy(file("seven-joint").with_extension(extension), folder.join(format!("seven-joint.{extension}")))
            .unwrap();
    }
    let log = folder.join("run.mcap");
    let log = log.to_str().unwrap();
    run_of(&folder.join("seven-joint.toml"), &["--log", log, "--controller", "adaptive"]);
    std::fs::remove_file(folder.join("seven-joint.urdf")).unwrap();

    let replay = uarm(&["replay", log]);
    let text = String::from_utf8_lossy(&replay.stdout).into_owned();
    assert!(replay.status.success() && text.contains("all equal, bit for bit"), "{text}");
    let other = uarm(&["replay", log, "--controller", "computed-torque"]);
    let text = String::from_utf8_lossy(&other.stdout).into_owned();
    assert!(other.status.success() && text.contains("joint 1") && text.contains("joint 7"), "{text}");

    let csv = folder.join("run.csv");
    let figure = folder.join("run.svg");
    let shown = uarm(&["show", log, "--csv", csv.to_str().unwrap(), "--figure", figure.to_str().unwrap()]);
    let text = String::from_utf8_lossy(&shown.stdout).into_owned();
    assert!(shown.status.success() && text.contains("joint 7") && !text.contains("base drift"), "{text}");
    let header = std::fs::read_to_string(&csv).unwrap().lines().next().unwrap().to_owned();
    assert!(header.contains("position_1_rad") && header.contains("torque_applied_7_nm"), "{header}");
    assert!(std::fs::read_to_string(&figure).unwrap().contains("joint 7"));
}

fn refused(folder: &str, changes: &[(&str, &str)], arguments: &[&str]) -> String {
    let folder = folder_of(folder);
    std::fs::copy(file("seven-joint").with_extension("urdf"), folder.join("seven-joint.urdf")).unwrap();
    let mut text = std::fs::read_to_string(file("seven-joint")).unwrap();
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replacen(from, to, 1);
    }
    let robot = folder.join("robot.toml");
    std::fs::write(&robot, text).unwrap();
    let common = ["run", "--virtual-time", "--log", "none", "--robot", robot.to_str().unwrap()];
    let output = uarm(&[common.as_slice(), arguments].concat());
    assert_eq!(output.status.code(), Some(1));
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn what_the_sensors_do_not_allow_is_refused_by_law() {
    for (law, mode, expected) in [
        ("nonlinear", "measured", "expected omitted or reduced"),
        ("nonlinear", "reduced-momentum", "expected omitted or reduced"),
        ("adaptive", "eliminated", "expected omitted"),
    ] {
        let robot = file("seven-joint");
        let run = ["run", "--virtual-time", "--log", "none", "--robot", robot.to_str().unwrap(), "--controller", law];
        let output = uarm(&[run.as_slice(), &["--base-acceleration", mode]].concat());
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(&format!("--base-acceleration {mode} with --controller {law}")), "{message}");
        assert!(message.trim_end().ends_with(expected), "{message}");
    }
}

#[test]
fn lists_of_another_length_are_refused_by_field() {
    let message = refused("any_arm_task", &[("start_deg = [0.0, ", "start_deg = [")], &[]);
    assert!(message.contains("task.start_deg = 6 values: expected 7, one for each active joint"), "{message}");
    let message = refused("any_arm_role", &[("role = \"active\"", "role = \"passive\"")], &[]);
    let expected = "joints = a passive base and 6 active joints: expected a passive base and 2 or 3 active joints, or 3 or 7 active joints alone";
    assert!(message.contains(expected), "{message}");
    let message = refused(
        "any_arm_plant",
        &[(
            "[bus]",
            "[plant]\nbase_inertia_scale = 1.0\nlink_scale = 1.0\nviscous_friction_nm_s = [0.0, 0.0, 0.0]\ncoulomb_friction_nm = [0.0, 0.0, 0.0]\ntorque_gain = 1.0\ntilt_m_per_s2 = [0.0, 0.0]\n\n[bus]",
        )],
        &[],
    );
    assert!(message.contains("plant = a table: expected none"), "{message}");
}

/// A second arm, and a spacecraft that belongs to no URDF.
#[test]
fn an_arm_is_described_once() {
    let urdf = "urdf = \"seven-joint.urdf\"\ntip = \"tool\"\n";
    let numbers = "base = { inertia_kg_m2 = 1.0, length_m = 1.0 }\n";
    let spacecraft = "spacecraft = { mass_kg = 1.0, inertia_kg_m2 = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0] }\n";
    let message = refused("any_arm_spacecraft", &[(urdf, &format!("{numbers}{spacecraft}"))], &[]);
    assert!(message.contains("model.spacecraft = a table: expected model.urdf beside it"), "{message}");
    let space = "[space_manipulator]\nspacecraft = { mass_kg = 1.0, inertia_kg_m2 = 1.0, centre_of_mass_to_joint_m = 1.0 }\nlinks = []\n";
    let message = refused("any_arm_twice", &[("[task]", &format!("{space}\n[task]"))], &[]);
    assert!(message.contains("model.urdf = a URDF: expected the arm once"), "{message}");
    let light = spacecraft.replace("mass_kg = 1.0", "mass_kg = -1.0");
    let message = refused("any_arm_light", &[(urdf, &format!("{urdf}{light}"))], &[]);
    assert!(message.contains("model.spacecraft = -1 kg"), "{message}");
}

/// The UARM's imperfections and its disturbance are its own.
#[test]
fn other_arms_are_simulated_as_they_are() {
    let robot = file("ets-vii");
    let run = ["run", "--virtual-time", "--robot", robot.to_str().unwrap(), "--plant", "uarm"];
    let output = uarm(&run);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("--plant uarm: expected ideal or space, since ETS-VII has no [plant]"), "{message}");

    let log = scratch("any_arm_undisturbed.mcap");
    let _ = std::fs::remove_file(&log);
    let log = log.to_str().unwrap();
    run_of(&robot, &["--log", log]);
    let csv = uarm(&["show", log, "--csv", "-"]);
    let text = String::from_utf8_lossy(&csv.stdout).into_owned();
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = lines.next().unwrap();
    let column = header.iter().position(|name| name.starts_with("disturbance_1")).unwrap();
    assert!(lines.all(|fields| fields[column].parse::<f64>().unwrap() == 0.0));
    let output = uarm(&["monitor", "--once", log]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1));
    assert!(message.contains("a run of 3 active joints, expected one of a passive base and 2"), "{message}");
}

#[test]
fn commands_for_the_papers_robot_alone_say_so() {
    let robot = file("seven-joint");
    let output = uarm(&["stability", "--robot", robot.to_str().unwrap()]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1));
    assert!(
        message.contains("joints = 7 active joints: expected a passive base and 2 active joints: `check`"),
        "{message}"
    );
}
