//! Homing by the drive itself, as CiA 402-2 has it: where home is, which bits say so, and what makes it fail. Expected counts are
//! worked out from angles: 33 739 counts are a revolution of the joint, of which 20 degrees are 1874.4.

mod support;

use std::time::Duration;
use support::{Master, PERIOD, drives_mounted, lockstep, node};
use uarm_io::drive::cia402::{Command, Controlword, HomingState, PowerState};
use uarm_io::drive::wire::{self, DriveCommand};
use uarm_io::drive::{DataType, NmtCommand, Value};
use uarm_io::encoder::Direction;
use uarm_sim::drive::DriveFault;
use uarm_sim::{DemPlant, EmulatedDrive, EmulatedRobot, InProcessLink, Joint, Pacing, VirtualClock};

type Robot = Master<InProcessLink<EmulatedRobot<DemPlant>, VirtualClock>>;

/// Limit switches of joint 2, degrees: it starts at 20.
const SWITCHES: [f64; 2] = [-10.0, 50.0];
/// Index and edge are looked for at 10 degrees per second, the switch at 30: in counts per second.
const SLOW: u32 = 937;
const FAST: u32 = 2_812;

/// A robot whose second drive is enabled in homing mode, with this method; nothing else is.
fn enabled(method: i8, direction: Direction) -> Robot {
    let parameters = drives_mounted([Direction::Positive, direction, Direction::Positive]);
    let switches = SWITCHES.map(f64::to_radians);
    let all = parameters.map(|drive| EmulatedDrive::new(drive.with_limit_switches(switches)));
    let plant = DemPlant::new(dem_model::ThreeLinkDem::table_2());
    let clock = VirtualClock::new();
    let link = InProcessLink::new(EmulatedRobot::with_drives(plant, all, lockstep()).unwrap(), clock.clone());
    let mut master = Master::on(link, clock);
    master.received();
    master.configure();
    for (index, subindex, value) in [
        (0x6060, 0, Value::Integer8(6)),
        (0x6098, 0, Value::Integer8(method)),
        (0x6099, 1, Value::Unsigned32(FAST)),
        (0x6099, 2, Value::Unsigned32(SLOW)),
        (0x609A, 0, Value::Unsigned32(20_000)),
    ] {
        master.write(2, index, subindex, value).unwrap();
    }
    master.nmt(NmtCommand::StartRemoteNode);
    for command in [Command::Shutdown, Command::SwitchOn, Command::EnableOperation] {
        master.command(2, command, 0);
    }
    master
}

/// One cycle with this controlword; the state of the procedure, and 6064h.
fn cycle(master: &mut Robot, word: Controlword) -> (HomingState, i32) {
    master.heartbeat();
    let feedback = master.sync();
    let (_, status, position) = feedback.into_iter().find(|(node, _, _)| *node == 2).unwrap();
    master.send(DriveCommand { controlword: word, target_torque: 0 }.frame(node(2)));
    master.wait(PERIOD);
    (status.homing(), position)
}

fn waiting() -> Controlword {
    Controlword::of(Command::EnableOperation)
}

fn started() -> Controlword {
    waiting().with(Controlword::HOMING_START)
}

/// Cycles until the state is one of an end, or `most` have passed.
fn run(master: &mut Robot, most: Duration) -> (HomingState, i32) {
    let mut last = cycle(master, started());
    for _ in 0..most.as_millis() / PERIOD.as_millis() {
        last = cycle(master, started());
        if matches!(last.0, HomingState::Done | HomingState::Failed) {
            break;
        }
    }
    last
}

fn joint_2(master: &Robot) -> f64 {
    master.position().y.to_degrees()
}

/// 6064h, which is read where the joint stands, is the way from home there.
#[track_caller]
fn assert_home(master: &Robot, position: i32, home: f64, sign: f64) {
    let expected = sign * (joint_2(master) - home) / 360.0 * 33_739.0;
    assert!((f64::from(position) - expected).abs() < 1.0, "{position} counts, expected {expected:.1}");
}

#[test]
fn nothing_starts_before_bit_4_rises_and_it_is_told_so() {
    let mut master = enabled(33, Direction::Positive);
    for _ in 0..20 {
        let (state, position) = cycle(&mut master, waiting());
        assert_eq!(state, HomingState::Idle);
        assert!((position - 1_874).abs() <= 1, "{position}");
    }
    cycle(&mut master, started());
    assert_eq!(cycle(&mut master, started()).0, HomingState::Running);
    // Bit 4 falls: interrupted.
    cycle(&mut master, waiting());
    assert_eq!(cycle(&mut master, waiting()).0, HomingState::Idle);
}

#[test]
fn the_present_position_becomes_home_at_once() {
    for method in [35, 37] {
        let mut master = enabled(method, Direction::Positive);
        master.write(2, 0x607C, 0, Value::Integer32(500)).unwrap();
        let (state, position) = run(&mut master, Duration::from_millis(60));
        // The zero position is home plus the offset: home is at minus the offset.
        assert_eq!((state, position), (HomingState::Done, -500), "method {method}");
        assert!((joint_2(&master) - 20.0).abs() < 0.1);
    }
}

#[test]
fn the_index_is_found_in_both_directions_and_on_a_mirrored_drive() {
    // The index is where a revolution begins: at 0 and 360 degrees of the joint.
    for (method, direction, home, sign) in [(33, Direction::Positive, 0.0, 1.0), (34, Direction::Negative, 0.0, -1.0)] {
        let mut master = enabled(method, direction);
        let (state, position) = run(&mut master, Duration::from_secs(5));
        assert_eq!(state, HomingState::Done, "method {method}");
        assert_home(&master, position, home, sign);
        assert!(joint_2(&master).abs() < 2.0, "it stops where it found it: {}", joint_2(&master));
    }
}

#[test]
fn the_edge_of_a_limit_switch_is_found_on_either_side() {
    for (method, direction, home, sign) in [
        (17, Direction::Positive, SWITCHES[0], 1.0),
        (18, Direction::Positive, SWITCHES[1], 1.0),
        (17, Direction::Negative, SWITCHES[1], -1.0),
    ] {
        let mut master = enabled(method, direction);
        let mut fastest = 0.0_f64;
        let (mut before, mut on_switch) = (joint_2(&master), false);
        let mut last = cycle(&mut master, started());
        while !matches!(last.0, HomingState::Done | HomingState::Failed) {
            last = cycle(&mut master, started());
            fastest = fastest.max((joint_2(&master) - before).abs() / PERIOD.as_secs_f64());
            before = joint_2(&master);
            let inputs = master.read(2, 0x60FD, 0, DataType::Unsigned32).unwrap();
            on_switch |= inputs == Value::Unsigned32(if method == 17 { 1 } else { 2 });
        }
        assert_eq!(last.0, HomingState::Done, "method {method}");
        assert!(on_switch, "60FDh shows the switch");
        assert_home(&master, last.1, home, sign);
        // 30 degrees per second were asked for; the loop overshoots.
        assert!((25.0..45.0).contains(&fastest), "{fastest}");
    }
}

#[test]
fn a_joint_that_cannot_move_is_a_homing_error() {
    let mut master = enabled(33, Direction::Positive);
    master.link.inject(Joint::TWO, DriveFault::BrakeStuckEngaged);
    let (state, _) = run(&mut master, Duration::from_secs(2));
    assert_eq!(state, HomingState::Failed);
}

#[test]
fn a_drive_that_was_homed_says_so_until_it_homes_again_or_boots_anew() {
    let mut master = enabled(33, Direction::Positive);
    assert_eq!(run(&mut master, Duration::from_secs(5)).0, HomingState::Done);
    assert_eq!(cycle(&mut master, waiting()).0, HomingState::Done, "bit 12 stays when bit 4 falls");
    cycle(&mut master, started());
    assert_eq!(cycle(&mut master, started()).0, HomingState::Running);
    master.send(wire::nmt_frame(NmtCommand::ResetNode, node(2)));
    assert_eq!(master.link.robot().drive(Joint::TWO).power_state(), PowerState::SwitchOnDisabled);
}

#[test]
fn a_method_that_it_does_not_know_is_refused() {
    let mut master = Master::with_robot(Pacing::WallClock);
    assert_eq!(master.write(2, 0x6098, 0, Value::Integer8(1)), Err(0x0609_0030));
}

#[test]
fn the_motor_is_off_in_homing_mode_as_soon_as_the_drive_is() {
    let mut master = enabled(33, Direction::Positive);
    for _ in 0..100 {
        cycle(&mut master, started());
    }
    assert!(master.link.robot().torque().y != 0.0);
    master.command(2, Command::DisableVoltage, 0);
    assert_eq!(master.link.robot().torque().y, 0.0);
}
