//! What the master has to know of its drives before it starts them.

use crate::drive::objects::{self, Object};
use crate::drive::wire::{self, Channel, MASTER_NODE, SYNC_COUNTER_OVERFLOW};
use crate::torque::RatedTorque;
use canopen_rs::pdo::PDO_COB_ID_INVALID;
use canopen_rs::{Address, MappingEntry, NodeId, Value};
use core::time::Duration;
use embedded_can::StandardId;

/// The most objects that a robot file can set in one drive.
pub const MAX_SETTINGS: usize = 32;

/// What a robot file sets in one drive, in this order.
pub type Settings = heapless::Vec<Setting, MAX_SETTINGS>;

/// One object to be written at start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// The object that is written.
    pub address: Address,
    /// The value that is written, of the object's type.
    pub value: Value,
    /// Whether it is read again.
    pub read_back: ReadBack,
}

/// Whether an object is read again after it was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReadBack {
    /// It must read as written.
    Same,
    /// The 11-bit identifier and the bit *PDO is off* must read as written; drives set other bits by themselves.
    SameIdentifier,
    /// It is not read: commands such as *store parameters* read as something else.
    Skipped,
}

impl Setting {
    /// An object that must read as written.
    pub const fn new(address: Address, value: Value) -> Self {
        Self { address, value, read_back: ReadBack::Same }
    }

    const fn of(object: &Object, value: Value) -> Self {
        Self::new(object.address(), value)
    }

    const fn identifier(object: &Object, value: u32) -> Self {
        Self { address: object.address(), value: Value::Unsigned32(value), read_back: ReadBack::SameIdentifier }
    }

    /// True if `found` is as good as what was written.
    pub(super) fn agrees(&self, found: Value) -> bool {
        match (self.read_back, self.value, found) {
            (ReadBack::Skipped, _, _) => true,
            (ReadBack::SameIdentifier, Value::Unsigned32(written), Value::Unsigned32(found)) => {
                let compared = PDO_COB_ID_INVALID | 0x7FF;
                written & compared == found & compared
            }
            (_, written, found) => written == found,
        }
    }
}

/// One drive.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveConfiguration {
    /// The node id on the bus, 1 to 126.
    pub node: NodeId,
    /// What 608Fh:01 must read: counts in [`DriveConfiguration::encoder_revolutions`].
    pub encoder_increments: u32,
    /// What 608Fh:02 must read.
    pub encoder_revolutions: u32,
    /// What 6076h must read.
    pub rated_torque: RatedTorque,
    /// What is written beyond what the protocol needs, in this order; data of the robot file, since drives differ.
    pub settings: Settings,
}

/// Who sends heartbeats how often, and how long silence is borne; whole milliseconds, as 1016h and 1017h hold them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Heartbeats {
    drive_period: u16,
    drive_timeout: Duration,
    master_period: Duration,
    master_timeout: u16,
}

impl Heartbeats {
    /// Drives send every `drive_period` and are lost after `drive_timeout`; the master sends every `master_period` and
    /// drives brake by themselves after `master_timeout` without it.
    ///
    /// # Errors
    /// [`ConfigurationError::Heartbeat`] unless all are whole milliseconds, 1 … 65535, and each timeout is longer than
    /// its period.
    pub fn new(
        drive_period: Duration,
        drive_timeout: Duration,
        master_period: Duration,
        master_timeout: Duration,
    ) -> Result<Self, ConfigurationError> {
        for (period, timeout) in [(drive_period, drive_timeout), (master_period, master_timeout)] {
            if whole_milliseconds(period).is_none() || whole_milliseconds(timeout).is_none() || timeout <= period {
                return Err(ConfigurationError::Heartbeat { period, timeout });
            }
        }
        Ok(Self {
            drive_period: whole_milliseconds(drive_period).unwrap_or(u16::MAX),
            drive_timeout,
            master_period,
            master_timeout: whole_milliseconds(master_timeout).unwrap_or(u16::MAX),
        })
    }

    /// After this long without a heartbeat a drive is lost.
    pub const fn drive_timeout(&self) -> Duration {
        self.drive_timeout
    }

    /// How often the master sends one.
    pub const fn master_period(&self) -> Duration {
        self.master_period
    }

    /// After this long without the master a drive brakes.
    pub fn master_timeout(&self) -> Duration {
        Duration::from_millis(self.master_timeout.into())
    }
}

impl Default for Heartbeats {
    /// Drives every 50 ms, lost after 200 ms; master every 20 ms, lost after 100 ms: four or five in a row must fail.
    fn default() -> Self {
        Self {
            drive_period: 50,
            drive_timeout: Duration::from_millis(200),
            master_period: Duration::from_millis(20),
            master_timeout: 100,
        }
    }
}

fn whole_milliseconds(duration: Duration) -> Option<u16> {
    let milliseconds = u16::try_from(duration.as_millis()).ok().filter(|milliseconds| *milliseconds > 0)?;
    (Duration::from_millis(milliseconds.into()) == duration).then_some(milliseconds)
}

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
            power_poll: Duration::from_millis(2),
        }
    }
}

/// Whether the SYNC carries its counter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SyncPayload {
    /// One byte, 1 … 240; 1019h is set.
    #[default]
    Counter,
    /// None, for drives without 1019h.
    Empty,
}

impl SyncPayload {
    /// The value of 1019h.
    pub(super) const fn overflow(self) -> u8 {
        match self {
            Self::Counter => SYNC_COUNTER_OVERFLOW,
            Self::Empty => 0,
        }
    }
}

/// What an emergency message of a drive does in the cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EmergencyReaction {
    /// It is an error, unless it says that an error is over.
    #[default]
    Stop,
    /// It is kept in the health record only; the statusword decides.
    Record,
}

/// The whole network.
#[derive(Clone, Debug, PartialEq)]
pub struct NetworkConfiguration<const JOINTS: usize> {
    drives: [DriveConfiguration; JOINTS],
    interpolation_time: (u8, i8),
    /// Heartbeats in both directions.
    pub heartbeats: Heartbeats,
    /// How long steps may take.
    pub timeouts: Timeouts,
    /// The SYNC's counter.
    pub sync_payload: SyncPayload,
    /// What emergencies do.
    pub emergency_reaction: EmergencyReaction,
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
    #[error(
        "a heartbeat every {period:?} with a timeout of {timeout:?}: whole milliseconds, 1 to 65535, the timeout longer than the period"
    )]
    Heartbeat {
        /// The period of the heartbeat.
        period: Duration,
        /// How long its absence is borne.
        timeout: Duration,
    },
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
        let interpolation_time = interpolation_time(period).ok_or(ConfigurationError::Period { period })?;
        Ok(Self {
            drives,
            interpolation_time,
            heartbeats: Heartbeats::default(),
            timeouts: Timeouts::default(),
            sync_payload: SyncPayload::default(),
            emergency_reaction: EmergencyReaction::default(),
            earliest_feedback: Duration::ZERO,
        })
    }

    /// The drives, joint 1 first.
    pub const fn drives(&self) -> &[DriveConfiguration; JOINTS] {
        &self.drives
    }

    /// Every identifier that the master listens to: what a link needs for its filters.
    pub fn receive_identifiers(&self) -> impl Iterator<Item = StandardId> {
        self.drives.iter().flat_map(|drive| {
            [Channel::Emergency, Channel::Tpdo1, Channel::SdoResponse, Channel::Heartbeat]
                .map(|channel| channel(drive.node).identifier())
        })
    }

    /// What the protocol itself needs in the drive of `node`, in the order of writing.
    pub fn protocol_settings(&self, node: NodeId) -> impl Iterator<Item = Setting> + use<JOINTS> {
        use objects::*;
        let (time_value, time_exponent) = self.interpolation_time;
        let heartbeat = wire::consumer_heartbeat_entry(self.heartbeats.master_timeout);
        let tpdo1 = u32::from(Channel::Tpdo1(node).identifier().as_raw());
        let rpdo1 = u32::from(Channel::Rpdo1(node).identifier().as_raw());
        let [statusword, position] = wire::TPDO1_MAPPING.map(mapped);
        let [controlword, torque] = wire::RPDO1_MAPPING.map(mapped);
        [
            Setting::of(&MODE_OF_OPERATION, Value::Integer8(CYCLIC_SYNCHRONOUS_TORQUE)),
            Setting::of(&INTERPOLATION_TIME_VALUE, Value::Unsigned8(time_value)),
            Setting::of(&INTERPOLATION_TIME_EXPONENT, Value::Integer8(time_exponent)),
            // A mapping may be changed only while its PDO is off and its count is zero (CiA 301).
            Setting::identifier(&TPDO1_IDENTIFIER, PDO_COB_ID_INVALID | tpdo1),
            Setting::of(&TPDO1_MAPPED_OBJECTS, Value::Unsigned8(0)),
            Setting::of(&TPDO1_FIRST_OBJECT, statusword),
            Setting::of(&TPDO1_SECOND_OBJECT, position),
            Setting::of(&TPDO1_MAPPED_OBJECTS, Value::Unsigned8(2)),
            Setting::of(&TPDO1_TRANSMISSION_TYPE, Value::Unsigned8(wire::TPDO1_TRANSMISSION.to_byte())),
            Setting::identifier(&TPDO1_IDENTIFIER, tpdo1),
            Setting::identifier(&RPDO1_IDENTIFIER, PDO_COB_ID_INVALID | rpdo1),
            Setting::of(&RPDO1_MAPPED_OBJECTS, Value::Unsigned8(0)),
            Setting::of(&RPDO1_FIRST_OBJECT, controlword),
            Setting::of(&RPDO1_SECOND_OBJECT, torque),
            Setting::of(&RPDO1_MAPPED_OBJECTS, Value::Unsigned8(2)),
            Setting::of(&RPDO1_TRANSMISSION_TYPE, Value::Unsigned8(wire::RPDO1_TRANSMISSION.to_byte())),
            Setting::identifier(&RPDO1_IDENTIFIER, rpdo1),
            Setting::of(&PRODUCER_HEARTBEAT_TIME, Value::Unsigned16(self.heartbeats.drive_period)),
            Setting::of(&CONSUMER_HEARTBEAT_TIME, Value::Unsigned32(heartbeat)),
        ]
        .into_iter()
        .chain(match self.sync_payload {
            SyncPayload::Counter => {
                Some(Setting::of(&SYNC_COUNTER_OVERFLOW, Value::Unsigned8(self.sync_payload.overflow())))
            }
            SyncPayload::Empty => None,
        })
    }
}

fn mapped(entry: MappingEntry) -> Value {
    Value::Unsigned32(entry.to_u32())
}

/// `period` as value · 10^exponent s, with the largest exponent that is exact.
pub(super) fn interpolation_time(period: Duration) -> Option<(u8, i8)> {
    let mut value = period.as_nanos();
    let mut exponent = -9_i8;
    while value != 0 && value.is_multiple_of(10) {
        value /= 10;
        exponent += 1;
    }
    let value = u8::try_from(value).ok().filter(|value| *value > 0)?;
    Some((value, exponent))
}
