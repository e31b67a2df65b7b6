//! From power-on to *Operation enabled*, step by step.

use super::bus::enabling;
use super::configuration::LISTEN;
use super::*;
use crate::drive::cia402::{Command, Controlword, PowerState};
use crate::drive::objects::*;
use crate::drive::wire::Channel;
use crate::drive::wishes::{Homing, Operation};
use crate::time::Clock;
use canopen_rs::{Address, Entry, NmtState, Value};
use proptest::prelude::*;
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
fn a_drive_that_is_not_there_is_named() {
    let mut network = network();
    network.link_mut().drives[1].script.never_boots = true;
    let error = start(&mut network).unwrap_err();
    assert_eq!(error, StartError::NoBootUp { node: 2, waited: Duration::from_secs(3) });
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
fn a_drive_that_stays_pre_operational_is_named() {
    let mut network = network();
    network.link_mut().drives[2].script.ignores_nmt_start = true;
    let error = start(&mut network).unwrap_err();
    assert_eq!(error, StartError::NotOperational { node: 3, found: Some(NmtState::PreOperational) });
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
fn a_failing_link_ends_the_start() {
    let mut network = network();
    network.link_mut().down = true;
    assert_eq!(start(&mut network).unwrap_err(), StartError::Link(bus::Down));
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

/// Homing is mode 6, which a drive must show before brakes open, as it must show mode 10 otherwise.
#[test]
fn a_drive_that_shall_home_must_show_mode_6() {
    let homing = Homing { method: 37, switch_speed: 1, zero_speed: 1, acceleration: None, offset: 0 };
    let mut drives = [drive(1), drive(2), drive(3)];
    drives[1].operation = Operation::Homing(homing);
    let bus = || {
        let mut bus = FakeBus::new(&[1, 2, 3]);
        let dictionary = &mut bus.drives[1].dictionary;
        dictionary.insert(SUPPORTED_MODES.address(), Entry::constant(Value::Unsigned32(1 << 5))).unwrap();
        for object in [HOME_OFFSET, HOMING_METHOD, HOMING_SWITCH_SPEED, HOMING_ZERO_SPEED] {
            let zero = Value::decode_le(object.data_type, &[0; 8][..object.data_type.size()]).unwrap();
            dictionary.insert(object.address(), Entry::rw(zero)).unwrap();
        }
        bus
    };
    let configuration = NetworkConfiguration::new(drives, PERIOD).unwrap();
    let mut network = DriveNetwork::new(bus(), configuration.clone());
    start(&mut network).unwrap();
    assert_eq!(value(&network, 1, &MODE_OF_OPERATION), Value::Integer8(6));
    assert_eq!(value(&network, 0, &MODE_OF_OPERATION), Value::Integer8(10));
    let mut network = DriveNetwork::new(bus(), configuration);
    network.link_mut().drives[1].script.shows_mode = Some(10);
    let error = start(&mut network).unwrap_err();
    let expected = Value::Integer8(6);
    assert!(matches!(error, StartError::Mismatch { node: 2, expected: found, .. } if found == expected), "{error}");
    assert!(network.link().drives.iter().all(|drive| drive.power != PowerState::OperationEnabled));
}
