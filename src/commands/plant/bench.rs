//! What a test bench does with an emulated robot, beside serving its bus.

use std::time::Duration;

use nalgebra::Vector3;
use uarm_io::time::Instant;
use uarm_sim::{Brake, EmulatedRobot, Joint, Outbox, Plant, RobotOnBus};

use super::faults::{Action, Order};
use crate::console;
use crate::simulated_robot::SimulatedRobot;

/// What the plant is, behind the encoders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// Plant time.
    pub time: Duration,
    /// Joint angles, rad.
    pub position: Vector3<f64>,
    /// Joint velocities, rad/s.
    pub velocity: Vector3<f64>,
    /// Torques at the motors, N·m.
    pub torque: Vector3<f64>,
    /// What the brakes do.
    pub brakes: [Brake; 3],
}

/// A robot whose truth is known and whose drives can be broken.
pub trait Bench: RobotOnBus {
    /// The truth, while plant time passes.
    fn truth(&self) -> Option<Truth>;

    /// Does what is ordered; nothing for a node that no drive has.
    fn obey(&mut self, order: &Order, now: Instant, outbox: &mut Outbox);
}

impl<P: Plant + Clone, const CAPACITY: usize> Bench for EmulatedRobot<P, 3, CAPACITY> {
    fn truth(&self) -> Option<Truth> {
        let plant = self.plant();
        self.is_running().then(|| Truth {
            time: plant.time(),
            position: plant.position(),
            velocity: plant.velocity(),
            torque: self.torque(),
            brakes: self.brakes(),
        })
    }

    fn obey(&mut self, order: &Order, now: Instant, outbox: &mut Outbox) {
        let joint = Joint::ALL.into_iter().find(|joint| self.drive(*joint).parameters().node() == order.node);
        match (joint, order.action) {
            (Some(joint), Action::Break(fault)) => self.inject(joint, fault),
            (Some(joint), Action::Repair) => self.repair(joint, now, outbox),
            (None, _) => console::tell(format_args!("no drive has node {}", order.node.raw())),
        }
    }
}

/// ODrive axes have no faults to bring about, and nobody asks for their truth: the options are refused for them.
impl<P: Plant + Clone> Bench for SimulatedRobot<P> {
    fn truth(&self) -> Option<Truth> {
        match self {
            Self::Canopen(robot) => robot.truth(),
            Self::Bought(robot) => robot.truth(),
            Self::Odrive(_) => None,
        }
    }

    fn obey(&mut self, order: &Order, now: Instant, outbox: &mut Outbox) {
        match self {
            Self::Canopen(robot) => robot.obey(order, now, outbox),
            Self::Bought(robot) => robot.obey(order, now, outbox),
            Self::Odrive(_) => {}
        }
    }
}
