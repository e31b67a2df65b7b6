//! What happens in each cycle: positions in, torques out, supervision.

use super::configuration::Positions;
use super::error::{OdriveCycleError, OdriveStartError};
use super::master::{Axis, NO_DEADLINE, OdriveNetwork};
use super::wire::AxisNode;
use super::{turns, wire};
use crate::drive::RobotDrives;
use crate::drive::identity::DriveIdentity;
use crate::drive::network::{Feedback, NetworkHealth, StopReport};
use crate::link::{Link, LinkHealth};
use crate::time::{Clock, Duration, Instant};

/// How many of an axis's own periods a position may be old: one may be lost.
const PERIODS_BORNE: u32 = 2;

impl<L: Link, const JOINTS: usize> RobotDrives<JOINTS> for OdriveNetwork<L, JOINTS>
where
    L::Error: 'static,
{
    type StartError = OdriveStartError<L::Error>;
    type CycleError = OdriveCycleError<L::Error>;

    fn configure<C: Clock>(&mut self, clock: &C) -> Result<[i32; JOINTS], Self::StartError> {
        self.set_up_axes(clock)
    }

    /// Hardware and firmware, as `Get_Version` tells them.
    fn identities(&self) -> [DriveIdentity; JOINTS] {
        self.axes.map(|axis| axis.identity())
    }

    fn positions_after<C: Clock>(&mut self, wait: Duration, clock: &C) -> Result<[i32; JOINTS], Self::StartError> {
        self.positions_after_wait(wait, clock)
    }

    fn enable<C: Clock>(&mut self, clock: &C) -> Result<(), Self::StartError> {
        self.arm_axes(clock)
    }

    /// Takes in what has come, and asks each axis for its position if it does not send it by itself. The instant is that of
    /// the first request; of cyclic positions, `now`.
    fn sync(&mut self, now: Instant) -> Result<Instant, Self::CycleError> {
        self.drain()?;
        self.traffic.cycles += 1;
        self.deadline = NO_DEADLINE;
        for axis in &mut self.axes {
            axis.fresh = false;
            axis.missed = false;
        }
        self.sync_at = match self.configuration.positions {
            Positions::Cyclic { .. } => now,
            Positions::OnRequest => self.request()?,
        };
        Ok(self.sync_at)
    }

    fn collect(&mut self, deadline: Instant) -> Result<Feedback<JOINTS>, Self::CycleError> {
        // Positions that come by themselves are never late: they belong to the cycle that finds them.
        if self.configuration.positions == Positions::OnRequest {
            self.deadline = deadline;
        }
        while self.axes.iter().any(|axis| axis.late || !self.is_usable(axis)) {
            match self.link.receive(deadline)? {
                Some(received) => {
                    self.absorb(&received);
                    // A bus full of other traffic must not hold the loop beyond its deadline.
                    if received.at > deadline {
                        break;
                    }
                }
                None => break,
            }
        }
        self.sound()?;
        self.feedback()
    }

    fn send_torques(&mut self, per_mille: [i16; JOINTS]) -> Result<Instant, Self::CycleError> {
        let mut torques = [0.0; JOINTS];
        for ((torque, axis), per_mille) in torques.iter_mut().zip(&self.configuration.axes).zip(per_mille) {
            *torque = narrow(f64::from(per_mille) * axis.rated_torque.per_mille());
        }
        Ok(self.torques(torques)?)
    }

    /// Takes in waiting frames and supervises heartbeats, states and errors. The axes' watchdogs are fed by the torques.
    /// None: an axis reports its torque on request only, and is not asked.
    fn torque_actual(&self) -> [Option<i16>; JOINTS] {
        [None; JOINTS]
    }

    fn housekeeping(&mut self, now: Instant) -> Result<(), Self::CycleError> {
        self.drain()?;
        self.sound()?;
        let limit = self.configuration.times.heartbeat_timeout;
        for axis in &self.axes {
            let silence = now.since(axis.health.last_heartbeat_at.unwrap_or_default());
            if silence > limit {
                return Err(OdriveCycleError::Lost { axis: axis.node, silence, limit });
            }
        }
        self.inquire(now)
    }

    fn stop<C: Clock>(&mut self, clock: &C) -> StopReport<JOINTS> {
        self.stop_axes(clock)
    }

    fn health(&self) -> NetworkHealth<JOINTS> {
        self.seen()
    }

    fn link_health(&self) -> LinkHealth {
        self.link.health()
    }
}

impl<L: Link, const JOINTS: usize> OdriveNetwork<L, JOINTS> {
    /// Asks all axes for their positions; when the first was asked.
    pub(super) fn request(&mut self) -> Result<Instant, L::Error> {
        let mut first = None;
        for node in self.nodes() {
            let at = self.send(&wire::estimates_request(node))?;
            first.get_or_insert(at);
        }
        for axis in &mut self.axes {
            axis.asked += 1;
        }
        Ok(first.unwrap_or_default())
    }

    /// The first axis that gave more positions than it was asked for, where they are asked for.
    pub(super) fn twin(&self) -> Option<AxisNode> {
        let is_asked = self.configuration.positions == Positions::OnRequest;
        self.axes.iter().find(|axis| is_asked && axis.is_twin()).map(|axis| axis.node)
    }

    /// True if the axis's last position can be used in this cycle.
    fn is_usable(&self, axis: &Axis) -> bool {
        match self.configuration.positions {
            Positions::OnRequest => axis.fresh,
            Positions::Cyclic { every } => {
                axis.estimate.is_some_and(|(_, at)| self.sync_at.since(at) <= every.saturating_mul(PERIODS_BORNE))
            }
        }
    }

    /// An error if somebody else commands the axes, two have one node id, or one is not armed, as far as its last heartbeat
    /// tells.
    fn sound(&self) -> Result<(), OdriveCycleError<L::Error>> {
        if let Some(foreign) = self.foreign {
            return Err(OdriveCycleError::AnotherMaster(foreign));
        }
        if let Some(axis) = self.twin() {
            return Err(OdriveCycleError::TwoAxes { axis });
        }
        match self.axes.iter().find(|axis| !axis.heartbeat.is_armed()) {
            Some(axis) => Err(OdriveCycleError::NotArmed { axis: axis.node, found: axis.heartbeat }),
            None => Ok(()),
        }
    }

    /// The positions of the axes; counts what is missing. The latency is that of the answer that took longest, or the age of
    /// the oldest cyclic position.
    fn feedback(&mut self) -> Result<Feedback<JOINTS>, OdriveCycleError<L::Error>> {
        let usable = self.axes.each_ref().map(|axis| self.is_usable(axis));
        let sync_at = self.sync_at;
        let mut positions = [None; JOINTS];
        let mut latency = Duration::ZERO;
        let axes = self.axes.iter_mut().zip(&self.configuration.axes).zip(usable);
        for (position, ((axis, made), usable)) in positions.iter_mut().zip(axes) {
            axis.missed = !usable && self.configuration.positions == Positions::OnRequest;
            axis.late = axis.missed;
            let Some((estimates, at)) = axis.estimate.filter(|_| usable) else {
                axis.health.missed_feedbacks += 1;
                continue;
            };
            axis.latency(match self.configuration.positions {
                Positions::OnRequest => at.since(sync_at),
                Positions::Cyclic { .. } => sync_at.since(at),
            });
            latency = latency.max(axis.health.latency);
            let counts = turns::counts(estimates.position, made.counts_per_turn);
            *position = Some(counts.map_err(|source| OdriveCycleError::Position { axis: axis.node, source })?);
        }
        let statuswords = self.axes.map(|axis| axis.health.statusword);
        Ok(Feedback { sync_at, latency, positions, statuswords })
    }
}

/// The nearest `f32`; torques are far within its range.
#[allow(clippy::as_conversions, clippy::cast_possible_truncation)] // there is no other conversion in core
fn narrow(value: f64) -> f32 {
    value as f32
}
