//! The emulated robot: a plant, a drive on each joint, and the rule by which plant time passes.

use crate::drive::{CAPACITY as OWN_OBJECTS, DriveFault, DriveParameters, EmulatedDrive, Reaction};
use crate::joint::Joint;
use crate::motors::{Commanded, Motors};
use crate::outbox::Outbox;
use crate::plant::{Brake, Plant};
use crate::robot_on_bus::RobotOnBus;
use core::time::Duration;
use nalgebra::SVector;
use uarm_io::drive::cia402::PowerState;
use uarm_io::drive::wire::Channel;
use uarm_io::frame::Frame;
use uarm_io::time::Instant;

/// How plant time passes.
///
/// In both cases it begins with the first SYNC at which a drive is in *Operation enabled*; before that nothing moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pacing {
    /// Each further SYNC moves the plant on by one period with the torques held: what happens does not depend on when it
    /// happens, so that a run is reproducible to the bit, in real time, in virtual time and over a bus.
    Lockstep {
        /// The time between two SYNCs, plant time.
        period: Duration,
    },
    /// As time passes.
    WallClock,
}

/// Why a robot is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RobotError {
    /// Two drives share a node.
    #[error("two drives have node {node}, expected one each")]
    NodeTwice {
        /// The node id that both have.
        node: u8,
    },
    /// A torque would act a period or more after its command.
    #[error("the torque of joint {joint} acts {found:?} after its command, expected less than {limit:?}")]
    TorqueDelay {
        /// The joint, counted from 1.
        joint: usize,
        /// What was asked for.
        found: Duration,
        /// The period of the lockstep, or the longest that a robot on the wall clock may have.
        limit: Duration,
    },
    /// The period of the lockstep is out of range.
    #[error("the lockstep period is {found:?}, expected 1 µs to 1 s")]
    Period {
        /// What was asked for.
        found: Duration,
    },
}

/// Shortest and longest period of the lockstep.
const PERIODS: core::ops::RangeInclusive<Duration> = Duration::from_micros(1)..=Duration::from_secs(1);

/// Whether plant time passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Run {
    Waiting,
    Since(Instant),
}

/// Emulated drives on the `J` joints of a plant, without I/O: frames and instants in, frames out.
///
/// Once NMT has reset all drives, the plant is back in its initial state: someone has carried the robot to where the
/// next experiment starts.
///
/// `CAPACITY` is how many objects each drive can hold; the default is for drives with the emulation's own dictionary.
#[derive(Debug)]
pub struct EmulatedRobot<P, const J: usize = 3, const CAPACITY: usize = OWN_OBJECTS> {
    plant: P,
    initial: P,
    drives: [EmulatedDrive<CAPACITY>; J],
    motors: Motors<J>,
    pacing: Pacing,
    run: Run,
    /// Which drives were reset since plant time began.
    reset: [bool; J],
    /// The latest instant seen: an injected fault has none of its own.
    now: Instant,
}

impl<P: Plant<J> + Clone, const J: usize> EmulatedRobot<P, J> {
    /// Drives without supply on a plant; [`power_on`](Self::power_on) starts them.
    ///
    /// # Errors
    /// [`RobotError`] if two drives share a node, or the lockstep's period is out of range.
    pub fn new(plant: P, drives: [DriveParameters; J], pacing: Pacing) -> Result<Self, RobotError> {
        Self::with_drives(plant, drives.map(EmulatedDrive::new), pacing)
    }
}

impl<P: Plant<J> + Clone, const J: usize, const CAPACITY: usize> EmulatedRobot<P, J, CAPACITY> {
    /// Drives without supply on a plant, each with the dictionary that it was made with.
    ///
    /// # Errors
    /// [`RobotError`] if two drives share a node, or the lockstep's period is out of range.
    pub fn with_drives(plant: P, drives: [EmulatedDrive<CAPACITY>; J], pacing: Pacing) -> Result<Self, RobotError> {
        if let Some(node) = twice(&drives.each_ref().map(|drive| drive.parameters().node())) {
            return Err(RobotError::NodeTwice { node: node.raw() });
        }
        if let Pacing::Lockstep { period } = pacing
            && !PERIODS.contains(&period)
        {
            return Err(RobotError::Period { found: period });
        }
        let initial = plant.clone();
        let motors = Motors::new([Duration::ZERO; J]);
        Ok(Self {
            plant,
            initial,
            drives,
            motors,
            pacing,
            run: Run::Waiting,
            reset: [false; J],
            now: Instant::default(),
        })
    }

    /// The same robot, whose motors follow a change of torque after `delays`, joint by joint: what a drive takes from the
    /// instant at which a command acts in it to current in the motor. Shorter than a period. What switches a motor off does
    /// so at once.
    ///
    /// In lockstep the command acts at the SYNC before it, or, from a synchronous RPDO, at the SYNC after it; the delay is then
    /// plant time, so that a run is the same to the bit whenever frames come.
    ///
    /// # Errors
    /// [`RobotError::TorqueDelay`].
    pub fn with_torque_delays(self, delays: [Duration; J]) -> Result<Self, RobotError> {
        let limit = match self.pacing {
            Pacing::Lockstep { period } => period,
            Pacing::WallClock => *PERIODS.end(),
        };
        for (found, joint) in delays.into_iter().zip(1..) {
            if found >= limit {
                return Err(RobotError::TorqueDelay { joint, found, limit });
            }
        }
        Ok(Self { motors: Motors::new(delays), ..self })
    }

    /// Switches the supply on: each drive sends its boot-up message.
    pub fn power_on(&mut self, now: Instant, outbox: &mut Outbox) {
        self.now = self.now.max(now);
        self.latch_positions();
        for drive in &mut self.drives {
            drive.power_on(now, outbox);
        }
    }

    /// The plant: the truth behind the encoders, as it was when they were last read or torques or brakes last changed.
    pub const fn plant(&self) -> &P {
        &self.plant
    }

    /// Whether plant time passes: a drive has been enabled at a SYNC since they were last reset.
    pub const fn is_running(&self) -> bool {
        matches!(self.run, Run::Since(_))
    }

    /// The drive of a joint.
    pub const fn drive(&self, joint: Joint<J>) -> &EmulatedDrive<CAPACITY> {
        joint.of(&self.drives)
    }

    /// Torques at the motors, N·m.
    pub fn torque(&self) -> SVector<f64, J> {
        self.motors.torque(&self.commanded())
    }

    /// What the drives want of the motors, N·m; nothing from a drive whose power stage is off.
    fn commanded(&self) -> [Commanded; J] {
        self.drives.each_ref().map(|drive| Commanded {
            torque: drive.torque(),
            power: drive.power_state() == PowerState::OperationEnabled,
        })
    }

    /// What the brakes do.
    pub fn brakes(&self) -> [Brake; J] {
        self.drives.each_ref().map(EmulatedDrive::brake)
    }

    /// Brings a fault of a joint's drive about.
    pub fn inject(&mut self, joint: Joint<J>, fault: DriveFault) {
        self.catch_up(self.now);
        joint.of_mut(&mut self.drives).inject(fault);
        self.command_motors(self.now);
    }

    /// Takes the injected faults of a joint's drive away.
    pub fn repair(&mut self, joint: Joint<J>, now: Instant, outbox: &mut Outbox) {
        self.catch_up(now);
        joint.of_mut(&mut self.drives).repair(now, outbox);
        self.command_motors(now);
    }

    /// The next instant at which a drive does something by itself: [`on_time`](Self::on_time) wants to be called then.
    pub fn next_deadline(&self) -> Option<Instant> {
        self.drives.iter().filter_map(EmulatedDrive::next_deadline).chain(self.motors.next_change()).min()
    }

    /// Does all that is due by `now`, in the order in which it falls due.
    pub fn on_time(&mut self, now: Instant, outbox: &mut Outbox) {
        while let Some(deadline) = self.next_deadline().filter(|deadline| *deadline <= now) {
            // Nothing is sent before what was sent already.
            let at = deadline.max(self.now);
            self.now = at;
            self.act(at, |drives| {
                for drive in drives {
                    if drive.next_deadline() == Some(deadline) {
                        drive.on_time(at, outbox);
                    }
                }
            });
        }
        self.now = self.now.max(now);
    }

    /// Handles a frame that came at `now`, after all that was due before.
    pub fn on_frame(&mut self, frame: &Frame, now: Instant, outbox: &mut Outbox) {
        self.on_time(now, outbox);
        match Channel::of(frame.id()) {
            Some(Channel::Sync) => self.on_sync(frame.data(), now, outbox),
            channel => {
                if matches!(channel, Some(Channel::SdoRequest(_))) {
                    self.catch_up(now);
                    self.latch_positions();
                }
                let mut reset = self.reset;
                self.act(now, |drives| {
                    for (drive, reset) in drives.iter_mut().zip(&mut reset) {
                        *reset |= drive.on_frame(frame, now, outbox) == Reaction::Reset;
                    }
                });
                self.reset = reset;
                self.rewind_after_reset();
            }
        }
    }

    /// Lets the drives act; if that changes torques or brakes, the plant first moves on to `at` with the old ones.
    ///
    /// What changes nothing, such as a heartbeat, does not touch the plant: an integrator's step that ends off its grid would
    /// show in the bits.
    fn act(&mut self, at: Instant, act: impl FnOnce(&mut [EmulatedDrive<CAPACITY>; J])) {
        let (torque, brakes) = (self.torque(), self.brakes());
        act(&mut self.drives);
        self.command_motors(at);
        if (torque, brakes) != (self.torque(), self.brakes()) {
            self.catch_up_with(at, &torque, brakes);
        }
    }

    fn on_sync(&mut self, data: &[u8], now: Instant, outbox: &mut Outbox) {
        self.catch_up(now);
        match (self.run, self.pacing) {
            (Run::Waiting, _) => {
                if self.drives.iter().any(|drive| drive.power_state() == PowerState::OperationEnabled) {
                    self.run = Run::Since(now);
                }
            }
            (Run::Since(_), Pacing::Lockstep { period }) => self.advance_in_lockstep(period),
            (Run::Since(_), Pacing::WallClock) => {}
        }
        self.latch_positions();
        for drive in &mut self.drives {
            drive.on_sync(data, now, outbox);
        }
        self.command_motors(now);
    }

    /// On the wall clock, tells the motors what the drives want at `now`. In lockstep they are told with each period.
    fn command_motors(&mut self, now: Instant) {
        if self.pacing == Pacing::WallClock {
            let commanded = self.commanded();
            self.motors.command(&commanded, now);
        }
    }

    /// On the wall clock, moves the plant on to `now`.
    fn catch_up(&mut self, now: Instant) {
        let (torque, brakes) = (self.torque(), self.brakes());
        self.catch_up_with(now, &torque, brakes);
    }

    fn catch_up_with(&mut self, now: Instant, torque: &SVector<f64, J>, brakes: [Brake; J]) {
        if let (Run::Since(start), Pacing::WallClock) = (self.run, self.pacing) {
            self.plant.advance(now.since(start), torque, brakes);
        }
    }

    /// Moves the plant on by one period, in which each motor follows the drives' commands after its delay.
    fn advance_in_lockstep(&mut self, period: Duration) {
        let (start, commanded, brakes) = (self.plant.time(), self.commanded(), self.brakes());
        let mut passed = Duration::ZERO;
        while let Some(delay) = self.motors.next_delay(passed) {
            self.plant.advance(start + delay, &self.motors.torque(&commanded), brakes);
            self.motors.follow(delay, &commanded);
            passed = delay;
        }
        self.plant.advance(start + period, &self.motors.torque(&commanded), brakes);
    }

    fn latch_positions(&mut self) {
        let position = self.plant.position();
        for (drive, angle) in self.drives.iter_mut().zip(position.iter()) {
            drive.latch_position(*angle);
        }
    }

    fn rewind_after_reset(&mut self) {
        if self.reset.iter().all(|reset| *reset) {
            self.reset = [false; J];
            self.run = Run::Waiting;
            self.motors = self.motors.at_rest();
            self.plant = self.initial.clone();
            self.latch_positions();
        }
    }
}

/// The first value that comes a second time.
pub(crate) fn twice<T: Copy + PartialEq>(values: &[T]) -> Option<T> {
    values
        .iter()
        .enumerate()
        .find(|(index, value)| values.iter().take(*index).any(|other| other == *value))
        .map(|(_, value)| *value)
}

impl<P: Plant<J> + Clone, const J: usize, const CAPACITY: usize> RobotOnBus for EmulatedRobot<P, J, CAPACITY> {
    fn power_on(&mut self, now: Instant, outbox: &mut Outbox) {
        Self::power_on(self, now, outbox);
    }

    fn next_deadline(&self) -> Option<Instant> {
        Self::next_deadline(self)
    }

    fn on_time(&mut self, now: Instant, outbox: &mut Outbox) {
        Self::on_time(self, now, outbox);
    }

    fn on_frame(&mut self, frame: &Frame, now: Instant, outbox: &mut Outbox) {
        Self::on_frame(self, frame, now, outbox);
    }
}
