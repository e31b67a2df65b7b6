//! What a test bench does with an emulated robot, beside serving its bus.

use std::time::Duration;

use uarm_io::time::Instant;
use uarm_sim::{Brake, EmulatedRobot, Joint, Outbox, Plant, RobotOnBus};

use super::faults::{Action, Order};
use crate::console;
use crate::simulated_robot::SimulatedRobot;

/// What the plant is, behind the encoders.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// Plant time.
    pub time: Duration,
    /// The joints, from the base outwards.
    pub joints: Vec<JointTruth>,
}

/// What a joint is, behind its encoder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointTruth {
    /// Angle, rad.
    pub position: f64,
    /// Velocity, rad/s.
    pub velocity: f64,
    /// Torque at the motor, N·m.
    pub torque: f64,
    /// What the brake does.
    pub brake: Brake,
}

/// A robot whose truth is known and whose drives can be broken.
pub trait Bench: RobotOnBus {
    /// Plant time, while it passes.
    fn time(&self) -> Option<Duration>;

    /// The truth, while plant time passes.
    fn truth(&self) -> Option<Truth>;

    /// Does what is ordered; nothing for a node that no drive has.
    fn obey(&mut self, order: &Order, now: Instant, outbox: &mut Outbox);
}

impl<P: Plant<J> + Clone, const J: usize, const CAPACITY: usize> Bench for EmulatedRobot<P, J, CAPACITY> {
    fn time(&self) -> Option<Duration> {
        self.is_running().then(|| self.plant().time())
    }

    fn truth(&self) -> Option<Truth> {
        let time = self.time()?;
        let (positions, velocities) = (self.plant().position(), self.plant().velocity());
        let motions = positions.iter().zip(velocities.iter());
        let drives = self.torque();
        let drives = drives.iter().zip(self.brakes());
        let joints = motions.zip(drives).map(|((position, velocity), (torque, brake))| JointTruth {
            position: *position,
            velocity: *velocity,
            torque: *torque,
            brake,
        });
        Some(Truth { time, joints: joints.collect() })
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
impl<P: Plant<J> + Clone, const J: usize> Bench for SimulatedRobot<P, J> {
    fn time(&self) -> Option<Duration> {
        match self {
            Self::Canopen(robot) => robot.time(),
            Self::Bought(robot) => robot.time(),
            Self::Odrive(_) => None,
        }
    }

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
