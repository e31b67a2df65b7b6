//! A bus with emulated drives in virtual time, for the tests of commands that talk to drives.

use hinf_control::Disturbance;
use uarm_io::drive::NodeId;
use uarm_sim::{EmulatedRobot, InProcessLink, Pacing, VirtualClock};

use crate::robot::Robot;
use crate::simulated_plant::{PlantChoice, SimulatedPlant};
use crate::simulated_robot::emulate;

/// The bus, and what stands on it.
pub type Bus = InProcessLink<EmulatedRobot<SimulatedPlant>, VirtualClock>;

/// The drives of the paper's robot, just switched on, at the start of its task: 0, 20 and 20 degrees.
pub fn bus() -> (Bus, VirtualClock) {
    bus_of(&Robot::load(None).unwrap())
}

/// The same for the drives of `robot`.
pub fn bus_of(robot: &Robot) -> (Bus, VirtualClock) {
    let plant = SimulatedPlant::new(robot, PlantChoice::Ideal, Disturbance::None).unwrap();
    let clock = VirtualClock::default();
    (InProcessLink::new(emulate(robot, plant, Pacing::WallClock).unwrap(), clock.clone()), clock)
}

/// The drive of joint 2.
pub fn node() -> NodeId {
    NodeId::new(2).unwrap()
}
