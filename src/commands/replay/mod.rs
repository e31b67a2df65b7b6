//! `uarm replay`: a recorded run again, bit for bit; or another law on its measurements.

mod chart;

use std::io::{self, BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use anyhow::{Context, anyhow, bail, ensure};
use hinf_control::{AdaptationGuard, BaseAcceleration, Disturbance, Law};
use serde::Serialize;
use uarm_log::candump::{self, CandumpError, Interface};
use uarm_log::description::Fields;
use uarm_log::ordered::InOrder;
use uarm_log::reader::Part;
use uarm_log::records::MAGIC;
use uarm_log::regular_file;
use uarm_log::replay::bus_cycles::bus_cycles;
use uarm_log::replay::exact::{ExactReplay, ExactRun, is_before};
use uarm_log::replay::one_clock::{ClockStep, Regularity, on_one_clock};
use uarm_log::replay::source::{Behind, ReplayError};
use uarm_log::replay::what_if::{TorqueSummary, WhatIfRun};
use uarm_log::replay::windows::Windows;
use uarm_loop::choice::Choice;
use uarm_loop::fault_code::FaultCode;
use uarm_loop::recording::FrameRecord;
use uarm_loop::robot::Protocol;
use uarm_loop::schedule::OverrunPolicy;
use uarm_loop::settings::Settings;
use uarm_loop::task_clock::PeriodSource;
use uarm_loop::torque::DisturbanceSite;
use uarm_plot::output::FigureFile;

use crate::console;
use crate::dimensions::{ACTIVE, JOINTS, OrderedLog};
use crate::exit::Exit;
use crate::log_files::newest;
use crate::options::{self, choice};
use crate::output_files::{Force, OutputFiles};
use crate::report::FAULT_CODE;
use crate::robot::Robot;
use crate::robot::overrides::Overrides;
use chart::chart;

type Source<'a> = uarm_log::replay::source::Source<'a, JOINTS, ACTIVE>;
type WhatIf = uarm_log::replay::what_if::WhatIfOutcome<ACTIVE>;
type Pair = uarm_log::replay::what_if::Pair<ACTIVE>;
type Begin = uarm_log::replay::exact::Begin<JOINTS, ACTIVE>;

/// Arguments of `uarm replay`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  uarm replay                                 the newest log in runs/, every signal compared bit for bit
  uarm replay run.mcap --from 2               from the last keyframe before 2 s
  uarm replay run.mcap --controller neural --plot what-if.svg
                                              what `neural` would have asked for on the same measurements
  uarm replay bus.log --controller adaptive   a file of candump -L: the torques on the bus, with the law that ran

A candump file is read as far as it is whole. Ticks come from the SYNC counter, so a clock that was set while it was recorded
does not matter; where SYNC has no counter, the time decides.

Exit codes: 0 equal (or a what-if was made), 1 something differs or nothing was compared, 3 equal as far as the log goes, but
parts are missing.")]
pub struct Arguments {
    /// A log of `uarm run`, or a file of `candump -L`; without it the newest log in runs/
    #[arg(value_name = "FILE")]
    file: Option<PathBuf>,
    /// Begin with the last keyframe before this task time, s
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true, value_parser = options::seconds)]
    from: Option<f64>,
    /// With a candump file of several interfaces: the one that the drives are on
    #[arg(long, value_name = "INTERFACE")]
    interface: Option<String>,
    /// Another controller on the same measurements; with a candump file: the one that ran
    #[arg(long, value_parser = choice::<Law>(), value_name = "LAW")]
    controller: Option<Law>,
    /// Another robot file; with a candump file: the one that the run had
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// Another way for controllers 1 and 2 to have the base acceleration
    #[arg(long, value_parser = choice::<BaseAcceleration>(), value_name = "MODE")]
    base_acceleration: Option<BaseAcceleration>,
    /// Other fuzzy sets
    #[arg(long, value_name = "FILE.toml")]
    fuzzy_sets: Option<PathBuf>,
    /// Another guard of the adapted parameters; with a candump file: the one that the run had, by default "bounded"
    #[arg(long, value_parser = choice::<AdaptationGuard>(), value_name = "GUARD")]
    adaptation: Option<AdaptationGuard>,
    /// With a candump file: where the period came from
    #[arg(long, value_parser = choice::<PeriodSource>(), value_name = "SOURCE")]
    dt: Option<PeriodSource>,
    /// With a candump file: the loop's period, instead of the robot file's
    #[arg(long, allow_hyphen_values = true, value_parser = options::period, value_name = "TIME")]
    period: Option<Duration>,
    /// With a candump file: the disturbance on the sent torque
    #[arg(long, value_parser = choice::<Disturbance>(), value_name = "KIND")]
    disturbance: Option<Disturbance>,
    /// Draw the recorded torques and the other controller's to this file, .svg or .png
    #[arg(long, value_name = "FILE.svg|FILE.png")]
    plot: Option<FigureFile>,
    /// Write both torques of each cycle to this file
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// What a file holds.
struct Recorded {
    name: String,
    robot: Robot,
    settings: Settings,
    records: Records,
    /// Why the run failed, if it did.
    fault: Option<String>,
    /// The version and commit that recorded it, if they are others.
    other_build: Option<String>,
    /// Which part of the run it is.
    part: Part,
    /// What is missing or cannot be read.
    damage: Vec<String>,
    /// Steps of the clock that stamped the frames, which were taken out.
    clock_steps: Vec<ClockStep>,
}

/// Where the records are.
enum Records {
    /// In a log, which is read in windows.
    Log(OrderedLog),
    /// In memory: those of a candump file.
    Frames(Vec<FrameRecord>),
}

impl Recorded {
    /// Gives the run to `each`, window by window.
    fn each_window(&mut self, each: &mut dyn FnMut(&Source<'_>) -> Result<(), ReplayError>) -> anyhow::Result<()> {
        let Self { robot, settings, records, fault, .. } = self;
        let (robot, fault) = (&robot.description, fault.as_deref());
        match records {
            Records::Frames(frames) => {
                let bus = bus_cycles(frames, robot.nodes());
                each(&Source {
                    robot,
                    settings,
                    bus: &bus,
                    records: &[],
                    keyframes: &[],
                    fault,
                    behind: Behind::Nothing,
                })?;
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
    fn begin(&mut self, from: Option<f64>) -> anyhow::Result<Begin> {
        let (Some(time), Records::Log(log)) = (from, &mut self.records) else { return Ok(Begin::Beginning) };
        let take = |found: &mut Option<_>, record: InOrder<'_, JOINTS, ACTIVE>| {
            if let InOrder::Keyframe(keyframe) = record
                && is_before(keyframe, time)
            {
                *found = Some(*keyframe);
            }
        };
        let (found, _) = log.pass(|| None, take)?;
        Ok(Begin::At(found.ok_or(ReplayError::NoKeyframe(time))?))
    }
}

/// The result as JSON.
#[derive(Serialize)]
struct Report<'a> {
    file: &'a str,
    controller: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    exact: Option<&'a ExactReplay>,
    #[serde(skip_serializing_if = "Option::is_none")]
    what_if: Option<WhatIfReport>,
    part: &'a Part,
    damage: &'a [String],
    clock_steps: &'a [ClockStep],
}

/// The torques of a what-if as JSON, N·m.
#[derive(Serialize)]
struct WhatIfReport {
    cycles: u64,
    rms_difference_nm: [f64; ACTIVE],
    largest_difference_nm: [f64; ACTIVE],
    rms_recorded_nm: [f64; ACTIVE],
    rms_other_nm: [f64; ACTIVE],
    lost_cycles: u64,
}

impl WhatIfReport {
    fn new(what_if: &WhatIf) -> Self {
        let TorqueSummary { rms_difference, largest_difference, rms_recorded, rms_other } = what_if.summary;
        Self {
            cycles: what_if.cycles,
            rms_difference_nm: rms_difference,
            largest_difference_nm: largest_difference,
            rms_recorded_nm: rms_recorded,
            rms_other_nm: rms_other,
            lost_cycles: what_if.lost_cycles,
        }
    }
}

/// Replays a file.
///
/// # Errors
/// If it cannot be read, or holds nothing to replay.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let path = arguments.file.clone().map_or_else(newest, Ok)?;
    let outputs = arguments.outputs(&path);
    outputs.check(arguments.plot.as_ref().map(FigureFile::path)).context("--plot")?;
    outputs.check(arguments.csv.as_deref()).context("--csv")?;
    let mut recorded = read(&path, arguments)?;
    let file = path.display().to_string();
    if arguments.asks_for_another(&recorded) {
        what_if(arguments, &mut recorded, &file, &outputs)
    } else {
        exact(arguments, &mut recorded, &file)
    }
}

impl Arguments {
    /// With a log, whatever says something about controller or robot asks for another; a candump file says nothing itself.
    fn asks_for_another(&self, recorded: &Recorded) -> bool {
        let something = self.controller.is_some()
            || self.robot.is_some()
            || self.base_acceleration.is_some()
            || self.fuzzy_sets.is_some()
            || self.adaptation.is_some();
        matches!(recorded.records, Records::Log(_)) && something
    }

    fn outputs(&self, recording: &Path) -> OutputFiles {
        let files = [&self.robot, &self.fuzzy_sets];
        OutputFiles::new(self.force, files.into_iter().flatten().map(PathBuf::as_path).chain([recording]))
    }

    fn overrides(&self, law: Law) -> Overrides {
        Overrides { period: self.period, hold: None, base_acceleration: self.base_acceleration.map(|mode| (law, mode)) }
    }
}

fn read(path: &Path, arguments: &Arguments) -> anyhow::Result<Recorded> {
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
    let wanted = arguments.interface.as_deref().map_or(Interface::TheOnlyOne, Interface::Named);
    let mut candump = candump::read(input, wanted).map_err(|error| match error {
        CandumpError::Interfaces(_) => anyhow!("{}: {error}: name it with --interface", path.display()),
        error => anyhow!("{}: {error}", path.display()),
    })?;
    let Some(law) = arguments.controller else {
        bail!("{}: a candump file does not say which controller ran: name it with --controller", path.display());
    };
    ensure!(arguments.from.is_none(), "--from needs keyframes, which a candump file has not");
    let mut robot = Robot::load_with(arguments.robot.as_deref(), &arguments.overrides(law))?;
    robot.load_fuzzy_sets(arguments.fuzzy_sets.as_deref())?;
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
    let clock_steps = on_one_clock(&mut candump.frames, regularity);
    let damage = candump.losses();
    let name = law.name().to_owned();
    Ok(Recorded {
        name,
        robot,
        settings,
        records: Records::Frames(candump.frames),
        fault: None,
        other_build: None,
        part: Part::default(),
        damage,
        clock_steps,
    })
}

/// The build that wrote a log, if it is another one.
fn other_build(machine: &Fields) -> Option<String> {
    let [version, commit] = ["version", "commit"].map(|name| machine.get(name).map_or("", String::as_str));
    let is_this = version == env!("CARGO_PKG_VERSION") && commit == env!("UARM_COMMIT");
    (!is_this).then(|| format!("uarm {version} (commit {commit})"))
}

fn exact(arguments: &Arguments, recorded: &mut Recorded, file: &str) -> anyhow::Result<ExitCode> {
    ensure!(
        arguments.plot.is_none() && arguments.csv.is_none(),
        "--plot and --csv compare two controllers: name the other one with --controller (or --robot)"
    );
    let begin = recorded.begin(arguments.from).with_context(|| file.to_owned())?;
    let (robot, settings) = (recorded.robot.description.clone(), recorded.settings);
    let mut controller = recorded.robot.controller(settings.law, settings.guard)?;
    let mut run = ExactRun::new(&robot, &settings, &mut controller, begin).with_context(|| file.to_owned())?;
    recorded.each_window(&mut |source| run.window(source)).with_context(|| file.to_owned())?;
    let replay = run.finish().with_context(|| file.to_owned())?;
    if arguments.json {
        console::print_json(&Report {
            file,
            controller: &recorded.name,
            exact: Some(&replay),
            what_if: None,
            part: &recorded.part,
            damage: &recorded.damage,
            clock_steps: &recorded.clock_steps,
        })?;
    } else {
        print_exact(&replay, recorded, file, &mut console::output())?;
    }
    let exit = if !replay.is_equal() || !replay.has_compared() {
        Exit::Failure
    } else if replay.has_loss() || !recorded.damage.is_empty() {
        Exit::Loss
    } else {
        Exit::Ok
    };
    Ok(exit.into())
}

fn print_exact(replay: &ExactReplay, recorded: &Recorded, file: &str, output: &mut impl Write) -> io::Result<()> {
    let ExactReplay { from, cycles, signals, keyframes, .. } = replay;
    writeln!(output, "replay of {file}: {}, controller {}", recorded.robot.description.name, recorded.name)?;
    if !recorded.part.is_all() {
        writeln!(output, "  {}", recorded.part)?;
    }
    let of_all = match replay.lost_cycles {
        0 => String::new(),
        lost => format!(" of {}", cycles + lost),
    };
    let compared =
        format!("{cycles}{of_all} cycles from {from:.3} s, {signals} signals and {keyframes} keyframes compared");
    if !replay.has_compared() {
        writeln!(output, "  {compared}: NOTHING was compared")?;
    } else if replay.differing_cycles == 0 && replay.lost_cycles > 0 {
        writeln!(output, "  {compared}: these are equal, bit for bit")?;
    } else if replay.differing_cycles == 0 {
        writeln!(output, "  {compared}: all equal, bit for bit")?;
    } else {
        writeln!(output, "  {compared}: DIFFERENT in {} cycles; the first:", replay.differing_cycles)?;
    }
    for difference in &replay.differences {
        writeln!(output, "    {difference}")?;
    }
    if replay.differing_keyframes > 0 {
        write!(output, "  DIFFERENT: the inner state in {} keyframes", replay.differing_keyframes)?;
        match &recorded.other_build {
            Some(build) => writeln!(output, ": the log was written by {build}, whose inner state may be another")?,
            None => writeln!(output)?,
        }
    }
    if let Some(time) = replay.faded_from {
        writeln!(output, "  the end was asked for: torques faded from {time:.3} s on (control.stop_ramp_ms)")?;
    }
    match (&replay.fault, replay.fault_reproduced) {
        (Some(fault), Some(true)) => writeln!(output, "  the fault is the recorded one: {fault}")?,
        (Some(fault), _) => {
            writeln!(output, "  DIFFERENT: the replay ends with a fault that was not recorded: {fault}")?
        }
        (None, _) => {}
    }
    let predicted = replay.predicted_cycles - replay.missing_positions;
    if predicted > 0 {
        writeln!(output, "  in {predicted} of these cycles an angle was predicted, as in the run")?;
    }
    if replay.missing_positions > 0 {
        writeln!(
            output,
            "  LOST               positions in {} of these cycles: they were predicted, and gave the torques that are in the file",
            replay.missing_positions
        )?;
    }
    if replay.lost_cycles > 0 {
        writeln!(
            output,
            "  LOST               {} cycles that cannot be compared, since something in them or before them is missing; \
             went on from a keyframe {} times",
            replay.lost_cycles, replay.resumed
        )?;
    }
    if replay.missing_torques > 0 {
        writeln!(output, "  LOST               {} torques that are not in the file", replay.missing_torques)?;
    }
    print_recording(recorded, output)
}

/// What is to be said of the recording itself.
fn print_recording(recorded: &Recorded, output: &mut impl Write) -> io::Result<()> {
    for ClockStep { after_s, by_s } in &recorded.clock_steps {
        writeln!(output, "  clock set          by {by_s:+.3} s, {after_s:.3} s after the first frame: taken out")?;
    }
    for damage in &recorded.damage {
        writeln!(output, "  LOST               {damage}")?;
    }
    Ok(())
}

fn what_if(
    arguments: &Arguments,
    recorded: &mut Recorded,
    file: &str,
    outputs: &OutputFiles,
) -> anyhow::Result<ExitCode> {
    ensure!(
        arguments.from.is_none(),
        "--from is for a replay of the run as it was: another law begins with its own state"
    );
    let law = arguments.controller.unwrap_or(recorded.settings.law);
    let mut robot = match &arguments.robot {
        Some(path) => Robot::load_with(Some(path), &arguments.overrides(law))?,
        None => {
            let text = toml::to_string(&recorded.robot.file).context("the robot file of the log")?;
            Robot::parse(Path::new(file), &text, &arguments.overrides(law))?
        }
    };
    robot.fuzzy_sets = recorded.robot.fuzzy_sets;
    robot.load_fuzzy_sets(arguments.fuzzy_sets.as_deref())?;
    let settings =
        Settings { law, guard: arguments.adaptation.unwrap_or(recorded.settings.guard), ..recorded.settings };
    let mut controller = robot.controller(law, settings.guard)?;
    let mut run = WhatIfRun::new(&robot.description, &settings, &mut controller).with_context(|| file.to_owned())?;
    // Only a figure needs all of them.
    let mut drawn = Vec::new();
    let mut go = |each: &mut dyn FnMut(&Pair)| {
        let draws = arguments.plot.is_some();
        let mut take = |pair| {
            each(&pair);
            drawn.extend(draws.then_some(pair));
        };
        recorded.each_window(&mut |source| run.window(source, &mut take))
    };
    match &arguments.csv {
        None => go(&mut |_| {}).with_context(|| file.to_owned())?,
        Some(path) => outputs.write(path, |output| write_csv(go, output)).context("--csv")?,
    }
    let what_if = run.finish().with_context(|| file.to_owned())?;
    let other_name = match arguments.robot {
        Some(_) => format!("{} of {}", law.name(), robot.description.name),
        None => law.name().to_owned(),
    };
    if let Some(figure) = &arguments.plot {
        let bytes = figure.render(&chart(&drawn, &recorded.name, &other_name, file)).context("--plot")?;
        outputs.write(figure.path(), |output| output.write_all(&bytes)).context("--plot")?;
    }
    if arguments.json {
        let report = Report {
            file,
            controller: &other_name,
            exact: None,
            what_if: Some(WhatIfReport::new(&what_if)),
            part: &recorded.part,
            damage: &recorded.damage,
            clock_steps: &recorded.clock_steps,
        };
        console::print_json(&report)?;
    } else {
        print_what_if(&what_if, recorded, &other_name, file, &mut console::output())?;
    }
    let whole = recorded.damage.is_empty() && what_if.lost_cycles == 0;
    let exit = match (what_if.cycles == 0, whole) {
        (true, _) => Exit::Failure,
        (false, true) => Exit::Ok,
        (false, false) => Exit::Loss,
    };
    Ok(exit.into())
}

fn print_what_if(
    what_if: &WhatIf,
    recorded: &Recorded,
    other: &str,
    file: &str,
    output: &mut impl Write,
) -> io::Result<()> {
    writeln!(
        output,
        "what {other} would have asked for on the measurements of {file}, where {} was in control",
        recorded.name
    )?;
    let TorqueSummary { rms_difference, largest_difference, rms_recorded, rms_other } = what_if.summary;
    let of_all = match what_if.lost_cycles {
        0 => String::new(),
        lost => format!(" of {}", what_if.cycles + lost),
    };
    writeln!(output, "  {}{of_all} cycles, open loop: the robot did not hear it", what_if.cycles)?;
    writeln!(output, "    torque (N m)         joint 2   joint 3")?;
    let mut row =
        |name: &str, [joint_2, joint_3]: [f64; 2]| writeln!(output, "    {name:<18} {joint_2:>9.5} {joint_3:>9.5}");
    row("recorded, RMS", rms_recorded)?;
    row("other, RMS", rms_other)?;
    row("difference, RMS", rms_difference)?;
    row("difference, most", largest_difference)?;
    if what_if.lost_cycles > 0 {
        writeln!(output, "  LOST               {} cycles that cannot be replayed", what_if.lost_cycles)?;
    }
    print_recording(recorded, output)
}

/// Writes what `go` gives: both torques of each cycle.
fn write_csv(go: impl FnOnce(&mut dyn FnMut(&Pair)) -> anyhow::Result<()>, output: &mut dyn Write) -> io::Result<()> {
    writeln!(output, "tick,time_s,torque_recorded_2_nm,torque_recorded_3_nm,torque_other_2_nm,torque_other_3_nm")?;
    let mut written = Ok(());
    let mut write = |pair: &Pair| {
        let ([recorded_2, recorded_3], [other_2, other_3]) = (pair.recorded, pair.other);
        if written.is_ok() {
            written = writeln!(output, "{},{},{recorded_2},{recorded_3},{other_2},{other_3}", pair.tick, pair.time);
        }
    };
    go(&mut write).map_err(io::Error::other)?;
    written
}
