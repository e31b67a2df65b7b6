//! What is read from the drives and written to them at start, and what is refused.

use super::configuration::LISTEN;
use super::*;
use crate::drive::cia402::PowerState;
use crate::drive::objects::*;
use crate::drive::pdo_objects::{PdoKind, PdoNumber};
use crate::drive::survey::Answer;
use crate::drive::wishes::{HeartbeatError, Resolution, SyncCounterChoice, Watchdog, WatchdogTest};
use crate::time::Clock;
use canopen_rs::{Address, Entry, Value};
use std::collections::BTreeSet;
use std::format;
use std::vec::Vec;

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
fn answers_without_a_size_are_understood() {
    let mut network = network();
    network.link_mut().drives[0].script.no_size = true;
    start(&mut network).unwrap();
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

/// That an object cannot be written is known when it is tried: the remedy is told, not the abort code.
#[test]
fn an_object_that_turns_out_to_be_read_only_is_refused_with_the_remedy() {
    for (object, value, message) in [
        (
            SYNC_COUNTER_OVERFLOW,
            Value::Unsigned8(0),
            "node 1: 1019h:00 (synchronous counter overflow value) is 0, expected 240 (F0h): [bus] sync_counter = \"off\"",
        ),
        (
            INTERPOLATION_TIME_VALUE,
            Value::Unsigned8(20),
            "node 1: 60C2h:01 (interpolation time period value) is 20 (14h), expected control.period_us, in whole \
             milliseconds as a rule: [control] period_us = 20000",
        ),
    ] {
        let mut configuration = configuration();
        configuration.sync_counter = SyncCounterChoice::On;
        let mut network = DriveNetwork::new(FakeBus::new(&[1, 2, 3]), configuration);
        network.link_mut().drives[0].dictionary.insert(object.address(), Entry::constant(value)).unwrap();
        assert_eq!(format!("{}", start(&mut network).unwrap_err()), message);
    }
}

/// The same of the objects of PDOs.
#[test]
fn a_pdo_that_turns_out_to_be_read_only_is_refused_with_the_remedy() {
    let number = |number| PdoNumber::new(number).unwrap();
    for (objects, message) in [
        (
            &[(RPDO1_IDENTIFIER, Value::Unsigned32(0x7FF))][..],
            "node 1: 1400h:01 (RPDO1 COB-ID) is 2047 (7FFh), expected 513 (201h): another drive, or another number in \
             drive.pdo.rpdo",
        ),
        (
            &[
                (PdoKind::Transmit.identifier(number(3)), Value::Unsigned32(0x381)),
                (PdoKind::Transmit.transmission(number(3)), Value::Unsigned8(255)),
                (PdoKind::Transmit.mapped_objects(number(3)), Value::Unsigned8(0)),
            ],
            "node 1: 1802h:01 is 897 (381h), expected off (bit 31): drive.pdo.keep_tpdos = [3]",
        ),
        (
            &[(PdoKind::Transmit.mapped_objects(PdoNumber::FIRST), Value::Unsigned8(0))],
            "node 1: 1A00h:00 (TPDO1 number of mapped objects) is 0, expected what the cycle carries, or a mapping that can be changed: another drive: no \
             PDO of it carries this",
        ),
        (
            &[(PdoKind::Transmit.mapped_object(PdoNumber::FIRST, 1), Value::Unsigned32(0))],
            "node 1: 1A00h:00 (TPDO1 number of mapped objects) is 0, expected what the cycle carries, or a mapping that can be changed: another drive: no \
             PDO of it carries this",
        ),
    ] {
        let mut network = network();
        for (object, value) in objects {
            network.link_mut().drives[0].dictionary.insert(object.address(), Entry::constant(*value)).unwrap();
        }
        assert_eq!(format!("{}", start(&mut network).unwrap_err()), message);
    }
}

#[test]
fn a_refused_object_is_told_in_words() {
    let mut drives = [drive(1), drive(2), drive(3)];
    // Four bytes, where the standard has two.
    drives[0].settings.push(Setting::of(&ABORT_CONNECTION_OPTION, Value::Unsigned32(3))).unwrap();
    let mut network = DriveNetwork::new(FakeBus::new(&[1, 2, 3]), NetworkConfiguration::new(drives, PERIOD).unwrap());
    assert_eq!(
        format!("{}", start(&mut network).unwrap_err()),
        "node 1 refused 6007h:00 (abort connection option code): data type does not match, length of parameter too high (06070012h)"
    );
}

/// Makers count lines and steps in objects of 8, 16 and 32 bits; the robot file does not say which.
#[test]
fn a_makers_resolution_is_read_whatever_its_length() {
    let address = Address::new(0x3010, 4);
    for value in [Value::Unsigned32(70_000), Value::Unsigned16(4096), Value::Unsigned8(200)] {
        let equals = Answer::of(value).number().unwrap();
        for (equals, is_right) in [(equals, true), (equals + 1, false)] {
            let mut drives = [drive(1), drive(2), drive(3)];
            drives[1].resolution = Resolution::Object { address, equals };
            let configuration = NetworkConfiguration::new(drives, PERIOD).unwrap();
            let mut network = DriveNetwork::new(FakeBus::new(&[1, 2, 3]), configuration);
            network.link_mut().drives[1].dictionary.insert(address, Entry::constant(value)).unwrap();
            assert_eq!(start(&mut network).is_ok(), is_right, "{value:?}, expected {equals}");
        }
    }
}

/// A drive that forgets its torque limit when its mode is written.
#[test]
fn a_setting_that_a_later_one_undoes_is_an_error_before_and_kept_after() {
    let limit = Setting::of(&MAXIMUM_TORQUE, Value::Unsigned16(500));
    let start_with = |settings: &[Setting], later: &[Setting]| {
        let mut drives = [drive(1), drive(2), drive(3)];
        drives[1].settings.extend_from_slice(settings).unwrap();
        drives[1].later_settings.extend_from_slice(later).unwrap();
        let configuration = NetworkConfiguration::new(drives, PERIOD).unwrap();
        let mut network = DriveNetwork::new(FakeBus::new(&[1, 2, 3]), configuration);
        let drive = &mut network.link_mut().drives[1];
        drive.script.mode_resets = Some(MAXIMUM_TORQUE);
        // As it is at power-up, and as an earlier start has left it.
        for found in [0, 500] {
            let drive = &mut network.link_mut().drives[1];
            drive.dictionary.insert(MAXIMUM_TORQUE.address(), Entry::rw(Value::Unsigned16(found))).unwrap();
            drive.dictionary.set(MODE_OF_OPERATION.address(), Value::Integer8(0)).unwrap();
            let started = start(&mut network);
            if let Err(error) = started {
                return Err(format!("{error}"));
            }
            stop(&mut network);
        }
        Ok(value(&network, 1, &MAXIMUM_TORQUE))
    };
    assert_eq!(
        start_with(&[limit], &[]).unwrap_err(),
        "node 2: 6072h:00 (max torque) was 500 (01F4h) and reads 0 (0000h) after another object was written: it belongs into drive.writes with when = \"after\""
    );
    assert_eq!(start_with(&[], &[limit]), Ok(Value::Unsigned16(500)));
}

/// The mapping was right when the drive was read, and no longer when its mode was written.
#[test]
fn a_mapping_that_the_mode_undoes_is_an_error() {
    let mut network = network();
    start(&mut network).unwrap();
    stop(&mut network);
    let drive = &mut network.link_mut().drives[0];
    drive.script.mode_resets = Some(PdoKind::Transmit.mapped_objects(PdoNumber::FIRST));
    drive.dictionary.set(MODE_OF_OPERATION.address(), Value::Integer8(0)).unwrap();
    let error = start(&mut network).unwrap_err();
    let object = Address::new(0x1A00, 0);
    assert!(matches!(error, StartError::Undone { node: 1, object: found, .. } if found == object), "{error}");
}

/// As an earlier start has left it, and then as the robot file has it until the protocol switches it on.
#[test]
fn what_the_protocol_sets_otherwise_than_the_robot_file_is_not_undone() {
    let off = Value::Unsigned32(0x8000_0201);
    let mut drives = [drive(1), drive(2), drive(3)];
    drives[0].settings.push(Setting::of(&RPDO1_IDENTIFIER, off)).unwrap();
    let configuration = NetworkConfiguration::new(drives, PERIOD).unwrap();
    let mut network = DriveNetwork::new(FakeBus::new(&[1, 2, 3]), configuration);
    network.link_mut().drives[0].dictionary.set(RPDO1_IDENTIFIER.address(), off).unwrap();
    start(&mut network).unwrap();
    assert_eq!(value(&network, 0, &RPDO1_IDENTIFIER), Value::Unsigned32(0x201));
}

#[test]
fn a_command_timeout_that_turns_out_to_be_read_only_is_refused_with_the_remedy() {
    let mut drives = [drive(1), drive(2), drive(3)];
    drives[0].watchdog = Watchdog::RpdoTimeout { milliseconds: 50, test: WatchdogTest::AtStart };
    let configuration = NetworkConfiguration::new(drives, PERIOD).unwrap();
    let mut network = DriveNetwork::new(FakeBus::new(&[1, 2, 3]), configuration);
    let fixed = Entry::constant(Value::Unsigned16(0));
    network.link_mut().drives[0].dictionary.insert(RPDO1_EVENT_TIMER.address(), fixed).unwrap();
    assert_eq!(
        format!("{}", start(&mut network).unwrap_err()),
        "node 1: 1400h:05 (RPDO1 event timer) is 0, expected 50 (32h): drive.watchdog = \"heartbeat\", or another drive"
    );
}

/// The robot file's last word is written, though the drive has it from an earlier start: the protocol's comes between.
#[test]
fn what_is_written_after_the_protocol_is_the_last_word_at_each_start() {
    let mut drives = [drive(1), drive(2), drive(3)];
    drives[1].later_settings.push(Setting::of(&EMERGENCY_IDENTIFIER, Value::Unsigned32(0x8000_0082))).unwrap();
    let configuration = NetworkConfiguration::new(drives, PERIOD).unwrap();
    let mut network = DriveNetwork::new(FakeBus::new(&[1, 2, 3]), configuration);
    for _ in 0..2 {
        start(&mut network).unwrap();
        assert_eq!(value(&network, 1, &EMERGENCY_IDENTIFIER), Value::Unsigned32(0x8000_0082));
        stop(&mut network);
    }
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

/// The first drive of `network`, which has been told to count or would be, is told not to, and a plain SYNC is sent.
fn assert_starts_without_a_counter(network: &mut DriveNetwork<FakeBus, 3>) {
    let started = start(network).unwrap();
    assert_eq!(started.sync_payload, SyncPayload::Empty);
    assert_eq!(value(network, 0, &SYNC_COUNTER_OVERFLOW), Value::Unsigned8(0));
    network.sync().unwrap();
    assert_eq!(*network.link().sent.last().unwrap(), wire::plain_sync_frame());
}

#[test]
fn one_drive_without_a_counter_makes_the_sync_of_all_one_without() {
    let mut network = network();
    network.link_mut().drives[1].lacks.push(SYNC_COUNTER_OVERFLOW.address());
    network.link_mut().drives[0].dictionary.set(SYNC_COUNTER_OVERFLOW.address(), Value::Unsigned8(240)).unwrap();
    assert_starts_without_a_counter(&mut network);
}

/// The second drive tells that its 1019h is fixed only when the first has been told to count.
#[test]
fn one_drive_whose_counter_is_fixed_at_0_makes_the_sync_of_all_one_without() {
    let mut network = network();
    let fixed = Entry::constant(Value::Unsigned8(0));
    network.link_mut().drives[1].dictionary.insert(SYNC_COUNTER_OVERFLOW.address(), fixed).unwrap();
    assert_starts_without_a_counter(&mut network);
}

#[test]
fn a_counter_that_is_fixed_at_another_value_is_refused() {
    let mut network = network();
    let fixed = Entry::constant(Value::Unsigned8(10));
    network.link_mut().drives[1].dictionary.insert(SYNC_COUNTER_OVERFLOW.address(), fixed).unwrap();
    assert_eq!(
        format!("{}", start(&mut network).unwrap_err()),
        "node 2: 1019h:00 (synchronous counter overflow value) is 10 (Ah), expected 0: another drive: its SYNC counter \
         cannot be switched off"
    );
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
