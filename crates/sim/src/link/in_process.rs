//! A link whose other end is an emulated robot in the same process.

use crate::drive::DriveFault;
use crate::joint::Joint;
use crate::outbox::Outbox;
use crate::plant::Plant;
use crate::robot::EmulatedRobot;
use crate::robot_on_bus::RobotOnBus;
use uarm_io::frame::Frame;
use uarm_io::link::{Link, LinkError, LinkErrorKind, Received};
use uarm_io::time::{Clock, Instant};

/// What can go wrong with an in-process link.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum InProcessError {
    /// Frames of the robot did not fit into the queue because nobody received them for long.
    #[error("{lost} frames of the emulated robot were lost: nobody received them in time")]
    FramesLost {
        /// How many since the last such error.
        lost: u64,
    },
}

impl LinkError for InProcessError {
    fn kind(&self) -> LinkErrorKind {
        LinkErrorKind::Other
    }
}

/// A [`Link`] to an emulated robot on a clock: no wire, no thread, and no allocation.
///
/// A frame sent is handled at once and its answers are queued. What the drives do by themselves happens at its own instant,
/// in the order in which it falls due, whenever the link is used next or while it waits in [`receive`](Link::receive).
#[derive(Debug)]
pub struct InProcessLink<R, C> {
    robot: R,
    clock: C,
    outbox: Outbox,
    losses_reported: u64,
}

impl<R: RobotOnBus, C: Clock> InProcessLink<R, C> {
    /// Switches the robot on, on `clock`.
    pub fn new(mut robot: R, clock: C) -> Self {
        let mut outbox = Outbox::new();
        robot.power_on(clock.now(), &mut outbox);
        Self { robot, clock, outbox, losses_reported: 0 }
    }

    /// The robot at the other end.
    pub const fn robot(&self) -> &R {
        &self.robot
    }

    /// A frame that somebody else sends: the drives handle it, and it is received like one of theirs.
    pub fn send_as_another(&mut self, frame: &Frame) {
        let now = self.clock.now();
        self.outbox.push(*frame, now);
        self.robot.on_frame(frame, now, &mut self.outbox);
    }

    /// The robot at the other end, to bring faults about.
    pub const fn robot_mut(&mut self) -> &mut R {
        &mut self.robot
    }

    fn check_losses(&mut self) -> Result<(), InProcessError> {
        let lost = self.outbox.lost().saturating_sub(self.losses_reported);
        self.losses_reported = self.outbox.lost();
        if lost == 0 { Ok(()) } else { Err(InProcessError::FramesLost { lost }) }
    }
}

impl<P: Plant<J> + Clone, C: Clock, const J: usize> InProcessLink<EmulatedRobot<P, J>, C> {
    /// Brings a fault of a joint's drive about.
    pub fn inject(&mut self, joint: Joint<J>, fault: DriveFault) {
        self.robot.inject(joint, fault);
    }

    /// Takes the injected faults of a joint's drive away.
    pub fn repair(&mut self, joint: Joint<J>) {
        self.robot.repair(joint, self.clock.now(), &mut self.outbox);
    }
}

impl<R: RobotOnBus, C: Clock> Link for InProcessLink<R, C> {
    type Error = InProcessError;

    fn send(&mut self, frame: &Frame) -> Result<Instant, InProcessError> {
        let now = self.clock.now();
        self.robot.on_frame(frame, now, &mut self.outbox);
        Ok(now)
    }

    fn receive(&mut self, deadline: Instant) -> Result<Option<Received>, InProcessError> {
        self.robot.on_time(self.clock.now(), &mut self.outbox);
        loop {
            self.check_losses()?;
            if let Some(received) = self.outbox.pop() {
                return Ok(Some(received));
            }
            if self.clock.now() >= deadline {
                return Ok(None);
            }
            let next = self.robot.next_deadline().map_or(deadline, |due| due.min(deadline));
            self.clock.sleep_until(next);
            self.robot.on_time(self.clock.now(), &mut self.outbox);
        }
    }
}
