//! Experiments as the command line asks for them: announced, run on their own thread, watched, reported.

use std::any::Any;
use std::panic::resume_unwind;
use std::path::Path;
use std::thread;

use uarm_log::description::ClockKind;
use uarm_log::parts::SizeLimit;
use uarm_loop::control_loop::LoopEnd;
use uarm_loop::run::Observer;
use uarm_loop::settings::Settings;
use uarm_loop::stop_request::StopRequest;

use super::learned::reasons;
use super::loop_thread::{Finished, LoopThread};
use super::place::Place;
use super::recording::{End, LogContent, Recorded, Repetition, RunRecording};
use super::watch::show_progress;
use crate::bought::Bought;
use crate::dimensions::Progress;
use crate::error_text::with_causes;
use crate::log_files::LogChoice;
use crate::realtime::Realtime;
use crate::report::{Ending, RunReport, Subject};
use crate::robot::model::impossible_inertia;
use crate::robot::{self, Robot};

/// Laws and emulated drives are made on the loop's stack: 2 MiB, the default of a thread, are too few in some builds.
const STACK: usize = 8 << 20;
/// Emulated drives with makers' dictionaries hold their objects by value, 0.4 MB each, and are made on the loop's stack.
const STACK_WITH_DICTIONARIES: usize = 32 << 20;

/// A series of experiments.
#[derive(Debug)]
pub struct Session<const J: usize, const N: usize> {
    /// What each of them does.
    pub settings: Settings,
    /// Where they take place.
    pub place: Place,
    /// Scheduling of the loop.
    pub realtime: Realtime,
    /// Where they are recorded.
    pub log: LogChoice,
    /// How much of that is kept.
    pub log_limit: SizeLimit,
    /// What is known of the simulated robot's drives.
    pub bought: Bought<J>,
}

impl<const J: usize, const N: usize> Session<J, N> {
    /// What is about to move, and within which limits, line by line.
    pub fn announcement(&self, robot: &Robot<J, N>) -> Vec<String> {
        let (law, description) = (self.settings.law, &robot.description);
        let mut lines = vec![
            format!("{}: controller {} ({})", description.name, law.name(), law.description()),
            self.place.announcement(),
        ];
        for joint in description.joints.iter().filter(|joint| joint.torque_limit > 0.0) {
            let [least, most] = joint.limits.position;
            lines.push(format!(
                "  {}: torque +-{} N m, {} N m/s; velocity +-{:.0} deg/s; angle {:.0} to {:.0} deg",
                joint.name,
                joint.torque_limit,
                joint.torque_rate_limit,
                joint.limits.velocity.to_degrees(),
                least.to_degrees(),
                most.to_degrees()
            ));
        }
        if description.supervision.is_none() {
            lines.push(format!("  {}", robot::UNSUPERVISED));
        }
        lines.extend(robot.trained_sets_of(self.settings.law).map(|sets| format!("  {sets}")));
        lines.extend(robot.profiles.iter().map(|profile| format!("  {profile}")));
        lines.extend(robot.impossible_inertias.iter().map(|link| format!("  {}", impossible_inertia(link))));
        lines.extend(reasons(robot));
        let period = description.period.duration();
        let bus = description.bus.time;
        lines.push(format!(
            "  period {period:?}; bus {:.0} us of it at {} bit/s; tracking error at most {} deg",
            bus.cyclic.as_secs_f64() * 1e6,
            description.bus.bit_rate.bits_per_second(),
            (description.tracking_error_limit.to_degrees() * 100.0).round() / 100.0
        ));
        lines
    }

    /// Runs one experiment.
    ///
    /// # Errors
    /// If it cannot be begun, or a file cannot be opened.
    pub fn run(&self, robot: &Robot<J, N>, repetition: Repetition, stop: &StopRequest) -> anyhow::Result<RunReport> {
        let announcement = self.announcement(robot);
        let content = LogContent {
            robot,
            settings: &self.settings,
            place: &self.place,
            machine: &self.realtime.machine(),
            announcement: &announcement,
        };
        let mut recording = RunRecording::start(&self.log, self.log_limit, &content, repetition)?;
        let progress = Progress::default();
        let finished = thread::scope(|scope| {
            let (loop_side, log) = recording.for_the_loop();
            let progress = &progress;
            let loop_thread = LoopThread {
                robot,
                settings: &self.settings,
                place: &self.place,
                bought: &self.bought,
                realtime: Some(self.realtime),
                loop_side,
                log,
                observer: Observer { progress, stop },
                announcement: if repetition.number == 1 { &announcement } else { &[] },
            };
            let run = move || loop_thread.run();
            let builder = thread::Builder::new().name("uarm-loop".into());
            let builder = builder.stack_size(if self.bought.is_none() { STACK } else { STACK_WITH_DICTIONARIES });
            let experiment = builder.spawn_scoped(scope, run)?;
            if self.place.clock() == ClockKind::Monotonic {
                show_progress(progress, robot.description.task.motion().end(), || experiment.is_finished());
            }
            Ok(experiment.join())
        });
        match finished.unwrap_or_else(|error: std::io::Error| Ok(Err(error.into()))) {
            Ok(Ok(finished)) => {
                let mut report = self.report(robot, &finished, recording.log());
                let Recorded { parts, dropped, texts } = recording.finish(&End::Reported(&report));
                report.log_parts = parts;
                report.records_dropped = dropped;
                report.losses = texts;
                Ok(report)
            }
            Ok(Err(error)) => {
                recording.finish(&End::Failed(&with_causes(&error)));
                Err(error)
            }
            // The motors have been stopped; what led to the bug is worth keeping.
            Err(panic) => {
                recording.finish(&End::Failed(&format!("a bug: {}", panic_text(panic.as_ref()))));
                resume_unwind(panic)
            }
        }
    }

    fn report(&self, robot: &Robot<J, N>, finished: &Finished<N>, log: Option<&Path>) -> RunReport {
        let Finished { end, outcome, stop } = finished;
        let ending = match end {
            Ok(LoopEnd::Completed) => Ending::completed(),
            Ok(LoopEnd::Interrupted) => Ending::interrupted(stop),
            Err(failure) => Ending::failed(failure, stop),
        };
        let (plant, clock) = (self.place.name(), self.place.clock());
        let controller = self.settings.law.name();
        let subject = Subject { robot, plant: &plant, controller, clock };
        RunReport::new(subject, ending, outcome, log.map(Path::to_owned))
    }
}

fn panic_text(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("a panic without words")
}
