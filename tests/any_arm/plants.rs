//! The plants: ideal, with the imperfections of the robot file, and the space manipulator itself.

use std::path::Path;

use crate::robots::{SHIPPED, file, folder_of, run_of};
use crate::support::{scratch, uarm};

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
