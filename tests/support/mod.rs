//! What several tests need: the binary, run; scratch files; a log of the built-in robot.
#![allow(dead_code, reason = "each test uses a part of it")]

use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Output};

use uarm::dimensions::{ACTIVE, JOINTS};
use uarm::robot::Robot;
use uarm_io::time::Instant;
use uarm_log::description::{LogHeader, MachineDescription, RunDescription};
use uarm_log::time_axis::TimeAxis;
use uarm_log::writer::LogWriter;
use uarm_loop::settings::Settings;
use uarm_loop::supervisor::{Ordinary, Supervisor};

/// Runs `uarm` in the folder of scratch files, so that logs that nobody named go there.
pub fn uarm(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_uarm")).args(arguments).current_dir(env!("CARGO_TARGET_TMPDIR")).output().unwrap()
}

/// All that a command printed.
pub fn text(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

/// Runs `uarm`, which must succeed, and gives what it printed on standard output.
pub fn standard_output(arguments: &[&str]) -> String {
    let output = uarm(arguments);
    assert!(output.status.success(), "{arguments:?}: {}", text(&output));
    String::from_utf8(output.stdout).unwrap()
}

/// A file of this test run, gone with the build folder.
pub fn scratch(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name)
}

/// A supervisor of a robot whose drives are enabled.
pub fn running_supervisor() -> Supervisor<()> {
    let mut supervisor = Supervisor::default();
    for event in [Ordinary::Begin, Ordinary::Prepared, Ordinary::Enabled] {
        supervisor.take(event);
    }
    supervisor
}

/// The log of a run of the built-in robot in virtual time, begun.
pub fn log_writer<W: Write>(output: W, settings: &Settings, preamble: &[String]) -> LogWriter<W, JOINTS, ACTIVE> {
    let robot = Robot::load(None).unwrap();
    let period = robot.description.period;
    let run = RunDescription::new(settings, "here", TimeAxis::simulated(), period, robot.for_log().unwrap());
    let header = LogHeader {
        name: "disk",
        run: &run,
        machine: &MachineDescription::default(),
        joints: &robot.joint_descriptions(),
        robot_source: &robot.source,
        start: Instant::default(),
        preamble,
    };
    LogWriter::new(output, &header).unwrap()
}
