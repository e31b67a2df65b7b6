//! The emulated drives where the standards are precise: lengths, error history, modes, PDOs, and starts of a drive with a past.

mod support;

use std::time::Duration;
use support::{Master, drives, lockstep, node};
use uarm_io::drive::cia402::{Command, PowerState};
use uarm_io::drive::wire::{self, Channel};
use uarm_io::drive::{Address, DataType, NmtCommand, NmtState, Value};
use uarm_io::frame::Frame;
use uarm_sim::drive::{CounterAtPowerUp, DictionaryError, DriveFault, DriveObject, Mappable};
use uarm_sim::{DemPlant, DriveDictionary, EmulatedDrive, EmulatedRobot, InProcessLink, Joint, PowerUp, VirtualClock};

type Robot = Master<InProcessLink<EmulatedRobot<DemPlant>, VirtualClock>>;

/// The emergency codes of node 2 among frames.
fn emergencies(frames: &[Frame]) -> Vec<u16> {
    let of_node_2 = frames.iter().filter(|frame| Channel::of(frame.id()) == Some(Channel::Emergency(node(2))));
    of_node_2.map(|frame| wire::decode_emergency(frame.data()).error_code).collect()
}

/// Sends an SDO request of these bytes to node 2 and returns the answer.
fn request(master: &mut Robot, bytes: [u8; 8]) -> [u8; 8] {
    master.send(wire::sdo_request_frame(node(2), &bytes));
    let frames = master.received();
    let answer = frames.iter().find(|frame| Channel::of(frame.id()) == Some(Channel::SdoResponse(node(2)))).unwrap();
    wire::decode_sdo(answer.data()).unwrap()
}

fn abort(index: u16, subindex: u8, code: u32) -> [u8; 8] {
    let ([low, high], [c0, c1, c2, c3]) = (index.to_le_bytes(), code.to_le_bytes());
    [0x80, low, high, subindex, c0, c1, c2, c3]
}

/// A master of three drives of which the second is `second`.
fn with_second(second: EmulatedDrive) -> Robot {
    let [first, _, third] = drives();
    let plant = DemPlant::new(dem_model::ThreeLinkDem::table_2());
    let all = [EmulatedDrive::new(first), second, EmulatedDrive::new(third)];
    let robot = EmulatedRobot::with_drives(plant, all, lockstep()).unwrap();
    let clock = VirtualClock::new();
    Master::on(InProcessLink::new(robot, clock.clone()), clock)
}

#[test]
fn a_sync_of_the_wrong_length_is_reported_once_and_not_answered() {
    let mut master = Master::with_robot(lockstep());
    master.enable();
    assert_eq!(master.sync().len(), 3);
    master.send(wire::plain_sync_frame());
    let frames = master.received();
    assert_eq!(emergencies(&frames), [0x8240]);
    assert!(!frames.iter().any(|frame| Channel::of(frame.id()) == Some(Channel::Tpdo1(node(2)))));
    master.send(wire::plain_sync_frame());
    assert_eq!(master.received(), [], "said once");
    assert_eq!(master.sync().len(), 3, "and all goes on with the right one");
}

#[test]
fn the_error_history_is_cleared_with_zero_only() {
    let mut master = Master::with_robot(lockstep());
    master.write(2, 0x1019, 0, Value::Unsigned8(240)).unwrap();
    master.send(wire::plain_sync_frame());
    assert_eq!(emergencies(&master.received()), [0x8240]);
    assert_eq!(master.read(2, 0x1003, 0, DataType::Unsigned8), Ok(Value::Unsigned8(1)));
    assert_eq!(master.read(2, 0x1003, 1, DataType::Unsigned32), Ok(Value::Unsigned32(0x8240)));
    assert_eq!(master.write(2, 0x1003, 0, Value::Unsigned8(1)), Err(0x0609_0030));
    assert_eq!(master.write(2, 0x1003, 0, Value::Unsigned8(0)), Ok(()));
    assert_eq!(master.read(2, 0x1003, 0, DataType::Unsigned8), Ok(Value::Unsigned8(0)));
    assert_eq!(master.read(2, 0x1003, 1, DataType::Unsigned32), Ok(Value::Unsigned32(0)));
    assert_eq!(
        master.read(2, 0x1001, 0, DataType::Unsigned8),
        Ok(Value::Unsigned8(0x11)),
        "the error itself is still there"
    );
}

/// CiA 301, table 22: 0607 0012h too many bytes, 0607 0013h too few.
#[test]
fn a_write_has_the_objects_length() {
    let mut master = Master::with_robot(lockstep());
    // 1017h has two bytes.
    assert_eq!(request(&mut master, [0x2F, 0x17, 0x10, 0, 50, 0, 0, 0]), abort(0x1017, 0, 0x0607_0013));
    assert_eq!(request(&mut master, [0x23, 0x17, 0x10, 0, 50, 0, 0, 0]), abort(0x1017, 0, 0x0607_0012));
    assert_eq!(request(&mut master, [0x2B, 0x17, 0x10, 0, 50, 0, 0, 0]), [0x60, 0x17, 0x10, 0, 0, 0, 0, 0]);
    assert_eq!(master.read(2, 0x1017, 0, DataType::Unsigned16), Ok(Value::Unsigned16(50)));
}

#[test]
fn a_write_in_segments_is_judged_when_it_is_whole() {
    let mut master = Master::with_robot(lockstep());
    let begin = [0x21, 0x60, 0x60, 0, 1, 0, 0, 0];
    assert_eq!(request(&mut master, begin), [0x60, 0x60, 0x60, 0, 0, 0, 0, 0]);
    // One byte of seven, the last segment: mode 10.
    assert_eq!(request(&mut master, [0x0D, 10, 0, 0, 0, 0, 0, 0]), [0x20, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(master.read(2, 0x6060, 0, DataType::Integer8), Ok(Value::Integer8(10)));
    request(&mut master, begin);
    assert_eq!(request(&mut master, [0x0D, 8, 0, 0, 0, 0, 0, 0]), abort(0x6060, 0, 0x0609_0030), "no such mode");
    request(&mut master, begin);
    assert_eq!(request(&mut master, [0x1D, 10, 0, 0, 0, 0, 0, 0]), abort(0x6060, 0, 0x0503_0000), "the toggle bit");
    assert_eq!(request(&mut master, [0x21, 0x60, 0x60, 0, 2, 0, 0, 0]), abort(0x6060, 0, 0x0607_0012));
}

/// The two bytes of 1017h in a segment each; the toggle bit alternates.
#[test]
fn a_write_may_have_several_segments() {
    let mut master = Master::with_robot(lockstep());
    let before = master.read(2, 0x1017, 0, DataType::Unsigned16);
    assert_ne!(before, Ok(Value::Unsigned16(0x012C)));
    assert_eq!(request(&mut master, [0x21, 0x17, 0x10, 0, 2, 0, 0, 0]), [0x60, 0x17, 0x10, 0, 0, 0, 0, 0]);
    assert_eq!(request(&mut master, [0x0C, 0x2C, 0, 0, 0, 0, 0, 0]), [0x20, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(request(&mut master, [0x1D, 0x01, 0, 0, 0, 0, 0, 0]), [0x30, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(master.read(2, 0x1017, 0, DataType::Unsigned16), Ok(Value::Unsigned16(0x012C)));
    // More bytes than the object has, and fewer, without a size said beforehand.
    let begin = [0x20, 0x17, 0x10, 0, 0, 0, 0, 0];
    request(&mut master, begin);
    assert_eq!(request(&mut master, [0x09, 1, 2, 3, 0, 0, 0, 0]), abort(0x1017, 0, 0x0607_0012));
    request(&mut master, begin);
    assert_eq!(request(&mut master, [0x0D, 1, 0, 0, 0, 0, 0, 0]), abort(0x1017, 0, 0x0607_0013));
    assert_eq!(master.read(2, 0x1017, 0, DataType::Unsigned16), Ok(Value::Unsigned16(0x012C)));
}

/// CiA 301, 7.2.4.3: client command specifiers 5 and 6 begin block transfers, which the drive does not have.
#[test]
fn block_transfers_are_refused_as_unknown_commands() {
    let mut master = Master::with_robot(lockstep());
    for command in [0xA0, 0xA4, 0xA3, 0xC0, 0xC2, 0xC6, 0xE0] {
        let [answer, .., c0, c1, c2, c3] = request(&mut master, [command, 0x60, 0x60, 0, 1, 0, 0, 0]);
        assert_eq!((answer, u32::from_le_bytes([c0, c1, c2, c3])), (0x80, 0x0504_0001), "{command:X}h");
    }
    assert_eq!(master.read(2, 0x6060, 0, DataType::Integer8), Ok(Value::Integer8(0)), "and all else goes on");
}

/// CiA 301, 7.5.2.19: an entry of 1016h is a node, 1 to 127, and a time; with a time of 0 it is not used.
#[test]
fn a_heartbeat_is_awaited_of_a_node_that_can_be() {
    let mut master = Master::with_robot(lockstep());
    for sender in [0, 128, 200, 255] {
        let refused = master.write(2, 0x1016, 1, Value::Unsigned32(sender << 16 | 50));
        assert_eq!(refused, Err(0x0609_0030), "node {sender}");
    }
    for sender in [1, 127] {
        assert_eq!(master.write(2, 0x1016, 1, Value::Unsigned32(sender << 16 | 50)), Ok(()), "node {sender}");
    }
    assert_eq!(master.write(2, 0x1016, 1, Value::Unsigned32(0)), Ok(()));
}

#[test]
fn a_missing_sub_index_is_not_a_missing_object() {
    let mut master = Master::with_robot(lockstep());
    assert_eq!(master.read(2, 0x608F, 3, DataType::Unsigned32), Err(0x0609_0011));
    assert_eq!(master.read(2, 0x6091, 1, DataType::Unsigned32), Err(0x0602_0000));
    assert_eq!(master.write(2, 0x1016, 9, Value::Unsigned32(0)), Err(0x0609_0011));
}

#[test]
fn without_a_mode_a_motor_goes_off_and_its_ratings_stand_while_it_is_on() {
    let mut master = Master::with_robot(lockstep());
    master.enable();
    assert_eq!(master.write(2, 0x6076, 0, Value::Unsigned32(100)), Err(0x0800_0022));
    master.write(2, 0x6060, 0, Value::Integer8(0)).unwrap();
    let state = |master: &Robot| master.link.robot().drive(Joint::TWO).power_state();
    assert_eq!(state(&master), PowerState::SwitchOnDisabled);
    master.command(2, Command::EnableOperation, 100);
    assert_eq!(state(&master), PowerState::SwitchOnDisabled, "the cyclic command does not bring it back");
    assert_eq!(master.write(2, 0x6076, 0, Value::Unsigned32(100)), Ok(()));
}

#[test]
fn quick_stop_options_below_five_end_in_switch_on_disabled() {
    for (option, state) in [(2, PowerState::SwitchOnDisabled), (6, PowerState::QuickStopActive)] {
        let mut master = Master::with_robot(lockstep());
        master.write(2, 0x605A, 0, Value::Integer16(option)).unwrap();
        master.enable();
        master.command(2, Command::QuickStop, 0);
        assert_eq!(master.link.robot().drive(Joint::TWO).power_state(), state, "{option}");
    }
}

/// TPDO2 carries 6077h; its identifier of the predefined connection set is 280h and the node.
#[test]
fn a_second_tpdo_is_sent_at_sync_or_when_it_changes() {
    let mut master = Master::with_robot(lockstep());
    master.write(2, 0x1801, 1, Value::Unsigned32(0x282)).unwrap();
    let second = |frames: Vec<Frame>| -> Vec<Vec<u8>> {
        frames.iter().filter(|frame| frame.id().as_raw() == 0x282).map(|frame| frame.data().to_vec()).collect()
    };
    master.enable();
    master.received();
    master.send(wire::sync_frame(1));
    assert_eq!(second(master.received()), [[0, 0]]);
    master.write(2, 0x1801, 2, Value::Unsigned8(255)).unwrap();
    master.send(wire::sync_frame(2));
    assert_eq!(second(master.received()), [[0; 2]; 0], "nothing has changed");
    master.command(2, Command::EnableOperation, 0x0102);
    master.send(wire::sync_frame(3));
    assert_eq!(second(master.received()), [[2, 1]]);
    master.write(2, 0x1801, 2, Value::Unsigned8(2)).unwrap();
    let every_second: Vec<usize> = (4..8)
        .map(|counter| {
            master.send(wire::sync_frame(counter));
            second(master.received()).len()
        })
        .collect();
    assert_eq!(every_second.iter().sum::<usize>(), 2);
    assert_ne!(every_second[0], every_second[1]);
}

#[test]
fn a_drive_takes_its_time_to_boot_and_is_deaf_until_then() {
    let slow = PowerUp { boot_time: Duration::from_millis(700), ..PowerUp::default() };
    let mut master = with_second(EmulatedDrive::new(drives()[1].with_power_up(slow)));
    let boot_up = wire::heartbeat_frame(node(2), NmtState::Initialising);
    assert!(!master.received().contains(&boot_up));
    master.send(wire::sdo_request_frame(node(2), &[0x40, 0x00, 0x10, 0, 0, 0, 0, 0]));
    assert_eq!(master.received(), []);
    let heard = master.listen(Duration::from_secs(1));
    assert_eq!(
        heard.iter().map(|(frame, at)| (*frame, at.nanoseconds())).collect::<Vec<_>>(),
        [(boot_up, 700_000_000)]
    );
    master.nmt(NmtCommand::ResetCommunication);
    assert!(!master.received().contains(&boot_up), "a reset takes as long");
    assert_eq!(master.listen(Duration::from_secs(1)).len(), 1);
}

#[test]
fn a_drive_may_start_with_an_emergency_or_in_fault() {
    let past = PowerUp { emergency: Some(0x8140), fault: Some(0x3220), ..PowerUp::default() };
    let mut master = with_second(EmulatedDrive::new(drives()[1].with_power_up(past)));
    assert_eq!(emergencies(&master.received()), [0x8140, 0x3220]);
    assert_eq!(master.link.robot().drive(Joint::TWO).power_state(), PowerState::Fault);
    master.nmt(NmtCommand::ResetNode);
    assert_eq!(emergencies(&master.received()), [0x8140], "the fault was that of the first start");
    assert_eq!(master.link.robot().drive(Joint::TWO).power_state(), PowerState::SwitchOnDisabled);
}

/// The joint stands still: an absolute encoder shows its angle, an incremental one zero since it has power, and what it turned.
#[test]
fn an_incremental_counter_begins_at_zero_with_each_power_up() {
    let incremental = PowerUp { counter: CounterAtPowerUp::Zero, ..PowerUp::default() };
    let drive = drives()[1];
    let shown = |master: &mut Robot| {
        let [.., a, b, c, d] = request(master, [0x40, 0x64, 0x60, 0, 0, 0, 0, 0]);
        i32::from_le_bytes([a, b, c, d])
    };
    let mut master = with_second(EmulatedDrive::new(drive));
    assert_ne!(shown(&mut master), 0);
    let mut master = with_second(EmulatedDrive::new(drive.with_power_up(incremental)));
    assert_eq!(shown(&mut master), 0);
    master.link.inject(Joint::TWO, DriveFault::EncoderJump { counts: -7 });
    assert_eq!(shown(&mut master), -7);
    master.nmt(NmtCommand::ResetCommunication);
    assert_eq!(shown(&mut master), -7, "a reset of the communication keeps it");
    master.nmt(NmtCommand::ResetNode);
    assert_eq!(shown(&mut master), 0);
    master.link.inject(Joint::TWO, DriveFault::EncoderJump { counts: 9 });
    master.link.inject(Joint::TWO, DriveFault::PowerLost);
    master.link.repair(Joint::TWO);
    assert_eq!(shown(&mut master), 0);
}

#[test]
fn a_stored_mapping_is_that_of_the_first_start() {
    let own = DriveDictionary::own(&drives()[1]);
    let stored = [(0x1A00, 0, Value::Unsigned8(1)), (0x1A00, 1, Value::Unsigned32(0x6061_0008))]
        .into_iter()
        .try_fold(own, |own, (index, subindex, value)| own.storing(Address::new(index, subindex), value))
        .unwrap();
    let mut master = with_second(EmulatedDrive::with_dictionary(drives()[1], stored).unwrap());
    master.received();
    master.nmt(NmtCommand::StartRemoteNode);
    master.send(wire::plain_sync_frame());
    let lengths: Vec<_> = master.received().iter().map(|frame| frame.data().len()).collect();
    assert_eq!(lengths, [6, 1, 6]);
}

/// What a maker's dictionary lacks, the drive lacks; what it limits, the drive refuses.
#[test]
fn a_drive_of_a_makers_dictionary_has_that_makers_objects() {
    let absent = [0x1019, 0x1016, 0x608F, 0x6072];
    let own = DriveDictionary::own(&drives()[1]);
    let kept = own.objects().iter().filter(|object| !absent.contains(&object.address.index)).copied();
    let maker = DriveObject {
        address: Address::new(0x2000, 0),
        data_type: DataType::Unsigned16,
        access: canopen_rs::AccessType::Rw,
        mappable: Mappable::No,
        value: Some(Value::Unsigned16(5)),
        low: Some(1),
        high: Some(9),
    };
    let objects = DriveDictionary::of_maker(&drives()[1], kept.chain([maker]));
    let too_many = EmulatedDrive::<10>::with_dictionary(drives()[1], objects.clone()).unwrap_err();
    assert!(matches!(too_many, DictionaryError::TooManyObjects { most: 10, .. }));
    let mut master = with_second(EmulatedDrive::with_dictionary(drives()[1], objects).unwrap());
    master.received();
    for index in absent {
        assert_eq!(master.read(2, index, 0, DataType::Unsigned8), Err(0x0602_0000), "{index:X}");
    }
    assert_eq!(master.read(2, 0x2000, 0, DataType::Unsigned16), Ok(Value::Unsigned16(5)));
    assert_eq!(master.write(2, 0x2000, 0, Value::Unsigned16(10)), Err(0x0609_0031));
    assert_eq!(master.write(2, 0x2000, 0, Value::Unsigned16(0)), Err(0x0609_0032));
    // Without 6072h the drive's own limit holds, and torque is what it was.
    master.write(2, 0x6060, 0, Value::Integer8(10)).unwrap();
    master.nmt(NmtCommand::StartRemoteNode);
    for command in [Command::Shutdown, Command::SwitchOn, Command::EnableOperation] {
        master.command(2, command, 125);
    }
    approx::assert_relative_eq!(master.link.robot().torque().y, 0.025, max_relative = 1e-15);
}
