//! What a log has told so far.

use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::dimensions::CycleRecord;
use crate::dimensions::Item;
use crate::robot::Robot;
use crate::robot::shape::Shape;
use uarm_log::decoder::LoggedNote;
use uarm_log::description::{Fields, RunDescription};
use uarm_log::follow::Growth;
use uarm_log::proto;
use uarm_log::reader::is_gap;
use uarm_loop::timing::{TimingRecorder, TimingSummary};

/// How much of the past is plotted.
pub const HISTORY: Duration = Duration::from_secs(10);
/// Notes that are kept.
const MOST_NOTES: usize = 8;
/// Damages that are kept.
const MOST_DAMAGES: usize = 8;
/// A log without an end that has not grown for so long is no longer written: a chunk comes four times a second.
const SILENCE: Duration = Duration::from_secs(2);

/// All that is known.
#[derive(Debug)]
pub struct State<const J: usize, const N: usize> {
    /// The log.
    pub file: PathBuf,
    /// Whether it may still grow.
    pub growth: Growth,
    /// How long it has not.
    pub silent_for: Duration,
    /// What is run.
    pub run: Option<RunDescription>,
    /// The shape of its robot, if the program knows it.
    pub shape: Option<Shape>,
    /// The names of the joints.
    pub joint_names: [String; J],
    /// When the first cycle was due, on the file's axis.
    pub begin: Option<u64>,
    /// Cycles in which the limiter cut a torque.
    pub limited_cycles: u64,
    /// Bus and drives as they were last.
    pub health: Option<Box<proto::CanHealth>>,
    /// The last lines of text.
    pub notes: Vec<LoggedNote>,
    /// Why it failed.
    pub fault: Option<proto::Fault>,
    /// The file beside this one in which the run goes on.
    pub next: Option<String>,
    /// How it ended.
    pub end: Option<Fields>,
    /// What could not be read, the last of it.
    pub damage: Vec<String>,
    timing: Option<TimingRecorder>,
    cycles: Vec<CycleRecord<J, N>>,
}

/// How the run is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Life {
    /// It has not begun.
    Beginning,
    /// Cycles are being recorded.
    Running,
    /// Nothing was written for so long: the process was killed or is stopped, or the disk stands still.
    Silent(Duration),
    /// It failed, of this first cause.
    Failed(String),
    /// It ended, as these words tell.
    Ended(String),
    /// Nothing more can be read: the file is damaged.
    Unreadable,
}

impl<const J: usize, const N: usize> State<J, N> {
    /// Nothing is known of this log.
    pub fn new(file: &Path) -> Self {
        Self {
            file: file.to_owned(),
            growth: Growth::Open,
            silent_for: Duration::ZERO,
            run: None,
            shape: None,
            joint_names: [const { String::new() }; J],
            begin: None,
            limited_cycles: 0,
            health: None,
            notes: Vec::new(),
            fault: None,
            next: None,
            end: None,
            damage: Vec::new(),
            timing: None,
            cycles: Vec::new(),
        }
    }

    /// Takes in what the log tells.
    pub fn take(&mut self, item: Item<J, N>) {
        match item {
            Item::Run(run) => {
                // The next part of a run repeats what is run.
                self.timing.get_or_insert_with(|| TimingRecorder::new(run.period.duration()));
                self.shape = Shape::of(&self.file, &run.robot.toml).ok();
                self.joint_names = joint_names::<J, N>(&self.file, &run);
                self.run = Some(*run);
            }
            Item::Cycle(record) => self.cycle(&record),
            Item::Health(health) => self.health = Some(health),
            Item::Note(note) => keep(&mut self.notes, note, MOST_NOTES),
            Item::Fault(fault) => self.fault = Some(fault),
            Item::Next(file) => self.next = Some(file),
            Item::End(end) => self.end = Some(end),
            Item::Damage(what) => keep(&mut self.damage, what, MOST_DAMAGES),
            Item::Machine(_) | Item::Drives(_) | Item::Part(_) | Item::Frame(_) | Item::Keyframe(..) | Item::Closed => {
            }
        }
    }

    fn cycle(&mut self, record: &CycleRecord<J, N>) {
        if let Some(previous) = self.cycles.last().filter(|previous| is_gap(previous, record)) {
            let what = format!("cycles between tick {} and tick {} are not in the log", previous.tick, record.tick);
            keep(&mut self.damage, what, MOST_DAMAGES);
        }
        if let Some(timing) = &mut self.timing {
            timing.record(&record.instants, record.elapsed_ticks);
        }
        if let Some(run) = &self.run {
            self.begin.get_or_insert(run.axis.at(record.instants.scheduled));
        }
        self.limited_cycles += u64::from(record.flags.limited.contains(&true));
        self.cycles.push(*record);
        // Seldom, so that it costs little, and still no run is too long.
        let first_kept = self.first_recent();
        if first_kept > self.cycles.len() / 2 {
            self.cycles.drain(..first_kept);
        }
    }

    fn first_recent(&self) -> usize {
        let start = self.cycles.last().map_or(0.0, |last| last.time - HISTORY.as_secs_f64());
        self.cycles.partition_point(|record| record.time < start)
    }

    /// The last cycles, of [`HISTORY`].
    pub fn recent(&self) -> &[CycleRecord<J, N>] {
        self.cycles.get(self.first_recent()..).unwrap_or_default()
    }

    /// The last cycle.
    pub fn last(&self) -> Option<&CycleRecord<J, N>> {
        self.cycles.last()
    }

    /// Timing since the start of the run.
    pub fn timing(&self) -> Option<TimingSummary> {
        self.timing.as_ref().map(TimingRecorder::summary)
    }

    /// How the run is.
    pub fn life(&self) -> Life {
        let end = self.end.as_ref().map(|end| end.get("end").cloned().unwrap_or_default());
        match (&self.fault, end) {
            (Some(fault), _) => Life::Failed(fault.cause.clone()),
            (None, Some(end)) => Life::Ended(end),
            (None, None) if self.growth == Growth::Ended => Life::Unreadable,
            (None, None) if self.silent_for > SILENCE => Life::Silent(self.silent_for),
            (None, None) if self.cycles.is_empty() => Life::Beginning,
            (None, None) => Life::Running,
        }
    }
}

fn keep<V>(kept: &mut Vec<V>, value: V, most: usize) {
    if kept.len() == most {
        kept.remove(0);
    }
    kept.push(value);
}

/// The names of the joints, as far as the robot in the log can be read.
fn joint_names<const J: usize, const N: usize>(file: &Path, run: &RunDescription) -> [String; J] {
    match Robot::<J, N>::from_log(file, &run.robot) {
        Ok(robot) => robot.description.joints.map(|joint| joint.name),
        Err(_) => std::array::from_fn(|index| format!("joint {}", index + 1)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_run_needs_no_more_room_than_its_history() {
        let mut state = State::<3, 2>::new(Path::new("run.mcap"));
        for tick in 0..100_000_u32 {
            let cycle = CycleRecord {
                tick: tick.into(),
                elapsed_ticks: 1,
                time: f64::from(tick) * 0.003,
                ..CycleRecord::default()
            };
            state.take(Item::Cycle(Box::new(cycle)));
        }
        assert_eq!(state.recent().len(), 3334, "10 s of 3 ms");
        assert!(state.cycles.len() < 2 * 3334 + 2, "{}", state.cycles.len());
        assert!(state.damage.is_empty());
        assert_eq!(state.life(), Life::Running);
    }

    #[test]
    fn a_gap_is_told() {
        let mut state = State::<3, 2>::new(Path::new("run.mcap"));
        for tick in [1, 2, 7] {
            state.take(Item::Cycle(Box::new(CycleRecord { tick, elapsed_ticks: 1, ..CycleRecord::default() })));
        }
        assert_eq!(state.damage, ["cycles between tick 2 and tick 7 are not in the log"]);
    }
}
