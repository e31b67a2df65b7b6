//! The torque of an emulated drive is looked up when something may have changed it: whatever that is, it must be noticed.

mod support;

use embedded_can::StandardId;
use support::{Master, RATED_TORQUE, lockstep};
use uarm_io::drive::cia402::{Command, Controlword};
use uarm_io::drive::wire::{self, DriveCommand};
use uarm_io::drive::{NmtCommand, NodeId, Value};
use uarm_io::frame::Frame;
use uarm_io::time::Instant;
use uarm_sim::{DemPlant, DriveFault, EmulatedRobot, InProcessLink, Joint, Outbox, VirtualClock};

/// Per mille of the rated torque.
const TARGET: i16 = 100;
/// The same in N·m.
const TORQUE: f64 = TARGET as f64 * RATED_TORQUE as f64 * 1e-6;
const JOINT: Joint = Joint::TWO;

type Robot = Master<InProcessLink<EmulatedRobot<DemPlant>, VirtualClock>>;

fn torque(master: &Robot) -> f64 {
    master.link.robot().torque().y
}

/// All drives enabled, joint 2 with `TARGET`.
fn driven() -> Robot {
    let mut master = Master::with_robot(lockstep());
    master.enable();
    master.command(2, Command::EnableOperation, TARGET);
    assert_eq!(torque(&master), TORQUE);
    master
}

#[test]
fn faults_and_their_repair() {
    let with_fault =
        [(DriveFault::TargetIgnored, 0.0), (DriveFault::MotorDisconnected, 0.0), (DriveFault::TorqueReversed, -TORQUE)];
    for (fault, expected) in with_fault {
        let mut master = driven();
        master.link.inject(JOINT, fault);
        assert_eq!(torque(&master), expected, "{fault:?}");
        master.link.repair(JOINT);
        assert_eq!(torque(&master), TORQUE, "{fault:?} repaired");
    }
    let mut master = driven();
    master.link.inject(JOINT, DriveFault::PowerLost);
    assert_eq!(torque(&master), 0.0);
}

#[test]
fn objects_that_are_written() {
    let mut master = driven();
    master.write(2, 0x6072, 0, Value::Unsigned16(50)).unwrap();
    assert_eq!(torque(&master), TORQUE / 2.0);
    master.write(2, 0x6060, 0, Value::Integer8(8)).unwrap_err();
    assert_eq!(torque(&master), TORQUE / 2.0);
    master.write(2, 0x6060, 0, Value::Integer8(0)).unwrap();
    assert_eq!(torque(&master), 0.0);
}

#[test]
fn commands_to_the_network_and_silence() {
    for command in [NmtCommand::ResetNode, NmtCommand::ResetCommunication, NmtCommand::StopRemoteNode] {
        let mut master = driven();
        master.nmt(command);
        assert_eq!(torque(&master), 0.0, "{command:?}");
    }
    let mut master = driven();
    master.heartbeat();
    assert_eq!(torque(&master), TORQUE);
    master.listen(std::time::Duration::from_secs(1));
    assert_eq!(torque(&master), 0.0);
}

/// The identifiers of RPDOs are looked up when they are written.
#[test]
fn a_command_under_another_identifier() {
    const OFF: u32 = 1 << 31;
    const OWN: u32 = 0x202;
    const OTHER: u16 = 0x242;
    let mut master = Master::with_robot(lockstep());
    master.configure();
    master.write(2, 0x1400, 1, Value::Unsigned32(OFF | OWN)).unwrap();
    master.write(2, 0x1400, 1, Value::Unsigned32(OTHER.into())).unwrap();
    master.nmt(NmtCommand::StartRemoteNode);
    let mut send = |command, target_torque| {
        let word = DriveCommand { controlword: Controlword::of(command), target_torque };
        let frame = word.frame(support::node(2));
        master.send(Frame::new(StandardId::new(OTHER).unwrap(), frame.data()).unwrap());
        torque(&master)
    };
    send(Command::Shutdown, 0);
    send(Command::SwitchOn, 0);
    send(Command::EnableOperation, 0);
    assert_eq!(send(Command::EnableOperation, TARGET), TORQUE);
    master.command(2, Command::EnableOperation, 0);
    assert_eq!(torque(&master), TORQUE, "nobody listens to the old one");
    master.nmt(NmtCommand::ResetNode);
    master.enable();
    master.command(2, Command::EnableOperation, TARGET);
    assert_eq!(torque(&master), TORQUE, "the reset has brought it back");
}

#[test]
fn a_command_that_waits_for_sync() {
    let mut master = driven();
    master.write(2, 0x1400, 2, Value::Unsigned8(1)).unwrap();
    master.command(2, Command::EnableOperation, -TARGET);
    assert_eq!(torque(&master), TORQUE);
    master.sync();
    assert_eq!(torque(&master), -TORQUE);
}

#[test]
fn a_supply_that_comes_back() {
    let mut outbox = Outbox::new();
    let now = Instant::default();
    let mut robot = support::robot(lockstep());
    robot.power_on(now, &mut outbox);
    let mode = wire::sdo_request_frame(support::node(2), &[0x2F, 0x60, 0x60, 0, 10, 0, 0, 0]);
    robot.on_frame(&mode, now, &mut outbox);
    robot.on_frame(&wire::nmt_frame(NmtCommand::StartRemoteNode, NodeId::BROADCAST), now, &mut outbox);
    for command in [Command::Shutdown, Command::SwitchOn, Command::EnableOperation, Command::EnableOperation] {
        let command = DriveCommand { controlword: Controlword::of(command), target_torque: TARGET };
        robot.on_frame(&command.frame(support::node(2)), now, &mut outbox);
    }
    assert_eq!(robot.torque().y, TORQUE);
    robot.power_on(now, &mut outbox);
    assert_eq!(robot.torque().y, 0.0);
}
