//! The torque that drives report, from their second TPDO to the columns of a CSV file.

mod support;

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Output};

use support::text;

fn uarm(folder: &Path, arguments: &[&str]) -> Output {
    let output = Command::new(env!("CARGO_BIN_EXE_uarm")).args(arguments).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{}", text(&output));
    output
}

/// The columns of a CSV file by name.
fn columns(file: &str) -> BTreeMap<&str, Vec<&str>> {
    let mut lines = file.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = lines.next().unwrap();
    let rows: Vec<_> = lines.collect();
    header.iter().enumerate().map(|(index, name)| (*name, rows.iter().map(|row| row[index]).collect())).collect()
}

/// The drives of joints 2 and 3 report, that of the base does not. An emulated drive's torque is the target of the cycle before,
/// and its rated torque 0.2 N m: one per mille of it are 0.0002 N m.
#[test]
fn what_the_drives_report_is_in_the_log_and_the_others_have_no_column() {
    let folder = support::scratch("torque-feedback");
    std::fs::create_dir_all(&folder).unwrap();
    let before = "drive = { ";
    let mut pieces = uarm::robot::BUILT_IN.split(before);
    let mut robot = pieces.next().unwrap().to_owned();
    for (joint, piece) in pieces.enumerate() {
        let pdo = if joint == 0 { "" } else { "pdo = { torque_tpdo = 2 }, " };
        robot += &format!("{before}{pdo}{piece}");
    }
    std::fs::write(folder.join("robot.toml"), robot).unwrap();
    uarm(&folder, &["run", "--virtual-time", "--robot", "robot.toml", "--log", "run.mcap", "--hold", "0s"]);
    uarm(&folder, &["show", "run.mcap", "--csv", "run.csv", "--force"]);
    let plot = uarm(&folder, &["show", "run.mcap", "--plot"]);
    uarm(&folder, &["replay", "run.mcap"]);
    let file = std::fs::read_to_string(folder.join("run.csv")).unwrap();
    std::fs::remove_dir_all(&folder).unwrap();

    let columns = columns(&file);
    assert!(!columns.keys().any(|name| name.starts_with("torque_actual_1")));
    for joint in [2, 3] {
        let of = |name: &str| &columns[format!("{name}_{joint}_per_mille").as_str()];
        let (sent, reported) = (of("torque_sent"), of("torque_actual"));
        assert_eq!(reported[0], "0", "before the first torque");
        assert_eq!(reported[1..], sent[..sent.len() - 1], "joint {joint}");
        assert!(reported.iter().any(|torque| torque.parse::<i32>().unwrap().abs() > 10), "joint {joint} moves");
        for (newton_metres, per_mille) in columns[format!("torque_actual_{joint}_nm").as_str()].iter().zip(reported) {
            let (torque, per_mille): (f64, f64) = (newton_metres.parse().unwrap(), per_mille.parse().unwrap());
            assert!((torque - 0.0002 * per_mille).abs() < 1e-15, "joint {joint}: {torque} N m, {per_mille} per mille");
        }
    }
    assert!(text(&plot).contains("joint 2, reported"), "{}", text(&plot));
}
