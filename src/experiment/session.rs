//! Experiments as the command line asks for them: announced, run on their own thread, watched, reported.

use std::io::{self, IsTerminal, Write};
use std::path::PathBuf;
use std::thread;
use std::time::Duration;

use anyhow::Context;
use hinf_control::Law;
use indicatif::{ProgressBar, ProgressStyle};
use sim::{Disturbance, VirtualClock};
use uarm_io::link::{Link, ObservedLink};
use uarm_io::monotonic::MonotonicClock;
use uarm_io::realtime::{Priority, Processor, RealtimePolicy, RealtimeSettings, RealtimeThread};
use uarm_io::time::{Clock, Instant};

use super::report::{COMPLETED, ClockKind, Ending, RunReport, Subject};
use super::{Finished, Settings, embedded, hardware};
use crate::commands::run::{PlantChoice, RealtimeChoice};
use crate::control_loop::LoopEnd;
use crate::control_loop::progress::Progress;
use crate::control_loop::record::NoRecorder;
use crate::control_loop::schedule::OverrunPolicy;
use crate::control_loop::task_clock::PeriodSource;
use crate::control_loop::torque::DisturbanceSite;
use crate::controllers::AdaptationGuard;
use crate::recording::{
    self, FrameRecorder, FullQueue, Leftovers, LoopRecorder, Notebook, Recording, RunEnd, Severity, Sink, Writer,
};
use crate::robot::Robot;
use crate::run_log::description::{RealtimeRequest, RunDescription};
use crate::run_log::place::LogChoice;
use crate::run_log::time_axis::TimeAxis;
use crate::run_log::writer::LogWriter;
use crate::signals::StopRequest;
use crate::trace::TraceWriter;

/// How often the progress line is drawn anew.
const PROGRESS_INTERVAL: Duration = Duration::from_millis(100);

/// Where experiments take place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// Drives on a CAN interface.
    Interface(String),
    /// The embedded robot on the wall clock.
    EmbeddedReal(PlantChoice),
    /// The embedded robot in virtual time.
    EmbeddedVirtual(PlantChoice),
}

/// How the loop's thread is scheduled.
#[derive(Clone, Copy, Debug)]
pub struct Realtime(RealtimeSettings);

impl Realtime {
    /// Settings from the command line.
    ///
    /// # Errors
    /// If priority or processor are out of range.
    pub fn new(choice: RealtimeChoice, priority: u8, processor: Option<usize>) -> anyhow::Result<Self> {
        let policy = match choice {
            RealtimeChoice::Enforce => RealtimePolicy::Enforce,
            RealtimeChoice::Prefer => RealtimePolicy::Prefer,
            RealtimeChoice::Off => RealtimePolicy::Off,
        };
        let priority = Priority::new(priority).context("--priority")?;
        let processor = processor.map(Processor::new).transpose().context("--cpu")?;
        Ok(Self(RealtimeSettings { policy, priority, processor }))
    }

    fn request(&self) -> RealtimeRequest {
        let RealtimeSettings { policy, priority, processor } = &self.0;
        RealtimeRequest {
            policy: policy.to_string(),
            priority: priority.to_string(),
            processor: processor.map_or_else(|| "any".to_owned(), |processor| processor.to_string()),
        }
    }
}

/// A series of experiments.
#[derive(Clone, Debug)]
pub struct Session {
    /// The law.
    pub law: Law,
    /// Where.
    pub place: Place,
    /// What keeps Φ from drifting.
    pub guard: AdaptationGuard,
    /// What to do about late cycles.
    pub overrun: OverrunPolicy,
    /// Where the laws' period comes from.
    pub period_source: PeriodSource,
    /// How long the way to the start of the task may take.
    pub approach: Option<Duration>,
    /// The disturbance.
    pub disturbance: Disturbance,
    /// Where it acts.
    pub disturbance_site: DisturbanceSite,
    /// Scheduling of the loop.
    pub realtime: Realtime,
    /// The log.
    pub log: LogChoice,
    /// The trace file.
    pub trace: Option<PathBuf>,
}

impl Session {
    /// What is about to move, and within which limits, line by line.
    pub fn announcement(&self, robot: &Robot) -> Vec<String> {
        let mut lines = vec![format!("{}: controller {} ({})", robot.name, self.law.name(), self.law.description())];
        lines.push(match &self.place {
            Place::Interface(interface) => format!("on real drives on {interface}: MOTORS WILL MOVE"),
            Place::EmbeddedReal(plant) => format!("on the embedded robot ({}), in real time", plant_name(*plant)),
            Place::EmbeddedVirtual(plant) => format!("on the embedded robot ({}), in virtual time", plant_name(*plant)),
        });
        for joint in robot.joints.iter().filter(|joint| joint.torque_limit > 0.0) {
            let [least, most] = joint.limits.position;
            lines.push(format!(
                "  {}: torque +-{} N m, {} N m/s; rate +-{:.0} deg/s; angle {:.0} to {:.0} deg",
                joint.name,
                joint.torque_limit,
                joint.torque_rate_limit,
                joint.limits.rate.to_degrees(),
                least.to_degrees(),
                most.to_degrees()
            ));
        }
        let period = robot.period.duration();
        let bus = robot.bus.time;
        lines.push(format!(
            "  period {period:?}; bus {:.0} us of it at {} bit/s; tracking error at most {:.0} deg",
            bus.cyclic.as_secs_f64() * 1e6,
            robot.bus.bit_rate.bits_per_second(),
            robot.tracking_error_limit.to_degrees()
        ));
        lines
    }

    /// Runs one experiment of `of`.
    ///
    /// # Errors
    /// If it cannot be begun, or a file cannot be opened.
    pub fn run(&self, robot: &Robot, number: u32, of: u32, stop: &StopRequest) -> anyhow::Result<RunReport> {
        let virtual_time = self.is_virtual();
        let Recorded { log, recording } = self.recorded(robot, number, of)?;
        let (mut tape, writer) = match recording {
            Some(Recording { loop_recorder, frame_recorder, writer }) => {
                (Some(Tape { loop_recorder, frame_recorder }), Some(writer))
            }
            None => (None, None),
        };
        let progress = Progress::default();
        let finished = thread::scope(|scope| {
            let (tape, notebook, progress) = (tape.as_mut(), writer.as_ref().map(Writer::notebook), &progress);
            let run = move || Start { session: self, robot, tape, notebook, progress, stop }.run();
            let experiment = thread::Builder::new().name("uarm-loop".into()).spawn_scoped(scope, run)?;
            if !virtual_time {
                show_progress(progress, robot.task.motion().end(), || experiment.is_finished());
            }
            experiment.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        });
        let leftovers =
            tape.map_or_else(Leftovers::default, |tape| Leftovers::of(tape.loop_recorder, tape.frame_recorder));
        let report = finished.map(|finished| self.report(robot, finished, log));
        let end = run_end(&report, &leftovers, writer.as_ref().map_or(0, Writer::dropped));
        let dropped = end.dropped;
        let losses = writer.map(|writer| writer.finish(leftovers, end)).unwrap_or_default();
        let mut report = report?;
        report.records_dropped = dropped;
        report.losses = losses;
        if dropped > 0 {
            report.losses.push(format!("{dropped} records found no room in queue and ring: the disk is too slow"));
        }
        Ok(report)
    }

    fn is_virtual(&self) -> bool {
        matches!(self.place, Place::EmbeddedVirtual(_))
    }

    /// Opens what the run is recorded in.
    fn recorded(&self, robot: &Robot, number: u32, of: u32) -> anyhow::Result<Recorded> {
        let file = |path: &PathBuf| if of == 1 { path.clone() } else { numbered(path, number) };
        let mut sinks: Vec<Box<dyn Sink>> = Vec::new();
        let choice = match &self.log {
            LogChoice::File(path) => LogChoice::File(file(path)),
            choice => choice.clone(),
        };
        let log = choice.create(self.law.name())?;
        if let Some((path, output)) = &log {
            let output = output.try_clone().with_context(|| path.display().to_string())?;
            sinks.push(Box::new(self.log_writer(robot, output, path)?));
        }
        if let Some(path) = &self.trace {
            let path = file(path);
            let output = std::fs::File::create(&path).with_context(|| format!("--trace {}", path.display()))?;
            sinks.push(Box::new(TraceWriter::new(io::BufWriter::new(output))));
        }
        if sinks.is_empty() {
            return Ok(Recorded { log: None, recording: None });
        }
        let full_queue = if self.is_virtual() { FullQueue::Wait } else { FullQueue::Keep };
        let recording = recording::start(sinks, full_queue).context("the writer thread")?;
        Ok(Recorded { log: log.map(|(path, _)| path), recording: Some(recording) })
    }

    fn log_writer(
        &self,
        robot: &Robot,
        output: std::fs::File,
        path: &std::path::Path,
    ) -> anyhow::Result<LogWriter<std::fs::File>> {
        let (axis, start) = match self.is_virtual() {
            true => (TimeAxis::simulated(), Instant::default()),
            false => (TimeAxis::monotonic(), MonotonicClock.now()),
        };
        let run = RunDescription { settings: self.settings(), place: self.place_name(), axis, robot: robot.clone() };
        LogWriter::new(output, path, &run, &self.realtime.request(), start, &self.announcement(robot))
            .with_context(|| format!("the log {}", path.display()))
    }

    fn settings(&self) -> Settings {
        Settings {
            law: self.law,
            guard: self.guard,
            overrun: self.overrun,
            period_source: self.period_source,
            approach: self.approach,
            disturbance: self.disturbance,
            disturbance_site: self.disturbance_site,
        }
    }

    fn place_name(&self) -> String {
        match &self.place {
            Place::Interface(interface) => interface.clone(),
            Place::EmbeddedReal(plant) => format!("embedded {}", plant_name(*plant)),
            Place::EmbeddedVirtual(plant) => format!("embedded {}, virtual time", plant_name(*plant)),
        }
    }

    fn plant_disturbance(&self) -> Disturbance {
        match self.disturbance_site {
            DisturbanceSite::Plant => self.disturbance,
            DisturbanceSite::Command => Disturbance::None,
        }
    }

    fn enter_real_time(&self, notebook: Option<&Notebook>) -> anyhow::Result<RealtimeThread> {
        let thread = RealtimeThread::enter(&self.realtime.0)?;
        for finding in thread.report() {
            let is_missing = !finding.how_to_get_it.is_empty();
            let text = format!("real time: {finding}");
            if is_missing {
                eprintln!("  {text}");
            }
            if let Some(notebook) = notebook {
                notebook.add(if is_missing { Severity::Warning } else { Severity::Info }, text);
            }
        }
        Ok(thread)
    }

    fn report(&self, robot: &Robot, finished: Finished, log: Option<PathBuf>) -> RunReport {
        let Finished { end, outcome, stop } = finished;
        let (completed, text, fault) = match &end {
            Ok(LoopEnd::Completed) => (true, COMPLETED.to_owned(), None),
            Ok(LoopEnd::Interrupted) => (false, format!("interrupted; {stop}"), None),
            Err(error) => (false, format!("FAILED: {error:#}; {stop}"), Some(format!("{error:#}"))),
        };
        let clock = match self.place {
            Place::EmbeddedVirtual(_) => ClockKind::Virtual,
            Place::EmbeddedReal(_) | Place::Interface(_) => ClockKind::Monotonic,
        };
        let subject = Subject { robot, plant: &self.place_name(), law: self.law, clock };
        RunReport::new(subject, Ending { text, fault, completed }, &outcome, log)
    }
}

/// What a run is recorded in.
struct Recorded {
    log: Option<PathBuf>,
    recording: Option<Recording>,
}

/// The loop's side of a recording.
struct Tape {
    loop_recorder: LoopRecorder,
    frame_recorder: FrameRecorder,
}

/// The end of a run, as the log keeps it.
fn run_end(report: &anyhow::Result<RunReport>, leftovers: &Leftovers, dropped: u64) -> RunEnd {
    let (text, fault, figures) = match report {
        Ok(report) => (report.end.clone(), report.fault.clone(), report.figures()),
        Err(error) => (format!("FAILED: {error:#}"), Some(format!("{error:#}")), Vec::new()),
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

/// All that an experiment needs.
struct Start<'a> {
    session: &'a Session,
    robot: &'a Robot,
    tape: Option<&'a mut Tape>,
    notebook: Option<Notebook>,
    progress: &'a Progress,
    stop: &'a StopRequest,
}

impl Start<'_> {
    /// On the loop's thread.
    fn run(self) -> anyhow::Result<Finished> {
        let Session { place, .. } = self.session;
        let (robot, disturbance) = (self.robot, self.session.plant_disturbance());
        match place {
            Place::EmbeddedVirtual(plant) => {
                let clock = VirtualClock::default();
                let link = embedded::link(robot, *plant, disturbance, clock.clone())?;
                self.on(link, clock)
            }
            Place::EmbeddedReal(plant) => {
                let link = embedded::link(robot, *plant, disturbance, MonotonicClock)?;
                let _thread = self.session.enter_real_time(self.notebook.as_ref())?;
                self.on(link, MonotonicClock)
            }
            Place::Interface(interface) => {
                let link = hardware::link(robot, interface)?;
                let _thread = self.session.enter_real_time(self.notebook.as_ref())?;
                self.on(link, MonotonicClock)
            }
        }
    }

    fn on<L: Link, C: Clock>(self, link: L, mut clock: C) -> anyhow::Result<Finished>
    where
        L::Error: Send + Sync + 'static,
    {
        let Self { session, robot, tape, progress, stop, .. } = self;
        let settings = session.settings();
        let finished = match tape {
            Some(Tape { loop_recorder, frame_recorder }) => {
                let link =
                    ObservedLink::new(link, |direction, frame: &_, at| frame_recorder.record(direction, frame, at));
                super::run(robot, &settings, link, &mut clock, loop_recorder, progress, stop)?.0
            }
            None => super::run(robot, &settings, link, &mut clock, NoRecorder, progress, stop)?.0,
        };
        Ok(finished)
    }
}

/// What a plant is called.
pub const fn plant_name(plant: PlantChoice) -> &'static str {
    match plant {
        PlantChoice::Uarm => "imperfect UARM",
        PlantChoice::Ideal => "ideal DEM",
        PlantChoice::Space => "free-floating space manipulator",
    }
}

/// `run.csv` of repetition 2 is `run-2.csv`.
fn numbered(path: &std::path::Path, number: u32) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let extension = path.extension().map(|extension| format!(".{}", extension.to_string_lossy())).unwrap_or_default();
    path.with_file_name(format!("{stem}-{number}{extension}"))
}

fn show_progress(progress: &Progress, duration: f64, finished: impl Fn() -> bool) {
    let bar =
        if io::stderr().is_terminal() { ProgressBar::new((duration * 1e3) as u64) } else { ProgressBar::hidden() };
    bar.set_style(ProgressStyle::with_template("  {bar:30} {msg}").unwrap_or_else(|_| ProgressStyle::default_bar()));
    while !finished() {
        let glimpse = progress.glimpse();
        let [error_2, error_3] = glimpse.error.map(f64::to_degrees);
        let [torque_2, torque_3] = glimpse.torque;
        bar.set_position((glimpse.time * 1e3) as u64);
        bar.set_message(format!(
            "{:6.2} s   error {error_2:+6.2} {error_3:+6.2} deg   torque {torque_2:+.3} {torque_3:+.3} N m",
            glimpse.time
        ));
        thread::sleep(PROGRESS_INTERVAL);
    }
    bar.finish_and_clear();
}

/// Prints the means over several experiments, as the paper gives them over five.
///
/// # Errors
/// If the output cannot be written.
pub fn print_mean(reports: &[RunReport], output: &mut impl Write) -> io::Result<()> {
    let count = reports.len() as f64;
    let mean = |value: fn(&RunReport) -> f64| reports.iter().map(value).sum::<f64>() / count;
    writeln!(
        output,
        "mean of {} experiments: L2 {:.4}, E {:.4} N m s",
        reports.len(),
        mean(|report| report.indices.l2),
        mean(|report| report.indices.e)
    )
}
