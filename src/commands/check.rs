//! `uarm check`: is a robot file right, and what margin does it leave? Nothing moves, no bus is needed.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use hinf_control::{Disturbance, Law};
use serde::Serialize;
use uarm_loop::dimensions;

use crate::bought::{Bought, DictionaryArguments};
use crate::commands::run::{SimulatedEnd, rehearse};
use crate::error_text::with_causes;
use crate::exit::Exit;
use crate::robot::RobotText;
use crate::robot::model::impossible_inertia;
use crate::robot::overrides::Overrides;
use crate::robot::shape::for_shape;
use crate::robot::{self, Robot, demand};
use crate::{console, options};

/// Arguments of `uarm check`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  uarm check                                 the paper's UARM, which is built in
  uarm check --robot my-robot.toml           before its first run: exit code 0 if `uarm run` would take it
  uarm check --robot my-robot.toml --eds drive.eds --node 2
                                             the simulated drive of node 2 has the objects of its maker's dictionary

What `uarm run` refuses before it opens an interface is refused here, with the same words: fields, postures, velocity and
torque of the task, bus time, heartbeats. What only the drives know (`uarm run --can` compares it at start) is not.
Torques are those of the nominal model on a base without momentum; friction and disturbances come on top. At last the
simulated robot does the task with controller 1, in virtual time: exit code 1 if a limit ends it, the base's too.")]
pub struct Arguments {
    /// The robot file; without it the paper's UARM
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// The loop's period, such as 3ms or 1ms, instead of the robot file's
    #[arg(long, allow_hyphen_values = true, value_parser = options::period, value_name = "TIME")]
    period: Option<Duration>,
    #[command(flatten)]
    dictionaries: DictionaryArguments,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// What is asked of a joint beside what it has.
#[derive(Debug, Serialize)]
struct Limit {
    quantity: &'static str,
    unit: &'static str,
    needed: f64,
    allowed: f64,
}

#[derive(Debug, Serialize)]
struct JointCheck {
    name: String,
    /// Angle range of the task, deg.
    task_deg: [f64; 2],
    /// Angle range allowed, deg.
    limits_deg: [f64; 2],
    limits: Vec<Limit>,
    /// The smallest torque that its drive can be told, N m, if the task never needs as much.
    #[serde(skip_serializing_if = "Option::is_none")]
    coarse_torque_step_nm: Option<f64>,
}

#[derive(Debug, Serialize)]
struct BusCheck {
    bit_rate: u32,
    cycle_us: f64,
    worst_cycle_us: f64,
    period_us: f64,
    controller_heartbeat_ms: f64,
    controller_timeout_ms: f64,
    drive_heartbeat_ms: f64,
    drive_timeout_ms: f64,
}

#[derive(Debug, Serialize)]
struct Check {
    file: String,
    robot: String,
    joints: Vec<JointCheck>,
    /// Drive profiles, and from what they are known.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    profiles: Vec<String>,
    bus: BusCheck,
    /// Links whose inertia no body can have.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    impossible_inertias: Vec<String>,
    /// Are counts and torques held against the model?
    supervised: bool,
    /// What a drive's dictionary leaves open of what is watched in a run.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    unjudged: Vec<String>,
    /// How it was simulated.
    #[serde(skip)]
    simulated: &'static str,
    /// What ends the task on the simulated robot, controller 1, without disturbance; nothing if it is completed.
    stopped_by: Option<String>,
}

/// Checks a robot file and prints the margins.
///
/// # Errors
/// If the file is wrong: file, field, value and what was expected.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let text = RobotText::read(arguments.robot.as_deref())?;
    for_shape!(text.shape()?, check_robot(arguments, &text))
}

fn check_robot<const J: usize, const N: usize>(arguments: &Arguments, text: &RobotText) -> anyhow::Result<ExitCode> {
    let overrides = Overrides { period: arguments.period, ..Overrides::default() };
    let robot = Robot::<J, N>::of_text(&text.name, &text.text, &overrides)?;
    let bought = Bought::read(&arguments.dictionaries, &robot.description.nodes())?;
    let mut check = check(arguments.robot.as_deref(), &robot);
    check.unjudged = bought.unjudged(&robot);
    check.stopped_by = match bought.refusal(&robot)? {
        Some(refusal) => Some(refusal.to_string()),
        None => match rehearse(&robot, &bought, Law::Nonlinear, Disturbance::None)? {
            SimulatedEnd::Completed(_) => None,
            SimulatedEnd::Failed(cause) => Some(with_causes(&cause)),
        },
    };
    if arguments.json {
        console::print_json(&check)?;
    } else {
        print(&mut console::output(), &check)?;
    }
    Ok(if check.stopped_by.is_none() { Exit::Ok } else { Exit::Failure }.into())
}

fn check<const J: usize, const N: usize>(file: Option<&Path>, robot: &Robot<J, N>) -> Check {
    let description = &robot.description;
    let task = &description.task.reference;
    let demands = demand::demand(robot.arm.as_ref(), task);
    let active = description.joints.iter().skip(dimensions::passive::<J, N>());
    let joints = active.zip(demands).map(|(joint, demand)| {
        let limit = |quantity, unit, needed, allowed| Limit { quantity, unit, needed, allowed };
        JointCheck {
            name: joint.name.clone(),
            task_deg: demand.position.map(f64::to_degrees),
            limits_deg: joint.limits.position.map(f64::to_degrees),
            limits: vec![
                limit("velocity", "deg/s", demand.velocity.to_degrees(), joint.limits.velocity.to_degrees()),
                limit("torque", "N m", demand.torque, joint.torque_limit),
                limit("torque rate", "N m/s", demand.torque_rate, joint.torque_rate_limit),
            ],
            coarse_torque_step_nm: Some(joint.torque_scale.per_mille()).filter(|step| demand.torque < *step),
        }
    });
    let bus = &description.bus;
    let microseconds = |time: Duration| time.as_secs_f64() * 1e6;
    let milliseconds = |time: Duration| time.as_secs_f64() * 1e3;
    Check {
        file: file.map_or_else(|| robot::BUILT_IN_NAME.to_owned(), |file| file.display().to_string()),
        robot: description.name.clone(),
        joints: joints.collect(),
        profiles: robot.profiles.iter().map(ToString::to_string).collect(),
        bus: BusCheck {
            bit_rate: bus.bit_rate.bits_per_second(),
            cycle_us: microseconds(bus.time.cyclic),
            worst_cycle_us: microseconds(bus.time.worst),
            period_us: microseconds(description.period.duration()),
            controller_heartbeat_ms: milliseconds(bus.controller_heartbeat),
            controller_timeout_ms: milliseconds(bus.controller_timeout),
            drive_heartbeat_ms: milliseconds(bus.drive_heartbeat),
            drive_timeout_ms: milliseconds(bus.drive_timeout),
        },
        impossible_inertias: robot.impossible_inertias.clone(),
        supervised: description.supervision.is_some(),
        unjudged: Vec::new(),
        simulated: match robot.file.plant {
            Some(_) => "simulated, with base and friction of the file",
            None => "simulated, without friction",
        },
        stopped_by: None,
    }
}

fn print(output: &mut impl Write, check: &Check) -> std::io::Result<()> {
    writeln!(output, "{}: {}", check.file, check.robot)?;
    for joint in &check.joints {
        let ([from, to], [least, most]) = (joint.task_deg, joint.limits_deg);
        writeln!(output, "  {}: {from:.1} to {to:.1} deg of {least:.1} to {most:.1}", joint.name)?;
        for Limit { quantity, unit, needed, allowed } in &joint.limits {
            let share = 100.0 * needed / allowed;
            writeln!(output, "    {quantity:<12} {needed:>9.4} of {allowed:>9.4} {unit:<6} {share:>5.1} %")?;
        }
        if let Some(step) = joint.coarse_torque_step_nm {
            writeln!(
                output,
                "    the task needs less torque than one step of its drive, {step:.4} N m, a per mille of the rated torque: expect jerks"
            )?;
        }
    }
    for profile in &check.profiles {
        writeln!(output, "  {profile}")?;
    }
    for link in &check.impossible_inertias {
        writeln!(output, "  {}", impossible_inertia(link))?;
    }
    let bus = &check.bus;
    writeln!(
        output,
        "  bus: {:.0} us of each {:.0} us at {} bit/s, {:.0} us at worst",
        bus.cycle_us, bus.period_us, bus.bit_rate, bus.worst_cycle_us
    )?;
    writeln!(
        output,
        "  heartbeats: controller every {:.0} ms, drives brake after {:.0} ms; drives every {:.0} ms, the run ends after {:.0} ms",
        bus.controller_heartbeat_ms, bus.controller_timeout_ms, bus.drive_heartbeat_ms, bus.drive_timeout_ms
    )?;
    if !check.supervised {
        writeln!(output, "  {}", robot::UNSUPERVISED)?;
    }
    for line in &check.unjudged {
        writeln!(output, "  {line}")?;
    }
    writeln!(output, "  the task is within the limits of its joints")?;
    match &check.stopped_by {
        None => writeln!(output, "  {}: completed", check.simulated),
        Some(cause) => writeln!(output, "  {}: STOPPED: {cause}", check.simulated),
    }
}
