//! The emulated drives as a master meets them: boot, configuration, states, torque, brakes, silence, faults.

mod support;

use nalgebra::Vector3;
use std::time::Duration;
use support::{Master, PATIENCE, PERIOD, RATED_TORQUE, drives, drives_mounted, lockstep, node, robot};
use uarm_io::drive::cia402::{Command, PowerState, Statusword};
use uarm_io::drive::wire::{self, Channel};
use uarm_io::drive::{DataType, NmtCommand, NmtState, NodeId, Value};
use uarm_io::encoder::Direction;
use uarm_io::link::Link;
use uarm_io::time::{Clock, Instant};
use uarm_sim::{
    Brake, DemPlant, DriveFault, EmulatedRobot, InProcessLink, Joint, Pacing, Plant, RobotError, VirtualClock,
};

fn states(master: &Master<InProcessLink<EmulatedRobot<DemPlant>, VirtualClock>>) -> [PowerState; 3] {
    Joint::ALL.map(|joint| master.link.robot().drive(joint).power_state())
}

/// The emergency codes among frames, with their nodes.
fn emergencies(frames: &[(uarm_io::frame::Frame, Instant)]) -> Vec<(u8, u16)> {
    let code = |frame: &uarm_io::frame::Frame| match Channel::of(frame.id()) {
        Some(Channel::Emergency(node)) => Some((node.raw(), wire::decode_emergency(frame.data()).error_code)),
        _ => None,
    };
    frames.iter().filter_map(|(frame, _)| code(frame)).collect()
}

#[test]
fn the_drives_boot_when_they_are_switched_on() {
    let clock = VirtualClock::new();
    let mut master = Master::on(InProcessLink::new(robot(lockstep()), clock.clone()), clock);
    let boot_ups = [1, 2, 3].map(|id| wire::heartbeat_frame(node(id), NmtState::Initialising));
    assert_eq!(master.received(), boot_ups);
    assert_eq!(master.link.robot().drive(Joint::ONE).nmt_state(), NmtState::PreOperational);
    assert_eq!(states(&master), [PowerState::SwitchOnDisabled; 3]);
}

#[test]
fn objects_are_read_and_written_by_sdo() {
    let mut master = Master::with_robot(lockstep());
    assert_eq!(master.read(2, 0x608F, 1, DataType::Unsigned32), Ok(Value::Unsigned32(33_739)));
    assert_eq!(master.read(2, 0x6076, 0, DataType::Unsigned32), Ok(Value::Unsigned32(RATED_TORQUE)));
    // 20° in counts.
    let counts = (20.0 / 360.0 * 33_739.0_f64).round() as i32;
    assert_eq!(master.read(3, 0x6064, 0, DataType::Integer32), Ok(Value::Integer32(counts)));
    let Ok(Value::VisibleString(name)) = master.read(1, 0x1008, 0, DataType::VisibleString) else { panic!() };
    assert_eq!(name.as_str(), Some("UARM emulated drive"), "19 bytes: a segmented transfer");
    assert_eq!(master.write(1, 0x6064, 0, Value::Integer32(0)), Err(0x0601_0002), "read only");
    assert_eq!(master.write(1, 0x6060, 0, Value::Integer8(8)), Err(0x0609_0030), "mode out of range");
    assert_eq!(master.read(1, 0x6084, 0, DataType::Unsigned32), Err(0x0602_0000), "no such object");
}

#[test]
fn brakes_open_in_operation_enabled_only() {
    let mut master = Master::with_robot(lockstep());
    master.configure();
    master.nmt(NmtCommand::StartRemoteNode);
    for (command, state, brake) in [
        (Command::Shutdown, PowerState::ReadyToSwitchOn, Brake::Engaged),
        (Command::SwitchOn, PowerState::SwitchedOn, Brake::Engaged),
        (Command::EnableOperation, PowerState::OperationEnabled, Brake::Released),
        (Command::QuickStop, PowerState::QuickStopActive, Brake::Engaged),
        (Command::DisableVoltage, PowerState::SwitchOnDisabled, Brake::Engaged),
    ] {
        master.command(2, command, 0);
        let status = master.sync().into_iter().find(|(id, ..)| *id == 2).unwrap().1;
        assert_eq!(status.state(), Some(state));
        assert!(status.contains(Statusword::REMOTE));
        assert_eq!(master.link.robot().brakes(), [Brake::Engaged, brake, Brake::Engaged]);
        let output = u32::from(brake == Brake::Engaged);
        assert_eq!(master.read(2, 0x60FE, 1, DataType::Unsigned32), Ok(Value::Unsigned32(output)));
    }
}

#[test]
fn torque_is_per_mille_of_the_rated_torque_and_limited() {
    let mut master = Master::with_robot(lockstep());
    master.write(3, 0x6072, 0, Value::Unsigned16(300)).unwrap();
    master.enable();
    master.command(2, Command::EnableOperation, -125);
    master.command(3, Command::EnableOperation, 301);
    let torque = master.link.robot().torque();
    approx::assert_relative_eq!(torque, Vector3::new(0.0, -0.025, 0.06), max_relative = 1e-15);
    let status: Vec<_> = master.sync().into_iter().map(|(_, status, _)| status).collect();
    assert!(!status[1].contains(Statusword::INTERNAL_LIMIT_ACTIVE));
    assert!(status[2].contains(Statusword::INTERNAL_LIMIT_ACTIVE));
    assert!(status[2].contains(Statusword::FOLLOWS_TARGET));
    assert_eq!(master.read(3, 0x6077, 0, DataType::Integer16), Ok(Value::Integer16(300)));
    // Once out of operation the old target is gone.
    master.command(2, Command::SwitchOn, -125);
    assert_eq!(master.link.robot().torque().y, 0.0);
    assert_eq!(master.read(2, 0x6071, 0, DataType::Integer16), Ok(Value::Integer16(0)));
}

/// A drive mounted in the negative direction is mirrored as a whole: counts and torque, but not what it says of itself.
#[test]
fn a_mirrored_drive_mirrors_counts_and_torque() {
    let directions = [Direction::Positive, Direction::Negative, Direction::Positive];
    let plant = DemPlant::new(dem_model::ThreeLinkDem::table_2());
    let robot = EmulatedRobot::new(plant, drives_mounted(directions), lockstep()).unwrap();
    let clock = VirtualClock::new();
    let mut master = Master::on(InProcessLink::new(robot, clock.clone()), clock);
    master.received();
    master.enable();
    // Both driven joints start at 20°, which are 1874 counts of 33739 in a revolution.
    let start = master.sync();
    assert_eq!([start[1].2, start[2].2], [-1_874, 1_874]);
    // 125 per mille of 200 mN·m.
    master.command(2, Command::EnableOperation, 125);
    master.command(3, Command::EnableOperation, 125);
    let torque = master.link.robot().torque();
    approx::assert_relative_eq!(torque, Vector3::new(0.0, -0.025, 0.025), max_relative = 1e-15);
    assert_eq!(master.read(2, 0x6077, 0, DataType::Integer16), Ok(Value::Integer16(125)));
    for _ in 0..30 {
        master.cycle([125, 0]);
    }
    assert!(master.position().y < 20.0_f64.to_radians(), "joint 2 turns in the negative direction");
    assert!(master.sync()[1].2 > -1_874, "and its counter rises, as a positive torque makes it do");
}

#[test]
fn without_the_torque_mode_there_is_no_torque() {
    let mut master = Master::with_robot(lockstep());
    master.enable();
    master.write(2, 0x6060, 0, Value::Integer8(0)).unwrap();
    master.command(2, Command::EnableOperation, 100);
    assert_eq!(master.link.robot().torque(), Vector3::zeros());
}

/// In lockstep the plant is a function of the SYNCs, and held torques act from one to the next.
#[test]
fn lockstep_moves_one_period_per_sync() {
    let mut master = Master::with_robot(lockstep());
    master.enable();
    let start = master.position();
    let first = master.cycle([100, 50]);
    assert_eq!(master.position(), start, "the first SYNC is plant time zero");
    assert_eq!(first.len(), 3);
    let mut reference = DemPlant::new(dem_model::ThreeLinkDem::table_2());
    for k in 1..=400_u32 {
        let torque = [100, 50].map(|torque| f64::from(torque) * f64::from(RATED_TORQUE) / 1e6);
        reference.advance(PERIOD * k, &Vector3::new(0.0, torque[0], torque[1]), [Brake::Released; 3]);
        let feedback = master.cycle([100, 50]);
        assert_eq!(master.position(), reference.position(), "bit for bit");
        let counts = (reference.position().z / std::f64::consts::TAU * 33_739.0 + 0.5).floor() as i32;
        assert_eq!(feedback[2].2, counts);
    }
    assert_eq!(master.link.robot().plant().time(), PERIOD * 400);
}

#[test]
fn nothing_moves_before_a_drive_is_enabled_and_then_only_its_joint() {
    let mut master = Master::with_robot(lockstep());
    master.enable();
    (1..=3).for_each(|node| master.command(node, Command::SwitchOn, 0));
    let start = master.position();
    for _ in 0..10 {
        master.sync();
        master.wait(PERIOD);
    }
    assert_eq!(master.position(), start);
    assert_eq!(master.link.robot().plant().time(), Duration::ZERO);
    for _ in 0..11 {
        master.command(2, Command::EnableOperation, 500);
        master.heartbeat();
        master.sync();
        master.wait(PERIOD);
    }
    assert_eq!(master.link.robot().plant().time(), PERIOD * 10, "the first SYNC is plant time zero");
    assert!(master.position().y > start.y);
    assert_eq!((master.position().x, master.position().z), (start.x, start.z), "brakes hold the others");
}

#[test]
fn on_the_wall_clock_the_plant_follows_time() {
    let mut master = Master::with_robot(Pacing::WallClock);
    master.enable();
    master.wait(Duration::from_millis(50));
    master.sync();
    assert_eq!(master.link.robot().plant().time(), Duration::ZERO, "the first SYNC is plant time zero");
    master.command(2, Command::EnableOperation, 200);
    master.wait(Duration::from_micros(2_345));
    master.sync();
    assert_eq!(master.link.robot().plant().time(), Duration::from_micros(2_345));
    assert!(master.position().y > 20.0_f64.to_radians());
}

#[test]
fn heartbeats_come_in_their_period() {
    let mut master = Master::with_robot(lockstep());
    master.write(2, 0x1017, 0, Value::Unsigned16(10)).unwrap();
    let start = master.clock.now();
    let beats = master.listen(Duration::from_millis(35));
    let expected = [10, 20, 30]
        .map(|ms| (wire::heartbeat_frame(node(2), NmtState::PreOperational), start + Duration::from_millis(ms)));
    assert_eq!(beats, expected);
}

/// The last line of defence: a drive that no longer hears its master brakes by itself.
#[test]
fn a_silent_master_means_brakes_within_the_heartbeat_time() {
    let mut master = Master::with_robot(lockstep());
    master.enable();
    for _ in 0..100 {
        master.cycle([50, 20]);
    }
    let last_heartbeat = master.clock.now() - PERIOD;
    let before = master.listen(Duration::from_millis(u64::from(PATIENCE)) - PERIOD - Duration::from_nanos(1));
    assert_eq!(before, []);
    assert_eq!(master.link.robot().brakes(), [Brake::Released; 3]);
    let after = master.listen(Duration::from_millis(1));
    assert_eq!(emergencies(&after), [(1, 0x8130), (2, 0x8130), (3, 0x8130)]);
    assert!(after.iter().all(|(_, at)| *at == last_heartbeat + Duration::from_millis(PATIENCE.into())));
    assert_eq!(master.link.robot().brakes(), [Brake::Engaged; 3]);
    assert_eq!(master.link.robot().torque(), Vector3::zeros());
    assert_eq!(states(&master), [PowerState::Fault; 3]);
    assert_eq!(master.link.robot().drive(Joint::TWO).nmt_state(), NmtState::PreOperational);

    // It recovers only when told to.
    master.heartbeat();
    master.nmt(NmtCommand::StartRemoteNode);
    master.command(2, Command::EnableOperation, 0);
    assert_eq!(states(&master)[1], PowerState::Fault);
    master.command(2, Command::FaultReset, 0);
    assert_eq!(states(&master)[1], PowerState::SwitchOnDisabled);
    let reset = master.listen(Duration::from_millis(1));
    assert_eq!(emergencies(&reset), [(2, 0)]);
}

#[test]
fn a_master_that_stops_commanding_is_noticed_too() {
    let mut master = Master::with_robot(lockstep());
    master.write(2, 0x1400, 5, Value::Unsigned16(20)).unwrap();
    master.enable();
    for _ in 0..10 {
        master.cycle([0, 0]);
    }
    let mut seen = Vec::new();
    for _ in 0..10 {
        master.heartbeat();
        seen.extend(master.listen(PERIOD));
    }
    assert_eq!(emergencies(&seen), [(2, 0x8250)]);
    assert_eq!(master.link.robot().brakes(), [Brake::Released, Brake::Engaged, Brake::Released]);
}

/// So the master can try this watchdog with brakes closed.
#[test]
fn a_master_that_stops_commanding_is_noticed_at_switched_on() {
    let mut master = Master::with_robot(lockstep());
    master.write(2, 0x1400, 5, Value::Unsigned16(20)).unwrap();
    master.nmt(NmtCommand::StartRemoteNode);
    master.command(2, Command::Shutdown, 0);
    assert_eq!(emergencies(&master.listen(Duration::from_millis(50))), [], "without power there is nothing to watch");
    master.command(2, Command::SwitchOn, 0);
    assert_eq!(states(&master)[1], PowerState::SwitchedOn);
    assert_eq!(emergencies(&master.listen(Duration::from_millis(19))), []);
    assert_eq!(emergencies(&master.listen(Duration::from_millis(2))), [(2, 0x8250)]);
    assert_eq!(states(&master)[1], PowerState::Fault);
}

#[test]
fn leaving_nmt_operational_closes_the_brakes() {
    for command in [NmtCommand::StopRemoteNode, NmtCommand::EnterPreOperational, NmtCommand::ResetCommunication] {
        let mut master = Master::with_robot(lockstep());
        master.enable();
        master.cycle([50, 20]);
        assert_eq!(master.link.robot().brakes(), [Brake::Released; 3]);
        master.nmt(command);
        assert_eq!(master.link.robot().brakes(), [Brake::Engaged; 3]);
        assert_eq!(states(&master), [PowerState::SwitchOnDisabled; 3]);
    }
}

#[test]
fn a_reset_of_all_drives_carries_the_robot_back() {
    let mut master = Master::with_robot(lockstep());
    let start = master.position();
    master.enable();
    for _ in 0..50 {
        master.cycle([50, 20]);
    }
    assert_ne!(master.position(), start);
    master.send(wire::nmt_frame(NmtCommand::ResetCommunication, node(2)));
    assert_ne!(master.position(), start, "one drive alone does not move the robot");
    master.nmt(NmtCommand::ResetNode);
    assert_eq!(master.position(), start);
    assert_eq!(master.link.robot().plant().time(), Duration::ZERO);
}

#[test]
fn a_reset_of_the_communication_keeps_the_application() {
    let mut master = Master::with_robot(lockstep());
    master.write(2, 0x6072, 0, Value::Unsigned16(400)).unwrap();
    master.write(2, 0x1017, 0, Value::Unsigned16(10)).unwrap();
    master.nmt(NmtCommand::ResetCommunication);
    master.received();
    assert_eq!(master.read(2, 0x6072, 0, DataType::Unsigned16), Ok(Value::Unsigned16(400)));
    assert_eq!(master.read(2, 0x1017, 0, DataType::Unsigned16), Ok(Value::Unsigned16(0)));
    master.nmt(NmtCommand::ResetNode);
    master.received();
    assert_eq!(master.read(2, 0x6072, 0, DataType::Unsigned16), Ok(Value::Unsigned16(1_000)));
}

#[test]
fn torque_can_be_mapped_into_the_feedback() {
    let mut master = Master::with_robot(lockstep());
    for (index, subindex, value) in [
        (0x1800, 1, Value::Unsigned32(0x8000_0182)),
        (0x1A00, 0, Value::Unsigned8(0)),
        (0x1A00, 3, Value::Unsigned32(0x6077_0010)),
        (0x1A00, 0, Value::Unsigned8(3)),
        (0x1800, 1, Value::Unsigned32(0x182)),
    ] {
        master.write(2, index, subindex, value).unwrap();
    }
    master.enable();
    master.command(2, Command::EnableOperation, -77);
    master.send(wire::sync_frame(1));
    let frames = master.received();
    let own = frames.iter().find(|frame| frame.id() == Channel::Tpdo1(node(2)).identifier()).unwrap();
    assert_eq!(own.data().len(), 8);
    assert_eq!(own.data()[6..], (-77_i16).to_le_bytes());
}

#[test]
fn a_synchronous_rpdo_acts_at_the_next_sync() {
    let mut master = Master::with_robot(lockstep());
    master.enable();
    master.write(2, 0x1400, 2, Value::Unsigned8(1)).unwrap();
    master.command(2, Command::SwitchOn, 0);
    assert_eq!(states(&master)[1], PowerState::OperationEnabled);
    master.sync();
    assert_eq!(states(&master)[1], PowerState::SwitchedOn);
}

#[test]
fn a_short_rpdo_is_reported_and_does_nothing() {
    let mut master = Master::with_robot(lockstep());
    master.enable();
    let short = uarm_io::frame::Frame::new(Channel::Rpdo1(node(2)).identifier(), &[0, 0]).unwrap();
    master.send(short);
    assert_eq!(states(&master), [PowerState::OperationEnabled; 3]);
    assert_eq!(emergencies(&master.listen(Duration::from_millis(1))), [(2, 0x8210)]);
}

#[test]
fn faults_of_the_power_stage() {
    let mut master = Master::with_robot(lockstep());
    master.enable();
    master.link.inject(Joint::TWO, DriveFault::OverTemperature);
    let seen = master.listen(Duration::from_millis(1));
    assert_eq!(emergencies(&seen), [(2, 0x4210)]);
    assert_eq!(states(&master)[1], PowerState::Fault);
    assert_eq!(master.read(2, 0x603F, 0, DataType::Unsigned16), Ok(Value::Unsigned16(0x4210)));
    assert_eq!(master.read(2, 0x1001, 0, DataType::Unsigned8), Ok(Value::Unsigned8(0b1001)));
    master.command(2, Command::FaultReset, 0);
    assert_eq!(states(&master)[1], PowerState::Fault, "still hot");
    master.link.repair(Joint::TWO);
    master.command(2, Command::DisableVoltage, 0);
    master.command(2, Command::FaultReset, 0);
    assert_eq!(states(&master)[1], PowerState::SwitchOnDisabled);
}

#[test]
fn a_drive_without_supply_is_silent_and_braked() {
    let mut master = Master::with_robot(lockstep());
    master.write(2, 0x1017, 0, Value::Unsigned16(10)).unwrap();
    master.enable();
    master.cycle([0, 0]);
    master.link.inject(Joint::TWO, DriveFault::PowerLost);
    let answering: Vec<_> = master.sync().into_iter().map(|(id, ..)| id).collect();
    assert_eq!(answering, [1, 3]);
    assert_eq!(master.link.robot().brakes()[1], Brake::Engaged);
    assert_eq!(master.listen(Duration::from_millis(30)), []);
    master.link.repair(Joint::TWO);
    assert_eq!(master.received(), [wire::heartbeat_frame(node(2), NmtState::Initialising)]);
}

#[test]
fn a_drive_off_the_bus_brakes_by_itself() {
    let mut master = Master::with_robot(lockstep());
    master.enable();
    master.cycle([0, 0]);
    master.link.inject(Joint::THREE, DriveFault::BusDisconnected);
    for _ in 0..(u32::from(PATIENCE) / 3 + 1) {
        master.cycle([10, 10]);
    }
    assert_eq!(master.link.robot().brakes(), [Brake::Released, Brake::Released, Brake::Engaged]);
}

#[test]
fn faults_of_encoder_brake_and_motor() {
    let mut master = Master::with_robot(lockstep());
    master.enable();
    let before = master.cycle([0, 0])[1].2;
    master.link.inject(Joint::TWO, DriveFault::EncoderJump { counts: -5_000 });
    assert_eq!(master.cycle([0, 0])[1].2, before - 5_000);

    master.link.inject(Joint::THREE, DriveFault::EncoderStuck);
    master.link.inject(Joint::TWO, DriveFault::MotorDisconnected);
    assert_eq!(master.link.robot().torque().y, 0.0);
    let stuck = master.cycle([300, 300])[2].2;
    for _ in 0..50 {
        assert_eq!(master.cycle([300, 300])[2].2, stuck);
    }
    assert_ne!(master.position().z, 20.0_f64.to_radians());

    master.link.inject(Joint::ONE, DriveFault::BrakeStuckEngaged);
    assert_eq!(master.link.robot().brakes()[0], Brake::Engaged);
    master.link.inject(Joint::TWO, DriveFault::BrakeStuckReleased);
    master.nmt(NmtCommand::StopRemoteNode);
    assert_eq!(master.link.robot().brakes(), [Brake::Engaged, Brake::Released, Brake::Engaged]);
}

#[test]
fn what_nobody_receives_is_lost_and_counted() {
    let mut master = Master::with_robot(lockstep());
    master.write(1, 0x1017, 0, Value::Unsigned16(1)).unwrap();
    master.wait(Duration::from_millis(300));
    let error = master.link.receive(master.clock.now()).unwrap_err();
    assert_eq!(error, uarm_sim::InProcessError::FramesLost { lost: 300 - uarm_sim::OUTBOX_CAPACITY as u64 });
    assert_eq!(master.received().len(), uarm_sim::OUTBOX_CAPACITY, "the error is told once");
}

#[test]
fn a_robot_that_cannot_be_is_refused() {
    let plant = || DemPlant::new(dem_model::ThreeLinkDem::table_2());
    let [first, second, _] = drives();
    let twice = EmulatedRobot::new(plant(), [first, second, first], lockstep());
    assert_eq!(twice.unwrap_err(), RobotError::NodeTwice { node: 1 });
    let still = EmulatedRobot::new(plant(), drives(), Pacing::Lockstep { period: Duration::ZERO });
    assert_eq!(still.unwrap_err(), RobotError::Period { found: Duration::ZERO });
}

/// Any frame at all, in any state: the drives neither panic nor open a brake that was not asked for.
#[test]
fn garbage_does_no_harm() {
    use proptest::prelude::*;
    let frames = prop::collection::vec((0_u16..0x800, prop::collection::vec(any::<u8>(), 0..=8)), 1..200);
    proptest!(ProptestConfig::with_cases(64), |(frames in frames)| {
        let mut master = Master::with_robot(Pacing::WallClock);
        for (id, data) in frames {
            let id = embedded_can::StandardId::new(id).unwrap();
            // The state machines' own channels are left out: with them, opening a brake may well be asked for.
            if matches!(Channel::of(id), Some(Channel::Rpdo1(_) | Channel::SdoRequest(_))) {
                continue;
            }
            master.send(uarm_io::frame::Frame::new(id, &data).unwrap());
            master.wait(Duration::from_micros(100));
        }
        prop_assert_eq!(master.link.robot().brakes(), [Brake::Engaged; 3]);
    });
    let all = prop::collection::vec((0_u16..0x800, prop::collection::vec(any::<u8>(), 0..=8)), 1..200);
    proptest!(ProptestConfig::with_cases(64), |(frames in all)| {
        let mut master = Master::with_robot(lockstep());
        master.nmt(NmtCommand::StartRemoteNode);
        for (id, data) in frames {
            let id = embedded_can::StandardId::new(id % 0x100 + [0x000, 0x100, 0x200, 0x600][usize::from(id / 0x200)]);
            master.send(uarm_io::frame::Frame::new(id.unwrap(), &data).unwrap());
        }
        prop_assert!(master.position().iter().all(|angle| angle.is_finite()));
    });
}

/// NMT for one node is for that node only.
#[test]
fn commands_are_for_their_addressee() {
    let mut master = Master::with_robot(lockstep());
    master.send(wire::nmt_frame(NmtCommand::StartRemoteNode, node(3)));
    let nmt = Joint::ALL.map(|joint| master.link.robot().drive(joint).nmt_state());
    assert_eq!(nmt, [NmtState::PreOperational, NmtState::PreOperational, NmtState::Operational]);
    assert!(NodeId::new(0).is_err());
}
