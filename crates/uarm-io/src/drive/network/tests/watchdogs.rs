//! What makes a drive brake by itself: armed and tried at start.

use super::bus::enabling;
use super::*;
use crate::drive::cia402::PowerState;
use crate::drive::network::LastDefence;
use crate::drive::objects::*;
use crate::drive::wishes::{Watchdog, WatchdogTest};
use crate::time::Clock;
use canopen_rs::{NmtState, Value};
use std::format;

/// A network whose second drive watches its commands, and lacks 1016h.
fn watched(test: WatchdogTest) -> DriveNetwork<FakeBus, 3> {
    let mut drives = [drive(1), drive(2), drive(3)];
    drives[1].watchdog = Watchdog::RpdoTimeout { milliseconds: 20, test };
    let configuration = NetworkConfiguration::new(drives, PERIOD).unwrap();
    let mut network = DriveNetwork::new(FakeBus::new(&[1, 2, 3]), configuration);
    network.link_mut().drives[1].lacks.push(CONSUMER_HEARTBEAT_TIME.address());
    network
}

#[test]
fn a_watchdog_of_commands_is_armed_tried_and_fed() {
    let mut network = watched(WatchdogTest::AtStart);
    network.link_mut().drives[1].script.faults_without_commands = true;
    start(&mut network).unwrap();
    assert_eq!(value(&network, 1, &RPDO1_EVENT_TIMER), Value::Unsigned16(20));
    let drive = &network.link().drives[1];
    assert_eq!(drive.timeouts, 1, "it was tried once, and never again on the way to Operation enabled");
    assert_eq!(drive.power, PowerState::OperationEnabled);
    assert_eq!(
        stop(&mut network).drives.map(|drive| drive.last_defence),
        [LastDefence::Heartbeat, LastDefence::RpdoTimeout, LastDefence::Heartbeat]
    );
}

#[test]
fn a_watchdog_that_does_not_react_refuses_the_start_with_brakes_closed() {
    let mut network = watched(WatchdogTest::AtStart);
    let error = start(&mut network).unwrap_err();
    assert!(matches!(error, StartError::WatchdogSilent { node: 2, .. }), "{error}");
    let commands = network.link().drives.iter().flat_map(|drive| &drive.commands);
    assert!(commands.clone().all(|command| command.controlword != enabling()));
    start(&mut watched(WatchdogTest::ByHand)).unwrap();
}

#[test]
fn without_any_watchdog_a_drive_is_refused() {
    let mut network = network();
    network.link_mut().drives[2].lacks.push(CONSUMER_HEARTBEAT_TIME.address());
    let error = start(&mut network).unwrap_err();
    assert!(format!("{error}").contains("drive.watchdog = \"rpdo-timeout\""), "{error}");
}

#[test]
fn a_drive_that_booted_anew_has_no_last_defence() {
    let mut network = network();
    start(&mut network).unwrap();
    let boot_up = wire::heartbeat_frame(NodeId::new(2).unwrap(), NmtState::Initialising);
    let now = network.link().clock.now();
    network.link_mut().inject(now, boot_up);
    let stopped = stop(&mut network).drives.map(|drive| drive.last_defence);
    assert_eq!(stopped, [LastDefence::Heartbeat, LastDefence::None, LastDefence::Heartbeat]);
}
