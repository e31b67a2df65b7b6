//! A robot file against the bus that its drives are on: bus time, node ids, and who is heard.

use std::time::Duration;

use uarm_io::finding::{Finding, Verdict};
use uarm_io::link::{Link, LinkError, LinkErrorKind};
use uarm_io::monotonic::MonotonicClock;
use uarm_io::socketcan_link::{InterfaceName, Reception, SocketCanLink};
use uarm_io::time::Clock;

use crate::bus_observation::BusObservation;
use crate::robot::on_bus::JointsOnBus;

/// How long the bus is listened to: drives send heartbeats several times a second, if at all.
const LISTENING: Duration = Duration::from_secs(1);

/// What `robot` asks of the bus; with an interface also who of it is heard there. Nothing is sent.
pub(super) fn findings(robot: &JointsOnBus, interface: Option<InterfaceName>) -> Vec<Finding> {
    let mut findings = vec![bus_time(robot)];
    if let Some(interface) = interface {
        match SocketCanLink::open(interface, Reception::Everything) {
            Ok(link) => {
                let heard = listen(link);
                findings.push(master(&heard));
                findings.push(nodes(robot, &heard, &interface.to_string()));
            }
            Err(error) => {
                findings.extend(["other masters", "node ids"].map(|name| not_looked(name, &error.to_string())))
            }
        }
    }
    findings
}

fn finding(name: &str, found: String, wanted: impl Into<String>) -> Finding {
    Finding {
        name: name.to_owned(),
        found,
        wanted: wanted.into(),
        verdict: Verdict::Good,
        how_to_get_it: String::new(),
    }
}

/// What nobody could listen for.
fn not_looked(name: &str, why: &str) -> Finding {
    Finding {
        verdict: Verdict::Warning,
        how_to_get_it: "an interface that can be opened: see CAN above".to_owned(),
        ..finding(name, format!("not looked for: {why}"), "the bus listened to")
    }
}

/// A robot file whose cycle does not fit is refused when it is read.
fn bus_time(robot: &JointsOnBus) -> Finding {
    let (bus, period) = (&robot.bus, robot.period);
    let found = format!(
        "{:.0} us of each {period:?} at {} bit/s ({:.0} %)",
        bus.time.cyclic.as_secs_f64() * 1e6,
        bus.bit_rate.bits_per_second(),
        bus.time.load * 100.0
    );
    finding("bus time of a cycle", found, "less than the period")
}

fn listen(mut link: SocketCanLink) -> BusObservation {
    let mut heard = BusObservation::default();
    let deadline = MonotonicClock.now() + LISTENING;
    while MonotonicClock.now() < deadline {
        match link.receive(deadline) {
            Ok(Some(received)) => heard.note(&received),
            Err(error) if matches!(error.kind(), LinkErrorKind::Down | LinkErrorKind::Gone) => break,
            // Errors on the wire are findings about CAN.
            Ok(None) | Err(_) => {}
        }
    }
    heard
}

fn master(heard: &BusObservation) -> Finding {
    let signs = heard.master_at_work();
    let found = if signs.is_empty() { "none heard".to_owned() } else { signs.join("; ") };
    let finding = finding("other masters", found, "none");
    if signs.is_empty() {
        finding
    } else {
        Finding {
            verdict: Verdict::Bad,
            how_to_get_it: "end it: two masters command the same drives".to_owned(),
            ..finding
        }
    }
}

fn nodes(robot: &JointsOnBus, heard: &BusObservation, interface: &str) -> Finding {
    let present: Vec<u8> = heard.present().map(|(node, _)| node).collect();
    let list = |nodes: Vec<u8>| nodes.iter().map(u8::to_string).collect::<Vec<_>>().join(" ");
    let silent: Vec<u8> = robot.nodes().into_iter().filter(|node| !present.contains(node)).collect();
    let found = if present.is_empty() { "none heard".to_owned() } else { format!("heard {}", list(present)) };
    let finding = finding("node ids", found, format!("{} of the robot file", list(robot.nodes())));
    if silent.is_empty() {
        return finding;
    }
    let advice = format!(
        "drives that have no heartbeat yet are silent: `uarm drive scan --can {interface}` asks whether {} is there",
        list(silent)
    );
    Finding { verdict: Verdict::Warning, how_to_get_it: advice, ..finding }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::Robot;
    use uarm_io::embedded_can::StandardId;
    use uarm_io::frame::Frame;
    use uarm_io::link::Received;
    use uarm_io::time::Instant;

    fn heard(identifiers: &[u16]) -> BusObservation {
        let mut heard = BusObservation::default();
        for identifier in identifiers {
            let frame = Frame::new(StandardId::new(*identifier).unwrap(), &[5]).unwrap();
            heard.note(&Received { frame, at: Instant::default() });
        }
        heard
    }

    /// 695 us of 3 ms at 1 Mbit/s: docs/wire.md, section 4.
    #[test]
    fn the_bus_time_is_the_robots() {
        let robot = JointsOnBus::of(&Robot::load(None).unwrap());
        assert_eq!(findings(&robot, None).len(), 1);
        assert_eq!(bus_time(&robot).found, "695 us of each 3ms at 1000000 bit/s (23 %)");
    }

    #[test]
    fn nodes_of_the_file_that_are_not_heard_are_named() {
        let robot = JointsOnBus::of(&Robot::load(None).unwrap());
        let all = nodes(&robot, &heard(&[0x701, 0x702, 0x703]), "can0");
        assert_eq!((all.verdict, all.found.as_str()), (Verdict::Good, "heard 1 2 3"));
        let one = nodes(&robot, &heard(&[0x702, 0x70A]), "can0");
        assert_eq!((one.verdict, one.found.as_str()), (Verdict::Warning, "heard 2 10"));
        assert!(one.how_to_get_it.contains("whether 1 3 is there"), "{}", one.how_to_get_it);
    }

    #[test]
    fn a_bus_that_nobody_could_listen_to_is_not_called_silent() {
        let robot = JointsOnBus::of(&Robot::load(None).unwrap());
        let findings = findings(&robot, Some("nosuchcan9".parse().unwrap()));
        for (finding, name) in findings[1..].iter().zip(["other masters", "node ids"]) {
            assert_eq!((finding.name.as_str(), finding.verdict), (name, Verdict::Warning));
            let found = &finding.found;
            assert!(found.starts_with("not looked for: ") && found.contains("nosuchcan9"), "{found}");
        }
    }

    #[test]
    fn another_master_is_bad() {
        assert_eq!(master(&heard(&[0x701])).verdict, Verdict::Good);
        assert_eq!(master(&heard(&[0x080])).verdict, Verdict::Bad);
    }
}
