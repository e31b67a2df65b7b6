//! The drives of a robot as the control loop sees them, whatever protocol they speak.
//!
//! A protocol is one implementation of [`RobotDrives`]. [`DriveNetwork`] is that of CiA 402 drives on CANopen.

use crate::drive::identity::DriveIdentity;
use crate::drive::network::{CycleError, DriveNetwork, Feedback, NetworkHealth, StartError, StopReport};
use crate::link::{Link, LinkHealth};
use crate::time::{Clock, Duration, Instant};
use core::error::Error;

/// The drives of `JOINTS` joints on one bus.
///
/// [`configure`](Self::configure), [`enable`](Self::enable) and [`stop`](Self::stop) block, with time limits. In the cycle there are only
/// [`sync`](Self::sync), [`collect`](Self::collect), [`send_torques`](Self::send_torques) and
/// [`housekeeping`](Self::housekeeping), in this order: they read no clock, allocate nothing, and wait nowhere but in
/// `collect`, for its deadline. All arrays have joint 1 first.
pub trait RobotDrives<const JOINTS: usize> {
    /// Why the drives did not start.
    type StartError: Error;
    /// What goes wrong in a cycle.
    type CycleError: Error;

    /// Sets all drives up without power, brakes closed; blocks. Returns where the joints stand, counts: the caller decides by
    /// them whether the drives may be enabled.
    ///
    /// # Errors
    /// Call [`stop`](Self::stop) then.
    fn configure<C: Clock>(&mut self, clock: &C) -> Result<[i32; JOINTS], Self::StartError>;

    /// What the drives said of themselves in [`configure`](Self::configure); nothing before it.
    fn identities(&self) -> [DriveIdentity; JOINTS];

    /// Where the joints stand after `wait`, counts: for drives that are set up and have no power; blocks.
    ///
    /// # Errors
    /// Call [`stop`](Self::stop) then.
    fn positions_after<C: Clock>(&mut self, wait: Duration, clock: &C) -> Result<[i32; JOINTS], Self::StartError>;

    /// Brings drives that are set up to where they follow a torque, brakes open, torques zero; blocks. From here on the caller
    /// owes a [`housekeeping`](Self::housekeeping) once per cycle.
    ///
    /// # Errors
    /// Call [`stop`](Self::stop) then, since some drives may be enabled.
    fn enable<C: Clock>(&mut self, clock: &C) -> Result<(), Self::StartError>;

    /// [`configure`](Self::configure), then [`enable`](Self::enable) wherever the joints stand.
    ///
    /// # Errors
    /// Those of both.
    fn start<C: Clock>(&mut self, clock: &C) -> Result<[i32; JOINTS], Self::StartError> {
        let positions = self.configure(clock)?;
        self.enable(clock)?;
        Ok(positions)
    }

    /// Begins a cycle at `now`: makes the drives latch their positions, if the protocol can. Returns the instant that
    /// the positions of this cycle belong to.
    ///
    /// # Errors
    /// If the bus failed.
    fn sync(&mut self, now: Instant) -> Result<Instant, Self::CycleError>;

    /// Takes in the positions of the drives, until all are here or `deadline` passes, and supervises the drives. A position
    /// that did not come by then is missing from the feedback, and not taken for one of a later cycle.
    ///
    /// # Errors
    /// If the bus or a drive failed.
    fn collect(&mut self, deadline: Instant) -> Result<Feedback<JOINTS>, Self::CycleError>;

    /// Sends the torques, per mille of each drive's rated torque. Returns when the last was handed to the link. A drive
    /// whose frame was not taken does not keep the others from theirs.
    ///
    /// # Errors
    /// If the bus failed.
    fn send_torques(&mut self, per_mille: [i16; JOINTS]) -> Result<Instant, Self::CycleError>;

    /// What is not bound to the positions, at the end of each cycle: sign of life to the drives, supervision of theirs.
    ///
    /// # Errors
    /// If the bus or a drive failed.
    fn housekeeping(&mut self, now: Instant) -> Result<(), Self::CycleError>;

    /// The torques that the drives reported for the last cycle, per mille of each drive's rated torque; `None` for a drive that
    /// reports none. Ask after [`housekeeping`](Self::housekeeping).
    fn torque_actual(&self) -> [Option<i16>; JOINTS];

    /// Stops all drives as well as it can be done: torque 0, power off, brakes closed; blocks. Never fails: what a drive
    /// did not confirm is told in the report.
    fn stop<C: Clock>(&mut self, clock: &C) -> StopReport<JOINTS>;

    /// What was seen of the drives so far.
    fn health(&self) -> NetworkHealth<JOINTS>;

    /// What the link has seen of its wire so far.
    fn link_health(&self) -> LinkHealth;
}

impl<L: Link, const JOINTS: usize> RobotDrives<JOINTS> for DriveNetwork<L, JOINTS>
where
    L::Error: 'static,
{
    type StartError = StartError<L::Error>;
    type CycleError = CycleError<L::Error>;

    fn configure<C: Clock>(&mut self, clock: &C) -> Result<[i32; JOINTS], Self::StartError> {
        Ok(Self::configure(self, clock)?.positions)
    }

    fn identities(&self) -> [DriveIdentity; JOINTS] {
        Self::identities(self)
    }

    fn positions_after<C: Clock>(&mut self, wait: Duration, clock: &C) -> Result<[i32; JOINTS], Self::StartError> {
        Self::positions_after(self, wait, clock)
    }

    fn enable<C: Clock>(&mut self, clock: &C) -> Result<(), Self::StartError> {
        Self::enable(self, clock)
    }

    fn sync(&mut self, _now: Instant) -> Result<Instant, Self::CycleError> {
        Self::sync(self)
    }

    fn collect(&mut self, deadline: Instant) -> Result<Feedback<JOINTS>, Self::CycleError> {
        Self::collect(self, deadline)
    }

    fn send_torques(&mut self, per_mille: [i16; JOINTS]) -> Result<Instant, Self::CycleError> {
        Self::send_torques(self, per_mille)
    }

    fn housekeeping(&mut self, now: Instant) -> Result<(), Self::CycleError> {
        Self::housekeeping(self, now)
    }

    fn torque_actual(&self) -> [Option<i16>; JOINTS] {
        Self::torque_actual(self)
    }

    fn stop<C: Clock>(&mut self, clock: &C) -> StopReport<JOINTS> {
        Self::stop(self, clock)
    }

    fn health(&self) -> NetworkHealth<JOINTS> {
        Self::health(self)
    }

    fn link_health(&self) -> LinkHealth {
        self.link().health()
    }
}
