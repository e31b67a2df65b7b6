//! Experiments as the command line asks for them: announced, run on their own thread, watched, reported.

use std::io::{self, IsTerminal, Write};
use std::path::PathBuf;
use std::thread;
use std::time::Duration;

use anyhow::Context;
use hinf_control::Law;
use indicatif::{ProgressBar, ProgressStyle};
use sim::{Disturbance, VirtualClock};
use uarm_io::finding::Finding;
use uarm_io::link::Link;
use uarm_io::monotonic::MonotonicClock;
use uarm_io::realtime::{Priority, Processor, RealtimePolicy, RealtimeSettings, RealtimeThread};
use uarm_io::time::Clock;

use super::report::{BusReport, ClockKind, Indices, RunReport};
use super::{Finished, Settings, embedded, hardware};
use crate::commands::run::{PlantChoice, RealtimeChoice};
use crate::control_loop::LoopEnd;
use crate::control_loop::progress::Progress;
use crate::control_loop::record::{CycleRecord, Recorder};
use crate::control_loop::schedule::OverrunPolicy;
use crate::control_loop::task_clock::PeriodSource;
use crate::control_loop::torque::DisturbanceSite;
use crate::controllers::AdaptationGuard;
use crate::recording::{self, FullQueue, QueueRecorder, Sink};
use crate::robot::Robot;
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
    /// The trace file.
    pub trace: Option<PathBuf>,
}

impl Session {
    /// Tells what is about to move, and within which limits, before anything does.
    ///
    /// # Errors
    /// If standard error cannot be written.
    pub fn announce(&self, robot: &Robot) -> io::Result<()> {
        let mut output = io::stderr().lock();
        writeln!(output, "{}: controller {} ({})", robot.name, self.law.name(), self.law.description())?;
        let place = match &self.place {
            Place::Interface(interface) => format!("real drives on {interface}: MOTORS WILL MOVE"),
            Place::EmbeddedReal(plant) => format!("the embedded robot ({}), in real time", plant_name(*plant)),
            Place::EmbeddedVirtual(plant) => format!("the embedded robot ({}), in virtual time", plant_name(*plant)),
        };
        writeln!(output, "on {place}")?;
        for joint in robot.joints.iter().filter(|joint| joint.torque_limit > 0.0) {
            let [least, most] = joint.limits.position;
            writeln!(
                output,
                "  {}: torque +-{} N m, {} N m/s; rate +-{:.0} deg/s; angle {:.0} to {:.0} deg",
                joint.name,
                joint.torque_limit,
                joint.torque_rate_limit,
                joint.limits.rate.to_degrees(),
                least.to_degrees(),
                most.to_degrees()
            )?;
        }
        let period = robot.period.duration();
        let bus = robot.bus.time;
        writeln!(
            output,
            "  period {period:?}; bus {:.0} us of it at {} bit/s; tracking error at most {:.0} deg",
            bus.cyclic.as_secs_f64() * 1e6,
            robot.bus.bit_rate.bits_per_second(),
            robot.tracking_error_limit.to_degrees()
        )
    }

    /// Runs one experiment of `of`.
    ///
    /// # Errors
    /// If it cannot be begun, or a file cannot be opened.
    pub fn run(&self, robot: &Robot, number: u32, of: u32, stop: &StopRequest) -> anyhow::Result<RunReport> {
        let virtual_time = matches!(self.place, Place::EmbeddedVirtual(_));
        let full_queue = if virtual_time { FullQueue::Wait } else { FullQueue::Drop };
        let sinks = self.sinks(number, of)?;
        let (recorder, writer) = match sinks.is_empty() {
            true => (None, None),
            false => {
                let (recorder, writer) = recording::start(sinks, full_queue).context("the writer thread")?;
                (Some(recorder), Some(writer))
            }
        };
        let progress = Progress::default();
        let finished = thread::scope(|scope| {
            let run = || self.place(robot, recorder, &progress, stop);
            let experiment = thread::Builder::new().name("uarm-loop".into()).spawn_scoped(scope, run)?;
            if !virtual_time {
                show_progress(&progress, robot.task.motion().end(), || experiment.is_finished());
            }
            experiment.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        });
        let (finished, recorder) = finished?;
        let failures = writer.map(recording::Writer::finish).unwrap_or_default();
        let mut report = self.report(robot, finished);
        report.records_dropped = recorder.map_or(0, |recorder| recorder.dropped());
        report.losses = failures.iter().map(ToString::to_string).collect();
        if report.records_dropped > 0 {
            report.losses.push(format!("{} records did not fit the queue to the writer", report.records_dropped));
        }
        Ok(report)
    }

    fn sinks(&self, number: u32, of: u32) -> anyhow::Result<Vec<Box<dyn Sink>>> {
        let Some(path) = &self.trace else { return Ok(Vec::new()) };
        let path = if of == 1 { path.clone() } else { numbered(path, number) };
        let file = std::fs::File::create(&path).with_context(|| format!("--trace {}", path.display()))?;
        Ok(vec![Box::new(TraceWriter::new(io::BufWriter::new(file)))])
    }

    fn place(
        &self,
        robot: &Robot,
        recorder: Option<QueueRecorder>,
        progress: &Progress,
        stop: &StopRequest,
    ) -> anyhow::Result<(Finished, Option<QueueRecorder>)> {
        let start = Start { session: self, robot, recorder, progress, stop };
        match &self.place {
            Place::EmbeddedVirtual(plant) => {
                let clock = VirtualClock::default();
                let link = embedded::link(robot, *plant, self.plant_disturbance(), clock.clone())?;
                start.run(link, clock)
            }
            Place::EmbeddedReal(plant) => {
                let link = embedded::link(robot, *plant, self.plant_disturbance(), MonotonicClock)?;
                let _thread = self.enter_real_time()?;
                start.run(link, MonotonicClock)
            }
            Place::Interface(interface) => {
                let link = hardware::link(robot, interface)?;
                let _thread = self.enter_real_time()?;
                start.run(link, MonotonicClock)
            }
        }
    }

    fn plant_disturbance(&self) -> Disturbance {
        match self.disturbance_site {
            DisturbanceSite::Plant => self.disturbance,
            DisturbanceSite::Command => Disturbance::None,
        }
    }

    fn enter_real_time(&self) -> anyhow::Result<RealtimeThread> {
        let thread = RealtimeThread::enter(&self.realtime.0)?;
        for missing in thread.report().iter().filter(|finding| !finding.how_to_get_it.is_empty()) {
            note(missing);
        }
        Ok(thread)
    }

    fn report(&self, robot: &Robot, finished: Finished) -> RunReport {
        let outcome = finished.outcome;
        let (completed, end) = match &finished.end {
            Ok(LoopEnd::Completed) => (true, "completed".to_owned()),
            Ok(LoopEnd::Interrupted) => (false, format!("interrupted; {}", finished.stop)),
            Err(error) => (false, format!("FAILED: {error:#}; {}", finished.stop)),
        };
        let plant = match &self.place {
            Place::Interface(interface) => interface.clone(),
            Place::EmbeddedReal(plant) => format!("embedded {}", plant_name(*plant)),
            Place::EmbeddedVirtual(plant) => format!("embedded {}, virtual time", plant_name(*plant)),
        };
        let clock = match self.place {
            Place::EmbeddedVirtual(_) => ClockKind::Virtual,
            Place::EmbeddedReal(_) | Place::Interface(_) => ClockKind::Monotonic,
        };
        let bus = robot.bus.time;
        RunReport {
            robot: robot.name.clone(),
            plant,
            controller: self.law.name(),
            end,
            completed,
            indices: outcome.indices,
            paper: Indices::published(self.law),
            final_error_deg: outcome.final_error.map(f64::to_degrees),
            peak_torque_nm: outcome.peak_torque,
            base_drift_deg: outcome.base_drift.to_degrees(),
            limited_cycles: outcome.limited_cycles,
            timing: outcome.timing,
            clock,
            timing_verdict: (clock == ClockKind::Monotonic).then(|| outcome.timing.verdict()),
            bus: BusReport { time_per_cycle_us: bus.cyclic.as_secs_f64() * 1e6, load: bus.load },
            records_dropped: 0,
            losses: Vec::new(),
        }
    }
}

/// All that an experiment needs beside a link and a clock.
struct Start<'a> {
    session: &'a Session,
    robot: &'a Robot,
    recorder: Option<QueueRecorder>,
    progress: &'a Progress,
    stop: &'a StopRequest,
}

impl Start<'_> {
    fn run<L: Link, C: Clock>(self, link: L, mut clock: C) -> anyhow::Result<(Finished, Option<QueueRecorder>)>
    where
        L::Error: Send + Sync + 'static,
    {
        let settings = Settings {
            law: self.session.law,
            guard: self.session.guard,
            overrun: self.session.overrun,
            period_source: self.session.period_source,
            approach: self.session.approach,
            disturbance: self.session.disturbance,
            disturbance_site: self.session.disturbance_site,
        };
        super::run(self.robot, &settings, link, &mut clock, self.recorder, self.progress, self.stop)
    }
}

impl<R: Recorder> Recorder for Option<R> {
    fn record(&mut self, record: &CycleRecord) {
        if let Some(recorder) = self {
            recorder.record(record);
        }
    }
}

fn note(finding: &Finding) {
    eprintln!("  real time: {finding}");
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
