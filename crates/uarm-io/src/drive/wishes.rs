//! What a robot wants of one drive and of the bus that they share, before anything is known of the drive.

use super::objects::{self, Object};
use super::pdo_objects::{PdoKind, PdoNumber};
use super::readings::Readings;
use super::wire::{Channel, SYNC_COUNTER_OVERFLOW};
use crate::torque::{RatedTorque, TorqueCeiling};
use canopen_rs::pdo::PDO_COB_ID_INVALID;
use canopen_rs::{Address, NodeId, Value};
use core::time::Duration;
use embedded_can::StandardId;

/// The most objects that a robot file can set in one drive, before and after those of the protocol each.
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

    /// `object`, which must read as written.
    pub const fn of(object: &Object, value: Value) -> Self {
        Self::new(object.address(), value)
    }

    /// An identifier: see [`ReadBack::SameIdentifier`].
    pub const fn identifier(object: &Object, value: u32) -> Self {
        Self { address: object.address(), value: Value::Unsigned32(value), read_back: ReadBack::SameIdentifier }
    }

    /// True if `found` is as good as what was written.
    pub fn agrees(&self, found: Value) -> bool {
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

/// Where the counts of a revolution are read in the drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Resolution {
    /// In 608Fh: :01 counts in :02 revolutions.
    #[default]
    Standard,
    /// Nowhere: the robot file alone says it.
    Stated,
    /// An object of the maker's.
    Object {
        /// Where it is.
        address: Address,
        /// What it must read.
        equals: i64,
    },
}

/// What the per mille of target torque 6071h are of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TorqueReference {
    /// Of 6076h, which must read as the robot file's rated torque.
    #[default]
    RatedTorque,
    /// Of the robot file's rated torque, which the drive states nowhere.
    StatedTorque,
    /// Of the rated current 6075h, which must read as this many mA; the robot file's rated torque is the torque at it.
    RatedCurrent {
        /// The rated current, mA.
        milliamperes: u32,
    },
}

/// When a drive applies the torque of an RPDO.
///
/// With the feature `serde` it is the text `"on-reception"` or `"at-sync"`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum TorqueApplies {
    /// When the frame comes: transmission type 255.
    #[default]
    OnReception,
    /// At the next SYNC, a period later: transmission type 1.
    AtSync,
}

impl TorqueApplies {
    /// The transmission type of the RPDO.
    pub const fn transmission_type(self) -> u8 {
        match self {
            Self::OnReception => 255,
            Self::AtSync => 1,
        }
    }

    /// When an RPDO of a transmission type acts (CiA 301): 0 … 240 at the SYNC, 254 and 255 on reception.
    pub const fn of_transmission_type(transmission: u8) -> Option<Self> {
        match transmission {
            0..=240 => Some(Self::AtSync),
            254 | 255 => Some(Self::OnReception),
            _ => None,
        }
    }
}

/// One PDO of the drive that the cycle uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PdoChannel {
    /// Its number in the drive.
    pub number: PdoNumber,
    /// Its identifier on the bus.
    pub identifier: StandardId,
}

/// A PDO of the drive that the cycle does not use and that stays as it is.
pub type KeptPdos = heapless::Vec<(PdoKind, PdoNumber), 8>;

/// The PDOs of a drive.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pdos {
    /// The RPDO of controlword and target torque.
    pub command: PdoChannel,
    /// The TPDO of statusword and position.
    pub feedback: PdoChannel,
    /// The TPDO of torque actual value, where it is wanted.
    pub torque_feedback: Option<PdoChannel>,
    /// What else stays on. Every other PDO is switched off.
    pub kept: KeptPdos,
}

impl Pdos {
    /// RPDO1 and TPDO1 with the identifiers of the predefined connection set, and nothing else.
    pub fn predefined(node: NodeId) -> Self {
        let first = |channel: Channel| PdoChannel { number: PdoNumber::FIRST, identifier: channel.identifier() };
        Self {
            command: first(Channel::Rpdo1(node)),
            feedback: first(Channel::Tpdo1(node)),
            torque_feedback: None,
            kept: KeptPdos::new(),
        }
    }

    /// True if the PDO is one of these.
    pub fn uses(&self, kind: PdoKind, number: PdoNumber) -> bool {
        let of_cycle = match kind {
            PdoKind::Receive => self.command.number == number,
            PdoKind::Transmit => {
                self.feedback.number == number || self.torque_feedback.is_some_and(|pdo| pdo.number == number)
            }
        };
        of_cycle || self.kept.contains(&(kind, number))
    }
}

/// What makes a drive brake by itself when its master is gone: the last line of defence.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Watchdog {
    /// The master's heartbeat, 1016h.
    #[default]
    Heartbeat,
    /// The event timer of the RPDO of commands, 1400h:05.
    RpdoTimeout {
        /// How long a drive bears to get no command, ms.
        milliseconds: u16,
        /// How it is known that the drive then reacts.
        test: WatchdogTest,
    },
}

/// How it is known that a drive reacts to the absence of its commands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WatchdogTest {
    /// The master lets it expire at each start, at *Switched on*, with brakes closed.
    #[default]
    AtStart,
    /// Somebody tried it, and the robot file says how: for drives that react only when enabled.
    ByHand,
}

/// Whether 6007h must say that a drive reacts to the loss of its master.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AbortOption {
    /// It must be there, and not 0.
    #[default]
    Required,
    /// The robot file says why it need not.
    Explained,
}

/// Which drive it must be, by its identity object 1018h; `None` is any.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PinnedIdentity {
    /// 1018h:01.
    pub vendor: Option<u32>,
    /// 1018h:02.
    pub product: Option<u32>,
    /// 1018h:04.
    pub serial: Option<u32>,
}

/// What a drive does in *Operation enabled*: its mode of operation 6060h.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Operation {
    /// It follows a target torque: cyclic synchronous torque.
    #[default]
    CyclicTorque,
    /// It finds its home position by itself.
    Homing(Homing),
}

impl Operation {
    /// The value of 6060h.
    pub const fn mode(self) -> i8 {
        match self {
            Self::CyclicTorque => objects::CYCLIC_SYNCHRONOUS_TORQUE,
            Self::Homing(_) => objects::HOMING,
        }
    }

    /// The bit of 6502h that says that the drive knows it.
    pub const fn supported_bit(self) -> u32 {
        match self {
            Self::CyclicTorque => objects::CYCLIC_SYNCHRONOUS_TORQUE_BIT,
            Self::Homing(_) => objects::HOMING_BIT,
        }
    }
}

/// How a drive finds its home position. Velocities and accelerations are in the drive's own units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Homing {
    /// 6098h.
    pub method: i8,
    /// 6099h:01.
    pub switch_speed: u32,
    /// 6099h:02.
    pub zero_speed: u32,
    /// 609Ah; `None` leaves it as it is.
    pub acceleration: Option<u32>,
    /// 607Ch, counts.
    pub offset: i32,
}

impl Homing {
    /// The objects that say so, and their values.
    pub fn objects(self) -> impl Iterator<Item = (&'static Object, i64)> {
        let always = [
            (&objects::HOMING_METHOD, i64::from(self.method)),
            (&objects::HOMING_SWITCH_SPEED, self.switch_speed.into()),
            (&objects::HOMING_ZERO_SPEED, self.zero_speed.into()),
            (&objects::HOME_OFFSET, self.offset.into()),
        ];
        let acceleration = self.acceleration.map(|acceleration| (&objects::HOMING_ACCELERATION, acceleration.into()));
        always.into_iter().chain(acceleration)
    }
}

/// One drive.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveConfiguration {
    /// The node id on the bus, 1 to 126.
    pub node: NodeId,
    /// Which drive it must be.
    pub identity: PinnedIdentity,
    /// Counts of 6064h in one revolution of the encoder.
    pub counts_per_revolution: u32,
    /// Where the drive states them.
    pub resolution: Resolution,
    /// What 6076h must read.
    pub rated_torque: RatedTorque,
    /// What 6071h refers to.
    pub torque_reference: TorqueReference,
    /// The most that is asked of it, to be compared with its own limit 6072h.
    pub torque_ceiling: TorqueCeiling,
    /// When the torque acts.
    pub torque_applies: TorqueApplies,
    /// Another transmission type for it than [`TorqueApplies::transmission_type`], with the same meaning.
    pub command_transmission: Option<u8>,
    /// Its PDOs.
    pub pdos: Pdos,
    /// What makes it brake when the master is gone.
    pub watchdog: Watchdog,
    /// What 6007h must say.
    pub abort_option: AbortOption,
    /// What it does when it is enabled.
    pub operation: Operation,
    /// What it is asked for in a run beside its motion.
    pub readings: Readings,
    /// What is in the drive as long as it has power, from when its joint was referenced on; a start only looks whether it can be.
    pub power_marker: Option<Setting>,
    /// What is written before the protocol's objects, in this order; data of the robot file, since drives differ.
    pub settings: Settings,
    /// What is written after them.
    pub later_settings: Settings,
}

impl DriveConfiguration {
    /// The drive of `node` with `counts` of 6064h in one revolution of its encoder, everything else at its default.
    pub fn new(node: NodeId, counts: u32, rated_torque: RatedTorque) -> Self {
        Self {
            node,
            identity: PinnedIdentity::default(),
            counts_per_revolution: counts,
            resolution: Resolution::default(),
            rated_torque,
            torque_reference: TorqueReference::default(),
            torque_ceiling: TorqueCeiling::RATED,
            torque_applies: TorqueApplies::default(),
            command_transmission: None,
            pdos: Pdos::predefined(node),
            watchdog: Watchdog::default(),
            abort_option: AbortOption::default(),
            operation: Operation::default(),
            readings: Readings::default(),
            power_marker: None,
            settings: Settings::new(),
            later_settings: Settings::new(),
        }
    }
}

/// Who sends heartbeats how often, and how long silence is borne; whole milliseconds, as 1016h and 1017h hold them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Heartbeats {
    drive_period: u16,
    drive_timeout: Duration,
    master_period: Duration,
    master_timeout: u16,
}

/// Heartbeat times that cannot be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "a heartbeat every {period:?} with a timeout of {timeout:?}: whole milliseconds, 1 to 65535, the timeout longer than the period"
)]
pub struct HeartbeatError {
    /// The period of the heartbeat.
    pub period: Duration,
    /// How long its absence is borne.
    pub timeout: Duration,
}

impl Heartbeats {
    /// Drives send every `drive_period` and are lost after `drive_timeout`; the master sends every `master_period` and
    /// drives brake by themselves after `master_timeout` without it.
    ///
    /// # Errors
    /// [`HeartbeatError`] unless all are whole milliseconds, 1 … 65535, and each timeout is longer than its period.
    pub fn new(
        drive_period: Duration,
        drive_timeout: Duration,
        master_period: Duration,
        master_timeout: Duration,
    ) -> Result<Self, HeartbeatError> {
        for (period, timeout) in [(drive_period, drive_timeout), (master_period, master_timeout)] {
            if whole_milliseconds(period).is_none() || whole_milliseconds(timeout).is_none() || timeout <= period {
                return Err(HeartbeatError { period, timeout });
            }
        }
        Ok(Self {
            drive_period: whole_milliseconds(drive_period).unwrap_or(u16::MAX),
            drive_timeout,
            master_period,
            master_timeout: whole_milliseconds(master_timeout).unwrap_or(u16::MAX),
        })
    }

    /// How often a drive sends one, ms.
    pub const fn drive_period(&self) -> u16 {
        self.drive_period
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

    /// The same in ms, as 1016h holds it.
    pub const fn master_timeout_milliseconds(&self) -> u16 {
        self.master_timeout
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
    pub const fn overflow(self) -> u8 {
        match self {
            Self::Counter => SYNC_COUNTER_OVERFLOW,
            Self::Empty => 0,
        }
    }
}

/// Whether a counter in the SYNC is wanted.
///
/// With the feature `serde` it is the text `"auto"`, `"on"` or `"off"`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum SyncCounterChoice {
    /// If all drives can count, by 1019h.
    #[default]
    Auto,
    /// In any case; a drive without 1019h is refused.
    On,
    /// Never.
    Off,
}

impl SyncCounterChoice {
    /// The SYNC for drives that all can count, or not.
    pub const fn payload(self, all_can_count: bool) -> SyncPayload {
        match (self, all_can_count) {
            (Self::On, _) | (Self::Auto, true) => SyncPayload::Counter,
            (Self::Off, _) | (Self::Auto, false) => SyncPayload::Empty,
        }
    }
}

/// What all drives of a bus share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Protocol {
    /// The period of the SYNC.
    pub period: Duration,
    /// Heartbeats in both directions.
    pub heartbeats: Heartbeats,
    /// Whether the SYNC carries its counter.
    pub sync_payload: SyncPayload,
}
