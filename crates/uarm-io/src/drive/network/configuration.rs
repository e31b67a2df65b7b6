//! What the master has to know of its drives before it starts them.

use crate::drive::objects::SYNC_COUNTER_OVERFLOW;
use crate::drive::plan::{Plan, interpolation_times, plan};
use crate::drive::survey::{Answer, Survey};
use crate::drive::wire::{Channel, MASTER_NODE};
use crate::drive::wishes::{DriveConfiguration, HeartbeatError, Heartbeats, Protocol, SyncCounterChoice, SyncPayload};
use canopen_rs::NodeId;
use core::time::Duration;
use embedded_can::StandardId;

/// How long each step of start and stop may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Timeouts {
    /// From reset to the boot-up message.
    pub boot: Duration,
    /// One SDO answer.
    pub sdo: Duration,
    /// How often an SDO request is made before its silence is an error; 0 counts as 1.
    pub sdo_attempts: u8,
    /// From an NMT command to the heartbeat that confirms it.
    pub nmt: Duration,
    /// From one state of CiA 402 to the wanted one, brake and power stage included.
    pub power: Duration,
    /// One step of a stop. A drive that did not confirm it by then is left to its own watchdog: the master falls silent.
    pub stop: Duration,
    /// How often the statusword is read while waiting for that.
    pub power_poll: Duration,
}

impl Default for Timeouts {
    /// Values that commercial drives keep with room to spare.
    fn default() -> Self {
        Self {
            boot: Duration::from_secs(3),
            sdo: Duration::from_millis(200),
            sdo_attempts: 3,
            nmt: Duration::from_millis(500),
            power: Duration::from_secs(2),
            stop: Duration::from_millis(500),
            power_poll: Duration::from_millis(2),
        }
    }
}

/// What an emergency message of a drive does in the cycle.
///
/// With the feature `serde` it is the text `"stop"` or `"record"`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum EmergencyReaction {
    /// It is an error, unless it says that an error is over.
    #[default]
    Stop,
    /// It is kept in the health record only; the statusword decides.
    Record,
}

/// What a drive does that says in bit 12 of its statusword that it ignores its target torque (CiA 402-2, *cyclic synchronous torque*).
///
/// With the feature `serde` it is the text `"stop"` or `"record"`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum IgnoredTargetReaction {
    /// It is an error, once the drive has said in the same run that it follows its target: there are makers that never set the bit.
    #[default]
    Stop,
    /// Nothing: for makers that use the bit for something else.
    Record,
}

/// Masters send SYNCs and heartbeats ten times a second or more often; of those that do, two are heard.
pub const LISTEN: Duration = Duration::from_millis(200);

/// The whole network.
#[derive(Clone, Debug, PartialEq)]
pub struct NetworkConfiguration<const JOINTS: usize> {
    drives: [DriveConfiguration; JOINTS],
    period: Duration,
    /// Heartbeats in both directions.
    pub heartbeats: Heartbeats,
    /// How long steps may take.
    pub timeouts: Timeouts,
    /// How long it is listened for another master before anything is sent.
    pub listen: Duration,
    /// Whether the SYNC is to carry a counter.
    pub sync_counter: SyncCounterChoice,
    /// What emergencies do.
    pub emergency_reaction: EmergencyReaction,
    /// What a target torque that a drive ignores does.
    pub ignored_target_reaction: IgnoredTargetReaction,
    /// How soon after a SYNC feedback for it can be here; what comes sooner is of an earlier SYNC. Zero where the bus
    /// has no bit rate, [`crate::bus_time::BitRate::earliest_feedback`] where it has.
    pub earliest_feedback: Duration,
}

/// What no network can be run with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ConfigurationError {
    /// No joints.
    #[error("no drives")]
    NoDrives,
    /// Two joints on one node, or one on the master's.
    #[error("node {node} is used twice, or is the master's ({MASTER_NODE})")]
    NodeTaken {
        /// The node id that is used twice.
        node: u8,
    },
    /// A period that 60C2h cannot hold.
    #[error("a period of {period:?} is no u8 multiple of a power of ten of a second, as 60C2h needs it")]
    Period {
        /// The period.
        period: Duration,
    },
    /// Heartbeat times that cannot be.
    #[error(transparent)]
    Heartbeat(#[from] HeartbeatError),
}

impl<const JOINTS: usize> NetworkConfiguration<JOINTS> {
    /// The drives of joints 1 … `JOINTS` in cycles of `period`, everything else at its default.
    ///
    /// # Errors
    /// [`ConfigurationError`].
    pub fn new(drives: [DriveConfiguration; JOINTS], period: Duration) -> Result<Self, ConfigurationError> {
        if JOINTS == 0 {
            return Err(ConfigurationError::NoDrives);
        }
        for (position, drive) in drives.iter().enumerate() {
            let taken = drives.iter().take(position).any(|other| other.node == drive.node);
            if taken || drive.node.raw() == MASTER_NODE || drive.node == NodeId::BROADCAST {
                return Err(ConfigurationError::NodeTaken { node: drive.node.raw() });
            }
        }
        if interpolation_times(period).next().is_none() {
            return Err(ConfigurationError::Period { period });
        }
        Ok(Self {
            drives,
            period,
            heartbeats: Heartbeats::default(),
            timeouts: Timeouts::default(),
            listen: LISTEN,
            sync_counter: SyncCounterChoice::default(),
            emergency_reaction: EmergencyReaction::default(),
            ignored_target_reaction: IgnoredTargetReaction::default(),
            earliest_feedback: Duration::ZERO,
        })
    }

    /// The drives, joint 1 first.
    pub const fn drives(&self) -> &[DriveConfiguration; JOINTS] {
        &self.drives
    }

    /// What the drives share, with this SYNC.
    pub fn protocol(&self, sync_payload: SyncPayload) -> Protocol {
        Protocol { period: self.period, heartbeats: self.heartbeats, sync_payload }
    }

    /// The plan of a start for `drive`, of which `survey` tells, where the other drives take the SYNC as it does.
    pub fn plan(&self, survey: &Survey, drive: &DriveConfiguration) -> Plan {
        let counter = survey.get(&SYNC_COUNTER_OVERFLOW);
        let wanted = i64::from(SyncPayload::Counter.overflow());
        let can_count = counter.answer == Answer::Number(wanted) || counter.may_become(wanted);
        plan(survey, drive, &self.protocol(self.sync_counter.payload(can_count)))
    }

    /// Every identifier that the master listens to: what a link needs for its filters.
    ///
    /// Those of its drives, and those that only a master sends: heard, they are another master's.
    pub fn receive_identifiers(&self) -> impl Iterator<Item = StandardId> {
        let drives = self.drives.iter().flat_map(|drive| {
            let predefined = [Channel::Emergency, Channel::SdoResponse, Channel::Heartbeat]
                .map(|channel| channel(drive.node).identifier());
            let torque = drive.pdos.torque_feedback.map(|pdo| pdo.identifier);
            predefined.into_iter().chain([drive.pdos.feedback.identifier]).chain(torque)
        });
        drives.chain(self.foreign().map(|(identifier, _)| identifier))
    }
}
