//! What was run, on what machine: the metadata records of a log.
//!
//! | record | holds |
//! |---|---|
//! | `uarm.run` | controller, settings, clock: all that a replay needs beside the robot |
//! | `uarm.robot` | the robot file with what the command line changed, as TOML; trained fuzzy sets, if any |
//! | `uarm.machine` | version, commit, kernel, CPU, real-time settings |
//! | `uarm.end` | how it ended; missing if the process was killed |

use std::collections::BTreeMap;
use std::path::Path;
use std::str::FromStr;
use std::time::Duration;

use anyhow::{Context, anyhow};
use clap::ValueEnum;
use hinf_control::Disturbance;
use hinf_control::{FuzzySets, GeneralisedBell, Law};

use super::time_axis::TimeAxis;
use crate::commands::run::DisturbanceChoice;
use crate::experiment::Settings;
use crate::experiment::report::ClockKind;
use crate::recording::RunEnd;
use crate::robot::Robot;
use crate::robot::overrides::Overrides;

/// What one metadata record holds.
pub type Fields = BTreeMap<String, String>;

/// Names of the metadata records.
pub const RUN: &str = "uarm.run";
/// See [`RUN`].
pub const ROBOT: &str = "uarm.robot";
/// See [`RUN`].
pub const MACHINE: &str = "uarm.machine";
/// See [`RUN`].
pub const END: &str = "uarm.end";

/// What was run.
#[derive(Clone, Debug)]
pub struct RunDescription {
    /// Settings of the experiment.
    pub settings: Settings,
    /// The interface, or what the embedded robot was.
    pub place: String,
    /// Where the loop's clock stands on the axis of the file.
    pub axis: TimeAxis,
    /// The robot.
    pub robot: Robot,
}

/// Scheduling as it was asked for.
#[derive(Clone, Debug, Default)]
pub struct RealtimeRequest {
    /// Policy.
    pub policy: String,
    /// `SCHED_FIFO` priority.
    pub priority: String,
    /// The processor, or "any".
    pub processor: String,
}

fn name_of(choice: impl ValueEnum) -> String {
    choice.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

impl RunDescription {
    /// The clock of the loop.
    pub fn clock(&self) -> ClockKind {
        if self.axis == TimeAxis::simulated() { ClockKind::Virtual } else { ClockKind::Monotonic }
    }

    /// The CAN interface, unless the robot was an embedded one: those have names of several words, interfaces never.
    pub fn interface(&self) -> Option<&str> {
        Some(self.place.as_str()).filter(|place| !place.contains(char::is_whitespace))
    }

    /// The record [`RUN`].
    pub fn run_fields(&self) -> Fields {
        let Settings { law, guard, overrun, period_source, approach, disturbance, disturbance_site } = &self.settings;
        let disturbance = match disturbance {
            Disturbance::Paper => DisturbanceChoice::Paper,
            Disturbance::None => DisturbanceChoice::None,
        };
        fields([
            ("controller", law.name().to_owned()),
            ("place", self.place.clone()),
            ("adaptation", name_of(*guard)),
            ("overrun", name_of(*overrun)),
            ("dt", name_of(*period_source)),
            (
                "approach",
                approach.map_or_else(String::new, |approach| humantime::format_duration(approach).to_string()),
            ),
            ("disturbance", name_of(disturbance)),
            ("disturbance_site", name_of(*disturbance_site)),
            ("clock_offset_ns", self.axis.offset_ns().to_string()),
            ("period_us", self.robot.file.control.period_us.to_string()),
        ])
    }

    /// The record [`ROBOT`].
    ///
    /// # Errors
    /// If the robot file cannot be written as TOML; a checked one can.
    pub fn robot_fields(&self) -> anyhow::Result<Fields> {
        let effective = toml::to_string(&self.robot.file).context("the robot file as TOML")?;
        let sets = self.robot.fuzzy_sets.as_ref().map_or_else(String::new, sets_to_text);
        Ok(fields([("name", self.robot.name.clone()), ("toml", effective), ("fuzzy_sets_rad", sets)]))
    }

    /// What was run, from the records [`RUN`] and [`ROBOT`] of the log called `name`.
    ///
    /// # Errors
    /// If a field is missing or wrong, with its name and value.
    pub fn from_fields(name: &Path, run: &Fields, robot: &Fields) -> anyhow::Result<Self> {
        let mut checked = Robot::parse(name, text(robot, ROBOT, "toml")?, &Overrides::default())
            .context("the robot file in the log")?;
        checked.fuzzy_sets = sets_from_text(text(robot, ROBOT, "fuzzy_sets_rad")?)?;
        let approach = text(run, RUN, "approach")?;
        let settings = Settings {
            law: parse(run, "controller", Law::from_name)?,
            guard: choice(run, "adaptation")?,
            overrun: choice(run, "overrun")?,
            period_source: choice(run, "dt")?,
            approach: if approach.is_empty() { None } else { Some(parse(run, "approach", duration)?) },
            disturbance: choice::<DisturbanceChoice>(run, "disturbance")?.into(),
            disturbance_site: choice(run, "disturbance_site")?,
        };
        let offset = parse(run, "clock_offset_ns", |text| i128::from_str(text).ok())?;
        let place = text(run, RUN, "place")?.to_owned();
        Ok(Self { settings, place, axis: TimeAxis::with_offset(offset), robot: checked })
    }
}

fn duration(text: &str) -> Option<Duration> {
    humantime::parse_duration(text).ok()
}

/// The record [`MACHINE`]. What cannot be found out is left empty.
pub fn machine_fields(realtime: &RealtimeRequest) -> Fields {
    let read = |file: &str| std::fs::read_to_string(file).unwrap_or_default().trim().to_owned();
    let cpu = read("/proc/cpuinfo");
    let cpu = cpu.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    fields([
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("commit", env!("UARM_COMMIT").to_owned()),
        ("kernel", format!("{} {}", read("/proc/sys/kernel/osrelease"), read("/proc/sys/kernel/version"))),
        ("cpu", cpu.map_or_else(String::new, |(_, model)| model.trim().to_owned())),
        ("realtime", realtime.policy.clone()),
        ("priority", realtime.priority.clone()),
        ("processor", realtime.processor.clone()),
    ])
}

/// The record [`END`].
pub fn end_fields(end: &RunEnd) -> Fields {
    let mut fields = fields([
        ("end", end.text.clone()),
        ("fault", end.fault.clone().unwrap_or_default()),
        ("records_dropped", end.dropped.to_string()),
    ]);
    fields.extend(end.figures.iter().cloned());
    fields
}

fn fields<const N: usize>(fields: [(&str, String); N]) -> Fields {
    fields.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}

fn text<'a>(fields: &'a Fields, record: &str, name: &str) -> anyhow::Result<&'a str> {
    fields.get(name).map(String::as_str).ok_or_else(|| anyhow!("metadata {record}: no field {name}"))
}

fn parse<V>(fields: &Fields, name: &str, parse: impl Fn(&str) -> Option<V>) -> anyhow::Result<V> {
    let text = text(fields, RUN, name)?;
    parse(text).ok_or_else(|| anyhow!("metadata {RUN}: {name} is `{text}`, which this version of uarm does not know"))
}

fn choice<V: ValueEnum>(fields: &Fields, name: &str) -> anyhow::Result<V> {
    parse(fields, name, |text| V::from_str(text, false).ok())
}

/// Centre, half width and steepness of each set, in the laws' own units, so that the bits come back.
fn sets_to_text(sets: &FuzzySets<f64>) -> String {
    let bells = sets.velocity.iter().chain(&sets.position);
    let bells = bells.map(|bell| format!("{:?} {:?} {:?}", bell.centre(), bell.half_width(), bell.steepness()));
    bells.collect::<Vec<_>>().join("; ")
}

fn sets_from_text(text: &str) -> anyhow::Result<Option<FuzzySets<f64>>> {
    if text.is_empty() {
        return Ok(None);
    }
    let wrong = || anyhow!("metadata {ROBOT}: fuzzy_sets_rad is `{text}`, expected six sets of three numbers");
    let bell = |text: &str| {
        let numbers: Option<Vec<f64>> = text.split_whitespace().map(|number| number.parse().ok()).collect();
        match numbers?.as_slice() {
            [centre, half_width, steepness] => GeneralisedBell::new(*centre, *half_width, *steepness).ok(),
            _ => None,
        }
    };
    let bells: Option<Vec<_>> = text.split(';').map(bell).collect();
    let bells = bells.ok_or_else(wrong)?;
    let (rate, position) = bells.split_at_checked(3).ok_or_else(wrong)?;
    let three = |bells: &[GeneralisedBell<f64>]| bells.try_into().map_err(|_| wrong());
    Ok(Some(FuzzySets { velocity: three(rate)?, position: three(position)? }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control_loop::schedule::OverrunPolicy;
    use crate::control_loop::task_clock::PeriodSource;
    use crate::control_loop::torque::DisturbanceSite;
    use crate::controllers::AdaptationGuard;
    use crate::robot::fuzzy_sets::TrainedSets;

    #[test]
    fn what_was_run_comes_back() {
        let overrides = Overrides { hold: Some(Duration::from_millis(1234)), ..Overrides::default() };
        let mut robot = Robot::load_with(None, &overrides).unwrap();
        robot.fuzzy_sets = Some(TrainedSets::embedded().unwrap().sets);
        for law in Law::ALL {
            let settings = Settings {
                law,
                guard: AdaptationGuard::Bounded,
                overrun: OverrunPolicy::CatchUp,
                period_source: PeriodSource::Measured,
                approach: Some(Duration::from_millis(5500)),
                disturbance: Disturbance::Paper,
                disturbance_site: DisturbanceSite::Command,
            };
            let axis = TimeAxis::with_offset(-17);
            let written = RunDescription { settings, place: "vcan0".into(), axis, robot: robot.clone() };
            let (run, file) = (written.run_fields(), written.robot_fields().unwrap());
            let read = RunDescription::from_fields(Path::new("log"), &run, &file).unwrap();
            assert_eq!(format!("{:?}", read.settings), format!("{settings:?}"));
            assert_eq!((read.place.as_str(), read.axis), ("vcan0", axis));
            assert_eq!(format!("{:?}", read.robot.file), format!("{:?}", robot.file));
            assert_eq!(read.robot.fuzzy_sets, robot.fuzzy_sets);
            assert_eq!(read.robot.task.hold, 1.234);
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        let robot = Robot::load(None).unwrap();
        let settings = Settings {
            law: Law::Fuzzy,
            guard: AdaptationGuard::None,
            overrun: OverrunPolicy::Skip,
            period_source: PeriodSource::Scheduled,
            approach: None,
            disturbance: Disturbance::None,
            disturbance_site: DisturbanceSite::Plant,
        };
        let written = RunDescription { settings, place: String::new(), axis: TimeAxis::simulated(), robot };
        let (mut run, file) = (written.run_fields(), written.robot_fields().unwrap());
        run.insert("controller".into(), "pid".into());
        let error = RunDescription::from_fields(Path::new("log"), &run, &file).unwrap_err();
        assert!(error.to_string().contains("controller is `pid`"), "{error}");
        run.remove("controller");
        let error = RunDescription::from_fields(Path::new("log"), &run, &file).unwrap_err();
        assert!(error.to_string().contains("no field controller"), "{error}");
    }
}
