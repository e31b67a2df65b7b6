//! Robots other than the paper's: every shipped one does its task under every law, and its log tells and replays it.

mod chain;
mod plants;
mod refusals;
mod robots;
mod studies;
#[path = "../support/mod.rs"]
mod support;

use hinf_control::Law;

use robots::{SHIPPED, changed, file, folder_of, refused, run_of};
use support::uarm;

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
