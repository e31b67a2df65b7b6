//! What the master must know of the axes.

use super::wire::{AxisNode, Message};
use crate::drive::readings::{QUANTITIES, ReadingLimits};
use crate::encoder::CountsPerRevolution;
use crate::time::Duration;
use crate::torque::RatedTorque;
use embedded_can::StandardId;

/// Which position of an axis a cycle uses. CANSimple has no SYNC upon which all axes latch theirs at one instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Positions {
    /// Each cycle begins with a request to each axis. A position is as old as the bus and the axis take to answer. The
    /// axis must not send positions by itself (`encoder_msg_rate_ms` = 0), or an older one could pass for the answer.
    OnRequest,
    /// Each axis sends its position by itself, and a cycle uses the last one: up to `every` old, and, since the axes' clocks
    /// drift against the loop's, of any age in between.
    Cyclic {
        /// `encoder_msg_rate_ms` of the axes.
        every: Duration,
    },
}

/// One axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OdriveAxis {
    /// Its node id.
    pub node: AxisNode,
    /// Counts per turn that the encoder stage works with.
    pub counts_per_turn: CountsPerRevolution,
    /// The torque of 1000 per mille. The axis gets N·m; per mille are the loop's unit.
    pub rated_torque: RatedTorque,
    /// Which hardware it must be, as [`Version::product`](super::wire::Version::product) counts it; `None` is any.
    pub product: Option<u32>,
    /// Between which values its supply voltage and the higher of its temperatures may be; what has no limits is not asked for.
    pub readings: [Option<ReadingLimits>; QUANTITIES],
}

/// How often something is said, and how long its absence is borne.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OdriveTimes {
    /// `heartbeat_msg_rate_ms` of the axes.
    pub heartbeat: Duration,
    /// After how long without a heartbeat of an axis the run ends.
    pub heartbeat_timeout: Duration,
    /// `watchdog_timeout` of the axes: after how long without a torque an axis disarms.
    pub watchdog: Duration,
    /// How often a torque of zero feeds the watchdogs while there is no cycle.
    pub feed: Duration,
    /// How long it is listened for another master before anything is sent.
    pub listen: Duration,
    /// How long an axis may take to be heard at first.
    pub presence: Duration,
    /// How long an axis may take to reach a state.
    pub state: Duration,
}

impl OdriveTimes {
    /// Heartbeats every 50 ms, borne for 200 ms; a watchdog of 50 ms, fed every 10 ms; 200 ms of listening, 3 s to be heard, 2 s for a state.
    pub const fn usual() -> Self {
        Self {
            heartbeat: Duration::from_millis(50),
            heartbeat_timeout: Duration::from_millis(200),
            watchdog: Duration::from_millis(50),
            feed: Duration::from_millis(10),
            listen: Duration::from_millis(200),
            presence: Duration::from_secs(3),
            state: Duration::from_secs(2),
        }
    }
}

/// All axes, joint 1 first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OdriveConfiguration<const JOINTS: usize> {
    /// Each axis.
    pub axes: [OdriveAxis; JOINTS],
    /// Where positions come from.
    pub positions: Positions,
    /// Periods and timeouts.
    pub times: OdriveTimes,
}

impl<const JOINTS: usize> OdriveConfiguration<JOINTS> {
    /// The identifiers that the axes send, and those that only their master sends: another's frames then.
    pub fn receive_identifiers(&self) -> impl Iterator<Item = StandardId> + '_ {
        self.axes.iter().flat_map(|axis| {
            Message::OF_AXIS.into_iter().chain(Message::OF_MASTER).map(|message| message.identifier(axis.node))
        })
    }
}
