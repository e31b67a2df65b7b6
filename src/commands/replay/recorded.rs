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
use uarm_log::replay::exact::is_before;
use uarm_log::replay::one_clock::{ClockStep, Regularity};
use uarm_log::replay::source::ReplayError;
use uarm_log::replay::windows::Windows;
use uarm_loop::choice::Choice;
use uarm_loop::fault_code::FaultCode;
use uarm_loop::robot::Protocol;
use uarm_loop::schedule::OverrunPolicy;
use uarm_loop::settings::Settings;
use uarm_loop::torque::DisturbanceSite;

use super::arguments::Arguments;
use super::bus_file::{self, BusFile};
use crate::dimensions::{ACTIVE, JOINTS, OrderedLog};
use crate::report::FAULT_CODE;
use crate::robot::Robot;
use crate::usage::UsageError;

type Source<'a> = uarm_log::replay::source::Source<'a, JOINTS, ACTIVE>;
type Begin = uarm_log::replay::exact::Begin<JOINTS, ACTIVE>;

/// What a file holds.
pub struct Recorded {
    pub name: String,
    pub robot: Robot,
    pub settings: Settings,
    pub records: Records,
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
pub enum Records {
    /// In a log, which is read in windows.
    Log(OrderedLog),
    /// In a file of candump, which is read in windows as well.
    Bus(BusFile),
}

impl Recorded {
    /// A log says itself what ran; a candump file does not.
    pub fn is_a_log(&self) -> bool {
        matches!(self.records, Records::Log(_))
    }

    /// Gives the run to `each`, window by window.
    pub fn each_window(&mut self, each: &mut dyn FnMut(&Source<'_>) -> Result<(), ReplayError>) -> anyhow::Result<()> {
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
                let take = |(): &mut (), record: InOrder<'_, JOINTS, ACTIVE>| {
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
    pub fn begin(&mut self, from: Option<f64>) -> anyhow::Result<Begin> {
        let (Some(time), Records::Log(log)) = (from, &mut self.records) else { return Ok(Begin::Beginning) };
        let take = |(found, span): &mut (Option<_>, Option<[f64; 2]>), record: InOrder<'_, JOINTS, ACTIVE>| match record
        {
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
pub fn read(path: &Path, arguments: &Arguments) -> anyhow::Result<Recorded> {
    let recorded = read_any(path, arguments)?;
    ensure!(
        recorded.robot.description.bus.protocol == Protocol::Canopen,
        "{}: the robot has ODrive axes; a replay reads the frames of CANopen drives only",
        path.display()
    );
    Ok(recorded)
}

fn read_any(path: &Path, arguments: &Arguments) -> anyhow::Result<Recorded> {
    let mut input = BufReader::new(regular_file::open(path).with_context(|| path.display().to_string())?);
    let is_mcap = input.fill_buf().with_context(|| path.display().to_string())?.starts_with(&MAGIC);
    if is_mcap {
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
    let mut robot = Robot::load_with(arguments.robot.as_deref(), &arguments.overrides(law))?;
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
