//! The recording of a run: its log, opened before it and closed after.

use std::fs::File;
use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};
use uarm_io::monotonic::MonotonicClock;
use uarm_io::time::{Clock, Instant};

use uarm_log::description::{ClockKind, LogHeader, MachineDescription, RunDescription};
use uarm_log::parts::{LogParts, SizeLimit};
use uarm_log::time_axis::TimeAxis;
use uarm_log::writer::LogWriter;
use uarm_loop::recording::{self, FrameRecorder, FullQueue, Leftovers, LoopRecorder, Recording, RunEnd, Sink};
use uarm_loop::settings::Settings;

use super::place::Place;
use crate::log_files::{LogChoice, LogPartFiles, PartCount, WrittenParts};
use crate::report::RunReport;
use crate::robot::Robot;

/// What lines of text are added to a log with.
pub use recording::LogHandle;

/// Which of how many repetitions a run is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Repetition {
    /// Counted from 1.
    pub number: u32,
    /// How many there are.
    pub of: u32,
}

impl Repetition {
    /// `run.mcap` of repetition 2 is `run-2.mcap`, unless it is the only one.
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
pub struct LoopSide<const J: usize, const N: usize> {
    /// What the loop records its cycles into.
    pub cycles: LoopRecorder<J, N>,
    /// What its link records frames into.
    pub frames: FrameRecorder,
}

/// The recording of a run, if one was asked for.
pub struct RunRecording<const J: usize, const N: usize> {
    log: Option<PathBuf>,
    parts: WrittenParts,
    ends: Option<(LoopSide<J, N>, recording::Writer<J, N>)>,
}

/// What a recording came to.
#[derive(Debug, Default)]
pub struct Recorded {
    /// The parts of its log, if there are several.
    pub parts: Option<PartCount>,
    /// Records that found no room.
    pub dropped: u64,
    /// In words, these and others.
    pub texts: Vec<String>,
}

impl<const J: usize, const N: usize> RunRecording<J, N> {
    /// Opens the log that `choice` asks for, and starts its writer.
    ///
    /// # Errors
    /// If the file cannot be opened.
    pub fn start(
        choice: &LogChoice,
        limit: SizeLimit,
        content: &LogContent<'_, J, N>,
        repetition: Repetition,
    ) -> anyhow::Result<Self> {
        let parts = WrittenParts::default();
        let choice = match choice {
            LogChoice::File(path) => LogChoice::File(repetition.file(path)),
            choice => choice.clone(),
        };
        let Some((path, output)) = choice.create(content.settings.law.name())? else {
            return Ok(Self { log: None, parts, ends: None });
        };
        let log = content.sink(output, &path, limit, &parts).with_context(|| format!("the log {}", path.display()))?;
        let full_queue = match content.place.clock() {
            ClockKind::Virtual => FullQueue::Wait,
            ClockKind::Monotonic => FullQueue::Keep,
        };
        let period = content.robot.description.period.duration();
        let Recording { loop_recorder, frame_recorder, writer } =
            recording::start(vec![log], full_queue, period).context("the writer thread")?;
        let loop_side = LoopSide { cycles: loop_recorder, frames: frame_recorder };
        Ok(Self { log: Some(path), parts, ends: Some((loop_side, writer)) })
    }

    /// The file, if there is one.
    pub fn log(&self) -> Option<&Path> {
        self.log.as_deref()
    }

    /// What the loop's thread needs of it.
    pub fn for_the_loop(&mut self) -> (Option<&mut LoopSide<J, N>>, Option<LogHandle<J, N>>) {
        match &mut self.ends {
            Some((loop_side, writer)) => (Some(loop_side), Some(writer.log_handle())),
            None => (None, None),
        }
    }

    /// Waits until all is written that can be.
    pub fn finish(self, end: &End<'_>) -> Recorded {
        let Some((LoopSide { cycles, frames }, writer)) = self.ends else { return Recorded::default() };
        let leftovers = Leftovers::of(cycles, frames);
        let dropped = writer.dropped();
        let end = end.record(&leftovers, dropped);
        let mut texts = writer.finish(leftovers, end);
        if dropped > 0 {
            texts.push(format!("{dropped} records found no room in queue and ring: the disk is too slow"));
        }
        let parts = Some(self.parts.count()).filter(|parts| parts.written > 1);
        Recorded { parts, dropped, texts }
    }
}

/// How an experiment ended.
#[derive(Clone, Copy, Debug)]
pub enum End<'a> {
    /// The run was made, and has a report.
    Reported(&'a RunReport),
    /// Before it could begin, or by a bug.
    Failed(&'a str),
}

impl End<'_> {
    fn record<const J: usize, const N: usize>(&self, leftovers: &Leftovers<J, N>, dropped: u64) -> RunEnd {
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

/// What a log is about.
#[derive(Clone, Copy, Debug)]
pub struct LogContent<'a, const J: usize, const N: usize> {
    /// The robot.
    pub robot: &'a Robot<J, N>,
    /// What the run does.
    pub settings: &'a Settings,
    /// Where it takes place.
    pub place: &'a Place,
    /// The machine.
    pub machine: &'a MachineDescription,
    /// What was announced, line by line.
    pub announcement: &'a [String],
}

impl<const J: usize, const N: usize> LogContent<'_, J, N> {
    /// Pipes and devices take all of it; files are parts of the size that `limit` asks for.
    fn sink(
        &self,
        output: File,
        path: &Path,
        limit: SizeLimit,
        parts: &WrittenParts,
    ) -> anyhow::Result<Box<dyn Sink<J, N>>> {
        let Self { robot, settings, place, machine, announcement } = self;
        let (axis, start) = match place.clock() {
            ClockKind::Virtual => (TimeAxis::simulated(), Instant::default()),
            ClockKind::Monotonic => (TimeAxis::monotonic(), MonotonicClock.now()),
        };
        let period = robot.description.period;
        let run = RunDescription::new(settings, &place.name(), axis, period, robot.for_log()?);
        let name = path.display().to_string();
        let header = LogHeader {
            name: &name,
            run: &run,
            machine,
            joints: &robot.joint_descriptions(),
            robot_source: &robot.source,
            start,
            preamble: announcement,
        };
        if output.metadata()?.is_file() {
            let behind = LogPartFiles::behind(path, &output, parts.clone())?;
            return Ok(Box::new(LogParts::new(output, behind, limit, &header)?));
        }
        ensure!(
            limit == SizeLimit::Unlimited,
            "it is no file, and what it was given cannot be deleted: expected a file with --log-limit"
        );
        Ok(Box::new(LogWriter::new(output, &header)?))
    }
}
