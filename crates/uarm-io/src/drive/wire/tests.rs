use super::*;
use crate::drive::cia402::{Command, PowerState};
use canopen_rs::pdo::{PdoMapping, pack};
use canopen_rs::{Entry, ObjectDictionary, Value};
use proptest::prelude::*;

fn node() -> impl Strategy<Value = NodeId> {
    (1_u8..=127).prop_map(|raw| NodeId::new(raw).unwrap())
}

#[test]
fn identifiers_are_those_of_the_predefined_connection_set() {
    let node = NodeId::new(3).unwrap();
    let raw = |channel: Channel| channel.identifier().as_raw();
    assert_eq!(raw(Channel::NmtCommand), 0x000);
    assert_eq!(raw(Channel::Sync), 0x080);
    assert_eq!(raw(Channel::Emergency(node)), 0x083);
    assert_eq!(raw(Channel::Tpdo1(node)), 0x183);
    assert_eq!(raw(Channel::Rpdo1(node)), 0x203);
    assert_eq!(raw(Channel::SdoResponse(node)), 0x583);
    assert_eq!(raw(Channel::SdoRequest(node)), 0x603);
    assert_eq!(raw(Channel::Heartbeat(node)), 0x703);
    assert_eq!(master_heartbeat_frame().id().as_raw(), 0x77F);
}

#[test]
fn every_identifier_names_at_most_one_channel() {
    let mut channels = 0;
    for raw in 0..=0x7FF {
        let identifier = StandardId::new(raw).unwrap();
        if let Some(channel) = Channel::of(identifier) {
            assert_eq!(channel.identifier(), identifier);
            channels += 1;
        }
    }
    assert_eq!(channels, 2 + 6 * 127);
}

#[test]
fn an_absent_payload_is_an_error_with_both_lengths() {
    assert_eq!(DriveFeedback::decode(&[0; 5]), Err(PayloadError::Length { expected: 6, found: 5 }));
    assert_eq!(DriveCommand::decode(&[]), Err(PayloadError::Length { expected: 4, found: 0 }));
    assert_eq!(decode_heartbeat(&[0x42]), Err(PayloadError::NmtState { found: 0x42 }));
    assert_eq!(decode_nmt(&[0x77, 1]), Err(PayloadError::NmtCommand { command: 0x77, node: 1 }));
}

#[test]
fn the_heartbeat_entry_names_the_master_and_the_time() {
    assert_eq!(consumer_heartbeat_entry(100), 0x007F_0064);
    assert_eq!(decode_consumer_heartbeat_entry(0x007F_0064), (MASTER_NODE, 100));
}

/// The hand-written layout against the packing that canopen-rs derives from the mapping.
#[test]
fn feedback_is_packed_as_its_mapping_says() {
    let feedback = DriveFeedback {
        statusword: Statusword::of(PowerState::OperationEnabled).with(Statusword::REMOTE),
        position: -123_456_789,
    };
    let mut dictionary = ObjectDictionary::<2>::new();
    dictionary.insert(STATUSWORD.address(), Entry::rw(Value::Unsigned16(feedback.statusword.bits()))).unwrap();
    dictionary.insert(POSITION_ACTUAL.address(), Entry::rw(Value::Integer32(feedback.position))).unwrap();
    let mut mapping = PdoMapping::<2>::new();
    for entry in TPDO1_MAPPING {
        mapping.push(entry).unwrap();
    }
    let mut packed = [0; 8];
    let length = pack(&mapping, &dictionary, &mut packed).unwrap();
    assert_eq!(&packed[..length], &feedback.encode());
}

#[test]
fn commands_are_packed_as_their_mapping_says() {
    let command = DriveCommand { controlword: Controlword::of(Command::EnableOperation), target_torque: -321 };
    let mut dictionary = ObjectDictionary::<2>::new();
    dictionary.insert(CONTROLWORD.address(), Entry::rw(Value::Unsigned16(command.controlword.bits()))).unwrap();
    dictionary.insert(TARGET_TORQUE.address(), Entry::rw(Value::Integer16(command.target_torque))).unwrap();
    let mut mapping = PdoMapping::<2>::new();
    for entry in RPDO1_MAPPING {
        mapping.push(entry).unwrap();
    }
    let mut packed = [0; 8];
    let length = pack(&mapping, &dictionary, &mut packed).unwrap();
    assert_eq!(&packed[..length], &command.encode());
}

#[test]
fn an_emergency_too_short_for_its_code_is_no_error_reset() {
    for data in [&[][..], &[0]] {
        assert_eq!(decode_emergency(data).error_code, 0x1000);
    }
    assert!(decode_emergency(&[0, 0]).is_error_reset());
    assert_eq!(decode_emergency(&[0x30, 0x81, 0x11]), EmergencyMessage::new(0x8130, ErrorRegister(0x11), [0; 5]));
}

proptest! {
    #[test]
    fn feedback_survives_the_wire(bits in any::<u16>(), position in any::<i32>(), node in node()) {
        let feedback = DriveFeedback { statusword: Statusword::from_bits(bits), position };
        let frame = feedback.frame(node);
        prop_assert_eq!(Channel::of(frame.id()), Some(Channel::Tpdo1(node)));
        prop_assert_eq!(DriveFeedback::decode(frame.data()), Ok(feedback));
    }

    #[test]
    fn commands_survive_the_wire(bits in any::<u16>(), target_torque in any::<i16>(), node in node()) {
        let command = DriveCommand { controlword: Controlword::from_bits(bits), target_torque };
        let frame = command.frame(node);
        prop_assert_eq!(Channel::of(frame.id()), Some(Channel::Rpdo1(node)));
        prop_assert_eq!(DriveCommand::decode(frame.data()), Ok(command));
    }

    /// Whatever comes, a parser answers; what it accepts, it writes back unchanged.
    #[test]
    fn parsers_never_panic(data in proptest::collection::vec(any::<u8>(), 0..=8)) {
        if let Ok(feedback) = DriveFeedback::decode(&data) {
            prop_assert_eq!(&feedback.encode()[..], &data[..]);
        }
        if let Ok(command) = DriveCommand::decode(&data) {
            prop_assert_eq!(&command.encode()[..], &data[..]);
        }
        if data.len() >= 2 {
            let whole = decode_emergency(&data).encode();
            prop_assert_eq!(&whole[..data.len()], &data[..]);
            prop_assert_eq!(&whole[data.len()..], &[0_u8; 8][data.len()..]);
        }
        if let Ok((command, target)) = decode_nmt(&data) {
            let frame = nmt_frame(command, target);
            prop_assert_eq!(frame.data(), &data[..]);
        }
        if let Ok(state) = decode_heartbeat(&data) {
            // Bit 7 is the toggle bit of node guarding and not part of the state.
            prop_assert_eq!(nmt::encode_heartbeat(state)[0], data[0] & 0x7F);
        }
        prop_assert_eq!(decode_sync(&data).is_ok(), data.len() <= 1);
        prop_assert_eq!(decode_sdo(&data).is_ok(), data.len() == 8);
    }
}
