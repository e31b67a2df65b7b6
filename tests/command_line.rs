//! The binary as its users run it.

mod patient_robot;
mod support;

use std::process::{Command, Output, Stdio};

use support::{scratch, uarm};

fn standard_output(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn standard_error(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

fn code(output: &Output) -> i32 {
    output.status.code().unwrap_or_else(|| panic!("{}", standard_error(output)))
}

#[test]
fn run_reports_the_indices_beside_the_papers() {
    let output = uarm(&["run", "--virtual-time"]);
    assert_eq!(code(&output), 0, "{}", standard_error(&output));
    let report = standard_output(&output);
    for part in ["completed", "L2", "paper 0.0778", "E (N m s)", "paper 0.1419", "virtual time", "base drift"] {
        assert!(report.contains(part), "{part}: {report}");
    }
    let announcement = standard_error(&output);
    assert!(announcement.contains("torque +-0.2 N m"), "limits stand before motion: {announcement}");
}

#[test]
fn run_as_json_has_nothing_else_on_standard_output() {
    let output = uarm(&["run", "--virtual-time", "--json", "--repeat", "2", "--controller", "adaptive"]);
    let mut reports: serde_json::Value = serde_json::from_str(&standard_output(&output)).unwrap();
    assert_eq!(reports.as_array().unwrap().len(), 2);
    let logs = [reports[0]["log"].take(), reports[1]["log"].take()];
    assert!(logs.iter().all(|log| log.as_str().is_some_and(|log| log.starts_with("runs/"))), "{logs:?}");
    assert_ne!(logs[0], logs[1]);
    assert_eq!(reports[0], reports[1], "virtual time repeats itself to the bit");
    assert_eq!(reports[0]["controller"], "adaptive");
    assert_eq!(reports[0]["timing"]["cycles"], 1167);
    assert_eq!(reports[0]["timing"]["missed_deadlines"], 0);
}

#[test]
fn every_plant_and_law_runs() {
    for plant in ["uarm", "ideal", "space"] {
        for law in hinf_control::Law::ALL {
            let output = uarm(&["run", "--virtual-time", "--plant", plant, "--controller", law.name()]);
            assert_eq!(code(&output), 0, "{plant}, {}: {}", law.name(), standard_error(&output));
        }
    }
}

#[test]
fn csv_files_are_the_same_bytes_each_time_and_hold_every_cycle() {
    let table = |name: &str| {
        let path = scratch(name);
        let _ = std::fs::remove_file(&path);
        let log = path.to_str().unwrap();
        let output = uarm(&["run", "--virtual-time", "--controller", "fuzzy", "--log", log]);
        assert_eq!(code(&output), 0, "{}", standard_error(&output));
        standard_output(&uarm(&["show", log, "--csv", "-"]))
    };
    let first = table("first.mcap");
    assert_eq!(first, table("second.mcap"));
    assert_eq!(first.lines().count(), 1 + 1_167);
    let columns = first.lines().next().unwrap().split(',').count();
    assert!(first.lines().all(|line| line.split(',').count() == columns));
    assert!(first.lines().next().unwrap().contains("phi_54"));
}

#[test]
fn a_real_time_run_is_interrupted_cleanly() {
    let running = Command::new(env!("CARGO_BIN_EXE_uarm"))
        .args(["run", "--rt", "off", "--hold", "60s", "--robot"])
        .arg(patient_robot::write(&scratch("")))
        .current_dir(env!("CARGO_TARGET_TMPDIR"))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    std::thread::sleep(std::time::Duration::from_millis(800));
    let pid = rustix::process::Pid::from_child(&running);
    rustix::process::kill_process(pid, rustix::process::Signal::INT).unwrap();
    let output = running.wait_with_output().unwrap();
    assert_eq!(code(&output), 1);
    let report = standard_output(&output);
    assert!(report.contains("interrupted; all drives confirmed power off, brakes closed"), "{report}");
    for part in ["cycles of 3 ms", "wake-up", "p99.9", "verdict"] {
        assert!(report.contains(part), "the summary follows, with {part}: {report}");
    }
}

#[test]
fn map_turns_table_1_into_table_2() {
    let report = standard_output(&uarm(&["map"]));
    for number in ["free", "0.850129", "0.624954", "0.203075", "0.203189", "0.202982", "0.0963200", "0.0769817"] {
        assert!(report.contains(number), "{number}: {report}");
    }
    let rows: serde_json::Value = serde_json::from_str(&standard_output(&uarm(&["map", "--json"]))).unwrap();
    assert_eq!(rows[0]["mass_kg"], serde_json::Value::Null);
    assert_eq!(rows.as_array().unwrap().len(), 3);
}

#[test]
fn map_takes_any_manipulator_and_refuses_what_is_none() {
    let path = scratch("manipulator.toml");
    let link =
        "{ mass_kg = 1.0, inertia_kg_m2 = 0.1, joint_to_centre_of_mass_m = 0.5, centre_of_mass_to_joint_m = 0.5 }";
    let text = |links: &str| {
        format!(
            "[space_manipulator]\nspacecraft = {{ mass_kg = 10.0, inertia_kg_m2 = 1.0, centre_of_mass_to_joint_m = 0.5 }}\n\
             links = [{links}]\n"
        )
    };
    std::fs::write(&path, text(&[link; 5].join(", "))).unwrap();
    let output = uarm(&["map", "--json", path.to_str().unwrap()]);
    let rows: serde_json::Value = serde_json::from_str(&standard_output(&output)).unwrap();
    assert_eq!(rows.as_array().unwrap().len(), 6);

    std::fs::write(&path, text(&link.replace("1.0,", "-1.0,"))).unwrap();
    let output = uarm(&["map", path.to_str().unwrap()]);
    assert_eq!(code(&output), 1);
    let message = standard_error(&output);
    assert!(message.contains("manipulator.toml") && message.contains("mass") && message.contains("-1"), "{message}");
}

#[test]
fn filters_compares_every_estimator_on_every_encoder() {
    let report = standard_output(&uarm(&["filters"]));
    for part in ["low-pass (paper)", "Kalman", "Levant", "65536", "best by the numbers", "default: low-pass (paper)"] {
        assert!(report.contains(part), "{part}: {report}");
    }
    let study: serde_json::Value = serde_json::from_str(&standard_output(&uarm(&["filters", "--json"]))).unwrap();
    assert_eq!(study["rows"].as_array().unwrap().len(), 6 * 5 * 2);
}

#[test]
fn wrong_usage_is_exit_code_2_and_names_what_there_is() {
    for arguments in [
        &["run", "--controller", "magic"][..],
        &["run", "--can", "vcan0", "--virtual-time"],
        &["run", "--period", "fast"],
        &["plant"],
        &["plant", "--can", "vcan0", "--step", "0"],
        &["plant", "--can", "vcan0", "--step", "11ms"],
        &["walk"],
    ] {
        assert_eq!(code(&uarm(arguments)), 2, "{arguments:?}");
    }
    assert!(standard_error(&uarm(&["run", "--controller", "magic"])).contains("neural-model"));
}

const UARM: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/uarm.toml");
const NO_NODE_9: &str = "--node 9: expected one of the robot's nodes, [1, 2, 3]";

/// What only the robot file, the log or another option can tell is wrong usage all the same.
#[test]
fn options_that_do_not_go_together_are_exit_code_2_and_named() {
    let log = scratch("usage.mcap");
    let _ = std::fs::remove_file(&log);
    let log = log.to_str().unwrap();
    assert_eq!(code(&uarm(&["run", "--virtual-time", "--log", log])), 0);
    let eds = scratch("usage.eds");
    std::fs::write(&eds, uarm_io::drive::wire::DRIVE_EDS).unwrap();
    let eds = eds.to_str().unwrap();
    for (arguments, message) in [
        (
            &["run", "--virtual-time", "--log", "none", "--log-limit", "500MB"][..],
            "uarm: --log-limit: expected a log, --log none writes none\n",
        ),
        (&["run", "--virtual-time", "--log-limit", "1kB"], "uarm: --log-limit: 1000 bytes, expected at least "),
        (
            &["run", "--virtual-time", "--controller", "neural", "--base-acceleration", "reduced"],
            "uarm: --base-acceleration reduced with --controller neural: expected ",
        ),
        (&["run", "--virtual-time", "--log", "none", "--eds", eds], "usage.eds: expected --node with it"),
        (&["check", "--eds", eds], "usage.eds: expected --node with it"),
        (&["replay", log, "--from", "-1"], "--from -1: expected a task time from 0.000 to 3.498 s, as the log has\n"),
        (&["replay", log, "--from", "99"], "--from 99: expected a task time from 0.000 to "),
        (&["compare", "--repeat", "0"], "invalid value '0' for '--repeat <N>': expected a whole number above 0"),
        (&["plant", "--can", "vcan0", "--fault", "2:fire"], "invalid value '2:fire' for '--fault <NODE[@TIME]:FAULT>'"),
        (
            &["plant", "--can", "vcan0", "--fault", "7:repair"],
            "--fault 7:...: expected one of the robot's nodes, [1, 2, 3]",
        ),
        (
            &["drive", "torque-test", "--per-mille", "20", "--yes", "--node", "9", "--robot", UARM, "--can", "vcan0"],
            NO_NODE_9,
        ),
        (&["drive", "direction", "--node", "9", "--robot", UARM, "--can", "vcan0"], NO_NODE_9),
        (
            &["drive", "reference", "--angles", "0,20", "--yes", "--robot", UARM, "--can", "vcan0"],
            "--angles: 2 angles, expected 3, one for each joint of the robot file",
        ),
        (
            &["drive", "reference", "--angles", "0,20,200", "--yes", "--robot", UARM, "--can", "vcan0"],
            "--angles: 200 deg for joint 3, expected its limits, ",
        ),
        (&["campaign", "--seeds", "0"], "invalid value '0' for '--seeds <N>': expected a whole number above 0"),
    ] {
        let output = uarm(arguments);
        assert_eq!(code(&output), 2, "{arguments:?}: {}", standard_error(&output));
        assert!(standard_error(&output).contains(message), "{arguments:?}: {}", standard_error(&output));
    }
}

#[test]
fn what_cannot_be_is_exit_code_1_and_says_why() {
    for (arguments, part) in [
        (&["run", "--virtual-time", "--robot", "no/such.toml"][..], "no/such.toml"),
        (&["run", "--virtual-time", "--robot", "-"], "-: cannot be read: standard input is not read, expected a file"),
        (&["show", "-"], "standard input is not read, expected a file: write it to one first"),
        (&["replay", "-"], "standard input is not read, expected a file: write it to one first"),
        (&["drive", "check", "--eds", "-"], "standard input is not read, expected a file: write it to one first"),
        (&["run", "--virtual-time", "--log", "no/such/folder/run.mcap"], "no/such/folder/run.mcap"),
        (&["run", "--can", "nosuchcan0"], "nosuchcan0"),
        (&["plant", "--can", "nosuchcan0"], "nosuchcan0"),
    ] {
        let output = uarm(arguments);
        assert_eq!(code(&output), 1, "{arguments:?}");
        assert!(standard_error(&output).contains(part), "{arguments:?}: {}", standard_error(&output));
    }
}

#[test]
fn manual_pages_are_written_once() {
    let folder = scratch("man");
    let _ = std::fs::remove_dir_all(&folder);
    let man = ["man", folder.to_str().unwrap()];
    assert_eq!(code(&uarm(&man)), 0);
    let page = std::fs::read_to_string(folder.join("uarm-drive-check.1")).unwrap();
    assert!(page.contains(".TH uarm-drive-check 1") && page.contains("\\-\\-eds"), "{page}");
    let again = uarm(&man);
    assert_eq!(code(&again), 1);
    assert!(standard_error(&again).contains("uarm.1"), "{}", standard_error(&again));
    assert_eq!(code(&uarm(&[man.as_slice(), &["--force"]].concat())), 0);
}

#[test]
fn help_version_and_completions_are_there() {
    assert!(standard_output(&uarm(&["--version"])).contains("commit"));
    assert!(standard_output(&uarm(&["run", "--help"])).contains("uarm run --can can0"));
    assert!(standard_output(&uarm(&["--help"])).contains("3 finished with a loss"));
    for shell in ["bash", "zsh", "fish"] {
        assert!(standard_output(&uarm(&["completions", shell])).contains("virtual-time"), "{shell}");
    }
}
