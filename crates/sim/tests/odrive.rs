//! The ODrive master and emulated ODrive axes, in virtual time.

use std::time::Duration;

use dem_model::ThreeLinkDem;
use uarm_io::drive::RobotDrives;
use uarm_io::drive::odrive::axis_error::AxisError;
use uarm_io::drive::odrive::wire::{AxisNode, AxisState};
use uarm_io::drive::odrive::{
    OdriveAxis, OdriveConfiguration, OdriveCycleError, OdriveNetwork, OdriveStartError, OdriveTimes, Positions,
};
use uarm_io::drive::readings::{Quantity, ReadingLimits};
use uarm_io::encoder::{CountsPerRevolution, Direction};
use uarm_io::time::Clock;
use uarm_io::torque::RatedTorque;
use uarm_sim::drive::EncoderDescription;
use uarm_sim::odrive::{AxisDescription, AxisFault, AxisParameters, EmulatedOdrives, OdriveRobotError};
use uarm_sim::{Brake, DemPlant, InProcessLink, Joint, Pacing, Plant, VirtualClock};

const PERIOD: Duration = Duration::from_millis(3);
const COUNTS: u32 = 33_739;
/// Where the plant begins: 0, 20 and 20 degrees, 1874.4 counts each, and the zero offsets.
const START: [i32; 3] = [100, 1_874 + 200, 1_874 + 300];
/// 20 degrees.
const START_ANGLE: f64 = 0.349;

type Robot = EmulatedOdrives<DemPlant>;
type Network = OdriveNetwork<InProcessLink<Robot, VirtualClock>, 3>;

fn axis(node: u8) -> AxisDescription {
    AxisDescription {
        node,
        maximum_torque: 0.2,
        direction: Direction::Positive,
        encoder: EncoderDescription {
            counts_per_revolution: COUNTS,
            counter_bits: 32,
            zero_offset: 100 * i32::from(node),
        },
        heartbeat: Duration::from_millis(50),
        encoder_period: Duration::ZERO,
        encoder_phase: Duration::ZERO,
        watchdog: Duration::from_millis(50),
        clock_error_ppm: 0,
    }
}

fn robot(change: impl Fn(AxisDescription) -> AxisDescription, pacing: Pacing) -> Result<Robot, OdriveRobotError> {
    let axes = [1, 2, 3].map(|node| AxisParameters::new(change(axis(node))).unwrap());
    EmulatedOdrives::new(DemPlant::new(ThreeLinkDem::table_2()), axes, pacing)
}

fn network(positions: Positions, robot: Robot) -> (Network, VirtualClock) {
    network_with(positions, robot, |axis| axis)
}

fn network_with(
    positions: Positions,
    robot: Robot,
    change: impl Fn(OdriveAxis) -> OdriveAxis,
) -> (Network, VirtualClock) {
    let clock = VirtualClock::new();
    let axis = |node| OdriveAxis {
        node: AxisNode::new(node).unwrap(),
        counts_per_turn: CountsPerRevolution::new(COUNTS).unwrap(),
        rated_torque: RatedTorque::from_millinewton_metres(200).unwrap(),
        product: None,
        readings: [None; 2],
    };
    let axes = [1, 2, 3].map(|node| change(axis(node)));
    let configuration = OdriveConfiguration { axes, positions, times: OdriveTimes::usual() };
    (OdriveNetwork::new(InProcessLink::new(robot, clock.clone()), configuration), clock)
}

fn started() -> (Network, VirtualClock) {
    let (mut network, clock) =
        network(Positions::OnRequest, robot(|axis| axis, Pacing::Lockstep { period: PERIOD }).unwrap());
    assert_eq!(network.start(&clock), Ok(START));
    (network, clock)
}

fn cycle(
    network: &mut Network,
    clock: &mut VirtualClock,
    torques: [i16; 3],
) -> Result<[Option<i32>; 3], OdriveCycleError<uarm_sim::InProcessError>> {
    let at = network.sync(clock.now())?;
    let feedback = network.collect(at + PERIOD)?;
    network.send_torques(torques)?;
    network.housekeeping(clock.now())?;
    clock.sleep_until(at + PERIOD);
    Ok(feedback.positions)
}

#[test]
fn a_torque_moves_the_plant_and_the_counts_are_those_of_its_encoders() {
    let (mut network, mut clock) = started();
    assert!(network.link().robot().brakes().iter().all(|brake| *brake == Brake::Released));
    let mut positions = [None; 3];
    for _ in 0..200 {
        positions = cycle(&mut network, &mut clock, [0, 100, -50]).unwrap();
    }
    let plant = network.link().robot().plant();
    assert_eq!(plant.time(), 199 * PERIOD, "the first request begins plant time, each further one is a period");
    let counts_per_radian = f64::from(COUNTS) / std::f64::consts::TAU;
    for ((count, angle), zero) in positions.into_iter().zip(plant.position().iter()).zip([100.0, 200.0, 300.0]) {
        let exact = angle * counts_per_radian + zero;
        let count = count.unwrap();
        assert!((f64::from(count) - exact).abs() <= 0.5 + 1e-6, "{count} of {exact}");
    }
    assert!(plant.position()[1] > START_ANGLE + 0.02, "joint 2 went in the direction of its torque");
    assert_eq!(network.link().robot().torque().as_slice(), [0.0, f64::from(0.02_f32), f64::from(-0.01_f32)]);
    assert!(network.stop(&clock).all_off());
    assert!(network.link().robot().brakes().iter().all(|brake| *brake == Brake::Engaged));
}

#[test]
fn the_watchdogs_brake_when_nothing_is_sent_any_more() {
    let (mut network, mut clock) = started();
    for _ in 0..10 {
        cycle(&mut network, &mut clock, [0, 100, -50]).unwrap();
    }
    // The controller is gone: nobody sends a torque, time goes on.
    let last_torque = clock.now() - PERIOD;
    let wait_until = |network: &mut Network, clock: &VirtualClock, after| {
        use uarm_io::link::Link;
        while network.link_mut().receive(last_torque + after).unwrap().is_some() {}
        assert!(clock.now() >= last_torque + after);
    };
    wait_until(&mut network, &clock, Duration::from_millis(49));
    assert!(network.link().robot().brakes().iter().all(|brake| *brake == Brake::Released));
    wait_until(&mut network, &clock, Duration::from_millis(50));
    for joint in Joint::ALL {
        let axis = network.link().robot().axis(joint);
        assert_eq!((axis.state(), axis.error()), (AxisState::IDLE, AxisError::WATCHDOG_TIMER_EXPIRED), "{joint:?}");
        assert_eq!((axis.brake(), axis.torque()), (Brake::Engaged, 0.0));
    }
}

#[test]
fn an_axis_error_ends_the_run_and_the_next_start_clears_it() {
    let (mut network, mut clock) = started();
    cycle(&mut network, &mut clock, [0; 3]).unwrap();
    network.link_mut().robot_mut().inject(Joint::TWO, AxisFault::Error(AxisError::MOTOR_OVER_TEMP));
    let error = (0..100).find_map(|_| cycle(&mut network, &mut clock, [0; 3]).err()).expect("an error");
    assert!(matches!(error, OdriveCycleError::NotArmed { axis, .. } if axis.raw() == 2), "{error}");
    network.stop(&clock);
    let hot = network.start(&clock).unwrap_err();
    assert!(matches!(hot, OdriveStartError::NotReached { axis, .. } if axis.raw() == 2), "still hot: {hot}");
    network.stop(&clock);
    network.link_mut().robot_mut().repair(Joint::TWO);
    network.start(&clock).unwrap();
}

/// 20 to 28 V, up to 80 degrees.
fn watched(axis: OdriveAxis) -> OdriveAxis {
    let supply = ReadingLimits::new([20.0, 28.0], [20.0, 28.0]);
    let temperature = ReadingLimits::new([f64::NEG_INFINITY, 80.0], [f64::NEG_INFINITY, 80.0]);
    OdriveAxis { readings: [supply, temperature], ..axis }
}

#[test]
fn an_axis_tells_who_it_is_its_supply_and_its_temperature() {
    let axes = [1, 2, 3].map(|node| AxisParameters::new(axis(node)).unwrap().with_product(0x0004_043A));
    let robot = EmulatedOdrives::new(DemPlant::new(ThreeLinkDem::table_2()), axes, Pacing::WallClock).unwrap();
    let pinned = |axis| OdriveAxis { product: Some(0x0004_043A), ..watched(axis) };
    let (mut network, clock) = network_with(Positions::OnRequest, robot, pinned);
    network.start(&clock).unwrap();
    assert!(network.identities().iter().all(|identity| identity.product == Some(0x0004_043A)));
    for node in network.health().nodes {
        assert_eq!(node.readings, [Some(24.0), Some(30.0)], "{node:?}");
    }
}

#[test]
fn a_supply_or_temperature_beyond_its_limits_ends_the_run_and_so_does_silence() {
    type Error = OdriveCycleError<uarm_sim::InProcessError>;
    let beyond = |error: &Error| match error {
        OdriveCycleError::Reading { axis, found } => Some((axis.raw(), found.quantity)),
        OdriveCycleError::NoReading { axis, quantity } => Some((axis.raw(), *quantity)),
        _ => None,
    };
    for (fault, quantity, is_told) in [
        (AxisFault::SupplyVoltage { millivolts: 19_900 }, Quantity::SupplyVoltage, "19.9 V"),
        (AxisFault::Temperature { tenths: 801 }, Quantity::Temperature, "80.1 deg C"),
        (AxisFault::ReadingsSilent, Quantity::SupplyVoltage, "does not tell its supply voltage any more"),
    ] {
        let pacing = Pacing::Lockstep { period: PERIOD };
        let (mut network, mut clock) = network_with(Positions::OnRequest, robot(|axis| axis, pacing).unwrap(), watched);
        network.start(&clock).unwrap();
        // 1.2 s: each quantity of each axis every 0.3 s.
        for _ in 0..400 {
            cycle(&mut network, &mut clock, [0; 3]).unwrap();
        }
        network.link_mut().robot_mut().inject(Joint::TWO, fault);
        let error = (0..400).find_map(|_| cycle(&mut network, &mut clock, [0; 3]).err()).expect("an error");
        assert_eq!(beyond(&error), Some((2, quantity)), "{fault:?}: {error}");
        assert!(error.to_string().contains(is_told), "{fault:?}: {error}");
        assert!(network.stop(&clock).all_off());
        network.link_mut().robot_mut().repair(Joint::TWO);
        network.start(&clock).unwrap();
    }
}

#[test]
fn a_drive_off_the_bus_gives_no_position_and_disarms_itself() {
    let (mut network, mut clock) = started();
    cycle(&mut network, &mut clock, [0; 3]).unwrap();
    network.link_mut().robot_mut().inject(Joint::THREE, AxisFault::BusDisconnected);
    assert_eq!(cycle(&mut network, &mut clock, [0; 3]).unwrap()[2], None);
    let report = network.stop(&clock);
    assert!(!report.all_off(), "nobody can confirm it");
    assert_eq!(network.link().robot().axis(Joint::THREE).brake(), Brake::Engaged, "its watchdog did it");
}

#[test]
fn an_axis_without_watchdog_is_refused_and_stopped() {
    let unwatched = robot(|axis| AxisDescription { watchdog: Duration::ZERO, ..axis }, Pacing::WallClock).unwrap();
    let (mut network, clock) = network(Positions::OnRequest, unwatched);
    let error = network.start(&clock).unwrap_err();
    assert!(matches!(error, OdriveStartError::NoWatchdog { axis, .. } if axis.raw() == 1), "{error}");
    assert!(network.stop(&clock).all_off());
}

#[test]
fn a_new_start_puts_the_robot_back() {
    let (mut network, mut clock) = started();
    for _ in 0..50 {
        cycle(&mut network, &mut clock, [0, 200, 0]).unwrap();
    }
    assert!(network.link().robot().plant().position()[1] > START_ANGLE + 0.001);
    network.stop(&clock);
    assert_eq!(network.start(&clock), Ok(START));
    assert_eq!(network.link().robot().plant().time(), Duration::ZERO);
}

#[test]
fn cyclic_positions_are_as_old_as_the_drift_of_the_clocks_makes_them() {
    let every = Duration::from_millis(3);
    let drifting = |axis: AxisDescription| AxisDescription {
        encoder_period: every,
        encoder_phase: Duration::from_micros(700) * u32::from(axis.node),
        clock_error_ppm: 400 * i32::from(axis.node),
        ..axis
    };
    let (mut network, mut clock) = network(Positions::Cyclic { every }, robot(drifting, Pacing::WallClock).unwrap());
    network.start(&clock).unwrap();
    let mut ages = Vec::new();
    for _ in 0..3_000 {
        cycle(&mut network, &mut clock, [0; 3]).unwrap();
        ages.push(network.health().nodes[2].latency);
    }
    let (least, most) = (ages.iter().min().unwrap(), ages.iter().max().unwrap());
    // 1200 ppm of 9 s are 10.8 ms: the age has gone through all that it can be.
    assert!(*least < Duration::from_micros(10), "{least:?}");
    assert!(*most > Duration::from_micros(2_990) && *most <= every + Duration::from_micros(4), "{most:?}");
}

#[test]
fn a_robot_that_cannot_be_is_refused() {
    let twice = robot(|_| axis(4), Pacing::WallClock).unwrap_err();
    assert!(matches!(twice, OdriveRobotError::NodeTwice { node } if node.raw() == 4));
    let cyclic = |axis| AxisDescription { encoder_period: PERIOD, ..axis };
    let unpaced = robot(cyclic, Pacing::Lockstep { period: PERIOD }).unwrap_err();
    assert_eq!(unpaced, OdriveRobotError::LockstepWithoutRequests);
}

/// One after the other, the requests of a wall-clock robot are answered with what the plant does at their instants.
#[test]
fn on_the_wall_clock_the_plant_moves_with_time() {
    let (mut network, mut clock) = network(Positions::OnRequest, robot(|axis| axis, Pacing::WallClock).unwrap());
    network.start(&clock).unwrap();
    for _ in 0..100 {
        cycle(&mut network, &mut clock, [0, 100, 0]).unwrap();
    }
    assert_eq!(network.link().robot().plant().time(), 99 * PERIOD);
}
