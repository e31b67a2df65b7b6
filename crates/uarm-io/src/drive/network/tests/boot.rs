//! Boot-up messages and emergencies during a start.

use super::bus::enabling;
use super::configuration::LISTEN;
use super::*;
use crate::drive::cia402::PowerState;
use crate::drive::objects::*;
use crate::time::Clock;
use canopen_rs::NmtState;
use std::format;

#[test]
fn a_boot_up_from_before_the_reset_is_not_taken_for_one_after_it() {
    let mut network = network();
    network.link_mut().drives[1].script.never_boots = true;
    let now = network.link().clock.now();
    let boot_up = wire::heartbeat_frame(NodeId::new(2).unwrap(), NmtState::Initialising);
    network.link_mut().inject(now, boot_up);
    assert!(matches!(start(&mut network), Err(StartError::NoBootUp { node: 2, .. })));
}

#[test]
fn an_emergency_of_the_last_run_does_not_end_the_next() {
    let mut network = network();
    network.link_mut().inject_emergency(1, 0x8130);
    start(&mut network).unwrap();
    let mut clock = network.link().clock.clone();
    let now = clock.now();
    network.sync().unwrap();
    network.collect(now + Duration::from_millis(2)).unwrap();
    network.send_torques([0; 3]).unwrap();
    network.housekeeping(now).unwrap();
    clock.sleep_until(now + PERIOD);
    assert_eq!(network.health().nodes[0].emergencies, 1);
}

fn boot_up(node: u8) -> crate::frame::Frame {
    wire::heartbeat_frame(NodeId::new(node).unwrap(), NmtState::Initialising)
}

fn rebooted(node: u8) -> StartError<bus::Down> {
    StartError::Disturbed(Disturbance::Rebooted { node })
}

/// From the first SDO to a drive until it is enabled, and whichever drive is being talked to.
#[test]
fn a_drive_that_boots_anew_after_its_first_sdo_fails_the_start() {
    for (asked, object) in [(3, STATUSWORD), (2, DEVICE_TYPE), (2, RATED_TORQUE), (3, DEVICE_TYPE)] {
        let mut network = network();
        network.link_mut().meanwhile = Some((asked, object.address(), boot_up(2)));
        assert_eq!(start(&mut network).unwrap_err(), rebooted(2), "node {asked}, {object}");
        // The rest of the start was not sent: no brake opened.
        let drives = &network.link().drives;
        assert!(drives.iter().all(|drive| drive.commands.iter().all(|command| command.controlword != enabling())));
        assert!(stop(&mut network).all_off());
    }
}

#[test]
fn a_drive_that_boots_anew_in_the_last_step_of_the_start_fails_it() {
    let mut network = network();
    network.link_mut().meanwhile = Some((3, MODE_OF_OPERATION_DISPLAY.address(), boot_up(1)));
    assert_eq!(start(&mut network).unwrap_err(), rebooted(1));
    assert!(stop(&mut network).all_off());
}

/// Drives that need their time, or boot twice, before anything was written to them.
#[test]
fn a_boot_up_before_the_first_sdo_of_its_drive_is_borne() {
    let mut network = network();
    network.link_mut().meanwhile = Some((1, DEVICE_TYPE.address(), boot_up(2)));
    start(&mut network).unwrap();
}

/// A heartbeat that was under way when the reset was sent says nothing of the reset.
#[test]
fn only_a_boot_up_message_confirms_a_reset() {
    let mut network = network();
    network.link_mut().drives[1].script.never_boots = true;
    let heartbeat = wire::heartbeat_frame(NodeId::new(2).unwrap(), NmtState::PreOperational);
    let soon = network.link().clock.now() + LISTEN + Duration::from_micros(100);
    network.link_mut().inject(soon, heartbeat);
    assert!(matches!(start(&mut network), Err(StartError::NoBootUp { node: 2, .. })));
}

fn emergency(node: u8, code: u16) -> crate::frame::Frame {
    let message = wire::EmergencyMessage::new(code, canopen_rs::ErrorRegister(1), [0; 5]);
    wire::emergency_frame(NodeId::new(node).unwrap(), &message)
}

#[test]
fn an_emergency_after_the_first_sdo_of_its_drive_fails_the_start() {
    for (asked, object) in [(2, RATED_TORQUE), (3, DEVICE_TYPE), (3, MODE_OF_OPERATION_DISPLAY)] {
        let mut network = network();
        network.link_mut().meanwhile = Some((asked, object.address(), emergency(2, 0x3220)));
        let error = start(&mut network).unwrap_err();
        assert!(matches!(error, StartError::Emergency { node: 2, message } if message.error_code == 0x3220), "{error}");
        let opened = network.link().drives.iter().any(|drive| drive.power == PowerState::OperationEnabled);
        assert_eq!(opened, object == MODE_OF_OPERATION_DISPLAY, "{object}");
    }
}

#[test]
fn an_emergency_that_is_over_before_the_drive_is_enabled_is_borne() {
    let mut network = network();
    network.link_mut().meanwhile = Some((2, RATED_TORQUE.address(), emergency(2, 0x3220)));
    let later = network.link().clock.now() + LISTEN + Duration::from_millis(31);
    network.link_mut().inject(later, emergency(2, 0));
    start(&mut network).unwrap();
    assert_eq!(network.health().nodes[1].emergencies, 2);
}

#[test]
fn emergencies_that_are_only_recorded_do_not_fail_a_start() {
    let mut configuration = configuration();
    configuration.emergency_reaction = EmergencyReaction::Record;
    let mut network = DriveNetwork::new(FakeBus::new(&[1, 2, 3]), configuration);
    network.link_mut().meanwhile = Some((2, RATED_TORQUE.address(), emergency(2, 0x3220)));
    start(&mut network).unwrap();
}

#[test]
fn a_stuck_drive_is_named_with_its_last_emergency() {
    let mut network = network();
    network.link_mut().drives[1].script.stuck_in = Some(PowerState::SwitchedOn);
    network.link_mut().inject_emergency(2, 0x3220);
    let error = start(&mut network).unwrap_err();
    assert!(matches!(error, StartError::NotReached { node: 2, expected: PowerState::OperationEnabled, .. }), "{error}");
    assert!(format!("{error}").contains("DC link under-voltage"), "{error}");
}
