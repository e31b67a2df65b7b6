//! Experiments as the command line asks for them: announced, run on their own thread, watched, reported.

use std::any::Any;
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::thread;

use super::loop_thread::Start;
use super::place::Place;
use super::realtime::Realtime;
use super::report::{COMPLETED, ClockKind, Ending, RunReport, Subject};
use super::tape::{End, Losses, Repetition, Tape};
use super::watch::show_progress;
use super::{Finished, Settings};
use crate::control_loop::LoopEnd;
use crate::control_loop::progress::Progress;
use crate::robot::Robot;
use crate::run_log::place::LogChoice;
use crate::signals::StopRequest;

/// A series of experiments.
#[derive(Clone, Debug)]
pub struct Session {
    /// What they do.
    pub settings: Settings,
    /// Where.
    pub place: Place,
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
        let law = self.settings.law;
        let mut lines = vec![
            format!("{}: controller {} ({})", robot.name, law.name(), law.description()),
            self.place.announcement(),
        ];
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

    /// Runs one experiment.
    ///
    /// # Errors
    /// If it cannot be begun, or a file cannot be opened.
    pub fn run(&self, robot: &Robot, repetition: Repetition, stop: &StopRequest) -> anyhow::Result<RunReport> {
        let mut tape = Tape::start(self, robot, repetition)?;
        let progress = Progress::default();
        let finished = thread::scope(|scope| {
            let (loop_side, notebook) = tape.for_the_loop();
            let progress = &progress;
            let run = move || Start { session: self, robot, loop_side, notebook, progress, stop }.run();
            let experiment = thread::Builder::new().name("uarm-loop".into()).spawn_scoped(scope, run)?;
            if self.place.clock() == ClockKind::Monotonic {
                show_progress(progress, robot.task.motion().end(), || experiment.is_finished());
            }
            Ok(experiment.join())
        });
        match finished.unwrap_or_else(|error: std::io::Error| Ok(Err(error.into()))) {
            Ok(Ok(finished)) => {
                let mut report = self.report(robot, &finished, tape.log());
                let Losses { dropped, texts } = tape.finish(&End::Reported(&report));
                report.records_dropped = dropped;
                report.losses = texts;
                Ok(report)
            }
            Ok(Err(error)) => {
                tape.finish(&End::Failed(&format!("{error:#}")));
                Err(error)
            }
            // The motors have been stopped; what led to the bug is worth keeping.
            Err(panic) => {
                tape.finish(&End::Failed(&format!("a bug: {}", panic_text(panic.as_ref()))));
                resume_unwind(panic)
            }
        }
    }

    fn report(&self, robot: &Robot, finished: &Finished, log: Option<&Path>) -> RunReport {
        let Finished { end, outcome, stop } = finished;
        let (completed, text, fault) = match end {
            Ok(LoopEnd::Completed) => (true, COMPLETED.to_owned(), None),
            Ok(LoopEnd::Interrupted) => (false, format!("interrupted; {stop}"), None),
            Err(error) => (false, format!("FAILED: {error:#}; {stop}"), Some(format!("{error:#}"))),
        };
        let (plant, law, clock) = (self.place.name(), self.settings.law, self.place.clock());
        let subject = Subject { robot, plant: &plant, law, clock };
        RunReport::new(subject, Ending { text, fault, completed }, outcome, log.map(Path::to_owned))
    }
}

fn panic_text(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("a panic without words")
}
