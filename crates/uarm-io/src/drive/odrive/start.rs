//! From any state to *closed loop control*, torque 0, watchdog proved.

use super::axis_error::AxisError;
use super::configuration::Positions;
use super::error::OdriveStartError;
use super::master::{Axis, NO_DEADLINE, OdriveNetwork};
use super::turns;
use super::wire::{self, AxisState, ControllerMode, Heartbeat};
use crate::drive::network::LastDefence;
use crate::frame::Frame;
use crate::link::Link;
use crate::time::{Clock, Duration, Instant};

type Outcome<T, L> = Result<T, OdriveStartError<<L as Link>::Error>>;

impl<L: Link, const JOINTS: usize> OdriveNetwork<L, JOINTS> {
    /// Nobody else is heard → each axis is heard, and is the one that is wanted → idle → errors cleared → torque control →
    /// supply, temperature and position read.
    pub(super) fn set_up_axes<C: Clock>(&mut self, clock: &C) -> Outcome<[i32; JOINTS], L> {
        self.drain()?;
        self.listen(clock)?;
        self.hear(clock)?;
        self.identify(clock)?;
        self.tell_identities();
        self.tell_all(|node| wire::state_frame(node, AxisState::IDLE))?;
        self.reach(clock, "IDLE", |heartbeat| heartbeat.state == AxisState::IDLE)?;
        self.clear(clock)?;
        self.read_watched(clock)?;
        self.read_positions(clock)
    }

    fn tell_identities(&self) {
        for axis in &self.axes {
            (self.identified)(axis.node.raw(), &axis.identity());
        }
    }

    /// Each axis is armed with torque 0 → left without a torque until its watchdog disarms it → errors cleared → no two with one
    /// node id → armed.
    ///
    /// CANSimple cannot tell whether the watchdog is on, so it is tried. The brakes are open meanwhile.
    pub(super) fn arm_axes<C: Clock>(&mut self, clock: &C) -> Outcome<(), L> {
        self.arm(clock)?;
        self.prove_watchdogs(clock)?;
        self.clear(clock)?;
        self.meet_twins(clock)?;
        self.arm(clock)
    }

    /// Listens without sending anything. When somebody else commands the axes nothing is sent afterwards either.
    fn listen<C: Clock>(&mut self, clock: &C) -> Outcome<(), L> {
        self.foreign = None;
        let listen = self.configuration.times.listen;
        self.wait(clock, clock.now() + listen, Feeding::Off, |_| false)?;
        self.is_withheld = self.foreign.is_some();
        self.undisturbed()
    }

    fn undisturbed(&self) -> Outcome<(), L> {
        self.foreign.map_or(Ok(()), |foreign| Err(OdriveStartError::AnotherMaster(foreign)))
    }

    /// Asks each axis twice for its position, and gives another one with its node id the time to answer.
    fn meet_twins<C: Clock>(&mut self, clock: &C) -> Outcome<(), L> {
        self.forget_positions();
        if self.configuration.positions != Positions::OnRequest {
            return Ok(());
        }
        for _ in 0..2 {
            for axis in &mut self.axes {
                axis.fresh = false;
            }
            self.request()?;
            let answering = self.configuration.times.heartbeat;
            self.wait(clock, clock.now() + answering, Feeding::On, |_| false)?;
        }
        self.twin().map_or(Ok(()), |axis| Err(OdriveStartError::TwoAxes { axis }))
    }

    /// Positions after `wait`, with the watchdogs fed.
    pub(super) fn positions_after_wait<C: Clock>(&mut self, wait: Duration, clock: &C) -> Outcome<[i32; JOINTS], L> {
        self.wait(clock, clock.now() + wait, Feeding::On, |_| false)?;
        self.read_positions(clock)
    }

    fn tell_all(&mut self, frame: impl Fn(wire::AxisNode) -> Frame) -> Result<(), L::Error> {
        for node in self.nodes() {
            self.send(&frame(node))?;
        }
        Ok(())
    }

    /// Waits for a heartbeat of each axis, sent after the start began.
    fn hear<C: Clock>(&mut self, clock: &C) -> Outcome<(), L> {
        for axis in &mut self.axes {
            axis.health.last_heartbeat_at = None;
            axis.last_defence = LastDefence::None;
        }
        let waited = self.configuration.times.presence;
        let silent = |axis: &&Axis| axis.health.last_heartbeat_at.is_none();
        self.wait(clock, clock.now() + waited, Feeding::On, |axes| !axes.iter().any(|axis| silent(&axis)))?;
        match self.axes.iter().find(silent) {
            Some(axis) => Err(OdriveStartError::NotHeard { axis: axis.node, waited }),
            None => Ok(()),
        }
    }

    /// Forgets errors, of earlier runs too, and sets torque control.
    fn clear<C: Clock>(&mut self, clock: &C) -> Outcome<(), L> {
        self.tell_all(wire::clear_errors_frame)?;
        self.torques([0.0; JOINTS])?;
        self.tell_all(|node| ControllerMode::TORQUE.frame(node))?;
        self.reach(clock, "IDLE without error", |heartbeat| {
            heartbeat.state == AxisState::IDLE && heartbeat.error.is_none()
        })
    }

    /// Arms all axes: brakes open.
    fn arm<C: Clock>(&mut self, clock: &C) -> Outcome<(), L> {
        self.torques([0.0; JOINTS])?;
        self.tell_all(|node| wire::state_frame(node, AxisState::CLOSED_LOOP_CONTROL))?;
        self.reach(clock, "CLOSED_LOOP_CONTROL without error", Heartbeat::is_armed)
    }

    /// Waits, feeding the watchdogs, until the last heartbeat of every axis is `wanted`.
    fn reach<C: Clock>(
        &mut self,
        clock: &C,
        expected: &'static str,
        wanted: impl Fn(&Heartbeat) -> bool,
    ) -> Outcome<(), L> {
        let waited = self.configuration.times.state;
        self.wait(clock, clock.now() + waited, Feeding::On, |axes| axes.iter().all(|axis| wanted(&axis.heartbeat)))?;
        self.undisturbed()?;
        match self.axes.iter().find(|axis| !wanted(&axis.heartbeat)) {
            Some(Axis { node, heartbeat, .. }) => {
                Err(OdriveStartError::NotReached { axis: *node, expected, found: *heartbeat, waited })
            }
            None => Ok(()),
        }
    }

    /// The positions before power is on.
    fn read_positions<C: Clock>(&mut self, clock: &C) -> Outcome<[i32; JOINTS], L> {
        self.forget_positions();
        if self.configuration.positions == Positions::OnRequest {
            self.request()?;
        }
        let waited = self.configuration.times.state;
        self.wait(clock, clock.now() + waited, Feeding::On, |axes| axes.iter().all(|axis| axis.fresh))?;
        let mut positions = [0; JOINTS];
        for ((position, axis), made) in positions.iter_mut().zip(&self.axes).zip(&self.configuration.axes) {
            let Some((estimates, _)) = axis.estimate.filter(|_| axis.fresh) else {
                return Err(OdriveStartError::NoPosition { axis: axis.node, waited });
            };
            *position = turns::counts(estimates.position, made.counts_per_turn)
                .map_err(|source| OdriveStartError::Position { axis: axis.node, source })?;
        }
        Ok(positions)
    }

    /// What came, and what was late, of a run before.
    fn forget_positions(&mut self) {
        self.deadline = NO_DEADLINE;
        for axis in &mut self.axes {
            (axis.fresh, axis.missed, axis.late) = (false, false, false);
            (axis.asked, axis.answered) = (0, 0);
        }
    }

    /// Feeds no watchdog until every axis has disarmed by its own. Positions that nobody asks for show here, too.
    fn prove_watchdogs<C: Clock>(&mut self, clock: &C) -> Outcome<(), L> {
        self.forget_positions();
        let times = self.configuration.times;
        let waited = times.watchdog + times.heartbeat.saturating_mul(HEARTBEATS_TO_TELL);
        let expired = |axis: &Axis| {
            axis.heartbeat.error.contains(AxisError::WATCHDOG_TIMER_EXPIRED)
                && axis.heartbeat.state != AxisState::CLOSED_LOOP_CONTROL
        };
        self.wait(clock, clock.now() + waited, Feeding::Off, |axes| axes.iter().all(expired))?;
        for axis in self.axes.iter_mut().filter(|axis| expired(axis)) {
            axis.last_defence = LastDefence::RpdoTimeout;
            // What was provoked is no emergency.
            axis.health.last_emergency = None;
            axis.health.emergencies = axis.health.emergencies.saturating_sub(1);
        }
        if let Some(axis) = self.axes.iter().find(|axis| !expired(axis)) {
            return Err(OdriveStartError::NoWatchdog { axis: axis.node, found: axis.heartbeat, waited });
        }
        let unrequested = self.axes.iter().find(|axis| axis.fresh);
        match unrequested.filter(|_| self.configuration.positions == Positions::OnRequest) {
            Some(axis) => Err(OdriveStartError::Unrequested { axis: axis.node }),
            None => Ok(()),
        }
    }

    /// Reads frames until all axes are as they are `wanted` or `deadline` passes.
    pub(super) fn wait<C: Clock>(
        &mut self,
        clock: &C,
        deadline: Instant,
        feeding: Feeding,
        wanted: impl Fn(&[Axis; JOINTS]) -> bool,
    ) -> Result<(), L::Error> {
        while !wanted(&self.axes) {
            let now = clock.now();
            let wake = match feeding {
                Feeding::On => self.feed(now)?.min(deadline),
                Feeding::Off => deadline,
            };
            match self.link.receive(wake)? {
                Some(received) => {
                    self.absorb(&received);
                    // A bus full of noise must not hold it beyond the deadline.
                    if received.at > deadline {
                        break;
                    }
                }
                None if wake < deadline => {}
                None => break,
            }
        }
        Ok(())
    }

    /// Feeds the watchdogs with torque 0 if it is time; when it is again.
    fn feed(&mut self, now: Instant) -> Result<Instant, L::Error> {
        if now >= self.next_feed {
            self.next_feed = now + self.configuration.times.feed;
            self.torques([0.0; JOINTS])?;
        }
        Ok(self.next_feed)
    }
}

/// Heartbeats within which an axis tells that its watchdog has expired.
const HEARTBEATS_TO_TELL: u32 = 3;

/// Whether the watchdogs of the axes are fed while the master waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Feeding {
    On,
    Off,
}
