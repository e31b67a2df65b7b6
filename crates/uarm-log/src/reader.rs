//! The file, or what is left of it, read.

use std::fmt;
use std::io::{self, Read};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use crate::decoder::{Decoder, Item, LoggedNote};
use crate::description::{Fields, RunDescription};
use crate::drives::LoggedDrive;
use crate::proto;
use crate::records::{self, Records, Step};
use crate::regular_file;
use uarm_loop::keyframe::Keyframe;
use uarm_loop::record::CycleRecord;
use uarm_loop::recording::FrameRecord;

/// A run as its log tells it, of a robot with `J` joints of which `N` are active.
#[derive(Clone, Debug)]
pub struct RunLog<const J: usize, const N: usize> {
    /// The file.
    pub path: PathBuf,
    /// What was run.
    pub run: RunDescription,
    /// The machine that it ran on.
    pub machine: Fields,
    /// The drives that moved the robot, joint 1 first; none before they were set up, and in logs of earlier versions.
    pub drives: Vec<LoggedDrive>,
    /// Cycles, in the order of their ticks.
    pub cycles: Vec<CycleRecord<J, N>>,
    /// Frames, in the order in which the controller sent and received them.
    pub frames: Vec<FrameRecord>,
    /// Inner states, each with the tick that it follows.
    pub keyframes: Vec<(Option<u64>, Keyframe<J, N>)>,
    /// Bus and drives, the last record of them last.
    pub health: Vec<proto::CanHealth>,
    /// Lines of text, in the order of the file.
    pub notes: Vec<LoggedNote>,
    /// Why the run failed.
    pub fault: Option<proto::Fault>,
    /// Which part of the run the file is.
    pub part: Part,
    /// How it ended; nothing if the process was killed, and in all parts but the last.
    pub end: Option<Fields>,
    /// What could not be read, and what is missing.
    pub damage: Vec<String>,
}

/// Which part of a run a file is.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Part {
    /// Counted from 1.
    pub number: u32,
    /// The file beside it in which the run goes on.
    pub next: Option<String>,
}

impl Default for Part {
    /// The only one, or the first of a run that was killed.
    fn default() -> Self {
        Self { number: 1, next: None }
    }
}

impl Part {
    /// Whether it is the whole run.
    pub fn is_all(&self) -> bool {
        *self == Self::default()
    }
}

impl fmt::Display for Part {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "part {} of a run", self.number)?;
        match &self.next {
            Some(next) => write!(formatter, ", which goes on in {next}"),
            None => Ok(()),
        }
    }
}

/// Why a file gives no run at all.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file cannot be read.
    #[error("{}: {source}", file.display())]
    Io {
        /// The file.
        file: PathBuf,
        /// Why it cannot be read.
        source: io::Error,
    },
    /// There is no description of a run in it.
    #[error("{}: not a run log: {reason}", file.display())]
    NotALog {
        /// The file.
        file: PathBuf,
        /// What was found.
        reason: String,
    },
}

/// Most damages that are listed one by one.
const MOST_DAMAGES: usize = 20;

impl<const J: usize, const N: usize> RunLog<J, N> {
    /// Reads a log, as far as it can be read.
    ///
    /// # Errors
    /// [`ReadError`] if there is no description of a run in it.
    pub fn read(path: &Path) -> Result<Self, ReadError> {
        let file = regular_file::open(path).map_err(|source| ReadError::Io { file: path.to_owned(), source })?;
        Self::read_from(file, path)
    }

    /// Reads a log from `input`; `path` is what messages call it.
    ///
    /// # Errors
    /// As [`RunLog::read`].
    pub fn read_from(input: impl Read, path: &Path) -> Result<Self, ReadError> {
        let mut collected = Collected::default();
        let take = &mut |item| {
            collected.take(item);
            ControlFlow::Continue(())
        };
        each_item(input, take).map_err(|source| ReadError::Io { file: path.to_owned(), source })?;
        let mut log = collected.into_log(path)?;
        log.note_gaps(log.gaps());
        Ok(log)
    }

    /// Says how often records are missing between two cycles.
    pub(crate) fn note_gaps(&mut self, gaps: usize) {
        if gaps > 0 {
            self.damage.push(format!("{gaps} gaps: cycles that ran and are not in the log"));
        }
    }

    /// How often records are missing between two cycles.
    pub fn gaps(&self) -> usize {
        self.cycles.windows(2).filter(|pair| matches!(pair, [one, other] if is_gap(one, other))).count()
    }
}

/// Gives each item that can be read from `input`, and what cannot be read as damage, until `take` breaks off.
pub(crate) fn each_item<const J: usize, const N: usize>(
    input: impl Read,
    take: &mut dyn FnMut(Item<J, N>) -> ControlFlow<()>,
) -> io::Result<()> {
    let mut decoder = Decoder::new();
    let mut records = Records::new(input);
    let mut flow = ControlFlow::Continue(());
    let mut give = |item, flow: &mut ControlFlow<()>| {
        if flow.is_continue() {
            *flow = take(item);
        }
    };
    while flow.is_continue() {
        let step = records.step(|opcode, data| decoder.take(opcode, data, &mut |item| give(item, &mut flow)))?;
        let reason = match step {
            Step::Record => continue,
            Step::End => break,
            Step::Checksum { section, .. } => {
                give(Item::Damage(records::checksum_damage(section)), &mut flow);
                continue;
            }
            Step::Starved => "the file ends in the middle: it was not closed".to_owned(),
            Step::Broken(broken) => broken.to_string(),
        };
        match records.find_next()? {
            Some(skipped) => give(Item::Damage(format!("{skipped} bytes are left out: {reason}")), &mut flow),
            None => {
                give(Item::Damage(reason), &mut flow);
                break;
            }
        }
    }
    Ok(())
}

/// Whether records are missing between two cycles: a loop that skips ticks says so.
pub const fn is_gap<const J: usize, const N: usize>(one: &CycleRecord<J, N>, other: &CycleRecord<J, N>) -> bool {
    other.tick.saturating_sub(one.tick) != other.elapsed_ticks
}

/// What a log has told so far.
#[derive(Default)]
pub(crate) struct Collected<const J: usize, const N: usize> {
    run: Option<RunDescription>,
    machine: Fields,
    drives: Vec<LoggedDrive>,
    cycles: Vec<CycleRecord<J, N>>,
    frames: Vec<FrameRecord>,
    keyframes: Vec<(Option<u64>, Keyframe<J, N>)>,
    health: Vec<proto::CanHealth>,
    notes: Vec<LoggedNote>,
    fault: Option<proto::Fault>,
    part: Part,
    end: Option<Fields>,
    closed: bool,
    damage: Vec<String>,
    more_damage: usize,
}

impl<const J: usize, const N: usize> Collected<J, N> {
    fn damage(&mut self, what: String) {
        if self.damage.len() < MOST_DAMAGES {
            self.damage.push(what);
        } else {
            self.more_damage += 1;
        }
    }

    /// Keeps an item; of the health records the last.
    pub(crate) fn take_last_health(&mut self, item: Item<J, N>) {
        if matches!(item, Item::Health(_)) {
            self.health.clear();
        }
        self.take(item);
    }

    pub(crate) fn take(&mut self, item: Item<J, N>) {
        match item {
            Item::Run(run) => self.run = Some(*run),
            Item::Machine(machine) => self.machine = machine,
            Item::Drives(drives) => self.drives = drives,
            Item::Part(number) => self.part.number = number,
            Item::Next(file) => self.part.next = Some(file),
            Item::End(end) => self.end = Some(end),
            Item::Cycle(record) => self.cycles.push(*record),
            Item::Frame(frame) => self.frames.push(frame),
            Item::Keyframe(keyframe, after) => self.keyframes.push((after, *keyframe)),
            Item::Health(health) => self.health.push(*health),
            Item::Note(note) => self.notes.push(note),
            Item::Fault(fault) => self.fault = Some(fault),
            Item::Damage(what) => self.damage(what),
            Item::Closed => self.closed = true,
        }
    }

    pub(crate) fn into_log(mut self, path: &Path) -> Result<RunLog<J, N>, ReadError> {
        if self.end.is_none() && self.part.next.is_none() {
            self.damage("no end is recorded: the process was killed, or the disk failed".to_owned());
        }
        if self.more_damage > 0 {
            self.damage.push(format!("and {} more of the kind", self.more_damage));
        }
        let Some(run) = self.run else {
            let reason = self.damage.first().cloned().unwrap_or_else(|| "no metadata uarm.run".to_owned());
            return Err(ReadError::NotALog { file: path.to_owned(), reason });
        };
        // What was kept for the writer stands behind what came later.
        self.cycles.sort_by_key(|record| record.tick);
        self.frames.sort_by_key(|frame| frame.sequence);
        self.keyframes.sort_by_key(|(after, _)| *after);
        Ok(RunLog {
            path: path.to_owned(),
            run,
            machine: self.machine,
            drives: self.drives,
            cycles: self.cycles,
            frames: self.frames,
            keyframes: self.keyframes,
            health: self.health,
            notes: self.notes,
            fault: self.fault,
            part: self.part,
            end: self.end,
            damage: self.damage,
        })
    }
}
