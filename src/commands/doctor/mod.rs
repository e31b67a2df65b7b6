//! `uarm doctor`: is this machine ready for a hard real-time loop on a CAN bus?

mod examination;
mod robot;
mod text;

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::Context;
use uarm_io::finding::Verdict;
use uarm_io::probe::{CanWish, Machine, WakeupReport, measure_wakeups};
use uarm_io::realtime::{Priority, Processor, RealtimePolicy, RealtimeSettings};
use uarm_io::socketcan_link::InterfaceName;

use crate::robot::on_bus::JointsOnBus;
use crate::{console, options};
use examination::Examination;

/// The period of the paper's loop.
const DEFAULT_PERIOD: Duration = Duration::from_millis(3);

/// Arguments of `uarm doctor`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Exit code 1 if anything is bad. docs/realtime.md sets up a robot PC step by step.
Examples:
  uarm doctor                    what `uarm run` needs on a simulated robot
  uarm doctor --can can0 --robot my-robot.toml     what its drives need; sends nothing
  uarm doctor --seconds 600 --cpu 3 --rt enforce    the worst case, under the load that the robot PC will have")]
pub struct Arguments {
    /// The CAN interface that will be used; without it all are looked at, and none is no fault
    #[arg(long, value_name = "INTERFACE")]
    can: Option<InterfaceName>,
    /// A robot file: its bit rate, period and node ids are looked for
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// The bit rate that the drives are set to, bit/s, instead of the robot file's
    #[arg(long, value_name = "RATE")]
    bit_rate: Option<u32>,
    /// How long wake-ups are measured
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=86_400), value_name = "N")]
    seconds: u32,
    /// The period of the loop, such as 3ms or 1ms; by default the robot file's, or 3ms
    #[arg(long, allow_hyphen_values = true, value_parser = options::period, value_name = "TIME")]
    period: Option<Duration>,
    /// Real-time scheduling of the measuring thread: enforce, prefer or off
    #[arg(long, default_value_t, value_name = "POLICY")]
    rt: RealtimePolicy,
    /// SCHED_FIFO priority of the measuring thread
    #[arg(long, default_value_t, value_name = "1..98")]
    priority: Priority,
    /// Keep the measuring thread on this CPU
    #[arg(long, value_name = "CPU")]
    cpu: Option<Processor>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Examines the machine and prints what was found.
///
/// # Errors
/// If wake-ups cannot be measured as asked, or nothing can be printed.
pub fn execute(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let machine = Machine::this();
    let robot = arguments.robot.as_deref().map(JointsOnBus::load).transpose()?;
    let rate_of_robot = robot.as_ref().map(|robot| robot.bus.bit_rate.bits_per_second());
    let wish = CanWish { interface: arguments.can, bit_rate: arguments.bit_rate.or(rate_of_robot) };
    let period = arguments.period.or(robot.as_ref().map(|robot| robot.period));
    // The facts come first: measuring locks memory and holds processors awake, which must not be mistaken for the machine's own.
    let (realtime, can) = (machine.realtime_findings(), machine.can_findings(&wish));
    let robot = robot.map_or_else(Vec::new, |robot| robot::findings(&robot, arguments.can));
    let wakeups = wakeups(arguments, period.unwrap_or(DEFAULT_PERIOD))?;
    let examination = Examination::new(realtime, can, robot, wakeups);

    if arguments.json {
        console::print_json(&examination)?;
    } else {
        console::output().write_all(text::examination(&examination).as_bytes())?;
    }
    Ok(examination.exit().into())
}

/// Measures wake-ups. What the policy `enforce` demands and the system does not grant is bad, and is measured without: a table
/// that is not printed helps nobody to get it.
fn wakeups(arguments: &Arguments, period: Duration) -> anyhow::Result<WakeupReport> {
    let enforced = arguments.rt == RealtimePolicy::Enforce;
    let policy = if enforced { RealtimePolicy::Prefer } else { arguments.rt };
    let settings = RealtimeSettings { policy, priority: arguments.priority, processor: arguments.cpu };
    let duration = Duration::from_secs(arguments.seconds.into());
    let mut report = measure_wakeups(period, duration, &settings).context("measuring wake-ups")?;
    if enforced {
        demand_all(&mut report);
    }
    Ok(report)
}

/// Makes everything bad that was not granted.
fn demand_all(report: &mut WakeupReport) {
    for item in report.realtime.iter_mut().filter(|item| item.verdict != Verdict::Good) {
        item.verdict = Verdict::Bad;
        report.verdict = Verdict::Bad;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exit::Exit;
    use uarm_io::finding::Finding;

    #[derive(clap::Parser)]
    struct Doctor {
        #[command(flatten)]
        arguments: Arguments,
    }

    fn parse(line: &str) -> Result<Arguments, clap::Error> {
        <Doctor as clap::Parser>::try_parse_from(line.split_whitespace()).map(|doctor| doctor.arguments)
    }

    fn examination(verdicts: [Verdict; 2], settings: &RealtimeSettings) -> Examination {
        let [realtime, can] = verdicts.map(|verdict| {
            vec![Finding {
                name: "a fact".into(),
                found: "this".into(),
                wanted: "that".into(),
                verdict,
                how_to_get_it: "so".into(),
            }]
        });
        let wakeups = measure_wakeups(Duration::from_millis(1), Duration::from_millis(5), settings).unwrap();
        Examination::new(realtime, can, Vec::new(), WakeupReport { verdict: Verdict::Good, ..wakeups })
    }

    #[test]
    fn the_worst_finding_decides() {
        use Verdict::{Bad, Good, Warning};
        for (verdicts, expected, outcome) in
            [([Good, Good], Good, Exit::Ok), ([Good, Warning], Warning, Exit::Ok), ([Bad, Warning], Bad, Exit::Failure)]
        {
            let examination = examination(verdicts, &RealtimeSettings::default());
            assert_eq!((examination.verdict, examination.exit()), (expected, outcome));
        }
    }

    #[test]
    fn json_holds_each_finding_and_the_histogram() {
        let examination = examination([Verdict::Warning, Verdict::Good], &RealtimeSettings::default());
        let json = serde_json::to_value(&examination).unwrap();
        assert_eq!(json["verdict"], "warning");
        assert_eq!(json["realtime"][0]["how_to_get_it"], "so");
        assert_eq!(json["wakeups"]["samples"], 5);
        let counts =
            json["wakeups"]["buckets"].as_array().unwrap().iter().map(|bucket| bucket["count"].as_u64().unwrap());
        assert_eq!(counts.sum::<u64>(), 5);
    }

    #[test]
    fn what_enforce_demands_and_does_not_get_is_bad_and_still_reported() {
        let mut report = examination([Verdict::Good; 2], &RealtimeSettings::default()).wakeups;
        let finding = |verdict| Finding {
            name: "SCHED_FIFO".into(),
            found: "refused".into(),
            wanted: "80".into(),
            verdict,
            how_to_get_it: "limits.conf".into(),
        };
        report.realtime = vec![finding(Verdict::Good)];
        demand_all(&mut report);
        assert_eq!((report.realtime[0].verdict, report.verdict), (Verdict::Good, Verdict::Good));
        report.realtime = vec![finding(Verdict::Good), finding(Verdict::Warning)];
        demand_all(&mut report);
        assert_eq!((report.realtime[1].verdict, report.verdict), (Verdict::Bad, Verdict::Bad));
        assert_eq!(Examination::new(vec![], vec![], vec![], report).exit(), Exit::Failure);
    }

    #[test]
    fn arguments_have_ranges() {
        let arguments = parse("doctor --can can0 --rt enforce --period 1ms --cpu 1").unwrap();
        assert_eq!((arguments.can.unwrap().as_str(), arguments.rt), ("can0", RealtimePolicy::Enforce));
        for line in
            ["doctor --can a/b", "doctor --rt yes", "doctor --seconds 0", "doctor --priority 99", "doctor --cpu 1024"]
        {
            assert!(parse(line).is_err(), "{line}");
        }
    }
}
