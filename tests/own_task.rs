//! Tasks of one's own: postures on the way, from the robot file or a CSV file, and oscillations for identification.

mod support;

use std::path::{Path, PathBuf};

use serde_json::Value;
use support::{scratch, text, uarm};

const UARM: &str = include_str!("../robots/uarm.toml");
const HOLD: &str = "hold_s = 0.5 ";

/// The paper's robot with lines more in its task, in an empty folder of this test.
fn robot_with(name: &str, lines: &str) -> PathBuf {
    let folder = scratch(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("robot.toml");
    assert!(UARM.contains(HOLD));
    std::fs::write(&file, UARM.replacen(HOLD, &format!("{lines}\n{HOLD}"), 1)).unwrap();
    file
}

/// The columns of a run's cycles, by the CSV file that `show` makes of its log.
fn motion_of(robot: &Path) -> (Vec<String>, Vec<Vec<f64>>) {
    let [log, csv] = ["run.mcap", "run.csv"].map(|name| robot.with_file_name(name));
    let [robot, log, csv] = [robot, &log, &csv].map(|path| path.to_str().unwrap());
    let run = ["run", "--virtual-time", "--plant", "ideal", "--disturbance", "none", "--controller", "nonlinear"];
    let output = uarm(&[run.as_slice(), &["--base-acceleration", "reduced", "--robot", robot, "--log", log]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
    assert_eq!(uarm(&["show", log, "--csv", csv]).status.code(), Some(0));
    let table = std::fs::read_to_string(csv).unwrap();
    let mut lines = table.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    let columns = lines.next().unwrap();
    (columns, lines.map(|line| line.iter().map(|cell| cell.parse().unwrap_or(f64::NAN)).collect()).collect())
}

/// Where the joints are told to be, and are, at a time, deg.
fn at(motion: &(Vec<String>, Vec<Vec<f64>>), time: f64) -> [[f64; 2]; 2] {
    let column =
        |name: &str| motion.0.iter().position(|column| column == name).unwrap_or_else(|| panic!("{:?}", motion.0));
    let row = motion.1.iter().find(|row| (row[column("time_s")] - time).abs() < 1e-9).unwrap();
    ["reference_position", "position"]
        .map(|quantity| [2, 3].map(|joint| row[column(&format!("{quantity}_{joint}_rad"))].to_degrees()))
}

fn assert_near(found: [f64; 2], expected: [f64; 2], tolerance: f64) {
    let is_near = found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < tolerance);
    assert!(is_near, "{found:?} for {expected:?}");
}

#[test]
fn postures_on_the_way_are_passed() {
    let robot = robot_with(
        "own_task_via",
        "via = [{ at_s = 0.9, angles_deg = [50.0, 5.0] }, { at_s = 2.1, angles_deg = [40.0, 70.0], passing = \"stop\" }]",
    );
    let motion = motion_of(&robot);
    for (time, posture) in [(0.0, [20.0, 20.0]), (0.9, [50.0, 5.0]), (2.1, [40.0, 70.0]), (3.0, [80.0, 60.0])] {
        let [reference, position] = at(&motion, time);
        assert_near(reference, posture, 1e-9);
        assert_near(position, posture, 1.5);
    }
    // At rest at the second posture, in motion at the first: 3 ms later.
    let travelled = |time: f64| {
        let [[now, _], _] = at(&motion, time);
        let [[then, _], _] = at(&motion, time + 0.003);
        (then - now).abs()
    };
    assert!(travelled(2.1) < 1e-4 && travelled(0.9) > 1e-3, "{} {}", travelled(2.1), travelled(0.9));
}

#[test]
fn a_run_along_a_file_of_postures_is_replayed_without_it() {
    let robot = robot_with("own_task_csv", "via_csv = \"way.csv\"");
    let way = robot.with_file_name("way.csv");
    std::fs::write(&way, "at_s,joint 2,joint 3\n0.9,50,5\n2.1,40,70\n").unwrap();
    let motion = motion_of(&robot);
    assert_near(at(&motion, 0.9)[0], [50.0, 5.0], 1e-9);
    std::fs::remove_file(&way).unwrap();
    let log = robot.with_file_name("run.mcap");
    let replay = uarm(&["replay", log.to_str().unwrap()]);
    assert_eq!(replay.status.code(), Some(0), "{}", text(&replay));
    assert!(text(&replay).contains("all equal, bit for bit"), "{}", text(&replay));
    let gone = uarm(&["check", "--robot", robot.to_str().unwrap()]);
    assert_eq!(gone.status.code(), Some(1));
    assert!(text(&gone).contains("task.via_csv = ") && text(&gone).contains("way.csv"), "{}", text(&gone));
}

/// Around a posture: in the middle of the motion the sine is as by hand.
#[test]
fn joints_oscillate_as_they_are_told() {
    let robot = robot_with(
        "own_task_oscillations",
        "oscillation_ramp_s = 0.5\noscillations = [{ joint = \"joint 3\", amplitude_deg = 4.0, frequency_hz = 1.0, phase_deg = 90.0 }]",
    );
    let resting =
        std::fs::read_to_string(&robot).unwrap().replacen("end_deg = [80.0, 60.0]", "end_deg = [20.0, 20.0]", 1);
    std::fs::write(&robot, resting).unwrap();
    let motion = motion_of(&robot);
    for (time, angle) in [(0.0, 20.0), (1.5, 16.0), (2.25, 20.0), (3.0, 20.0)] {
        assert_near(at(&motion, time)[0], [20.0, angle], 1e-9);
    }
}

#[test]
fn a_way_beyond_what_the_joints_can_is_refused_before_anything_moves() {
    for (name, lines, expected) in [
        ("beyond", "via = [{ at_s = 1.5, angles_deg = [175.0, 20.0] }]", "task = a motion by "),
        ("count", "via = [{ at_s = 1.5, angles_deg = [50.0] }]", "task.via[0].angles_deg = 1 values: expected 2"),
        ("late", "via = [{ at_s = 3.0, angles_deg = [50.0, 20.0] }]", "task.via[0].at_s = 3: expected 0.001 to 2.999"),
        (
            "order",
            "via = [{ at_s = 2.0, angles_deg = [50.0, 20.0] }, { at_s = 1.0, angles_deg = [50.0, 20.0] }]",
            "task.via[1].at_s = 1: expected 2.001 to 2.999",
        ),
        (
            "fast",
            "via = [{ at_s = 0.2, angles_deg = [80.0, 20.0], passing = \"stop\" }]",
            "task.duration_s = 3: expected a motion within joints[1].limits",
        ),
        ("passing", "via = [{ at_s = 1.0, angles_deg = [50.0, 20.0], passing = \"slow\" }]", "through"),
        ("unknown", "via = [{ at_s = 1.0, angle_deg = [50.0, 20.0] }]", "angles_deg"),
        (
            "both",
            "via = [{ at_s = 1.0, angles_deg = [50.0, 20.0] }]\nvia_csv = \"way.csv\"",
            "task.via or task.via_csv, not both",
        ),
        ("ramp", "oscillation_ramp_s = 1.0", "task.oscillation_ramp_s = 1: expected task.oscillations beside it"),
        (
            "joint",
            "oscillations = [{ joint = \"base\", amplitude_deg = 4.0, frequency_hz = 1.0 }]",
            "task.oscillations[0].joint = \"base\": expected an active joint, of [\"joint 2\", \"joint 3\"]",
        ),
        (
            "frequency",
            "oscillations = [{ joint = \"joint 2\", amplitude_deg = 4.0, frequency_hz = 0.0 }]",
            "task.oscillations[0].frequency_hz = 0: expected a finite number above 0",
        ),
        (
            "alias",
            "oscillations = [{ joint = \"joint 2\", amplitude_deg = 0.001, frequency_hz = 34.0 }]",
            "task.oscillations[0].frequency_hz = 34: expected a number from 0 to 33.33",
        ),
        (
            "swing",
            "oscillations = [{ joint = \"joint 2\", amplitude_deg = 20.0, frequency_hz = 5.0 }]",
            "expected a motion within joints[1].limits.velocity_deg_per_s",
        ),
    ] {
        let robot = robot_with(&format!("own_task_{name}"), lines);
        for command in [&["check"][..], &["run", "--virtual-time", "--log", "none"]] {
            let output = uarm(&[command, &["--robot", robot.to_str().unwrap()]].concat());
            assert_eq!(output.status.code(), Some(1), "{name}: {}", text(&output));
            assert!(text(&output).contains(expected), "{name}: {}", text(&output));
        }
    }
}

#[test]
fn the_check_tells_how_far_the_way_goes() {
    let robot = robot_with("own_task_check", "via = [{ at_s = 1.5, angles_deg = [100.0, 20.0] }]");
    let output = uarm(&["check", "--json", "--robot", robot.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
    let check: Value = serde_json::from_slice(&output.stdout).unwrap();
    let reach = check["joints"][0]["task_deg"].as_array().unwrap();
    assert_eq!(reach[0], 20.0);
    assert!(reach[1].as_f64().unwrap() >= 100.0, "{reach:?}");
}
