use super::bus::enabling;
use super::configuration::LISTEN;
use super::*;
use crate::drive::cia402::{Command, Controlword, PowerState};
use crate::drive::network::LastDefence;
use crate::drive::objects::*;
use crate::drive::survey::Answer;
use crate::drive::wire::Channel;
use crate::drive::wishes::{HeartbeatError, SyncCounterChoice, Watchdog, WatchdogTest};
use crate::time::Clock;
use canopen_rs::{Address, Entry, NmtState, Value};
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::format;

fn value(network: &DriveNetwork<FakeBus, 3>, joint: usize, object: &Object) -> Value {
    network.link().drives[joint].dictionary.read(object.address()).unwrap()
}

#[test]
fn drives_are_configured_and_enabled() {
    let mut network = network();
    network.link_mut().drives[1].position = -77;
    let started = start(&mut network).unwrap();
    assert_eq!(started.positions[1], -77);
    assert_eq!(started.drives[0].vendor, Some(0x55));
    for joint in 0..3 {
        let node = joint as u32 + 1;
        assert_eq!(network.link().drives[joint].power, PowerState::OperationEnabled);
        assert_eq!(network.link().drives[joint].nmt, NmtState::Operational);
        for (object, expected) in [
            (MODE_OF_OPERATION, Value::Integer8(10)),
            (INTERPOLATION_TIME_VALUE, Value::Unsigned8(3)),
            (INTERPOLATION_TIME_EXPONENT, Value::Integer8(-3)),
            (TPDO1_IDENTIFIER, Value::Unsigned32(0x180 + node)),
            (TPDO1_MAPPED_OBJECTS, Value::Unsigned8(2)),
            (TPDO1_FIRST_OBJECT, Value::Unsigned32(0x6041_0010)),
            (TPDO1_SECOND_OBJECT, Value::Unsigned32(0x6064_0020)),
            (TPDO1_TRANSMISSION_TYPE, Value::Unsigned8(1)),
            (RPDO1_IDENTIFIER, Value::Unsigned32(0x200 + node)),
            (RPDO1_FIRST_OBJECT, Value::Unsigned32(0x6040_0010)),
            (RPDO1_SECOND_OBJECT, Value::Unsigned32(0x6071_0010)),
            (RPDO1_TRANSMISSION_TYPE, Value::Unsigned8(255)),
            (CONSUMER_HEARTBEAT_TIME, Value::Unsigned32(0x007F_0064)),
            (PRODUCER_HEARTBEAT_TIME, Value::Unsigned16(50)),
            (SYNC_COUNTER_OVERFLOW, Value::Unsigned8(240)),
        ] {
            assert_eq!(value(&network, joint, &object), expected, "{object}");
        }
    }
}

#[test]
fn no_torque_and_no_sync_is_sent_at_start_and_brakes_open_together() {
    let mut network = network();
    start(&mut network).unwrap();
    let bus = network.link();
    assert!(bus.drives.iter().all(|drive| drive.commands.iter().all(|command| command.target_torque == 0)));
    assert!(bus.sent.iter().all(|frame| Channel::of(frame.id()) != Some(Channel::Sync)));
    // No drive is enabled before the last is switched on.
    let channel = |frame: &crate::frame::Frame| Channel::of(frame.id());
    let enabling_frames: Vec<usize> = positions(&bus.sent, |frame| {
        matches!(channel(frame), Some(Channel::Rpdo1(_))) && frame.data()[..2] == enabling().bits().to_le_bytes()
    });
    let other = positions(&bus.sent, |frame| {
        matches!(channel(frame), Some(Channel::Rpdo1(_))) && frame.data()[..2] != enabling().bits().to_le_bytes()
    });
    assert_eq!(enabling_frames.len(), 3);
    assert!(enabling_frames[0] > *other.last().unwrap());
}

fn positions(frames: &[crate::frame::Frame], wanted: impl Fn(&crate::frame::Frame) -> bool) -> Vec<usize> {
    frames.iter().enumerate().filter(|(_, frame)| wanted(frame)).map(|(position, _)| position).collect()
}
use std::vec::Vec;

#[test]
fn the_master_is_heard_all_the_while() {
    let mut network = network();
    network.link_mut().drives[2].script.stuck_in = Some(PowerState::SwitchedOn);
    let _ = start(&mut network);
    let bus_time = network.link().clock.now().since(Default::default());
    let heartbeats = network.link().sent.iter().filter(|frame| frame.id().as_raw() == 0x77F).count();
    assert!(
        heartbeats as u128 >= (bus_time - LISTEN).as_millis() / 20,
        "{heartbeats} heartbeats in {bus_time:?} of simulated bus time"
    );
}

#[test]
fn settings_of_the_robot_file_are_written_and_read_back() {
    let setting = Setting::new(ABORT_CONNECTION_OPTION.address(), Value::Integer16(3));
    let mut drives = [drive(1), drive(2), drive(3)];
    drives[2].settings.push(setting).unwrap();
    let configuration = NetworkConfiguration::new(drives, PERIOD).unwrap();
    let mut network = DriveNetwork::new(FakeBus::new(&[1, 2, 3]), configuration);
    start(&mut network).unwrap();
    assert_eq!(value(&network, 2, &ABORT_CONNECTION_OPTION), Value::Integer16(3));
    assert_eq!(value(&network, 1, &ABORT_CONNECTION_OPTION), Value::Integer16(1));
}

#[test]
fn a_drive_in_fault_is_reset_by_an_edge() {
    let mut network = network();
    network.link_mut().drives[0].power = PowerState::Fault;
    start(&mut network).unwrap();
    assert_eq!(network.link().drives[0].power, PowerState::OperationEnabled);
}

#[test]
fn a_fault_that_stays_is_reset_again_by_a_new_edge() {
    let mut network = network();
    network.link_mut().drives[0].power = PowerState::Fault;
    network.link_mut().drives[0].script.stubborn_faults = 2;
    start(&mut network).unwrap();
    assert_eq!(network.link().drives[0].script.stubborn_faults, 0);
}

#[test]
fn answers_without_a_size_are_understood() {
    let mut network = network();
    network.link_mut().drives[0].script.no_size = true;
    start(&mut network).unwrap();
}

#[test]
fn a_drive_that_is_not_there_is_named() {
    let mut network = network();
    network.link_mut().drives[1].script.never_boots = true;
    let error = start(&mut network).unwrap_err();
    assert_eq!(error, StartError::NoBootUp { node: 2, waited: Duration::from_secs(3) });
}

#[test]
fn another_encoder_or_motor_is_refused_with_both_values() {
    for (object, found) in [(ENCODER_INCREMENTS, 4096), (RATED_TORQUE, 150)] {
        let mut network = network();
        let entry = Entry::constant(Value::Unsigned32(found));
        network.link_mut().drives[2].dictionary.insert(object.address(), entry).unwrap();
        let error = start(&mut network).unwrap_err();
        assert!(
            matches!(error, StartError::Refused { node: 3, finding }
                if finding.object == object.address() && finding.found == Answer::Number(found.into())),
            "{error}"
        );
    }
}

#[test]
fn a_mismatch_reads_well() {
    let mut network = network();
    let entry = Entry::constant(Value::Unsigned32(4096));
    network.link_mut().drives[2].dictionary.insert(ENCODER_INCREMENTS.address(), entry).unwrap();
    assert_eq!(
        format!("{}", start(&mut network).unwrap_err()),
        "node 3: 608Fh:01 (encoder increments) is 4096 (1000h), expected 8000 (1F40h): encoder.counts_per_revolution = \
         4096 if the drive is right; if the robot file is, write 608Fh in drive.writes"
    );
}

#[test]
fn a_refused_object_is_told_in_words() {
    let mut network = network();
    let entry = Entry::constant(Value::Unsigned8(0));
    network.link_mut().drives[0].dictionary.insert(SYNC_COUNTER_OVERFLOW.address(), entry).unwrap();
    assert_eq!(
        format!("{}", start(&mut network).unwrap_err()),
        "node 1 refused 1019h:00 (synchronous counter overflow value): attempt to write a read-only object (06010002h)"
    );
}

#[test]
fn a_value_that_does_not_stay_is_found_by_reading_back() {
    // The fake drive rewrites its statusword before every answer.
    let mut drives = [drive(1), drive(2), drive(3)];
    drives[0].settings.push(Setting::new(STATUSWORD.address(), Value::Unsigned16(0x1234))).unwrap();
    let configuration = NetworkConfiguration::new(drives, PERIOD).unwrap();
    let mut network = DriveNetwork::new(FakeBus::new(&[1, 2, 3]), configuration);
    let error = start(&mut network).unwrap_err();
    assert!(matches!(error, StartError::ReadBack { node: 1, written: Value::Unsigned16(0x1234), .. }), "{error}");
}

#[test]
fn silence_is_an_error_after_the_configured_attempts() {
    let mut network = network();
    network.link_mut().drives[1].script.mute_object = Some(RATED_TORQUE.address());
    let error = start(&mut network).unwrap_err();
    let timeout =
        SdoError::Timeout { node: 2, object: RATED_TORQUE.address(), waited: Duration::from_millis(200), attempts: 3 };
    assert_eq!(error, StartError::Sdo(timeout));
}

#[test]
fn a_node_that_is_no_drive_is_refused() {
    let mut network = network();
    let entry = Entry::constant(Value::Unsigned32(401));
    network.link_mut().drives[0].dictionary.insert(DEVICE_TYPE.address(), entry).unwrap();
    assert_eq!(start(&mut network).unwrap_err(), StartError::NotADrive { node: 1, profile: 401 });
}

/// SDO downloads to the drive of `node`.
fn writes(network: &DriveNetwork<FakeBus, 3>, node: u16) -> Vec<Address> {
    const DOWNLOAD: u8 = 0x20;
    let requests = network.link().sent.iter().filter(|frame| frame.id().as_raw() == 0x600 + node);
    requests
        .map(|frame| frame.data())
        .filter(|data| data[0] & 0xE0 == DOWNLOAD)
        .map(|data| Address::new(u16::from_le_bytes([data[1], data[2]]), data[3]))
        .collect()
}

#[test]
fn a_drive_without_the_mode_is_refused_before_anything_is_written_or_commanded() {
    let mut network = network();
    let position_only = Entry::constant(Value::Unsigned32(0x3_01A5));
    network.link_mut().drives[0].dictionary.insert(SUPPORTED_MODES.address(), position_only).unwrap();
    let error = start(&mut network).unwrap_err();
    assert!(
        matches!(error, StartError::Refused { node: 1, finding } if finding.object == SUPPORTED_MODES.address()),
        "{error}"
    );
    assert_eq!(writes(&network, 1), []);
    assert!(network.link().drives.iter().all(|drive| drive.commands.is_empty()));
}

#[test]
fn a_drive_that_is_found_enabled_is_disabled_before_anything_else_is_written() {
    let mut network = network();
    network.link_mut().drives[1].power = PowerState::OperationEnabled;
    start(&mut network).unwrap();
    assert_eq!(writes(&network, 2).first(), Some(&CONTROLWORD.address()));
    let first = network.link().drives[1].commands[0].controlword;
    assert_eq!(first, Controlword::of(Command::DisableVoltage));
    assert_eq!(network.link().drives[1].power, PowerState::OperationEnabled);
    assert!(!writes(&network, 1).contains(&CONTROLWORD.address()), "those without power are left alone");
}

#[test]
fn a_drive_that_keeps_its_power_refuses_the_start() {
    let mut network = network();
    network.link_mut().drives[1].power = PowerState::OperationEnabled;
    network.link_mut().drives[1].script.stuck_in = Some(PowerState::OperationEnabled);
    let error = start(&mut network).unwrap_err();
    assert!(matches!(error, StartError::NotReached { node: 2, expected: PowerState::SwitchOnDisabled, .. }), "{error}");
}

/// In *Pre-operational* a drive takes no PDO.
#[test]
fn a_stop_reaches_a_drive_that_is_enabled_before_nmt_start() {
    let mut network = network();
    network.link_mut().drives[0].script.never_boots = true;
    network.link_mut().drives[1].power = PowerState::OperationEnabled;
    start(&mut network).unwrap_err();
    let clock = network.link().clock.clone();
    let report = network.stop(&clock);
    assert_eq!(report.drives[1].power_off, Confirmation::Confirmed);
    assert_eq!(network.link().drives[1].power, PowerState::SwitchOnDisabled);
}

#[test]
fn a_second_start_writes_nothing() {
    let mut network = network();
    start(&mut network).unwrap();
    assert!(!writes(&network, 1).is_empty());
    stop(&mut network);
    network.link_mut().sent.clear();
    start(&mut network).unwrap();
    assert_eq!(writes(&network, 1), []);
}

#[test]
fn one_drive_without_a_counter_makes_the_sync_of_all_one_without() {
    let mut network = network();
    network.link_mut().drives[1].lacks.push(SYNC_COUNTER_OVERFLOW.address());
    network.link_mut().drives[0].dictionary.set(SYNC_COUNTER_OVERFLOW.address(), Value::Unsigned8(240)).unwrap();
    let started = start(&mut network).unwrap();
    assert_eq!(started.sync_payload, SyncPayload::Empty);
    assert_eq!(value(&network, 0, &SYNC_COUNTER_OVERFLOW), Value::Unsigned8(0));
    network.sync().unwrap();
    assert_eq!(*network.link().sent.last().unwrap(), wire::plain_sync_frame());
}

#[test]
fn a_counter_that_the_robot_file_wants_is_refused_where_a_drive_has_none() {
    let mut configuration = configuration();
    configuration.sync_counter = SyncCounterChoice::On;
    let mut network = DriveNetwork::new(FakeBus::new(&[1, 2, 3]), configuration);
    network.link_mut().drives[1].lacks.push(SYNC_COUNTER_OVERFLOW.address());
    assert_eq!(
        format!("{}", start(&mut network).unwrap_err()),
        "node 2: 1019h:00 (synchronous counter overflow value) is absent, expected 240 (F0h): [bus] sync_counter = \
         \"auto\""
    );
}

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

#[test]
fn pdos_have_the_identifiers_of_the_configuration() {
    let mut drives = [drive(1), drive(2), drive(3)];
    drives[2].pdos.command.identifier = embedded_can::StandardId::new(0x333).unwrap();
    drives[2].pdos.feedback.identifier = embedded_can::StandardId::new(0x1F3).unwrap();
    let configuration = NetworkConfiguration::new(drives, PERIOD).unwrap();
    assert!(configuration.receive_identifiers().any(|id| id.as_raw() == 0x1F3));
    let mut network = DriveNetwork::new(FakeBus::new(&[1, 2, 3]), configuration);
    network.link_mut().drives[2].position = 77;
    start(&mut network).unwrap();
    assert_eq!(value(&network, 2, &RPDO1_IDENTIFIER), Value::Unsigned32(0x333));
    assert_eq!(value(&network, 2, &TPDO1_IDENTIFIER), Value::Unsigned32(0x1F3));
    let now = network.link().clock.now();
    network.sync().unwrap();
    assert_eq!(network.collect(now + Duration::from_millis(2)).unwrap().positions, [Some(0), Some(0), Some(77)]);
}

/// Only joint 3 sends it.
#[test]
fn torque_feedback_is_heard_and_is_not_unexpected() {
    let mut drives = [drive(1), drive(2), drive(3)];
    let identifier = embedded_can::StandardId::new(0x283).unwrap();
    let number = crate::drive::pdo_objects::PdoNumber::FIRST;
    drives[2].pdos.torque_feedback = Some(crate::drive::wishes::PdoChannel { number, identifier });
    let configuration = NetworkConfiguration::new(drives, PERIOD).unwrap();
    assert!(configuration.receive_identifiers().any(|id| id == identifier));
    let mut network = DriveNetwork::new(FakeBus::new(&[1, 2, 3]), configuration);
    let frame = |data: &[u8]| crate::frame::Frame::new(identifier, data).unwrap();
    let now = network.link().clock.now();
    for data in [&[0xFF_u8, 0xFE][..], &[1, 2, 3]] {
        network.link_mut().inject(now, frame(data));
    }
    network.sync().unwrap();
    let health = network.health();
    assert_eq!(health.nodes.map(|node| node.torque), [None, None, Some(-257)]);
    assert_eq!((health.unexpected_frames, health.nodes[2].malformed), (0, 1));
    network.sync().unwrap();
    assert_eq!(network.torque_actual(), [None; 3], "nothing came since the SYNC before");
    let late = network.link().clock.now();
    network.link_mut().inject(late, frame(&[0x10, 0]));
    network.sync().unwrap();
    assert_eq!(
        network.torque_actual(),
        [None, None, Some(16)],
        "the answer to the SYNC before, that came too late for it"
    );
}

#[test]
fn what_was_learned_is_told_before_a_drive_has_power() {
    use std::cell::RefCell;
    std::thread_local!(static TOLD: RefCell<Vec<(u8, usize)>> = const { RefCell::new(Vec::new()) });
    let mut network = network();
    network.link_mut().drives[1].script.stuck_in = Some(PowerState::SwitchOnDisabled);
    network.on_learned(|node, _, findings| TOLD.with_borrow_mut(|told| told.push((node, findings.len()))));
    start(&mut network).unwrap_err();
    let questions = crate::drive::plan::Question::ALL.len();
    assert_eq!(TOLD.take(), [(1, questions), (2, questions), (3, questions)]);
}

#[test]
fn a_drive_that_stays_pre_operational_is_named() {
    let mut network = network();
    network.link_mut().drives[2].script.ignores_nmt_start = true;
    let error = start(&mut network).unwrap_err();
    assert_eq!(error, StartError::NotOperational { node: 3, found: Some(NmtState::PreOperational) });
}

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
fn a_drive_that_shows_another_mode_is_refused() {
    let mut network = network();
    network.link_mut().drives[1].script.shows_mode = Some(8);
    let error = start(&mut network).unwrap_err();
    let (object, expected, found) = (Address::new(0x6061, 0), Value::Integer8(10), Value::Integer8(8));
    assert_eq!(error, StartError::Mismatch { node: 2, object, expected, found });
    let commands = network.link().drives.iter().flat_map(|drive| &drive.commands);
    assert!(commands.clone().count() > 0 && commands.clone().all(|command| command.controlword != enabling()));
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

/// After each silence the transfer is aborted (0504 0000h), so that the drive does not wait for the rest of it.
#[test]
fn a_request_that_was_not_answered_is_aborted() {
    let mut network = network();
    network.link_mut().drives[0].script.mute_object = Some(DEVICE_TYPE.address());
    assert!(matches!(start(&mut network), Err(StartError::Sdo(SdoError::Timeout { node: 1, attempts: 3, .. }))));
    let about_it =
        |frame: &&crate::frame::Frame| frame.id().as_raw() == 0x601 && frame.data()[1..4] == [0x00, 0x10, 0x00];
    let to_drive = network.link().sent.iter().filter(about_it);
    let frames: Vec<[u8; 8]> = to_drive.map(|frame| frame.data().try_into().unwrap()).collect();
    let request = [0x40, 0x00, 0x10, 0x00, 0, 0, 0, 0];
    let abort = [0x80, 0x00, 0x10, 0x00, 0x00, 0x00, 0x04, 0x05];
    assert_eq!(frames, [request, abort, request, abort, request, abort]);
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

#[test]
fn a_failing_link_ends_the_start() {
    let mut network = network();
    network.link_mut().down = true;
    assert_eq!(start(&mut network).unwrap_err(), StartError::Link(bus::Down));
}

#[test]
fn configurations_are_checked() {
    let of = |nodes: [u8; 2], period| NetworkConfiguration::new(nodes.map(drive), period).map(|_| ());
    assert_eq!(of([1, 1], PERIOD), Err(ConfigurationError::NodeTaken { node: 1 }));
    assert_eq!(of([1, 127], PERIOD), Err(ConfigurationError::NodeTaken { node: 127 }));
    let odd = Duration::from_micros(2_997);
    assert_eq!(of([1, 2], odd), Err(ConfigurationError::Period { period: odd }));
    assert_eq!(NetworkConfiguration::new([], PERIOD).map(|_| ()), Err(ConfigurationError::NoDrives));
    let ms = Duration::from_millis;
    assert!(Heartbeats::new(ms(50), ms(50), ms(10), ms(50)).is_err());
    assert!(Heartbeats::new(ms(50), ms(100), Duration::from_micros(1500), ms(50)).is_err());
    assert!(Heartbeats::new(ms(50), ms(100), ms(10), ms(70_000)).is_err());
    assert!(Heartbeats::new(ms(50), ms(100), ms(10), ms(50)).is_ok());
    // A timeout of exactly one period is one late heartbeat away from a brake.
    let refused = Err(HeartbeatError { period: ms(10), timeout: ms(10) });
    assert_eq!(Heartbeats::new(ms(50), ms(100), ms(10), ms(10)), refused);
    let kept = Heartbeats::new(ms(50), ms(51), ms(10), ms(11)).unwrap();
    assert_eq!((kept.drive_timeout(), kept.master_period(), kept.master_timeout()), (ms(51), ms(10), ms(11)));
}

#[test]
fn filters_get_exactly_the_identifiers_of_the_drives_and_of_masters() {
    let found: BTreeSet<u16> = configuration().receive_identifiers().map(|id| id.as_raw()).collect();
    let of_drives = [0x080, 0x180, 0x580, 0x700];
    let of_masters = [0x200, 0x300, 0x400, 0x500, 0x600];
    let bases = || of_drives.into_iter().chain(of_masters);
    let expected = (1..=3).flat_map(|node| bases().map(move |base| base + node)).chain([0x000, 0x080, 0x77F]);
    assert_eq!(found, expected.collect());
    assert_eq!(
        configuration().receive_identifiers().count(),
        found.len(),
        "none twice: each is a filter in the kernel"
    );
}

proptest! {
    #[test]
    fn interpolation_times_are_exact(value in 1_u8..=255, exponent in 0_u32..=9) {
        let nanoseconds = u64::from(value) * 10_u64.pow(exponent);
        let period = Duration::from_nanos(nanoseconds);
        let mut times = 0;
        for (mantissa, power) in crate::drive::plan::interpolation_times(period) {
            times += 1;
            prop_assert_eq!(u64::from(mantissa) * 10_u64.pow(u32::try_from(power + 9).unwrap()), nanoseconds);
        }
        prop_assert!(times > 0);
    }

    /// Whatever is on the bus besides, starting ends, with the drives enabled or with an error.
    #[test]
    fn noise_does_not_hang_or_panic_the_start(
        noise in proptest::collection::vec((0_u64..2_000, 0_u16..=0x7FF, proptest::collection::vec(any::<u8>(), 0..=8)), 0..200),
        other_masters in any::<bool>(),
    ) {
        let mut network = network();
        for (millisecond, id, data) in noise {
            // Most noise would end the start while it listens.
            if !other_masters && configuration().foreign().any(|(identifier, _)| identifier.as_raw() == id) {
                continue;
            }
            let frame = crate::frame::Frame::new(embedded_can::StandardId::new(id).unwrap(), &data).unwrap();
            network.link_mut().inject(Default::default(), frame);
            network.link_mut().inject(crate::time::Instant::from_nanoseconds(millisecond * 1_000_000), frame);
        }
        let _ = start(&mut network);
        let _ = stop(&mut network);
    }

    /// SDO answers that are noise themselves.
    #[test]
    fn broken_answers_do_not_hang_or_panic_the_start(
        answers in proptest::collection::vec((1_u8..=3, any::<[u8; 8]>()), 0..300),
        delay in 0_u64..100,
    ) {
        let mut network = network();
        for (position, (node, payload)) in answers.into_iter().enumerate() {
            let mut payload = payload;
            // Half of them about an object that is really asked for.
            if position % 2 == 0 {
                let address = ALL[position % ALL.len()].address();
                payload[1..3].copy_from_slice(&address.index.to_le_bytes());
                payload[3] = address.subindex;
            }
            let at = crate::time::Instant::from_nanoseconds((delay + position as u64) * 1_000_000) + LISTEN;
            let frame = wire::sdo_response_frame(NodeId::new(node).unwrap(), &payload);
            network.link_mut().inject(at, frame);
        }
        let _ = start(&mut network);
    }
}

/// Segments that never end must not keep the master busy: an upload of empty segments is cut.
#[test]
fn endless_segments_are_cut() {
    let mut network = network();
    network.link_mut().drives[0].script.mute_object = Some(DEVICE_TYPE.address());
    let node = NodeId::new(1).unwrap();
    let at = |milliseconds: u64| crate::time::Instant::from_nanoseconds(milliseconds * 1_000_000) + LISTEN;
    let mut first = [0x41, 0x00, 0x10, 0x00, 9, 0, 0, 0];
    network.link_mut().inject(at(40), wire::sdo_response_frame(node, &first));
    for segment in 0..100_u8 {
        first = [0x0E | (segment % 2) << 4, 0, 0, 0, 0, 0, 0, 0];
        network.link_mut().inject(at(41), wire::sdo_response_frame(node, &first));
    }
    let error = start(&mut network).unwrap_err();
    assert!(
        matches!(error, StartError::Sdo(SdoError::Response { node: 1, object, .. }) if object == Address::new(0x1000, 0)),
        "{error}"
    );
}
