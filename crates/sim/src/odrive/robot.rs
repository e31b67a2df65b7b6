//! The emulated robot with ODrive axes.

use super::axis::{AxisFault, EmulatedAxis};
use super::parameters::AxisParameters;
use crate::joint::Joint;
use crate::outbox::Outbox;
use crate::plant::{Brake, Plant};
use crate::robot::{Pacing, twice};
use crate::robot_on_bus::RobotOnBus;
use nalgebra::SVector;
use uarm_io::drive::odrive::wire::{AxisNode, Message};
use uarm_io::frame::Frame;
use uarm_io::time::Instant;

/// Why a robot is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OdriveRobotError {
    /// Two axes share a node id.
    #[error("two ODrive axes have node {node}, expected one each")]
    NodeTwice {
        /// The node id that both have.
        node: AxisNode,
    },
    /// Nobody asks, so nothing paces the lockstep.
    #[error("lockstep moves the plant at each request, expected axes that send positions on request only")]
    LockstepWithoutRequests,
}

/// Emulated axes on the `J` joints of a plant, without I/O: frames and instants in, frames out.
///
/// Plant time begins with the first request of joint 1's position with all axes armed, or with the first torque other than
/// zero then; before that nothing moves. In lockstep each further such request moves the plant by one period. Once all
/// axes were told to clear their errors while idle, the plant is back in its initial state: someone has carried the robot
/// to where the next experiment starts.
#[derive(Debug)]
pub struct EmulatedOdrives<P, const J: usize = 3> {
    plant: P,
    initial: P,
    axes: [EmulatedAxis; J],
    pacing: Pacing,
    started: Option<Instant>,
    /// Which axes were cleared since plant time began.
    cleared: [bool; J],
    /// The latest instant seen: an injected fault has none of its own.
    now: Instant,
}

impl<P: Plant<J> + Clone, const J: usize> EmulatedOdrives<P, J> {
    /// Axes without supply on a plant; [`RobotOnBus::power_on`] starts them.
    ///
    /// # Errors
    /// [`OdriveRobotError`] if two axes share a node id, or nothing would pace the lockstep.
    pub fn new(plant: P, axes: [AxisParameters; J], pacing: Pacing) -> Result<Self, OdriveRobotError> {
        if let Some(node) = twice(&axes.map(|axis| axis.node())) {
            return Err(OdriveRobotError::NodeTwice { node });
        }
        if matches!(pacing, Pacing::Lockstep { .. }) && axes.iter().any(|axis| axis.encoder_period.is_some()) {
            return Err(OdriveRobotError::LockstepWithoutRequests);
        }
        let axes = axes.map(EmulatedAxis::new);
        let (started, cleared, now) = (None, [false; J], Instant::default());
        Ok(Self { initial: plant.clone(), plant, axes, pacing, started, cleared, now })
    }

    /// The plant: the truth behind the encoders, as it was when they were last read or torques or brakes last changed.
    pub const fn plant(&self) -> &P {
        &self.plant
    }

    /// The axis of a joint.
    pub const fn axis(&self, joint: Joint<J>) -> &EmulatedAxis {
        joint.of(&self.axes)
    }

    /// Brings a fault of a joint's axis about.
    pub fn inject(&mut self, joint: Joint<J>, fault: AxisFault) {
        let now = self.now;
        self.act(now, |robot| joint.of_mut(&mut robot.axes).inject(fault));
    }

    /// Takes the injected faults of a joint's axis away.
    pub fn repair(&mut self, joint: Joint<J>) {
        joint.of_mut(&mut self.axes).repair();
    }

    /// Torques at the motors, N·m.
    pub fn torque(&self) -> SVector<f64, J> {
        SVector::from(self.axes.each_ref().map(EmulatedAxis::torque))
    }

    /// What the brakes do.
    pub fn brakes(&self) -> [Brake; J] {
        self.axes.each_ref().map(EmulatedAxis::brake)
    }

    fn all_armed(&self) -> bool {
        self.axes.iter().all(EmulatedAxis::is_armed)
    }

    /// Does something; if that changes torques or brakes, the plant first moves on to `at` with the old ones. What changes
    /// nothing does not touch the plant: an integrator's step that ends off its grid would show in the bits.
    fn act(&mut self, at: Instant, act: impl FnOnce(&mut Self)) {
        let (torque, brakes) = (self.torque(), self.brakes());
        act(self);
        if (torque, brakes) != (self.torque(), self.brakes()) {
            self.catch_up_with(at, &torque, brakes);
        }
    }

    /// On the wall clock, moves the plant on to `now`.
    fn catch_up(&mut self, now: Instant) {
        let (torque, brakes) = (self.torque(), self.brakes());
        self.catch_up_with(now, &torque, brakes);
    }

    fn catch_up_with(&mut self, now: Instant, torque: &SVector<f64, J>, brakes: [Brake; J]) {
        if let (Some(start), Pacing::WallClock) = (self.started, self.pacing) {
            self.plant.advance(now.since(start), torque, brakes);
        }
    }

    /// A request of joint `index`'s position.
    fn on_request(&mut self, index: usize, now: Instant, outbox: &mut Outbox) {
        self.catch_up(now);
        if index == 0 {
            match (self.started, self.pacing) {
                (None, _) if self.all_armed() => self.started = Some(now),
                (Some(_), Pacing::Lockstep { period }) => {
                    let (torque, brakes) = (self.torque(), self.brakes());
                    self.plant.advance(self.plant.time() + period, &torque, brakes);
                }
                _ => {}
            }
        }
        let position = self.plant.position();
        if let (Some(axis), Some(angle)) = (self.axes.get_mut(index), position.get(index)) {
            axis.measure(*angle);
            axis.answer(now, outbox);
        }
    }

    fn on_message(&mut self, index: usize, message: Message, data: &[u8], now: Instant) {
        let mut cleared = false;
        self.act(now, |robot| {
            if let Some(axis) = robot.axes.get_mut(index) {
                cleared = axis.on_message(message, data, now);
            }
        });
        if self.started.is_none() && self.all_armed() && self.torque() != SVector::<f64, J>::zeros() {
            self.started = Some(now);
        }
        if let Some(flag) = self.cleared.get_mut(index) {
            *flag |= cleared;
        }
        if self.cleared.iter().all(|cleared| *cleared) {
            self.cleared = [false; J];
            self.started = None;
            self.plant = self.initial.clone();
        }
    }
}

impl<P: Plant<J> + Clone, const J: usize> RobotOnBus for EmulatedOdrives<P, J> {
    fn power_on(&mut self, now: Instant, outbox: &mut Outbox) {
        self.now = self.now.max(now);
        for axis in &mut self.axes {
            axis.power_on(now);
        }
        self.on_time(now, outbox);
    }

    fn next_deadline(&self) -> Option<Instant> {
        self.axes.iter().filter_map(EmulatedAxis::next_deadline).min()
    }

    fn on_time(&mut self, now: Instant, outbox: &mut Outbox) {
        while let Some(deadline) = self.next_deadline().filter(|deadline| *deadline <= now) {
            // Nothing is sent before what was sent already.
            let at = deadline.max(self.now);
            self.now = at;
            if self.axes.iter().any(|axis| axis.measures_at(deadline)) {
                self.catch_up(at);
            }
            let position = self.plant.position();
            self.act(at, |robot| {
                for (axis, angle) in robot.axes.iter_mut().zip(position.iter()) {
                    if axis.next_deadline() == Some(deadline) {
                        axis.measure(*angle);
                        axis.on_time(at, outbox);
                    }
                }
            });
        }
        self.now = self.now.max(now);
    }

    fn on_frame(&mut self, frame: &Frame, now: Instant, outbox: &mut Outbox) {
        self.on_time(now, outbox);
        let Some((message, node)) = Message::of(frame.id()) else { return };
        let Some(index) = self.axes.iter().position(|axis| axis.parameters().node() == node) else { return };
        // With data a message of an axis is no request.
        match (Message::OF_AXIS.contains(&message), message) {
            (true, _) if !frame.data().is_empty() => {}
            (true, Message::EncoderEstimates) => self.on_request(index, now, outbox),
            (true, _) => {
                if let Some(axis) = self.axes.get(index) {
                    axis.tell(message, now, outbox);
                }
            }
            (false, _) => self.on_message(index, message, frame.data(), now),
        }
    }
}
