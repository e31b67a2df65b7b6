//! The controller and the simulated robot as two processes on a real `vcan0` make the motion that a run in process makes,
//! to the last bit.
//!
//! In guest time (`tools/can-guest run --mode icount`): on a busy machine in real time, a position may come later than
//! `control.feedback_timeout_us`. It is predicted then, as it must be, and the motion is another.

mod vcan_support;

use std::path::{Path, PathBuf};
use std::process::Command;
use uarm::dimensions::RunLog;
use uarm_log::signals::signals;
use vcan_support::bus::Bus;
use vcan_support::process::{Robot, Scheduling, succeed};
use vcan_support::report::need_guest_time;
use vcan_support::{INTERFACE, Workshop, odrive};

/// Cycles of the paper's task and its hold: 3.5 s at 3 ms.
const CYCLES: usize = 1_167;

/// What the two runs share, so that nothing but the bus differs: the loop in real time neither skips a cycle nor bounds the
/// parameters, and the one in process injects nothing.
const OVER_VCAN: [&str; 9] =
    ["run", "--can", INTERFACE, "--rt", "enforce", "--overrun", "catch-up", "--adaptation", "none"];
const IN_PROCESS: [&str; 4] = ["run", "--virtual-time", "--disturbance", "none"];

/// Runs both, with what `command` adds, and compares every signal but those of instants.
fn assert_same_motion(workshop: &Workshop, name: &str, command: impl Fn(&[&str]) -> Command) {
    let [over_vcan, in_process] = ["vcan", "in-process"].map(|kind| workshop.file(&format!("{kind}-{name}.mcap")));
    succeed(command(&OVER_VCAN).arg("--log").arg(&over_vcan));
    succeed(command(&IN_PROCESS).arg("--log").arg(&in_process));

    let (over_vcan, in_process) = (signals_of(&over_vcan), signals_of(&in_process));
    assert_eq!((over_vcan.len(), in_process.len()), (CYCLES, CYCLES), "{name}: cycles");
    for (cycle, (over, inside)) in over_vcan.iter().zip(&in_process).enumerate() {
        assert_eq!(over, inside, "{name}: cycle {cycle}");
    }
}

/// The signals of each cycle in a log, without the instants and without what the supervision makes of them: it takes the
/// instants as measured.
fn signals_of(log: &Path) -> Vec<String> {
    let log = RunLog::<3, 2>::read(log).unwrap_or_else(|error| panic!("{error}"));
    let row = |record: &_| {
        let signals = signals(record).into_iter().filter(|signal| !signal.name().starts_with("residual"));
        signals.map(|signal| format!("{} = {}", signal.name(), signal.value)).collect::<Vec<_>>().join(", ")
    };
    log.cycles.iter().map(row).collect()
}

#[test]
fn the_motion_over_vcan_is_the_one_in_process_byte_for_byte() {
    need_guest_time();
    let workshop = Workshop::new("motion");
    let robot: PathBuf = workshop.robot();
    for law in ["nonlinear", "adaptive", "fuzzy-model"] {
        let _drives = Robot::start(&workshop, &Bus::open(), Scheduling::Fifo, &[]);
        assert_same_motion(&workshop, law, |arguments| {
            let mut command = workshop.command();
            command.args(arguments).args(["--controller", law, "--robot"]).arg(&robot);
            command
        });
    }
}

#[test]
fn so_is_the_motion_of_odrive_axes() {
    need_guest_time();
    let workshop = Workshop::new("odrive-motion");
    let robot = odrive::robot_file(&workshop);
    let _axes = odrive::plant(&workshop, &Bus::open(), &robot, &[]);
    assert_same_motion(&workshop, "odrive", |arguments| odrive::command(&workshop, arguments, &robot));
}
