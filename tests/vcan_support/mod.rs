//! What the tests on a real `vcan0` share: a folder in memory with the binary and the robot file, the two processes, and
//! an observer on the bus that shares no code with them.
#![allow(dead_code, reason = "each test binary uses its own part")]

pub mod bus;
pub mod disk;
pub mod odrive;
pub mod process;
pub mod report;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The interface that `tools/can-guest` brings up.
pub const INTERFACE: &str = "vcan0";

/// The drives' node ids in `robots/uarm.toml`: joint i is node i.
pub const NODES: [u8; 3] = [1, 2, 3];

/// The node of the first driven joint.
pub const DRIVEN_NODE: u8 = 2;

/// A folder for one test. In a guest it lies in memory, as all that a timed part touches must: the guest's time leaps
/// while it waits for a file of its host.
pub struct Workshop {
    folder: PathBuf,
}

impl Workshop {
    /// A folder named after the test, with a copy of the binary and of the robot file in it.
    pub fn new(test: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("uarm-{test}-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let workshop = Self { folder };
        fs::copy(env!("CARGO_BIN_EXE_uarm"), workshop.uarm()).unwrap();
        workshop.write_robot(&[]);
        workshop
    }

    /// The binary under test.
    pub fn uarm(&self) -> PathBuf {
        self.folder.join("uarm")
    }

    /// A command of the binary, in the folder: logs go there.
    pub fn command(&self) -> Command {
        let mut command = Command::new(self.uarm());
        command.current_dir(&self.folder);
        command
    }

    /// The robot file in use.
    pub fn robot(&self) -> PathBuf {
        self.folder.join("uarm.toml")
    }

    /// A path in the folder.
    pub fn file(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// Writes the robot file anew, with each first text replaced by the second; returns its path.
    pub fn write_robot(&self, replacements: &[(&str, &str)]) -> PathBuf {
        self.write_robot_as("uarm.toml", replacements)
    }

    /// As [`Workshop::write_robot`], to a file of another name.
    pub fn write_robot_as(&self, name: &str, replacements: &[(&str, &str)]) -> PathBuf {
        let original = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/uarm.toml");
        let mut text = fs::read_to_string(original).unwrap();
        for (from, to) in replacements {
            assert!(text.contains(from), "robots/uarm.toml no longer holds `{from}`");
            text = text.replace(from, to);
        }
        let path = self.file(name);
        fs::write(&path, text).unwrap();
        path
    }
}

impl Drop for Workshop {
    fn drop(&mut self) {
        // What is left behind lies in a temporary folder.
        let _ = fs::remove_dir_all(&self.folder);
    }
}
