//! Literal frames, from the maker's documentation: "CAN Protocol" (identifiers, layout), "CAN Bus Guide" (heartbeats of
//! `candump`), <https://docs.odriverobotics.com/v/latest/manual/can-protocol.html>.

use super::*;
use proptest::prelude::*;

fn axis(node: u8) -> AxisNode {
    AxisNode::new(node).unwrap()
}

fn bytes(frame: &Frame) -> (u16, &[u8]) {
    (frame.id().as_raw(), frame.data())
}

#[test]
fn identifiers_are_node_times_32_plus_message() {
    // "0x01 << 5 | 0x0C = 0x2C" is the documentation's example; 0Ch is not used here, its neighbours are.
    assert_eq!(Message::SetControllerMode.identifier(axis(1)).as_raw(), 0x02B);
    assert_eq!(Message::SetInputTorque.identifier(axis(1)).as_raw(), 0x02E);
    assert_eq!(Message::Heartbeat.identifier(axis(62)).as_raw(), 0x7C1);
    assert_eq!(Message::EncoderEstimates.identifier(axis(3)).as_raw(), 0x069);
    assert_eq!(Message::ClearErrors.identifier(axis(3)).as_raw(), 0x078);
    for message in Message::ALL {
        for node in AxisNode::RANGE {
            assert_eq!(Message::of(message.identifier(axis(node))), Some((message, axis(node))));
        }
    }
    // Nodes 0 and 63 and the messages that are not used.
    for raw in [0x001, 0x7E1, 0x02C, 0x02D, 0x023, 0x03F] {
        assert_eq!(Message::of(StandardId::new(raw).unwrap()), None, "{raw:03X}");
    }
    assert_eq!((AxisNode::new(0), AxisNode::new(63)), (None, None));
}

#[test]
fn a_heartbeat_reads_as_candump_shows_it() {
    // "(000.001995)  can0  RX - -  021   [8]  00 00 00 00 08 00 00 00" in the CAN Bus Guide.
    let closed_loop = Heartbeat::decode(&[0, 0, 0, 0, 8, 0, 0, 0]).unwrap();
    assert_eq!((closed_loop.state, closed_loop.error), (AxisState::CLOSED_LOOP_CONTROL, AxisError(0)));
    assert!(closed_loop.is_armed());
    assert_eq!(bytes(&closed_loop.frame(axis(1))), (0x021, [0, 0, 0, 0, 8, 0, 0, 0].as_slice()));
    // 16777216: WATCHDOG_TIMER_EXPIRED; procedure result 2, trajectory done.
    let expired = Heartbeat::decode(&[0, 0, 0, 1, 1, 2, 1, 0]).unwrap();
    assert_eq!(expired.error, AxisError::WATCHDOG_TIMER_EXPIRED);
    assert_eq!((expired.state, expired.procedure_result, expired.trajectory_done), (AxisState::IDLE, 2, 1));
    assert!(!expired.is_armed());
    let failing = Heartbeat::decode(&[0, 0x20, 0, 0, 8, 0, 0, 0]).unwrap();
    assert!(!failing.is_armed(), "armed with an error is not armed: {failing:?}");
}

/// "CAN Messages" of the documentation: 00h Get_Version, eight numbers of a byte; 15h Get_Temperature, FET and motor; 17h
/// Get_Bus_Voltage_Current.
#[test]
fn version_temperatures_and_supply_are_laid_out_as_documented() {
    let version = Version::decode(&[2, 4, 4, 58, 0, 6, 10, 1]).unwrap();
    let expected = Version { protocol: 2, hardware: [4, 4, 58], firmware: [0, 6, 10], unreleased: 1 };
    assert_eq!(version, expected);
    assert_eq!(bytes(&version.frame(axis(1))), (0x020, [2, 4, 4, 58, 0, 6, 10, 1].as_slice()));
    assert_eq!((version.identity().product, version.identity().revision), (Some(0x0004_043A), Some(0x0006_0A01)));
    // 1.0f = 3F800000h, -2.5f = C0200000h.
    let data = [0x00, 0x00, 0x80, 0x3F, 0x00, 0x00, 0x20, 0xC0];
    let temperature = Temperature::decode(&data).unwrap();
    assert_eq!((temperature.inverter, temperature.motor, temperature.highest()), (1.0, -2.5, 1.0));
    assert_eq!(bytes(&temperature.frame(axis(1))), (0x035, data.as_slice()));
    assert_eq!(Temperature { inverter: f32::NAN, motor: 20.0 }.highest(), 20.0, "a thermistor that is not there");
    let supply = Supply::decode(&data).unwrap();
    assert_eq!((supply.voltage, supply.current), (1.0, -2.5));
    assert_eq!(bytes(&supply.frame(axis(1))), (0x037, data.as_slice()));
    assert_eq!(bytes(&request(Message::Version, axis(3))), (0x060, [].as_slice()));
    assert_eq!(Version::decode(&data[1..]), Err(LengthError { expected: 8, found: 7 }));
    assert_eq!(Supply::decode(&[]), Err(LengthError { expected: 8, found: 0 }));
}

#[test]
fn estimates_are_position_and_velocity_in_turns() {
    // 1.0f = 3F800000h, -2.5f = C0200000h.
    let read = EncoderEstimates::decode(&[0x00, 0x00, 0x80, 0x3F, 0x00, 0x00, 0x20, 0xC0]).unwrap();
    assert_eq!((read.position, read.velocity), (1.0, -2.5));
    let (id, data) = (0x029, [0x00, 0x00, 0x80, 0x3F, 0x00, 0x00, 0x20, 0xC0]);
    assert_eq!(bytes(&read.frame(axis(1))), (id, data.as_slice()));
    assert_eq!(bytes(&estimates_request(axis(1))), (id, [].as_slice()));
}

#[test]
fn commands_are_the_bytes_of_the_documentation() {
    // 0.25f = 3E800000h.
    assert_eq!(bytes(&torque_frame(axis(2), 0.25)), (0x04E, [0x00, 0x00, 0x80, 0x3E].as_slice()));
    assert_eq!(bytes(&state_frame(axis(2), AxisState::CLOSED_LOOP_CONTROL)), (0x047, [8, 0, 0, 0].as_slice()));
    assert_eq!(bytes(&state_frame(axis(2), AxisState::IDLE)), (0x047, [1, 0, 0, 0].as_slice()));
    // TORQUE_CONTROL is 1, PASSTHROUGH is 1.
    assert_eq!(bytes(&ControllerMode::TORQUE.frame(axis(2))), (0x04B, [1, 0, 0, 0, 1, 0, 0, 0].as_slice()));
    assert_eq!(bytes(&clear_errors_frame(axis(2))), (0x058, [0].as_slice()));
    assert_eq!(bytes(&estop_frame(axis(2))), (0x042, [].as_slice()));
}

#[test]
fn what_an_axis_takes_reads_back() {
    assert_eq!(decode_torque(&[0x00, 0x00, 0x80, 0x3E]), Ok(0.25));
    assert_eq!(decode_torque(&[0x00, 0x00, 0x80, 0x3E, 9, 9, 9, 9]), Ok(0.25), "frames of eight bytes are taken, too");
    assert_eq!(decode_state(&[8, 0, 0, 0]), Ok(AxisState::CLOSED_LOOP_CONTROL));
    assert_eq!(decode_state(&[8, 1, 0, 0]), Ok(AxisState(0)), "264 is not 8");
    assert_eq!(ControllerMode::decode(&[1, 0, 0, 0, 1, 0, 0, 0]), Ok(ControllerMode::TORQUE));
    assert_eq!(ControllerMode::decode(&[1, 0, 0, 1, 1, 0, 0, 0]).unwrap().control, 0x0100_0001);
}

#[test]
fn states_are_named_as_the_maker_names_them() {
    use std::string::ToString;
    let named = [(1, "IDLE"), (8, "CLOSED_LOOP_CONTROL"), (11, "HOMING"), (5, "state 5")];
    for (state, name) in named {
        assert_eq!(AxisState(state).to_string(), name);
    }
}

proptest! {
    /// No payload panics; only the documented lengths are read.
    #[test]
    fn wrong_lengths_are_refused(data in prop::collection::vec(any::<u8>(), 0..=8)) {
        let found = data.len();
        let exact = |expected| if found == expected { Ok(()) } else { Err(LengthError { expected, found }) };
        let least = |expected| if found >= expected { Ok(()) } else { Err(LengthError { expected, found }) };
        prop_assert_eq!(Heartbeat::decode(&data).map(|_| ()), exact(8));
        prop_assert_eq!(EncoderEstimates::decode(&data).map(|_| ()), exact(8));
        prop_assert_eq!(decode_torque(&data).map(|_| ()), least(4));
        prop_assert_eq!(decode_state(&data).map(|_| ()), least(4));
        prop_assert_eq!(ControllerMode::decode(&data).map(|_| ()), least(8));
    }

    /// Any identifier is one axis's message or none; never two.
    #[test]
    fn identifiers_are_read_or_left(raw in 0_u16..0x800) {
        if let Some((message, node)) = Message::of(StandardId::new(raw).unwrap()) {
            prop_assert_eq!(message.identifier(node).as_raw(), raw);
        }
    }
}
