//! The master of `uarm_io` against the emulated drives, over an in-process link and virtual time.

mod support;

use std::time::Duration;
use support::{PERIOD, RATED_TORQUE, drives, lockstep, robot};
use uarm_io::drive::cia402::PowerState;
use uarm_io::drive::network::{
    CycleError, Disturbance, DriveConfiguration, ForeignFrame, NetworkConfiguration, Setting, StartError,
};
use uarm_io::drive::wire::{self, DriveCommand};
use uarm_io::drive::{Address, DriveNetwork, NmtCommand, NmtState, NodeId, Value};
use uarm_io::link::Link;
use uarm_io::time::{Clock, Instant};
use uarm_io::torque::RatedTorque;
use uarm_sim::{Brake, DemPlant, DriveFault, EmulatedRobot, InProcessLink, Joint, Pacing, Plant, VirtualClock};

type Network = DriveNetwork<InProcessLink<EmulatedRobot<DemPlant>, VirtualClock>, 3>;

fn configuration() -> NetworkConfiguration<3> {
    let rated_torque = RatedTorque::from_millinewton_metres(RATED_TORQUE).unwrap();
    let drives = drives().map(|drive| {
        let counts = drive.encoder().description().counts_per_revolution;
        let settings = [Setting::new(Address::new(0x6072, 0), Value::Unsigned16(900))].into_iter().collect();
        DriveConfiguration { settings, ..DriveConfiguration::new(drive.node(), counts, rated_torque) }
    });
    NetworkConfiguration::new(drives, PERIOD).unwrap()
}

fn network(pacing: Pacing) -> (Network, VirtualClock) {
    let clock = VirtualClock::new();
    let link = InProcessLink::new(robot(pacing), clock.clone());
    (DriveNetwork::new(link, configuration()), clock)
}

fn started(pacing: Pacing) -> (Network, VirtualClock) {
    let (mut network, clock) = network(pacing);
    network.start(&clock).unwrap();
    (network, clock)
}

/// One cycle as the loop makes it; the positions.
fn cycle(
    network: &mut Network,
    clock: &mut VirtualClock,
    tick: Instant,
) -> Result<[Option<i32>; 3], CycleError<uarm_sim::InProcessError>> {
    clock.sleep_until(tick);
    network.sync()?;
    let feedback = network.collect(tick + PERIOD / 3)?;
    network.send_torques([0, 60, 30])?;
    network.housekeeping(clock.now())?;
    Ok(feedback.positions)
}

/// A run of so many cycles; all positions.
fn run(network: &mut Network, clock: &mut VirtualClock, cycles: u32) -> Vec<[Option<i32>; 3]> {
    let start = clock.now();
    (0..cycles).map(|k| cycle(network, clock, start + PERIOD * k).unwrap()).collect()
}

#[test]
fn boot_configure_enable_cycle_stop() {
    let (mut network, mut clock) = network(lockstep());
    let identities = network.start(&clock).unwrap().drives;
    assert_eq!(identities.map(|drive| drive.serial), [Some(1), Some(2), Some(3)]);
    let robot = network.link().robot();
    assert_eq!(robot.brakes(), [Brake::Released; 3]);
    assert_eq!(robot.drive(Joint::TWO).object(Address::new(0x6072, 0)), Some(Value::Unsigned16(900)));
    assert_eq!(robot.plant().time(), Duration::ZERO, "no SYNC, no motion");

    let positions = run(&mut network, &mut clock, 1_001);
    assert_eq!(network.link().robot().plant().time(), Duration::from_secs(3), "the first SYNC is plant time zero");
    assert_ne!(positions[0], positions[1_000]);

    let report = network.stop(&clock);
    assert!(report.all_off());
    let robot = network.link().robot();
    assert_eq!(robot.brakes(), [Brake::Engaged; 3]);
    assert_eq!(robot.drive(Joint::ONE).nmt_state(), NmtState::Stopped);
    assert_eq!(robot.drive(Joint::ONE).power_state(), PowerState::SwitchOnDisabled);
}

/// The contract: a lockstep run is the same each time, and starting again carries the robot back.
#[test]
fn runs_repeat_bit_for_bit() {
    let (mut network, mut clock) = started(lockstep());
    let first = run(&mut network, &mut clock, 500);
    let first_end = network.link().robot().plant().position();
    network.stop(&clock);
    network.start(&clock).unwrap();
    let second = run(&mut network, &mut clock, 500);
    assert_eq!(first, second);
    let second_end = network.link().robot().plant().position();
    assert_eq!(first_end.map(f64::to_bits), second_end.map(f64::to_bits));
}

/// With the master exactly on its ticks, wall clock and lockstep are the same experiment, bit for bit, although the drives'
/// heartbeats fall between the ticks.
#[test]
fn wall_clock_and_lockstep_agree_when_the_master_keeps_time() {
    let (mut lockstep, mut lockstep_clock) = started(lockstep());
    let (mut wall, mut wall_clock) = started(Pacing::WallClock);
    assert_eq!(run(&mut lockstep, &mut lockstep_clock, 500), run(&mut wall, &mut wall_clock, 500));
    let bits = |network: &Network| {
        let plant = network.link().robot().plant();
        assert_eq!(plant.time(), PERIOD * 499);
        (plant.position().map(f64::to_bits), plant.velocity().map(f64::to_bits))
    };
    assert_eq!(bits(&lockstep), bits(&wall));
}

#[test]
fn a_silent_master_means_brakes_within_the_heartbeat_time() {
    for pacing in [lockstep(), Pacing::WallClock] {
        let (mut network, mut clock) = started(pacing);
        run(&mut network, &mut clock, 200);
        let limit = configuration().heartbeats.master_timeout();
        // The master is killed: from here on nobody sends. The link's other end goes on in its own time.
        let last = clock.now();
        let link = network.link_mut();
        while link.receive(last + limit + Duration::from_millis(1)).unwrap().is_some() {}
        assert_eq!(network.link().robot().brakes(), [Brake::Engaged; 3]);
        let stopped = network.link().robot().plant().position();
        clock.sleep_until(last + Duration::from_secs(1));
        let link = network.link_mut();
        while link.receive(last + Duration::from_secs(1)).unwrap().is_some() {}
        assert_eq!(network.link().robot().plant().position(), stopped);
    }
}

#[test]
fn the_position_of_a_drive_that_falls_silent_is_missing() {
    let (mut network, mut clock) = started(lockstep());
    run(&mut network, &mut clock, 10);
    network.link_mut().inject(Joint::THREE, DriveFault::PowerLost);
    let tick = clock.now() + PERIOD;
    assert_eq!(cycle(&mut network, &mut clock, tick).unwrap()[2], None);
}

#[test]
fn an_emergency_ends_the_run() {
    let (mut network, mut clock) = started(lockstep());
    run(&mut network, &mut clock, 10);
    network.link_mut().inject(Joint::TWO, DriveFault::OverTemperature);
    let tick = clock.now() + PERIOD;
    let error = cycle(&mut network, &mut clock, tick).unwrap_err();
    assert!(matches!(error, CycleError::Emergency { node: 2, .. }), "{error}");
    let report = network.stop(&clock);
    assert!(report.all_off());
}

#[test]
fn a_drive_that_was_left_in_fault_starts_again() {
    let (mut network, mut clock) = started(lockstep());
    run(&mut network, &mut clock, 10);
    network.link_mut().inject(Joint::TWO, DriveFault::OverTemperature);
    let tick = clock.now() + PERIOD;
    cycle(&mut network, &mut clock, tick).unwrap_err();
    let error = network.start(&clock).unwrap_err();
    assert!(matches!(error, StartError::NotReached { node: 2, .. }), "still hot: {error}");
    network.link_mut().repair(Joint::TWO);
    network.start(&clock).unwrap();
    run(&mut network, &mut clock, 10);
}

#[test]
fn a_drive_that_is_not_the_robot_files_is_refused() {
    let clock = VirtualClock::new();
    let link = InProcessLink::new(robot(lockstep()), clock.clone());
    let mut other = configuration().drives().clone();
    other[2].counts_per_revolution = 8_000;
    let configuration = NetworkConfiguration::new(other, PERIOD).unwrap();
    let error = DriveNetwork::new(link, configuration).start(&clock).unwrap_err();
    assert!(matches!(error, StartError::Refused { node: 3, .. }), "{error}");
}

/// Another master resets a drive in the motion: the run ends in that cycle, and the brakes hold.
#[test]
fn another_master_ends_the_run() {
    let (mut network, mut clock) = started(lockstep());
    run(&mut network, &mut clock, 10);
    network.link_mut().send_as_another(&wire::nmt_frame(NmtCommand::ResetNode, NodeId::new(2).unwrap()));
    let tick = clock.now() + PERIOD;
    let error = cycle(&mut network, &mut clock, tick).unwrap_err();
    assert_eq!(error, CycleError::Disturbed(Disturbance::AnotherMaster(ForeignFrame::NmtCommand)));
    assert!(network.stop(&clock).all_off());
    assert_eq!(network.link().robot().brakes(), [Brake::Engaged; 3]);
}

/// The drives of a run whose master was killed while they were enabled, with a watchdog that is not to be relied on.
#[test]
fn drives_that_are_found_enabled_are_braked_before_their_settings() {
    let (network, clock) = started(lockstep());
    let mut link = network.into_link();
    assert_eq!(link.robot().brakes(), [Brake::Released; 3]);
    link.send(&DriveCommand::default().frame(NodeId::new(1).unwrap())).unwrap();
    assert_eq!(link.robot().brakes(), [Brake::Engaged, Brake::Released, Brake::Released]);
    let mut next = DriveNetwork::new(link, configuration());
    next.start(&clock).unwrap();
    assert!(next.stop(&clock).all_off());
}
