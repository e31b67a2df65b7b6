//! The robot files, and what a run of one reports.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::support::{scratch, uarm};

pub const SHIPPED: [(&str, usize); 3] = [("planar-four-link", 3), ("ets-vii", 3), ("seven-joint", 7)];

/// An empty folder of this test.
pub fn folder_of(name: &str) -> PathBuf {
    let folder = scratch(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

pub fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("robots/{name}.toml"))
}

/// A run in virtual time without disturbance, and its report.
pub fn run_of(robot: &Path, arguments: &[&str]) -> Value {
    let robot = robot.to_str().unwrap();
    let common = ["run", "--virtual-time", "--json", "--robot", robot];
    let output = uarm(&[common.as_slice(), arguments].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice::<Value>(&output.stdout).unwrap()[0].take()
}

/// The robot of seven joints with other text, in a folder of its own.
pub fn changed(folder: &str, changes: &[(&str, &str)]) -> PathBuf {
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

pub fn refused(folder: &str, changes: &[(&str, &str)], arguments: &[&str]) -> String {
    let robot = changed(folder, changes);
    let common = ["run", "--virtual-time", "--log", "none", "--robot", robot.to_str().unwrap()];
    let output = uarm(&[common.as_slice(), arguments].concat());
    assert_eq!(output.status.code(), Some(1));
    String::from_utf8_lossy(&output.stderr).into_owned()
}
