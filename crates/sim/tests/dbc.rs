//! The DBC reads each frame as `uarm_io`'s wire writes it.

use can_dbc::{ByteOrder, Dbc, MessageId, Signal, ValueType};
use proptest::prelude::*;
use std::collections::BTreeMap;
use uarm_io::drive::cia402::{Controlword, Statusword};
use uarm_io::drive::wire::FRAMES_DBC;
use uarm_io::drive::wire::{self, DriveCommand, DriveFeedback, EmergencyMessage};
use uarm_io::drive::{NmtCommand, NmtState, NodeId};
use uarm_io::frame::Frame;

/// A signal's value, by the DBC's own rules alone.
fn decode(signal: &Signal, data: &[u8]) -> i64 {
    assert_eq!(signal.byte_order, ByteOrder::LittleEndian);
    assert_eq!((signal.factor, signal.offset), (1.0, 0.0));
    let mut bytes = [0; 8];
    bytes[..data.len()].copy_from_slice(data);
    let shifted = u64::from_le_bytes(bytes) << (64 - signal.start_bit - signal.size);
    match signal.value_type {
        ValueType::Signed => shifted as i64 >> (64 - signal.size),
        ValueType::Unsigned => (shifted >> (64 - signal.size)) as i64,
    }
}

/// All signals of a frame.
fn signals(frame: &Frame) -> BTreeMap<String, i64> {
    let dbc = Dbc::try_from(FRAMES_DBC).unwrap();
    let message = dbc.messages.iter().find(|message| message.id == MessageId::Standard(frame.id().as_raw()));
    let message = message.unwrap_or_else(|| panic!("no message {:x}", frame.id().as_raw()));
    assert_eq!(message.size, frame.data().len() as u64, "{}", message.name);
    message.signals.iter().map(|signal| (signal.name.clone(), decode(signal, frame.data()))).collect()
}

fn named<const N: usize>(expected: [(&str, i64); N]) -> BTreeMap<String, i64> {
    expected.map(|(name, value)| (name.to_owned(), value)).into()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn feedback(id in 1_u8..=3, status: u16, position: i32) {
        let feedback = DriveFeedback { statusword: Statusword::from_bits(status), position };
        let expected = named([("Statusword", status.into()), ("Position", position.into())]);
        prop_assert_eq!(signals(&feedback.frame(NodeId::new(id).unwrap())), expected);
    }

    #[test]
    fn command(id in 1_u8..=3, control: u16, target_torque: i16) {
        let command = DriveCommand { controlword: Controlword::from_bits(control), target_torque };
        let expected = named([("Controlword", control.into()), ("TargetTorque", target_torque.into())]);
        prop_assert_eq!(signals(&command.frame(NodeId::new(id).unwrap())), expected);
    }

    #[test]
    fn emergency(id in 1_u8..=3, code: u16, register: u8, manufacturer: [u8; 5]) {
        let message = EmergencyMessage::new(code, canopen_rs::ErrorRegister(register), manufacturer);
        let [m0, m1, m2, m3, m4] = manufacturer;
        let manufacturer = i64::from_le_bytes([m0, m1, m2, m3, m4, 0, 0, 0]);
        let expected =
            named([("ErrorCode", code.into()), ("ErrorRegister", register.into()), ("Manufacturer", manufacturer)]);
        prop_assert_eq!(signals(&wire::emergency_frame(NodeId::new(id).unwrap(), &message)), expected);
    }

    #[test]
    fn sync(counter in 1_u8..=240) {
        prop_assert_eq!(signals(&wire::sync_frame(counter)), named([("Counter", counter.into())]));
    }
}

#[test]
fn network_management() {
    let start = wire::nmt_frame(NmtCommand::StartRemoteNode, NodeId::new(3).unwrap());
    assert_eq!(signals(&start), named([("Command", 1), ("Node", 3)]));
    assert_eq!(signals(&wire::master_heartbeat_frame()), named([("NmtState", 5)]));
    for id in 1..=3 {
        let heartbeat = wire::heartbeat_frame(NodeId::new(id).unwrap(), NmtState::PreOperational);
        assert_eq!(signals(&heartbeat), named([("NmtState", 127)]));
    }
}
