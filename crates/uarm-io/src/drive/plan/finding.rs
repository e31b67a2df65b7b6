//! What a plan says of a drive: one finding for each question that is asked of every drive.

use crate::drive::pdo_objects::{PdoKind, PdoNumber};
use crate::drive::survey::Answer;
use crate::drive::wishes::{Setting, TorqueApplies};
use crate::drive::words::{Named, type_name};
use canopen_rs::{Address, DataType, Value};
use core::fmt;

/// Declares the questions, in the order in which they are answered and printed.
macro_rules! questions {
    ($($(#[$doc:meta])* $name:ident: $title:literal, $objects:literal;)*) => {
        /// A question that is asked of every drive: a row of `docs/wire.md`, section 10.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Question {
            $($(#[$doc])* $name,)*
        }

        impl Question {
            /// All of them, in their order.
            pub const ALL: &[Self] = &[$(Self::$name),*];

            /// The question, as printed.
            pub const fn title(self) -> &'static str {
                match self {
                    $(Self::$name => $title,)*
                }
            }

            /// The objects that answer it.
            pub const fn objects(self) -> &'static str {
                match self {
                    $(Self::$name => $objects,)*
                }
            }
        }
    };
}

questions! {
    /// Device profile.
    DeviceType: "Is it a CiA 402 drive?", "1000h";
    /// Vendor, product, revision, serial number.
    Identity: "Which drive is it?", "1018h:01 to :04";
    /// Cyclic synchronous torque.
    Mode: "Does it know *cyclic synchronous torque*?", "6502h, 6060h, 6061h";
    /// Controlword, statusword, target torque.
    CyclicObjects: "Does it have what the cycle carries?", "6040h, 6041h, 6064h, 6071h";
    /// What per mille of target torque are of.
    RatedTorque: "To what does the target torque refer?", "6071h, 6076h, 6075h";
    /// The drive's own torque and current limits.
    TorqueLimits: "How does it limit torque and current by itself?", "6072h, 6073h";
    /// Counts per revolution.
    Resolution: "How many counts has a revolution of the encoder?", "608Fh:01, :02";
    /// Gear and user units in the drive.
    PositionUnits: "Is 6064h in counts, with no gear or unit of the drive between?", "6091h, 6092h";
    /// Signs in the drive.
    Polarity: "Does it leave the signs alone?", "607Eh";
    /// Objects that the robot file sets.
    Writes: "Can it take what the robot file writes?", "`drive.writes`";
    /// Every PDO that the cycle does not use.
    OtherPdos: "Are the PDOs off that the cycle does not use?", "1400h ff., 1800h ff.";
    /// The RPDO of commands.
    Command: "Can an RPDO carry controlword and target torque?", "1400h ff., 1600h ff.";
    /// The TPDO of feedback.
    Feedback: "Can a TPDO carry statusword and position at each SYNC?", "1800h ff., 1A00h ff.";
    /// The TPDO of torque feedback.
    TorqueFeedback: "Can a second TPDO carry the torque, if it is wanted?", "6077h, 1801h ff., 1A01h ff.";
    /// SYNC.
    Sync: "Does it take the SYNC, with or without counter?", "1005h, 1019h";
    /// Interpolation time.
    Period: "Does it take the period?", "60C2h:01, :02";
    /// The drive's heartbeat.
    DriveHeartbeat: "Does it send a heartbeat?", "1017h";
    /// Emergency messages.
    Emergency: "Does it send its emergencies where they are heard?", "1014h";
    /// The last line of defence.
    Watchdog: "Does it notice that its master is gone?", "1016h:01, or 1400h:05";
    /// What it then does.
    LossReaction: "What does it do then?", "6007h";
    /// What quick stop does.
    QuickStop: "What does its quick stop do?", "605Ah";
    /// Homing.
    Homing: "Can it home by itself?", "6098h";
    /// Supply voltage and temperature.
    Readings: "Can it be asked in a run for what is watched?", "6079h, `drive.temperature_c`";
    /// What tells of a loss of power.
    PowerMarker: "Is it seen that it has lost its power, where its encoder is incremental?", "`encoder.power_marker`, or a bit of 6041h";
}

/// What a finding comes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// It works.
    Works,
    /// It works with what the remedy says, or it is known only when the drive itself is asked.
    WorksWith,
    /// It cannot work.
    Cannot,
}

impl fmt::Display for Verdict {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Works => "works",
            Self::WorksWith => "works with what is said",
            Self::Cannot => "cannot",
        })
    }
}

/// What a drive should say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// This number.
    Number(i64),
    /// In words.
    Words(&'static str),
    /// An object of this type with which this can be done.
    Type(DataType, &'static str),
}

impl fmt::Display for Wanted {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(value) => Answer::Number(*value).fmt(formatter),
            Self::Words(words) => formatter.write_str(words),
            Self::Type(data_type, words) => write!(formatter, "{words}, of type {}", type_name(*data_type)),
        }
    }
}

/// What helps. Robot-file keys are those of the joint, unless their table is named.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Remedy {
    /// Nothing is needed.
    None,
    /// Nothing is owed before a start; this is to be known.
    Note(&'static str),
    /// What no robot file can help: how else it may be helped.
    Outside(&'static str),
    /// Something in the robot file that depends on more than this drive.
    RobotFile(&'static str),
    /// An entry of `drive.writes`.
    Write(Setting),
    /// `encoder.counts_per_revolution`, if the drive is right; an entry of `drive.writes` if the file is.
    CountsPerRevolution(u32),
    /// `encoder.resolution_object = "absent"`.
    ResolutionStated,
    /// `drive.rated_torque_unit = "uNm"`.
    MicronewtonMetres,
    /// `drive.rated_torque_nm`, as the drive counts it in 6076h, if the drive is right.
    RatedTorque(u32),
    /// `drive.rated_current_ma`, as the drive has it in 6075h, if the drive is right.
    RatedCurrent(u32),
    /// `drive.target_torque_of = "stated-torque"`.
    TorqueStated,
    /// The number of the PDO that carries what is wanted: `drive.pdo`.
    PdoNumber(PdoKind, PdoNumber),
    /// The transmission type of the RPDO of commands, as the drive has it: `drive.torque_applies`, and
    /// `drive.pdo.rpdo_transmission` where that alone does not say it.
    CommandTransmission(u8),
    /// A PDO that cannot be switched off: `drive.pdo.keep_rpdos` or `keep_tpdos`.
    KeepPdo(PdoKind, PdoNumber),
    /// `[bus] sync_counter = "auto"`.
    SyncWithoutCounter,
    /// `[bus] drive_heartbeat_ms`, as the drive has it.
    DriveHeartbeat(u16),
    /// `[control] period_us`, as the drive has it.
    Period(u32),
    /// `drive.watchdog = "rpdo-timeout"`.
    RpdoTimeout,
    /// `drive.without_6007h`, with the reason.
    ExplainAbortOption,
}

impl Remedy {
    /// True if a start is refused until it is done.
    pub const fn is_owed(&self) -> bool {
        !matches!(self, Self::None | Self::Note(_))
    }
}

impl fmt::Display for Remedy {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => formatter.write_str("nothing"),
            Self::Note(words) | Self::Outside(words) | Self::RobotFile(words) => formatter.write_str(words),
            Self::Write(setting) => write!(formatter, "drive.writes: {}", WriteEntry(setting)),
            Self::CountsPerRevolution(counts) => write!(
                formatter,
                "encoder.counts_per_revolution = {counts} if the drive is right; if the robot file is, write 608Fh in drive.writes"
            ),
            Self::ResolutionStated => formatter.write_str("encoder.resolution_object = \"absent\""),
            Self::MicronewtonMetres => formatter.write_str("drive.rated_torque_unit = \"uNm\""),
            Self::RatedTorque(raw) => write!(
                formatter,
                "drive.rated_torque_nm that makes {raw} in the unit of 6076h if the drive is right; if the robot file is, write 6076h in drive.writes"
            ),
            Self::RatedCurrent(milliamperes) => write!(
                formatter,
                "drive.rated_current_ma = {milliamperes} if the drive is right; if the robot file is, write 6075h in drive.writes"
            ),
            Self::TorqueStated => formatter.write_str("drive.target_torque_of = \"stated-torque\""),
            Self::PdoNumber(PdoKind::Receive, number) => write!(formatter, "drive.pdo.rpdo = {}", number.get()),
            Self::PdoNumber(PdoKind::Transmit, number) => write!(formatter, "drive.pdo.tpdo = {}", number.get()),
            Self::CommandTransmission(transmission) => {
                let applies = TorqueApplies::of_transmission_type(*transmission).unwrap_or_default();
                let name = match applies {
                    TorqueApplies::OnReception => "on-reception",
                    TorqueApplies::AtSync => "at-sync",
                };
                write!(formatter, "drive.torque_applies = \"{name}\"")?;
                if applies.transmission_type() == *transmission {
                    return Ok(());
                }
                write!(formatter, " and drive.pdo.rpdo_transmission = {transmission}")
            }
            Self::KeepPdo(PdoKind::Receive, number) => write!(formatter, "drive.pdo.keep_rpdos = [{}]", number.get()),
            Self::KeepPdo(PdoKind::Transmit, number) => write!(formatter, "drive.pdo.keep_tpdos = [{}]", number.get()),
            Self::SyncWithoutCounter => formatter.write_str("[bus] sync_counter = \"auto\""),
            Self::DriveHeartbeat(milliseconds) => write!(formatter, "[bus] drive_heartbeat_ms = {milliseconds}"),
            Self::Period(microseconds) => write!(formatter, "[control] period_us = {microseconds}"),
            Self::RpdoTimeout => formatter.write_str("drive.watchdog = \"rpdo-timeout\""),
            Self::ExplainAbortOption => {
                formatter.write_str("drive.without_6007h = \"how it is known that it brakes without its master\"")
            }
        }
    }
}

/// A setting as an entry of `drive.writes` in a robot file.
#[derive(Clone, Copy, Debug)]
pub struct WriteEntry<'a>(pub &'a Setting);

impl fmt::Display for WriteEntry<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Setting { address: Address { index, subindex }, value, .. } = self.0;
        let data_type = type_name(value.data_type());
        let number = Answer::of(*value).number().unwrap_or_default();
        write!(
            formatter,
            "{{ index = 0x{index:04X}, subindex = {subindex}, type = \"{data_type}\", value = {number} }}"
        )
    }
}

/// One row: what was asked, what was found, what was wanted, and what helps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finding {
    /// The question.
    pub question: Question,
    /// The object that decided.
    pub object: Address,
    /// What it says.
    pub found: Answer,
    /// What it should say.
    pub wanted: Wanted,
    /// What helps.
    pub remedy: Remedy,
    /// What it comes to.
    pub verdict: Verdict,
}

impl Finding {
    /// True if a drive with this finding must not be started.
    pub fn refuses_start(&self) -> bool {
        self.verdict == Verdict::Cannot || self.remedy.is_owed()
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{} is {}, expected {}", Named(self.object), self.found, self.wanted)?;
        match self.remedy {
            Remedy::None => Ok(()),
            remedy => write!(formatter, ": {remedy}"),
        }
    }
}

/// `number` as a value of `data_type`; `None` if it does not fit, or the type is none of whole numbers up to 32 bits.
pub fn value_of(data_type: DataType, number: i64) -> Option<Value> {
    match data_type {
        DataType::Unsigned8 => u8::try_from(number).ok().map(Value::Unsigned8),
        DataType::Unsigned16 => u16::try_from(number).ok().map(Value::Unsigned16),
        DataType::Unsigned32 => u32::try_from(number).ok().map(Value::Unsigned32),
        DataType::Integer8 => i8::try_from(number).ok().map(Value::Integer8),
        DataType::Integer16 => i16::try_from(number).ok().map(Value::Integer16),
        DataType::Integer32 => i32::try_from(number).ok().map(Value::Integer32),
        _ => None,
    }
}
