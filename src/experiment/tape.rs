//! What an experiment is recorded in: its log and its trace, opened before it and closed after.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use anyhow::Context;
use uarm_io::monotonic::MonotonicClock;
use uarm_io::time::{Clock, Instant};

use super::report::{ClockKind, RunReport};
use super::session::Session;
use crate::recording::{
    self, FrameRecorder, FullQueue, Leftovers, LoopRecorder, Notebook, Recording, RunEnd, Sink, Writer,
};
use crate::robot::Robot;
use crate::run_log::description::RunDescription;
use crate::run_log::place::LogChoice;
use crate::run_log::time_axis::TimeAxis;
use crate::run_log::writer::LogWriter;
use crate::trace::TraceWriter;

/// Which of how many repetitions an experiment is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Repetition {
    /// Counted from 1.
    pub number: u32,
    /// How many there are.
    pub of: u32,
}

impl Repetition {
    /// `run.csv` of repetition 2 is `run-2.csv`, unless it is the only one.
    fn file(self, path: &Path) -> PathBuf {
        if self.of == 1 {
            return path.to_owned();
        }
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let extension =
            path.extension().map(|extension| format!(".{}", extension.to_string_lossy())).unwrap_or_default();
        path.with_file_name(format!("{stem}-{}{extension}", self.number))
    }
}

/// The loop's side of a recording.
#[derive(Debug)]
pub struct LoopSide {
    /// For the loop.
    pub cycles: LoopRecorder,
    /// For its link.
    pub frames: FrameRecorder,
}

/// A recording that runs, if one was asked for.
pub struct Tape {
    log: Option<PathBuf>,
    ends: Option<(LoopSide, Writer)>,
}

/// What a recording lost.
#[derive(Debug, Default)]
pub struct Losses {
    /// Records that found no room.
    pub dropped: u64,
    /// In words, these and others.
    pub texts: Vec<String>,
}

impl Tape {
    /// Opens the files that `session` asks for, and starts their writer.
    ///
    /// # Errors
    /// If a file cannot be opened.
    pub fn start(session: &Session, robot: &Robot, repetition: Repetition) -> anyhow::Result<Self> {
        let mut sinks: Vec<Box<dyn Sink>> = Vec::new();
        let choice = match &session.log {
            LogChoice::File(path) => LogChoice::File(repetition.file(path)),
            choice => choice.clone(),
        };
        let mut log = None;
        if let Some((path, output)) = choice.create(session.settings.law.name())? {
            sinks.push(Box::new(log_writer(session, robot, output, &path)?));
            log = Some(path);
        }
        if let Some(path) = &session.trace {
            let path = repetition.file(path);
            let output = File::create(&path).with_context(|| format!("--trace {}", path.display()))?;
            sinks.push(Box::new(TraceWriter::new(BufWriter::new(output))));
        }
        if sinks.is_empty() {
            return Ok(Self { log, ends: None });
        }
        let full_queue = match session.place.clock() {
            ClockKind::Virtual => FullQueue::Wait,
            ClockKind::Monotonic => FullQueue::Keep,
        };
        let Recording { loop_recorder, frame_recorder, writer } =
            recording::start(sinks, full_queue, robot.period.duration()).context("the writer thread")?;
        Ok(Self { log, ends: Some((LoopSide { cycles: loop_recorder, frames: frame_recorder }, writer)) })
    }

    /// The log.
    pub fn log(&self) -> Option<&Path> {
        self.log.as_deref()
    }

    /// What the loop's thread needs of it.
    pub fn for_the_loop(&mut self) -> (Option<&mut LoopSide>, Option<Notebook>) {
        match &mut self.ends {
            Some((loop_side, writer)) => (Some(loop_side), Some(writer.notebook())),
            None => (None, None),
        }
    }

    /// Waits until all is written that can be.
    pub fn finish(self, end: &End<'_>) -> Losses {
        let Some((LoopSide { cycles, frames }, writer)) = self.ends else { return Losses::default() };
        let leftovers = Leftovers::of(cycles, frames);
        let dropped = writer.dropped();
        let end = end.record(&leftovers, dropped);
        let mut texts = writer.finish(leftovers, end);
        if dropped > 0 {
            texts.push(format!("{dropped} records found no room in queue and ring: the disk is too slow"));
        }
        Losses { dropped, texts }
    }
}

/// How an experiment ended.
#[derive(Clone, Copy, Debug)]
pub enum End<'a> {
    /// With a report.
    Reported(&'a RunReport),
    /// Before it could begin, or by a bug.
    Failed(&'a str),
}

impl End<'_> {
    fn record(&self, leftovers: &Leftovers, dropped: u64) -> RunEnd {
        let (text, fault, figures) = match self {
            Self::Reported(report) => (report.end.clone(), report.fault.clone(), report.figures()),
            Self::Failed(cause) => (format!("FAILED: {cause}"), Some((*cause).to_owned()), Vec::new()),
        };
        let count = |kept: usize| u64::try_from(kept).unwrap_or(u64::MAX);
        RunEnd {
            text,
            fault,
            figures,
            cycles_kept: count(leftovers.cycles.len()),
            frames_kept: count(leftovers.frames.len()),
            dropped,
        }
    }
}

fn log_writer(session: &Session, robot: &Robot, output: File, path: &Path) -> anyhow::Result<LogWriter<File>> {
    let (axis, start) = match session.place.clock() {
        ClockKind::Virtual => (TimeAxis::simulated(), Instant::default()),
        ClockKind::Monotonic => (TimeAxis::monotonic(), MonotonicClock.now()),
    };
    let run = RunDescription { settings: session.settings, place: session.place.name(), axis, robot: robot.clone() };
    LogWriter::new(output, path, &run, &session.realtime.request(), start, &session.announcement(robot))
        .with_context(|| format!("the log {}", path.display()))
}
