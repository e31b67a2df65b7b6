//! When a torque acts: at reception or at SYNC, and a fraction of a period later.

mod support;

use dem_model::ThreeLinkDem;
use nalgebra::Vector3;
use std::time::Duration;
use support::{Master, PERIOD, RATED_TORQUE, lockstep, robot};
use uarm_io::drive::Value;
use uarm_io::drive::cia402::Command;
use uarm_sim::{
    Brake, DemPlant, DriveFault, EmulatedRobot, InProcessLink, Joint, Pacing, Plant, RobotError, VirtualClock,
};

const DELAY: Duration = Duration::from_micros(700);

type Tested = Master<InProcessLink<EmulatedRobot<DemPlant>, VirtualClock>>;

fn with_delays(pacing: Pacing, delays: [Duration; 3]) -> Tested {
    let clock = VirtualClock::new();
    let robot = robot(pacing).with_torque_delays(delays).unwrap();
    let mut master = Master::on(InProcessLink::new(robot, clock.clone()), clock);
    master.received();
    master
}

/// 6071h in N·m.
fn newton_metres(per_mille: i16) -> f64 {
    f64::from(per_mille) * f64::from(RATED_TORQUE) / 1e6
}

/// Torques of one cycle, per mille, changing all the time.
fn torques(cycle: u32) -> [i16; 2] {
    let step = i16::try_from(cycle % 7).unwrap();
    [40 * step - 100, 90 - 25 * step]
}

/// The ideal plant, moved cut by cut: each cut is its length and the torques of joints 2 and 3, per mille.
struct Reference {
    plant: DemPlant,
    time: Duration,
}

impl Reference {
    fn new() -> Self {
        Self { plant: DemPlant::new(ThreeLinkDem::table_2()), time: Duration::ZERO }
    }

    fn advance(&mut self, by: Duration, [second, third]: [i16; 2]) {
        self.time += by;
        let torque = Vector3::new(0.0, newton_metres(second), newton_metres(third));
        self.plant.advance(self.time, &torque, [Brake::Released; 3]);
    }
}

#[test]
fn the_torque_of_a_synchronous_rpdo_acts_from_the_next_sync_on() {
    let mut master = Master::with_robot(lockstep());
    master.enable();
    for node in [2, 3] {
        master.write(node, 0x1400, 2, Value::Unsigned8(1)).unwrap();
    }
    master.cycle(torques(0));
    assert_eq!(master.link.robot().torque(), Vector3::zeros(), "not yet");
    let mut reference = Reference::new();
    let mut acting = [0, 0];
    for cycle in 1..200 {
        master.cycle(torques(cycle));
        reference.advance(PERIOD, acting);
        assert_eq!(master.position(), reference.plant.position(), "bit for bit, cycle {cycle}");
        acting = torques(cycle - 1);
        assert_eq!(master.link.robot().torque().y, newton_metres(acting[0]));
    }
}

#[test]
fn a_fraction_of_a_period_passes_before_the_motor_follows() {
    for pacing in [lockstep(), Pacing::WallClock] {
        let mut master = with_delays(pacing, [Duration::ZERO, DELAY, DELAY]);
        master.enable();
        let mut reference = Reference::new();
        let mut acting = [0, 0];
        for cycle in 0..200 {
            // The torques come in the instant of their SYNC: then both pacings are the same.
            master.cycle(torques(cycle));
            assert_eq!(master.position(), reference.plant.position(), "bit for bit, {pacing:?}, cycle {cycle}");
            reference.advance(DELAY, acting);
            acting = torques(cycle);
            reference.advance(PERIOD - DELAY, acting);
        }
    }
}

#[test]
fn each_joint_has_its_own_delay() {
    let later = DELAY * 2;
    let mut master = with_delays(lockstep(), [Duration::ZERO, later, DELAY]);
    master.enable();
    let mut reference = Reference::new();
    let mut acting = [0, 0];
    for cycle in 0..50 {
        master.cycle(torques(cycle));
        assert_eq!(master.position(), reference.plant.position(), "bit for bit, cycle {cycle}");
        let [second, third] = torques(cycle);
        reference.advance(DELAY, acting);
        reference.advance(later - DELAY, [acting[0], third]);
        reference.advance(PERIOD - later, [second, third]);
        acting = [second, third];
    }
}

#[test]
fn power_that_goes_takes_the_torque_with_it_at_once() {
    for pacing in [lockstep(), Pacing::WallClock] {
        let mut master = with_delays(pacing, [DELAY; 3]);
        master.enable();
        for _ in 0..3 {
            master.cycle([100, 100]);
        }
        assert_eq!(master.link.robot().torque().y, newton_metres(100));
        master.command(2, Command::SwitchOn, 100);
        assert_eq!(master.link.robot().torque().y, 0.0, "{pacing:?}");
        master.link.inject(Joint::THREE, DriveFault::PowerLost);
        assert_eq!(master.link.robot().torque().z, 0.0, "{pacing:?}");
    }
}

#[test]
fn a_delay_of_a_period_is_refused() {
    let refused = |pacing, delay| robot(pacing).with_torque_delays([Duration::ZERO, delay, Duration::ZERO]).err();
    assert_eq!(refused(lockstep(), PERIOD), Some(RobotError::TorqueDelay { joint: 2, found: PERIOD, limit: PERIOD }));
    assert_eq!(refused(lockstep(), PERIOD - Duration::from_nanos(1)), None);
    assert_eq!(refused(Pacing::WallClock, PERIOD), None);
}
