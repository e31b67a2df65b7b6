//! What was run, on what machine: the metadata records of a log.
//!
//! | record | holds |
//! |---|---|
//! | `uarm.run` | controller, settings, clock: all that a replay needs beside the robot |
//! | `uarm.robot` | the robot as its describer wrote it down, as TOML; trained fuzzy sets, if any |
//! | `uarm.machine` | version, commit, kernel, CPU, real-time settings |
//! | `uarm.drives` | which drives moved it, as they said themselves ([`mod@crate::drives`]) |
//! | `uarm.part` | which part of the run the file is; missing in the first |
//! | `uarm.next` | the file in which the run goes on, where it does |
//! | `uarm.end` | how it ended; missing if the process was killed, and where the run goes on in another file |
//!
//! Reading is lenient: what a log says of a controller or a robot that this version does not know is kept as text, and
//! refused only where it is needed.

use std::collections::BTreeMap;
use std::time::Duration;

use uarm_loop::choice::Choice;
use uarm_loop::hinf_control::{BellShape, FuzzySets, GeneralisedBell, SETS};
use uarm_loop::period::Period;
use uarm_loop::recording::RunEnd;
use uarm_loop::settings::Settings;
use uarm_loop::uarm_io::time::Instant;

use crate::time_axis::TimeAxis;

/// What one metadata record holds.
pub type Fields = BTreeMap<String, String>;

/// Name of the metadata record that tells what was run.
pub const RUN: &str = "uarm.run";
/// Name of the metadata record that describes the robot.
pub const ROBOT: &str = "uarm.robot";
/// Name of the metadata record that describes the machine.
pub const MACHINE: &str = "uarm.machine";
/// Name of the metadata record that tells how the run ended.
pub const END: &str = "uarm.end";

/// Name of the metadata record that tells which part of a run a file is.
pub const PART: &str = "uarm.part";
/// Name of the metadata record that tells in which file a run goes on.
pub const NEXT: &str = "uarm.next";

/// The clock that a loop ran on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ClockKind {
    /// The machine's monotonic clock.
    Monotonic,
    /// Virtual time, which passes only while the loop sleeps.
    Virtual,
}

/// What was run, as a log tells it.
#[derive(Clone, Debug, PartialEq)]
pub struct RunDescription {
    /// The record [`RUN`] as it is written.
    pub fields: Fields,
    /// The name of the controller; this version may not know it.
    pub controller: String,
    /// The interface, or what the simulated robot was.
    pub place: String,
    /// Where the loop's clock stands on the axis of the file.
    pub axis: TimeAxis,
    /// The loop's period.
    pub period: Period,
    /// The robot.
    pub robot: RobotDescription,
}

/// The robot of a run, as a log describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotDescription {
    /// The robot's name.
    pub name: String,
    /// All that a replay must know of it, as the program that ran it wrote it down.
    pub toml: String,
    /// Trained premise sets of the fuzzy laws, if the run had any, rad/s and rad.
    pub fuzzy_sets: Option<FuzzySets<f64>>,
}

/// A joint as the scene of a log shows it.
#[derive(Clone, Debug, PartialEq)]
pub struct JointDescription {
    /// The joint's name.
    pub name: String,
    /// The node id of its drive.
    pub node: u8,
    /// The link behind it.
    pub link: LinkDescription,
}

/// A link as it is shown. The frames of all links are parallel while all angles are zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkDescription {
    /// From the joint before to this one, m, in axes of the link before.
    pub from_parent: [f64; 3],
    /// The axis that the joint turns about, of length one.
    pub axis: [f64; 3],
    /// From the joint to the next one, or to the end effector, m.
    pub reach: [f64; 3],
}

impl LinkDescription {
    /// A link in the plane: `before` is the length of the link that it is joined to, m, and `length` its own; both lie along x.
    pub const fn along_x(before: f64, length: f64) -> Self {
        Self { from_parent: [before, 0.0, 0.0], axis: [0.0, 0.0, 1.0], reach: [length, 0.0, 0.0] }
    }
}

/// The machine and the program of a run. What cannot be found out is left empty.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MachineDescription {
    /// Version of the program.
    pub version: String,
    /// Commit that it was built from.
    pub commit: String,
    /// Real-time policy asked for.
    pub realtime_policy: String,
    /// `SCHED_FIFO` priority asked for.
    pub priority: String,
    /// The processor asked for, or "any".
    pub processor: String,
}

/// All that stands at the beginning of a log.
#[derive(Clone, Copy, Debug)]
pub struct LogHeader<'a, const J: usize> {
    /// What messages call the log.
    pub name: &'a str,
    /// The run.
    pub run: &'a RunDescription,
    /// The machine that it runs on.
    pub machine: &'a MachineDescription,
    /// The joints, the passive base first.
    pub joints: &'a [JointDescription; J],
    /// The text that the robot's description was read from: an attachment.
    pub robot_source: &'a str,
    /// When the log begins.
    pub start: Instant,
    /// Lines of text to begin with.
    pub preamble: &'a [String],
}

/// Why the metadata of a log cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DescriptionError {
    /// A field is not there.
    #[error("metadata {record}: no field {field}")]
    Missing {
        /// The metadata record.
        record: &'static str,
        /// The field.
        field: &'static str,
    },
    /// A field holds something that this version does not know.
    #[error("metadata {record}: {field} is `{value}`, expected {expected}")]
    Value {
        /// The metadata record.
        record: &'static str,
        /// The field.
        field: &'static str,
        /// Its value.
        value: String,
        /// What this version knows.
        expected: String,
    },
}

impl RunDescription {
    /// The description of a run that is about to begin.
    pub fn new(settings: &Settings, place: &str, axis: TimeAxis, period: Period, robot: RobotDescription) -> Self {
        let Settings { law, guard, overrun, period_source, approach, disturbance, disturbance_site } = settings;
        let approach = approach.map_or_else(String::new, |approach| format!("{}ns", approach.as_nanos()));
        let fields = fields([
            ("controller", law.name().to_owned()),
            ("place", place.to_owned()),
            ("adaptation", guard.name().to_owned()),
            ("overrun", overrun.name().to_owned()),
            ("dt", period_source.name().to_owned()),
            ("approach", approach),
            ("disturbance", disturbance.name().to_owned()),
            ("disturbance_site", disturbance_site.name().to_owned()),
            ("clock_offset_ns", axis.offset_ns().to_string()),
            ("period_us", period.duration().as_micros().to_string()),
        ]);
        Self { fields, controller: law.name().to_owned(), place: place.to_owned(), axis, period, robot }
    }

    /// The clock of the loop.
    pub fn clock(&self) -> ClockKind {
        if self.axis == TimeAxis::simulated() { ClockKind::Virtual } else { ClockKind::Monotonic }
    }

    /// The CAN interface, unless the robot was a simulated one: those have names of several words, interfaces never.
    pub fn interface(&self) -> Option<&str> {
        Some(self.place.as_str()).filter(|place| !place.contains(char::is_whitespace))
    }

    /// The settings of the run.
    ///
    /// # Errors
    /// [`DescriptionError`] if a field is missing, or names a choice that this version does not know.
    pub fn settings(&self) -> Result<Settings, DescriptionError> {
        let run = &self.fields;
        let approach = match text(run, RUN, "approach")? {
            "" => None,
            _ => Some(parse(run, "approach", "a duration such as 5s", duration)?),
        };
        Ok(Settings {
            law: choice(run, "controller")?,
            guard: choice(run, "adaptation")?,
            overrun: choice(run, "overrun")?,
            period_source: choice(run, "dt")?,
            approach,
            disturbance: choice(run, "disturbance")?,
            disturbance_site: choice(run, "disturbance_site")?,
        })
    }

    /// What was run, from the records [`RUN`] and [`ROBOT`].
    ///
    /// # Errors
    /// [`DescriptionError`] if a field is missing or wrong without which nothing in the log can be read.
    pub fn from_fields(run: Fields, robot: Fields) -> Result<Self, DescriptionError> {
        let offset = parse(&run, "clock_offset_ns", "a whole number of nanoseconds", |text| text.parse().ok())?;
        let period =
            parse(&run, "period_us", "100 to 100000", |text| Period::new(Duration::from_micros(text.parse().ok()?)))?;
        Ok(Self {
            controller: text(&run, RUN, "controller")?.to_owned(),
            place: text(&run, RUN, "place")?.to_owned(),
            axis: TimeAxis::with_offset(offset),
            period,
            robot: RobotDescription::from_fields(&robot)?,
            fields: run,
        })
    }
}

impl RobotDescription {
    /// The record [`ROBOT`].
    pub fn fields(&self) -> Fields {
        let sets = self.fuzzy_sets.as_ref().map_or_else(String::new, sets_to_text);
        fields([("name", self.name.clone()), ("toml", self.toml.clone()), ("fuzzy_sets_rad", sets)])
    }

    fn from_fields(robot: &Fields) -> Result<Self, DescriptionError> {
        Ok(Self {
            name: robot.get("name").cloned().unwrap_or_default(),
            toml: text(robot, ROBOT, "toml")?.to_owned(),
            fuzzy_sets: sets_from_text(text(robot, ROBOT, "fuzzy_sets_rad")?)?,
        })
    }
}

impl MachineDescription {
    /// The record [`MACHINE`], with kernel and CPU of this machine.
    pub fn fields(&self) -> Fields {
        let read = |file: &str| std::fs::read_to_string(file).unwrap_or_default().trim().to_owned();
        let cpu = read("/proc/cpuinfo");
        let cpu = cpu.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
        fields([
            ("version", self.version.clone()),
            ("commit", self.commit.clone()),
            ("kernel", format!("{} {}", read("/proc/sys/kernel/osrelease"), read("/proc/sys/kernel/version"))),
            ("cpu", cpu.map_or_else(String::new, |(_, model)| model.trim().to_owned())),
            ("realtime", self.realtime_policy.clone()),
            ("priority", self.priority.clone()),
            ("processor", self.processor.clone()),
        ])
    }
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

/// The record [`PART`] of the part of this number, counted from 1.
pub(crate) fn part_fields(number: u32) -> Fields {
    fields([("number", number.to_string())])
}

/// The number in a record [`PART`].
pub(crate) fn part_number(part: &Fields) -> Result<u32, DescriptionError> {
    let value = text(part, PART, "number")?;
    let wrong = || DescriptionError::Value {
        record: PART,
        field: "number",
        value: value.to_owned(),
        expected: "a whole number".to_owned(),
    };
    value.parse().map_err(|_| wrong())
}

/// The record [`NEXT`] that names a file beside this one.
pub(crate) fn next_fields(file: &str) -> Fields {
    fields([("file", file.to_owned())])
}

/// The file name in a record [`NEXT`].
pub(crate) fn next_file(next: &Fields) -> Result<&str, DescriptionError> {
    text(next, NEXT, "file")
}

/// A duration as this version writes it, in whole nanoseconds, or as earlier ones did: `5s 500ms`.
fn duration(text: &str) -> Option<Duration> {
    let mut total = Duration::ZERO;
    for part in text.split_whitespace() {
        let (number, unit) = part.split_at(part.find(|letter: char| !letter.is_ascii_digit())?);
        let number = number.parse().ok()?;
        let part = match unit {
            "ns" => Duration::from_nanos(number),
            "us" => Duration::from_micros(number),
            "ms" => Duration::from_millis(number),
            "s" => Duration::from_secs(number),
            "m" => Duration::from_secs(number.checked_mul(60)?),
            "h" => Duration::from_secs(number.checked_mul(3600)?),
            _ => return None,
        };
        total = total.checked_add(part)?;
    }
    Some(total)
}

fn fields<const F: usize>(fields: [(&str, String); F]) -> Fields {
    fields.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}

fn text<'a>(fields: &'a Fields, record: &'static str, field: &'static str) -> Result<&'a str, DescriptionError> {
    fields.get(field).map(String::as_str).ok_or(DescriptionError::Missing { record, field })
}

fn parse<V>(
    fields: &Fields,
    field: &'static str,
    expected: &str,
    parse: impl Fn(&str) -> Option<V>,
) -> Result<V, DescriptionError> {
    let value = text(fields, RUN, field)?;
    let wrong =
        || DescriptionError::Value { record: RUN, field, value: value.to_owned(), expected: expected.to_owned() };
    parse(value).ok_or_else(wrong)
}

fn choice<C: Choice>(fields: &Fields, field: &'static str) -> Result<C, DescriptionError> {
    let names: Vec<_> = C::ALL.iter().map(|choice| choice.name()).collect();
    let expected = format!("one of {}, which this version knows", names.join(", "));
    parse(fields, field, &expected, |text| C::from_name(text))
}

/// Centre, half width and steepness of each set, in the laws' own units, so that the bits come back.
fn sets_to_text(sets: &FuzzySets<f64>) -> String {
    let bells = sets.velocity.iter().chain(&sets.position);
    let bells = bells.map(|bell| format!("{:?} {:?} {:?}", bell.centre(), bell.half_width(), bell.steepness()));
    bells.collect::<Vec<_>>().join("; ")
}

fn sets_from_text(text: &str) -> Result<Option<FuzzySets<f64>>, DescriptionError> {
    if text.is_empty() {
        return Ok(None);
    }
    let wrong = || DescriptionError::Value {
        record: ROBOT,
        field: "fuzzy_sets_rad",
        value: text.to_owned(),
        expected: "six sets of three numbers".to_owned(),
    };
    let bell = |text: &str| {
        let numbers: Option<Vec<f64>> = text.split_whitespace().map(|number| number.parse().ok()).collect();
        match *numbers?.as_slice() {
            [centre, half_width, steepness] => GeneralisedBell::new(BellShape { centre, half_width, steepness }).ok(),
            _ => None,
        }
    };
    let bells: Option<Vec<_>> = text.split(';').map(bell).collect();
    let bells = bells.ok_or_else(wrong)?;
    let (velocity, position) = bells.split_at_checked(SETS).ok_or_else(wrong)?;
    let three = |bells: &[GeneralisedBell<f64>]| bells.try_into().map_err(|_| wrong());
    Ok(Some(FuzzySets { velocity: three(velocity)?, position: three(position)? }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use uarm_loop::hinf_control::{AdaptationGuard, Disturbance, Law};
    use uarm_loop::schedule::OverrunPolicy;
    use uarm_loop::task_clock::PeriodSource;
    use uarm_loop::torque::DisturbanceSite;

    fn period() -> Period {
        Period::new(Duration::from_millis(3)).unwrap()
    }

    fn robot() -> RobotDescription {
        RobotDescription { name: "UARM".into(), toml: "a = 1".into(), fuzzy_sets: Some(FuzzySets::untrained()) }
    }

    #[test]
    fn what_was_run_comes_back() {
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
            let written = RunDescription::new(&settings, "vcan0", axis, period(), robot());
            let read = RunDescription::from_fields(written.fields.clone(), written.robot.fields()).unwrap();
            assert_eq!(read, written);
            assert_eq!(read.settings(), Ok(settings));
            assert_eq!((read.place.as_str(), read.interface(), read.axis), ("vcan0", Some("vcan0"), axis));
        }
    }

    #[test]
    fn durations_of_earlier_versions_are_read() {
        assert_eq!(duration("5s 500ms"), Some(Duration::from_millis(5500)));
        assert_eq!(duration("1m 1ns"), Some(Duration::new(60, 1)));
        assert_eq!(duration("5 s"), None);
        assert_eq!(duration("5x"), None);
    }

    #[test]
    fn a_controller_that_is_not_known_is_kept_as_a_name_and_refused_as_a_setting() {
        let written = RunDescription::new(
            &Settings::paper(Law::Fuzzy),
            "simulated robot",
            TimeAxis::simulated(),
            period(),
            robot(),
        );
        let mut run = written.fields.clone();
        run.insert("controller".into(), "pid".into());
        let read = RunDescription::from_fields(run.clone(), written.robot.fields()).unwrap();
        assert_eq!(read.controller, "pid");
        let error = read.settings().unwrap_err().to_string();
        assert!(error.starts_with("metadata uarm.run: controller is `pid`, expected one of nonlinear, "), "{error}");
        run.remove("controller");
        let error = RunDescription::from_fields(run, written.robot.fields()).unwrap_err();
        assert_eq!(error, DescriptionError::Missing { record: RUN, field: "controller" });
    }

    #[test]
    fn sets_of_another_shape_are_refused() {
        for wrong in
            ["1 2", "1 2 3", "1 2 3; 1 2 3; 1 2 3; 1 2 3; 1 2 3; 1 2 x", "0 0 0; 1 2 3; 1 2 3; 1 2 3; 1 2 3; 1 2 3"]
        {
            assert!(sets_from_text(wrong).is_err(), "{wrong}");
        }
        assert_eq!(sets_from_text(""), Ok(None));
    }
}
