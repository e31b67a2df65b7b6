//! What is replayed: a log of `uarm run`, or a file of candump.

use std::io::{BufRead, BufReader};
use std::path::Path;

use anyhow::{Context, bail, ensure};
use hinf_control::{AdaptationGuard, Disturbance};
use uarm_log::description::Fields;
use uarm_log::ordered::InOrder;
use uarm_log::reader::Part;
use uarm_log::records::MAGIC;
use uarm_log::regular_file;
use uarm_log::replay::exact::{Begin, is_before};
use uarm_log::replay::one_clock::{ClockStep, Regularity};
use uarm_log::replay::source::{ReplayError, Source};
use uarm_log::replay::windows::Windows;
use uarm_loop::choice::Choice;
use uarm_loop::fault_code::FaultCode;
use uarm_loop::robot::Protocol;
use uarm_loop::schedule::OverrunPolicy;
use uarm_loop::settings::Settings;
use uarm_loop::torque::DisturbanceSite;

use super::arguments::Arguments;
use super::bus_file::{self, BusFile};
use crate::dimensions::OrderedLog;
use crate::report::FAULT_CODE;
use crate::robot::Robot;
use crate::robot::RobotText;
use crate::robot::shape::Shape;
use crate::usage::UsageError;

/// What a file holds.
pub struct Recorded<const J: usize, const N: usize> {
    pub name: String,
    pub robot: Robot<J, N>,
    pub settings: Settings,
    pub records: Records<J, N>,
    /// Why the run failed, if it did.
    pub fault: Option<String>,
    /// The version and commit that recorded it, if they are others.
    pub other_build: Option<String>,
    /// Which part of the run it is.
    pub part: Part,
    /// What is missing or cannot be read.
    pub damage: Vec<String>,
    /// Steps of the clock that stamped the frames, which were taken out.
    pub clock_steps: Vec<ClockStep>,
}

/// Where the records are.
pub enum Records<const J: usize, const N: usize> {
    /// In a log, which is read in windows.
    Log(OrderedLog<J, N>),
    /// In a file of candump, which is read in windows as well.
    Bus(BusFile),
}

impl<const J: usize, const N: usize> Recorded<J, N> {
    /// A log says itself what ran; a candump file does not.
    pub fn is_a_log(&self) -> bool {
        matches!(self.records, Records::Log(_))
    }

    /// Gives the run to `each`, window by window.
    pub fn each_window(
        &mut self,
        each: &mut dyn FnMut(&Source<'_, J, N>) -> Result<(), ReplayError>,
    ) -> anyhow::Result<()> {
        let Self { robot, settings, records, fault, .. } = self;
        let (robot, fault) = (&robot.description, fault.as_deref());
        match records {
            Records::Bus(file) => {
                let mut windows = Windows::of_bus(robot, settings, file.largest_counter);
                let mut given = Ok(());
                file.each_frame(&mut |frame| {
                    if given.is_ok() {
                        given = windows.take(InOrder::Frame(&frame), each);
                    }
                })?;
                given.and_then(|()| windows.finish(each))?;
            }
            Records::Log(log) => {
                let mut windows = Windows::new(robot, settings, fault);
                // Late records are known: there is one pass.
                let mut given = Ok(());
                let take = |(): &mut (), record: InOrder<'_, J, N>| {
                    if given.is_ok() {
                        given = windows.take(record, each);
                    }
                };
                log.pass(|| (), take)?;
                given.and_then(|()| windows.finish(each))?;
            }
        }
        Ok(())
    }

    /// The state that a replay begins with: of a log with the last keyframe before a task time, s, if one is asked for.
    pub fn begin(&mut self, from: Option<f64>) -> anyhow::Result<Begin<J, N>> {
        let (Some(time), Records::Log(log)) = (from, &mut self.records) else { return Ok(Begin::Beginning) };
        let take = |(found, span): &mut (Option<_>, Option<[f64; 2]>), record: InOrder<'_, J, N>| match record {
            InOrder::Keyframe(keyframe) if is_before(keyframe, time) => *found = Some(*keyframe),
            InOrder::Cycle(cycle) => *span = Some([span.map_or(cycle.time, |[first, _]| first), cycle.time]),
            InOrder::Keyframe(_) | InOrder::Frame(_) => {}
        };
        let ((found, span), _) = log.pass(|| (None, None), take)?;
        if let Some([first, last]) = span.filter(|[first, last]| !(*first..=*last).contains(&time)) {
            let expected = format!("a task time from {first:.3} to {last:.3} s, as the log has");
            return Err(UsageError::new(format!("--from {time}: expected {expected}")).into());
        }
        Ok(Begin::At(found.ok_or(ReplayError::NoKeyframe(time))?))
    }
}

/// Reads a log, or a file of candump.
///
/// # Errors
/// If it cannot be read, or is of a robot whose frames cannot be replayed.
pub fn read<const J: usize, const N: usize>(path: &Path, arguments: &Arguments) -> anyhow::Result<Recorded<J, N>> {
    let recorded = read_any::<J, N>(path, arguments)?;
    ensure!(
        recorded.robot.description.bus.protocol == Protocol::Canopen,
        "{}: the robot has ODrive axes; a replay reads the frames of CANopen drives only",
        path.display()
    );
    Ok(recorded)
}

/// How many joints the recorded robot has: the log says so; beside a candump file, the robot file does.
///
/// # Errors
/// If the file cannot be read.
pub fn shape(path: &Path, arguments: &Arguments) -> anyhow::Result<Shape> {
    if is_mcap(path)? {
        let run = OrderedLog::<3, 2>::new(path).run()?;
        return Shape::of(path, &run.robot.toml).context("the robot in the log");
    }
    Ok(RobotText::read(arguments.robot.as_deref())?.shape()?)
}

fn is_mcap(path: &Path) -> anyhow::Result<bool> {
    let mut input = BufReader::new(regular_file::open(path).with_context(|| path.display().to_string())?);
    Ok(input.fill_buf().with_context(|| path.display().to_string())?.starts_with(&MAGIC))
}

fn read_any<const J: usize, const N: usize>(path: &Path, arguments: &Arguments) -> anyhow::Result<Recorded<J, N>> {
    if is_mcap(path)? {
        ensure!(
            arguments.dt.is_none()
                && arguments.period.is_none()
                && arguments.disturbance.is_none()
                && arguments.interface.is_none(),
            "--dt, --period, --disturbance and --interface are for candump files: {} tells its own",
            path.display()
        );
        let mut log = OrderedLog::new(path);
        // Late records are met here, and what is told at the end.
        let ((), told) = log.pass(|| (), |(), _| {})?;
        let code = told.end.as_ref().and_then(|end| FaultCode::from_name(end.get(FAULT_CODE)?));
        return Ok(Recorded {
            name: told.run.controller.clone(),
            robot: Robot::from_log(path, &told.run.robot).context("the robot in the log")?,
            settings: told.run.settings().with_context(|| path.display().to_string())?,
            records: Records::Log(log),
            // What drives and bus do is not computed, and does not come again.
            fault: told.fault.map(|fault| fault.cause).filter(|_| code.is_none_or(FaultCode::is_of_signals)),
            other_build: other_build(&told.machine),
            part: told.part,
            damage: told.damage,
            clock_steps: Vec::new(),
        });
    }
    let interface = arguments.interface.as_deref();
    let Some(law) = arguments.controller else {
        bus_file::read(path, interface, |_| {})?;
        bail!("{}: a candump file does not say which controller ran: name it with --controller", path.display());
    };
    ensure!(arguments.from.is_none(), "--from needs keyframes, which a candump file has not");
    let RobotText { name, text } = RobotText::read(arguments.robot.as_deref())?;
    let mut robot = Robot::<J, N>::of_text(&name, &text, &arguments.overrides(law))?;
    robot.load_fuzzy_sets(arguments.fuzzy_sets.as_deref(), std::iter::once(law))?;
    let settings = Settings {
        law,
        guard: arguments.adaptation.unwrap_or(AdaptationGuard::Bounded),
        overrun: OverrunPolicy::default(),
        period_source: arguments.dt.unwrap_or_default(),
        approach: None,
        disturbance: arguments.disturbance.unwrap_or(Disturbance::None),
        disturbance_site: DisturbanceSite::Command,
    };
    let regularity = Regularity {
        period: robot.description.period.duration(),
        longest_pause: robot.description.bus.controller_timeout,
    };
    let (file, survey) = BusFile::survey(path, interface, regularity)?;
    let name = law.name().to_owned();
    Ok(Recorded {
        name,
        robot,
        settings,
        records: Records::Bus(file),
        fault: None,
        other_build: None,
        part: Part::default(),
        damage: survey.candump.losses(),
        clock_steps: survey.clock_steps,
    })
}

/// The build that wrote a log, if it is another one.
fn other_build(machine: &Fields) -> Option<String> {
    let [version, commit] = ["version", "commit"].map(|name| machine.get(name).map_or("", String::as_str));
    let is_this = version == env!("CARGO_PKG_VERSION") && commit == env!("UARM_COMMIT");
    (!is_this).then(|| format!("uarm {version} (commit {commit})"))
}
