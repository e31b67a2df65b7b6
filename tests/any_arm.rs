//! Robots other than the paper's: every shipped one does its task under every law, and its log tells and replays it.

mod chain;
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

#[test]
fn an_arm_has_one_to_eight_active_joints() {
    let folder = folder_of("any_arm_chains");
    for base in [chain::Base::Encoder, chain::Base::NoSensor] {
        for links in 1..=8 {
            let report = run_of(&chain::write(&folder, links, base), &["--log", "none"]);
            assert_eq!(report["completed"], true, "{links}, {base:?}");
            let errors = report["final_error_deg"].as_array().unwrap();
            assert_eq!(errors.len(), links, "{base:?}");
            assert!(errors.iter().all(|error| error.as_f64().unwrap().abs() < 1.0), "{links}, {base:?}: {errors:?}");
        }
        let nine = chain::write(&folder, 9, base);
        let output = uarm(&["run", "--virtual-time", "--log", "none", "--robot", nine.to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(1), "{base:?}");
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(told.contains("expected 1 to 8 active joints, alone or behind a passive base"), "{told}");
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
    assert!(!header.contains("base_acceleration"), "no sensor is on the base: {header}");
    assert!(std::fs::read_to_string(&figure).unwrap().contains("joint 7"));

    let seen = uarm(&["monitor", "--once", log]);
    let text = String::from_utf8_lossy(&seen.stdout).into_owned();
    let rows: Vec<&str> = text.lines().filter(|line| line.starts_with("\u{2502}joint ")).collect();
    // A header, and a row for each joint: all are active, so that all have an error and a torque.
    assert_eq!(rows.len(), 8, "{text}");
    assert!(seen.status.success() && rows[1..].iter().all(|row| row.split_whitespace().count() >= 9), "{text}");
}

/// 1535 us of 3 ms at 1 Mbit/s: `uarm check` and docs/wire.md, section 4.
#[test]
fn the_bus_of_seven_drives_is_examined_and_judged() {
    let robot = file("seven-joint");
    let examined = uarm(&["doctor", "--seconds", "1", "--robot", robot.to_str().unwrap()]);
    let text = String::from_utf8_lossy(&examined.stdout).into_owned();
    assert!(text.contains("1535 us of each 3ms at 1000000 bit/s"), "{text}");
    let slow = ("bitrate_hz = 1000000", "bitrate_hz = 500000");
    let message = refused("any_arm_bus", &[slow], &[]);
    // 4110 us, and the next number of microseconds that one byte of 60C2h can tell in a power of ten of them.
    let expected = "control.period_us = 3000: expected at least 4200: 7 joints need 4.11ms of bus time at 500000 bit/s";
    assert!(message.contains(expected), "{message}");
    let fitting = changed("any_arm_bus", &[slow, ("period_us = 3000 ", "period_us = 4200 ")]);
    let checked = uarm(&["check", "--robot", fitting.to_str().unwrap()]);
    assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stderr));
}

/// The robot of seven joints with other text, in a folder of its own.
fn changed(folder: &str, changes: &[(&str, &str)]) -> PathBuf {
    let folder = folder_of(folder);
    std::fs::copy(file("seven-joint").with_extension("urdf"), folder.join("seven-joint.urdf")).unwrap();
    let mut text = std::fs::read_to_string(file("seven-joint")).unwrap();
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replacen(from, to, 1);
    }
    let robot = folder.join("robot.toml");
    std::fs::write(&robot, text).unwrap();
    robot
}

fn refused(folder: &str, changes: &[(&str, &str)], arguments: &[&str]) -> String {
    let robot = changed(folder, changes);
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
    assert!(message.contains("seven-joint.urdf: 7 joints between base and tip, expected 6"), "{message}");
    let message = refused(
        "any_arm_roles",
        &[("name = \"joint 2\"\nrole = \"active\"", "name = \"joint 2\"\nrole = \"passive\"")],
        &[],
    );
    assert!(
        message.contains("joints[1].role = passive: expected active: only the first joint may be passive"),
        "{message}"
    );
    for (from, to, expected) in [
        (
            "coulomb_friction_nm = [1.0, ",
            "coulomb_friction_nm = [",
            "plant.coulomb_friction_nm = 6 values: expected 7, one for each joint",
        ),
        (
            "viscous_friction_nm_s = [2.0, ",
            "viscous_friction_nm_s = [-2.0, ",
            "plant.viscous_friction_nm_s = -2: expected a finite value >= 0",
        ),
        ("link_scale = 1.05", "link_scale = 0.0", "plant.link_scale = 0: expected"),
        ("torque_gain = 0.98", "torque_gain = 0.0", "plant.torque_gain = 0: expected a finite value > 0"),
        (
            "torque_gain = 0.98",
            "torque_gain = 1.0\ntilt_m_per_s2 = [0.1, 0.0]",
            "plant.tilt_m_per_s2 = [0.1, 0.0]: expected [0, 0]",
        ),
    ] {
        let message = refused("any_arm_plant", &[(from, to)], &[]);
        assert!(message.contains(expected), "{message}");
    }
}

/// The work that a run's motors were told to do, J: all of it, and the most on the way.
#[derive(Debug)]
struct Work {
    all: f64,
    most: f64,
}

/// ∫ Σ τ q̇ dt over a run of `robot` on `plant`; by default on that with imperfections.
fn work_of(test: &str, robot: &Path, plant: Option<&str>) -> Work {
    let [log, csv] = ["mcap", "csv"].map(|extension| scratch(&format!("any_arm_{test}.{extension}")));
    let _ = std::fs::remove_file(&log);
    let log = log.to_str().unwrap();
    let chosen: Vec<_> = plant.iter().flat_map(|plant| ["--plant", *plant]).collect();
    run_of(robot, &[["--log", log].as_slice(), &chosen].concat());
    assert!(uarm(&["show", log, "--force", "--csv", csv.to_str().unwrap()]).status.success());
    let text = std::fs::read_to_string(&csv).unwrap();
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = lines.next().unwrap();
    let column = |name: String| header.iter().position(|other| *other == name);
    let joints: Vec<_> = (1..=7)
        .filter_map(|joint| {
            column(format!("torque_applied_{joint}_nm")).zip(column(format!("velocity_{joint}_rad_per_s")))
        })
        .collect();
    let period = column("period_s".to_owned()).unwrap();
    let mut work = Work { all: 0.0, most: 0.0 };
    for line in lines {
        let number = |column: usize| line[column].parse::<f64>().unwrap();
        let power: f64 = joints.iter().map(|(torque, velocity)| number(*torque) * number(*velocity)).sum();
        work.all += power * number(period);
        work.most = work.most.max(work.all);
    }
    work
}

/// From rest to rest all work is friction's: of a quintic over Δ in T it is b (10/7) Δ²/T + c |Δ|. On the ideal plant there is none; what
/// is left there, by the delay of a velocity behind its torque, is left on both.
#[test]
fn the_friction_of_the_robot_file_takes_the_work_of_its_motors() {
    for (name, active) in SHIPPED {
        let robot: toml::Table = std::fs::read_to_string(file(name)).unwrap().parse().unwrap();
        let list = |table: &str, field: &str| -> Vec<f64> {
            let numbers: Vec<f64> = robot[table][field].clone().try_into().unwrap();
            numbers[numbers.len() - active..].to_vec()
        };
        let (start, end) = (list("task", "start_deg"), list("task", "end_deg"));
        let (viscous, coulomb) = (list("plant", "viscous_friction_nm_s"), list("plant", "coulomb_friction_nm"));
        let duration = robot["task"]["duration_s"].as_float().unwrap();
        let lost: f64 = (0..active)
            .map(|joint| {
                let turned = (end[joint] - start[joint]).to_radians().abs();
                viscous[joint] * 10.0 / 7.0 * turned.powi(2) / duration + coulomb[joint] * turned
            })
            .sum();
        let [ideal, imperfect] = [Some("ideal"), None].map(|plant| work_of("friction", &file(name), plant).all);
        let gain = robot["plant"]["torque_gain"].as_float().unwrap();
        approx::assert_relative_eq!((imperfect - ideal) * gain, lost, max_relative = 0.05);
    }
}

/// Bodies that are all heavier by a half move with half as much more energy, and motors of half the strength are told twice of it.
#[test]
fn heavier_bodies_and_weaker_motors_of_the_robot_file_are_felt() {
    for (name, gain) in [("planar-four-link", 1.0), ("ets-vii", 0.5)] {
        let text = std::fs::read_to_string(file(name)).unwrap();
        let (before, plant) = text.split_once("[plant]").unwrap();
        let without_friction = plant.lines().map(|line| {
            if line.contains("friction") {
                line.replace(|digit: char| digit.is_ascii_digit(), "0")
            } else {
                line.to_owned()
            }
        });
        let plant = without_friction.collect::<Vec<_>>().join("\n");
        let plant =
            plant.replace("= 1.02", "= 1.5").replace("= 1.05", "= 1.5").replace("= 0.98", &format!("= {gain:?}"));
        let folder = folder_of("any_arm_heavy");
        std::fs::copy(file(name).with_extension("urdf"), folder.join(format!("{name}.urdf"))).unwrap();
        let heavy = folder.join(format!("{name}.toml"));
        std::fs::write(&heavy, format!("{before}[plant]{plant}")).unwrap();
        let (nominal, heavy) =
            (work_of("heavy", &file(name), Some("ideal")).most, work_of("heavy", &heavy, Some("imperfect")).most);
        approx::assert_relative_eq!(heavy * gain, 1.5 * nominal, max_relative = 0.05);
    }
}

/// What a newcomer tried: each is refused or told in the terms of robots.
#[test]
fn what_no_body_or_drive_has_is_told() {
    let urdf = "tip = \"tool\"\n";
    let with = |inertia: &str| format!("{urdf}spacecraft = {{ mass_kg = 100.0, inertia_kg_m2 = {inertia} }}\n");
    for impossible in
        ["[1.0, 1.0, 3.0, 0.0, 0.0, 0.0]", "[1.0, 1.0, -1.0, 0.0, 0.0, 0.0]", "[1.0, 1.0, 1.0, 2.0, 0.0, 0.0]"]
    {
        let message = refused("any_arm_inertia", &[(urdf, &with(impossible))], &[]);
        assert!(message.contains("model.spacecraft = 100 kg") && message.contains("two others together"), "{message}");
    }
    let heavy = changed("any_arm_inertia", &[(urdf, &with("[10.0, 20.0, 29.0, 0.0, 0.0, 0.0]"))]);
    let checked = uarm(&["check", "--robot", heavy.to_str().unwrap()]);
    let text = String::from_utf8_lossy(&checked.stdout).into_owned();
    // As published: docs/your-own-robot.md.
    assert!(checked.status.success() && text.matches("no body has this inertia").count() == 1, "{text}");

    // 16 bits of 1 048 576 counts per revolution are 22.5 degrees of 340.
    let message = refused("any_arm_counter", &[("counter_bits = 32", "counter_bits = 16")], &[]);
    assert!(message.contains("joints[0].encoder.counter_bits = 16") && message.contains("22.5 deg"), "{message}");

    // A per mille of 100 kN m is 100 N m.
    let coarse = [("rated_torque_nm = 100.0", "rated_torque_nm = 100000.0")];
    let checked = uarm(&["check", "--robot", changed("any_arm_coarse", &coarse).to_str().unwrap()]);
    let text = String::from_utf8_lossy(&checked.stdout).into_owned();
    assert!(text.contains("less torque than one step of its drive, 100.0000 N m"), "{text}");
    assert_eq!(text.matches("one step of its drive").count(), 1, "{text}");
}

#[test]
fn a_robot_file_of_another_arm_is_mapped_and_refused_in_place_of_the_papers() {
    let of = |name: &str| uarm(&["map", name, "--json"]);
    let toml = of(file("seven-joint").to_str().unwrap());
    let urdf = file("seven-joint").with_extension("urdf");
    let urdf = uarm(&["map", urdf.to_str().unwrap(), "--tip", "tool", "--json"]);
    assert!(toml.status.success(), "{}", String::from_utf8_lossy(&toml.stderr));
    assert_eq!(toml.stdout, urdf.stdout);

    let log = scratch("any_arm_of_the_paper.mcap");
    let _ = std::fs::remove_file(&log);
    let log = log.to_str().unwrap();
    assert!(uarm(&["run", "--virtual-time", "--log", log]).status.success());
    let replayed = uarm(&["replay", log, "--robot", file("seven-joint").to_str().unwrap()]);
    let message = String::from_utf8_lossy(&replayed.stderr).into_owned();
    assert_eq!(replayed.status.code(), Some(1), "{message}");
    let expected =
        "joints = 7 active joints: expected a passive base and 2 active joints, as the robot has whose place it takes";
    assert!(message.contains(expected), "{message}");
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
    assert!(
        message.contains("--plant uarm: expected imperfect, ideal or space, since ETS-VII is another arm"),
        "{message}"
    );

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
}

#[test]
fn commands_for_the_papers_robot_alone_say_so() {
    let output = uarm(&["campaign", "--robot", file("seven-joint").to_str().unwrap()]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1));
    let expected = "joints = 7 active joints: expected a passive base and 2 active joints: what was asked for is for the paper's arm alone";
    assert!(message.contains(expected), "{message}");
}

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
