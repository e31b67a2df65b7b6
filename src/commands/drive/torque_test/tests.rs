use super::trial::End;
use super::*;
use crate::commands::drive::enabled::Enabled;
use crate::emulated_bus::{Bus, bus_of};
use crate::robot::Robot;
use uarm_io::drive::cia402::{Command, Controlword, PowerState};
use uarm_io::drive::objects::CONTROLWORD;
use uarm_io::drive::sdo::{Bystander, Patience};
use uarm_io::drive::wire::{self, Channel};
use uarm_io::drive::{NmtCommand, Value};
use uarm_io::frame::Frame;
use uarm_io::link::{FrameDirection, ObservedLink};
use uarm_sim::VirtualClock;
use uarm_sim::drive::DriveFault;

const PATIENCE: Patience = Patience { timeout: Duration::from_millis(100), attempts: 1 };

/// The paper's robot on its bus, where somebody has enabled the other two drives.
fn bus() -> (Robot, Bus, VirtualClock) {
    let robot = Robot::load(None).unwrap();
    let (mut link, clock) = bus_of(&robot);
    let mut somebody = Bystander::new(&mut link, &clock, PATIENCE, |_| {});
    for node in [1, 3].map(|node| NodeId::new(node).unwrap()) {
        somebody.send(&wire::nmt_frame(NmtCommand::StartRemoteNode, node)).unwrap();
        for command in [Command::Shutdown, Command::SwitchOn, Command::EnableOperation] {
            let word = Value::Unsigned16(Controlword::of(command).bits());
            somebody.write(node, CONTROLWORD.address(), word).unwrap();
        }
    }
    (robot, link, clock)
}

/// 3 ms, one degree is 93.7 counts.
fn a_plan(per_mille: i16, window: f64) -> Plan {
    Plan { per_mille, ramp: RAMP, hold: HOLD, period: Duration::from_millis(3), window, speed: 1e6 }
}

fn report(plan: &Plan, stop: &StopRequest, prepare: impl FnOnce(&mut Bus)) -> (anyhow::Result<Report>, Vec<Frame>) {
    let (robot, mut link, mut clock) = bus();
    prepare(&mut link);
    let configuration = robot.description.network_configuration_of(&robot.description.joints[1]).unwrap();
    let mut commands = Vec::new();
    let node = robot.description.joints[1].node;
    let observed = ObservedLink::new(link, |direction, frame: &Frame, _| {
        if direction == FrameDirection::Sent && Channel::of(frame.id()) == Some(Channel::Rpdo1(node)) {
            commands.push(*frame);
        }
    });
    let report = attempt(DriveNetwork::new(observed, configuration), &mut clock, plan, stop);
    (report, commands)
}

/// Controlword and torque of the commands, from their bytes.
fn torques(commands: &[Frame]) -> Vec<i16> {
    commands.iter().map(|frame| i16::from_le_bytes([frame.data()[2], frame.data()[3]])).collect()
}

#[test]
fn a_torque_moves_the_joint_the_way_it_counts() {
    for per_mille in [20, -20] {
        let (report, commands) = report(&a_plan(per_mille, 10_000.0), &StopRequest::default(), |_| {});
        let report = report.unwrap();
        assert!(report.is_good(), "{report:?}");
        assert_eq!((report.trial.end, report.trial.sent_per_mille), (End::Completed, per_mille));
        assert_eq!(report.trial.travelled_counts.signum(), i64::from(per_mille.signum()));
        // Up and down again, never by more than one per mille in a cycle: 20 in 167 cycles.
        let torques = torques(&commands);
        assert!(torques.windows(2).all(|pair| (pair[1] - pair[0]).abs() <= 1), "{torques:?}");
        assert_eq!(torques.iter().map(|torque| torque.abs()).max(), Some(20));
        assert_eq!(torques.last(), Some(&0));
    }
}

#[test]
fn a_joint_that_leaves_its_window_or_is_too_fast_gets_no_torque_any_more() {
    let window = report(&a_plan(100, 94.0), &StopRequest::default(), |_| {}).0.unwrap();
    assert_eq!(window.trial.end, End::LeftWindow);
    assert!(window.braked && window.trial.travelled_counts.abs() < 150, "{window:?}");
    let plan = Plan { speed: 500.0, ..a_plan(100, 1e9) };
    let fast = report(&plan, &StopRequest::default(), |_| {}).0.unwrap();
    assert_eq!(fast.trial.end, End::TooFast);
    assert!(fast.braked);
}

#[test]
fn a_request_to_stop_brakes() {
    let stop = StopRequest::default();
    stop.make();
    let (report, commands) = report(&a_plan(20, 1e9), &stop, |_| {});
    let report = report.unwrap();
    assert_eq!((report.trial.end, report.braked, report.moved), (End::Interrupted, true, false));
    assert!(torques(&commands).iter().all(|torque| *torque == 0));
}

#[test]
fn a_drive_that_fails_in_the_trial_ends_it_and_is_told_to_stop() {
    let broken = |link: &mut Bus| link.inject(uarm_sim::Joint::TWO, DriveFault::BrakeStuckEngaged);
    let stuck = report(&a_plan(20, 10_000.0), &StopRequest::default(), broken).0.unwrap();
    assert!(!stuck.moved && !stuck.is_good() && stuck.text("joint 2", 2).contains("did not move"), "{stuck:?}");
    let hot = |link: &mut Bus| link.inject(uarm_sim::Joint::TWO, DriveFault::OverTemperature);
    let (failed, commands) = report(&a_plan(20, 1e9), &StopRequest::default(), hot);
    assert!(failed.unwrap_err().to_string().contains("ended early"));
    assert!(torques(&commands).iter().all(|torque| *torque == 0));
}

/// Whatever unwinds, the drive is braked.
#[test]
fn who_forgets_to_stop_has_stopped() {
    let (robot, link, mut clock) = bus();
    let configuration = robot.description.network_configuration_of(&robot.description.joints[1]).unwrap();
    let mut network = DriveNetwork::new(link, configuration);
    network.start(&clock).unwrap();
    drop(Enabled::new(&mut network, &mut clock));
    assert_eq!(network.link().robot().drive(uarm_sim::Joint::TWO).power_state(), PowerState::SwitchOnDisabled);
}

#[test]
fn counts_against_the_torque_are_no_success() {
    let trial = Trial { end: End::Completed, sent_per_mille: 20, travelled_counts: -400, seconds: 1.5 };
    let report = Report { trial, braked: true, moved: true };
    assert!(!report.is_good() && report.text("joint 2", 2).contains("AGAINST THE TORQUE"));
}
