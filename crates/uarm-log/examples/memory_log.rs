//! Writes a log of two cycles to memory, reads it back and prints it as CSV.

use std::io;
use std::path::Path;

use uarm_log::csv;
use uarm_log::description::{
    JointDescription, LinkDescription, LogHeader, MachineDescription, RobotDescription, RunDescription,
};
use uarm_log::reader::RunLog;
use uarm_log::time_axis::TimeAxis;
use uarm_log::writer::LogWriter;
use uarm_loop::hinf_control::Law;
use uarm_loop::period::Period;
use uarm_loop::record::CycleRecord;
use uarm_loop::recording::{Entry, RunEnd, Sink};
use uarm_loop::settings::Settings;
use uarm_loop::timing::CycleInstants;
use uarm_loop::uarm_io::time::{Duration, Instant};

/// Joints with drives, and how many of them are active.
const JOINTS: usize = 3;
const ACTIVE: usize = 2;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let period = Period::new(Duration::from_millis(3)).ok_or("a period of 0.1 to 100 ms")?;
    let robot = RobotDescription { name: "three joints".to_owned(), toml: String::new(), fuzzy_sets: None };
    let joints = [("base", 1), ("joint 2", 2), ("joint 3", 3)].map(|(name, node)| JointDescription {
        name: name.to_owned(),
        node,
        link: LinkDescription::along_x(0.203, 0.203),
    });
    let settings = Settings::paper(Law::Nonlinear);
    let header = LogHeader {
        name: "memory",
        run: &RunDescription::new(&settings, "no robot at all", TimeAxis::simulated(), period, robot),
        machine: &MachineDescription::default(),
        joints: &joints,
        robot_source: "",
        start: Instant::default(),
        preamble: &["written by an example".to_owned()],
    };

    let mut file = Vec::new();
    let mut log = LogWriter::new(&mut file, &header)?;
    for tick in 0..2 {
        let at = Instant::from_nanoseconds(period.nanoseconds(tick));
        let instants =
            CycleInstants { scheduled: at, woke: at, sync_sent: at, counts_in: at, torque_out: at, done: at };
        let cycle = CycleRecord::<JOINTS, ACTIVE> {
            tick,
            elapsed_ticks: tick.min(1),
            time: 0.003 * tick as f64,
            instants,
            measured_position: [0.0, 0.35, 0.35],
            ..CycleRecord::default()
        };
        log.take(Entry::Cycle(&cycle))?;
    }
    let end = RunEnd { text: "completed".to_owned(), ..RunEnd::default() };
    Sink::<JOINTS, ACTIVE>::take(&mut log, Entry::End(&end))?;
    drop(log);

    let read = RunLog::<JOINTS, ACTIVE>::read_from(file.as_slice(), Path::new("memory"))?;
    assert!(read.damage.is_empty(), "{:?}", read.damage);
    eprintln!("{} bytes, {} cycles, controller {}", file.len(), read.cycles.len(), read.run.controller);
    csv::write(&read.cycles, io::stdout().lock())?;
    Ok(())
}
