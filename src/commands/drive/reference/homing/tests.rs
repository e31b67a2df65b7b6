use std::path::Path;
use std::time::Duration;

use super::*;
use crate::emulated_bus::{Bus, bus_of, node};
use crate::reference::verify::verify;
use crate::robot::overrides::Overrides;
use crate::robot::{BUILT_IN, Robot};
use uarm_io::drive::cia402::PowerState;
use uarm_io::drive::wire::Channel;
use uarm_io::drive::{Address, Value};
use uarm_io::frame::Frame;
use uarm_io::link::{FrameDirection, ObservedLink};
use uarm_sim::drive::DriveFault;
use uarm_sim::{Joint, Plant, VirtualClock};

const PLAIN: &str =
    "node = 2\nencoder = { counts_per_revolution = 33739, counter_bits = 32, direction = \"positive\", zero_counts = 0";
/// The index is at 0 degrees; the joint starts at 20. 937 counts per second are 10 degrees per second.
const INDEX: &str = "method = 33, speeds = [2812, 937], acceleration = 20000, angle_deg = 0.0, travel_deg = 40.0";

fn robot(homing: &str) -> JointsOnBus {
    let marker = "power_marker = { index = 0x6081, subindex = 0, type = \"u32\", value = 77 }";
    let keys = format!("{PLAIN}, reference = \"incremental\", {marker}, homing = {{ {homing} }}");
    let text = BUILT_IN.replace(PLAIN, &keys).replace("velocity_deg_per_s = 360.0", "velocity_deg_per_s = 80.0");
    JointsOnBus::of(&Robot::parse(Path::new("robot.toml"), &text, &Overrides::default()).unwrap())
}

/// The robot of its file in virtual time, whose second counter shows 5000 at angle zero.
fn bus() -> (Bus, VirtualClock) {
    let text = BUILT_IN.replace(PLAIN, &PLAIN.replace("zero_counts = 0", "zero_counts = 5000"));
    bus_of(&Robot::parse(Path::new("robot.toml"), &text, &Overrides::default()).unwrap())
}

/// Homes, and returns what came of it, and the bus as it then is.
fn homed(homing: &str, prepare: impl FnOnce(&mut Bus)) -> (anyhow::Result<References>, Bus, VirtualClock) {
    let (mut bus, clock) = bus();
    prepare(&mut bus);
    homed_on(homing, None, bus, clock)
}

fn homed_on<L: Link>(
    homing: &str,
    earlier: Option<References>,
    link: L,
    mut clock: VirtualClock,
) -> (anyhow::Result<References>, L, VirtualClock)
where
    L::Error: Send + Sync + 'static,
{
    let robot = robot(homing);
    let plan = Plan::new(&robot, node()).unwrap();
    let mut network = DriveNetwork::new(link, plan.network_configuration(&robot).unwrap());
    let outcome = plan.reference(&robot, earlier, &mut network, &mut clock, &StopRequest::default());
    (outcome, network.into_link(), clock)
}

fn joint_2(bus: &Bus) -> f64 {
    let position: nalgebra::Vector3<f64> = bus.robot().plant().position();
    position.y.to_degrees()
}

#[track_caller]
fn assert_braked(bus: &Bus) {
    assert_eq!(bus.robot().drive(Joint::TWO).power_state(), PowerState::SwitchOnDisabled);
}

#[test]
fn home_becomes_the_reference_of_its_joint() {
    let switch = "method = 17, speeds = [2812, 937], acceleration = 20000, angle_deg = -170.0, travel_deg = 200.0";
    let here = "method = 37, speeds = [1, 1], angle_deg = 20.0, travel_deg = 1.0";
    let offset =
        "method = 37, speeds = [1, 1], angle_deg = 20.0, travel_deg = 1.0, offset = 300, counts_at_home = -300";
    for (homing, method, counts) in [(INDEX, 33, 0), (switch, 17, 0), (here, 37, 0), (offset, 37, -300)] {
        let (outcome, mut bus, clock) = homed(homing, |_| {});
        let references = outcome.unwrap_or_else(|error| panic!("method {method}: {error:#}"));
        let [reference] = references.joints.as_slice() else { panic!("{references:?}") };
        assert_eq!((reference.node, reference.homing_method, reference.position_counts), (2, Some(method), counts));
        assert_braked(&bus);
        // The angle that the reference gives is the plant's own.
        let robot = robot(homing);
        let shown = show(&mut bus, &clock, node(), &robot.written[1].encoder).unwrap();
        assert_eq!(shown.marker, Some(Value::Unsigned32(77)));
        let angle = verify(&robot.written[1], &robot.joints[1], reference, &shown).unwrap();
        // A count is 0.011 degrees.
        assert!((angle.to_degrees() - joint_2(&bus)).abs() < 0.02, "{} {}", angle.to_degrees(), joint_2(&bus));
    }
}

/// CiA 402-2, homing mode: 6098h the method, 6099h:01 and :02 the speeds, 609Ah the acceleration, 607Ch the offset.
#[test]
fn method_speeds_acceleration_and_offset_are_the_files() {
    let homing = "method = 37, speeds = [2812, 937], acceleration = 20000, angle_deg = 20.0, travel_deg = 1.0, \
                  offset = 300, counts_at_home = -300";
    let (outcome, bus, _) = homed(homing, |_| {});
    outcome.unwrap();
    let drive = bus.robot().drive(Joint::TWO);
    for (index, subindex, expected) in [
        (0x6098, 0, Value::Integer8(37)),
        (0x6099, 1, Value::Unsigned32(2812)),
        (0x6099, 2, Value::Unsigned32(937)),
        (0x609A, 0, Value::Unsigned32(20_000)),
        (0x607C, 0, Value::Integer32(300)),
    ] {
        assert_eq!(drive.object(Address::new(index, subindex)), Some(expected), "{index:X}h:{subindex:02X}");
    }
}

/// From 20 degrees to the index at 0, with 937 counts or 10 degrees per second: 2 s, and what starting and stopping take.
#[test]
fn the_joint_turns_at_the_files_speed() {
    let (bus, clock) = bus();
    let mut homing_cycles = 0;
    let observed = ObservedLink::new(bus, |direction, frame: &Frame, _| {
        let is_command = direction == FrameDirection::Sent && Channel::of(frame.id()) == Some(Channel::Rpdo1(node()));
        if is_command && frame.data()[0] & 0x10 != 0 {
            homing_cycles += 1;
        }
    });
    homed_on(INDEX, None, observed, clock).0.unwrap();
    let took = f64::from(homing_cycles) * 3e-3;
    assert!((2.0..2.5).contains(&took), "{took} s");
}

/// Just so long as the file allows, and not a second longer.
#[test]
fn a_homing_ends_at_the_files_timeout() {
    for (timeout_s, ends) in [(2, true), (3, false)] {
        let (outcome, bus, _) = homed(&format!("{INDEX}, timeout_s = {timeout_s}"), |_| {});
        let message = outcome.as_ref().err().map(|error| format!("{error:#}")).unwrap_or_default();
        assert_eq!(outcome.is_err(), ends, "{timeout_s} s: {message}");
        assert!(!ends || message.contains("not home after 2s"), "{message}");
        assert_braked(&bus);
    }
}

#[test]
fn no_torque_is_asked_for_and_bit_4_rises_once() {
    let (bus, clock) = bus();
    let mut commands = Vec::new();
    let observed = ObservedLink::new(bus, |direction, frame: &Frame, _| {
        if direction == FrameDirection::Sent && Channel::of(frame.id()) == Some(Channel::Rpdo1(node())) {
            commands.push(*frame);
        }
    });
    homed_on(INDEX, None, observed, clock).0.unwrap();
    assert!(commands.iter().all(|frame| frame.data()[2..4] == [0, 0]));
    let starts: Vec<bool> = commands.iter().map(|frame| frame.data()[0] & 0x10 != 0).collect();
    assert_eq!(starts.windows(2).filter(|pair| !pair[0] && pair[1]).count(), 1);
}

#[test]
fn a_drive_that_was_homed_before_homes_again() {
    let (outcome, bus, clock) = homed(INDEX, |_| {});
    // It stands a little behind the index, and comes back over it.
    let back = INDEX.replace("method = 33", "method = 34");
    let again = homed_on(&back, Some(outcome.unwrap()), bus, clock).0.unwrap();
    assert_eq!(again.joints.len(), 1, "it takes the place of the earlier one");
    assert_eq!(again.joints[0].homing_method, Some(34));
}

#[test]
fn whatever_goes_wrong_brakes_and_stores_nothing() {
    let stuck: fn(&mut Bus) = |bus| bus.inject(Joint::TWO, DriveFault::BrakeStuckEngaged);
    let hot: fn(&mut Bus) = |bus| bus.inject(Joint::TWO, DriveFault::OverTemperature);
    let none: fn(&mut Bus) = |_| {};
    let fast = "method = 17, speeds = [90000, 937], angle_deg = -170.0, travel_deg = 200.0".to_owned();
    for (homing, prepare, parts) in [
        (INDEX.to_owned(), stuck, ["homing error", "power off, brake closed"]),
        (INDEX.replace("40.0", "10.0"), none, ["encoder.homing.travel_deg", "power off, brake closed"]),
        (format!("{INDEX}, timeout_s = 1"), none, ["not home after 1s", "power off, brake closed"]),
        (fast, none, ["velocity_deg_per_s", "power off, brake closed"]),
        (INDEX.replace("method = 33", "method = 1"), none, ["6098h:00 (homing method)", "power off, brake closed"]),
        (INDEX.to_owned(), hot, ["4210h", "power off, brake closed"]),
        (INDEX.replace("angle_deg = 0.0", "angle_deg = -170.0"), none, ["nothing was stored", "angle_deg"]),
    ] {
        let (outcome, bus, _) = homed(&homing, prepare);
        let error = format!("{:#}", outcome.unwrap_err());
        for part in parts {
            assert!(error.contains(part), "{error}: expected {part}");
        }
        let state = bus.robot().drive(Joint::TWO).power_state();
        assert!(!state.has_power(), "{error}: {state:?}");
    }
}

#[test]
fn a_request_to_stop_brakes() {
    let robot = robot(INDEX);
    let (bus, mut clock) = bus();
    let stop = StopRequest::default();
    stop.make();
    let plan = Plan::new(&robot, node()).unwrap();
    let mut network = DriveNetwork::new(bus, plan.network_configuration(&robot).unwrap());
    let error = plan.reference(&robot, None, &mut network, &mut clock, &stop).unwrap_err();
    assert!(format!("{error:#}").contains("interrupted"), "{error:#}");
    assert_braked(network.link());
    assert!((joint_2(network.link()) - 20.0).abs() < 0.1);
}

#[test]
fn a_joint_without_homing_or_node_is_named() {
    let built_in = JointsOnBus::of(&Robot::load(None).unwrap());
    let refused = |node| Plan::new(&built_in, NodeId::new(node).unwrap()).err().unwrap().to_string();
    assert!(refused(2).contains("joints[1].encoder.homing (joint 2, node 2) is absent"), "{}", refused(2));
    assert!(refused(9).contains("--node 9: expected one of the robot's nodes, [1, 2, 3]"), "{}", refused(9));
}

#[test]
fn the_longest_homing_is_bounded() {
    let plan = Plan::new(&robot(INDEX), node()).unwrap();
    assert_eq!(plan.watch.timeout, Duration::from_secs(60));
    // 40 of 360 degrees of 33 739 counts.
    assert!((plan.watch.travel - 3_748.8).abs() < 0.1, "{}", plan.watch.travel);
}
