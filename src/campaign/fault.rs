//! What happens in a trial.

use std::fmt;
use std::time::Duration;

use uarm_sim::DriveFault;

use crate::study::random::Stream;

/// What happens to a drive, to a frame, to the interface or to the controller's computer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Nothing: a run without a fault must not end early.
    Nothing,
    /// Somebody asks for the end.
    StopRequest,
    /// The drive itself.
    Drive(DriveFault),
    /// The drive's feedback does not arrive, for so many cycles in a row.
    FeedbackLost {
        /// Cycles without feedback.
        cycles: u64,
    },
    /// The drive's feedback arrives twice.
    FeedbackTwice,
    /// The last byte of the drive's feedback is missing, once.
    FeedbackShort,
    /// Somebody sends what only this controller may send.
    Foreign(ForeignFault),
    /// The drive's boot-up message is on the bus.
    BootUp,
    /// An emergency message of the drive, with so many data bytes.
    Emergency {
        /// Data bytes; the standard's have eight.
        bytes: u8,
    },
    /// The interface refuses one frame.
    LinkRefusesOnce,
    /// The interface refuses every frame from now on.
    LinkDown,
    /// The controller's computer stands still.
    Suspended {
        /// For how long.
        duration: Duration,
    },
}

/// What another master sends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ForeignFault {
    /// A SYNC.
    Sync,
    /// A heartbeat of the controller's node id.
    Heartbeat,
    /// Full torque to the drive.
    Torque,
    /// NMT stop to all nodes.
    NmtStop,
    /// NMT reset to the drive.
    NmtReset,
}

/// Longest standstill of the controller's computer that is drawn: four times what the drives' watchdogs bear.
const LONGEST_SUSPENSION: Duration = Duration::from_millis(200);
/// The shortest as a share of that: 0.2 ms.
const SHORTEST_SUSPENSION_SHARE: f64 = 1e-3;
/// Most cycles in a row that lose their feedback.
const MOST_LOST: f64 = 6.0;
/// Largest jump of a counter that is drawn, counts: half a revolution of the paper's encoders.
const LARGEST_JUMP: f64 = 16_000.0;

/// Least and most counts in a cycle by which a counter drifts that is drawn: fewer look like a joint that turns.
const DRIFTS: [f64; 2] = [20.0, 200.0];

impl Fault {
    /// One fault of each kind, for the list of kinds and to be drawn from.
    const KINDS: [Self; 27] = [
        Self::Nothing,
        Self::StopRequest,
        Self::Drive(DriveFault::PowerLost),
        Self::Drive(DriveFault::BusDisconnected),
        Self::Drive(DriveFault::EncoderJump { counts: 0 }),
        Self::Drive(DriveFault::EncoderStuck),
        Self::Drive(DriveFault::EncoderReversed),
        Self::Drive(DriveFault::EncoderDrift { counts: 0 }),
        Self::Drive(DriveFault::TorqueReversed),
        Self::Drive(DriveFault::OverTemperature),
        Self::Drive(DriveFault::BrakeStuckEngaged),
        Self::Drive(DriveFault::BrakeStuckReleased),
        Self::Drive(DriveFault::MotorDisconnected),
        Self::FeedbackLost { cycles: 0 },
        Self::FeedbackTwice,
        Self::FeedbackShort,
        Self::Foreign(ForeignFault::Sync),
        Self::Foreign(ForeignFault::Heartbeat),
        Self::Foreign(ForeignFault::Torque),
        Self::Foreign(ForeignFault::NmtStop),
        Self::Foreign(ForeignFault::NmtReset),
        Self::BootUp,
        Self::Emergency { bytes: 8 },
        Self::Emergency { bytes: 0 },
        Self::LinkRefusesOnce,
        Self::LinkDown,
        Self::Suspended { duration: Duration::ZERO },
    ];

    /// A fault of a kind, with its size drawn.
    pub fn draw(stream: &mut Stream) -> Self {
        match Self::KINDS[stream.below(Self::KINDS.len())] {
            Self::Drive(DriveFault::EncoderJump { .. }) => {
                // Small jumps are the hard ones: as many between 10 and 100 counts as between 1000 and 10000.
                let size = LARGEST_JUMP.powf(stream.uniform(0.0, 1.0)).round();
                let sign = if stream.below(2) == 0 { -1.0 } else { 1.0 };
                Self::Drive(DriveFault::EncoderJump { counts: (sign * size) as i32 })
            }
            Self::Drive(DriveFault::EncoderDrift { .. }) => {
                let [least, most] = DRIFTS;
                let sign = if stream.below(2) == 0 { -1.0 } else { 1.0 };
                Self::Drive(DriveFault::EncoderDrift { counts: (sign * stream.uniform(least, most)) as i32 })
            }
            Self::FeedbackLost { .. } => Self::FeedbackLost { cycles: stream.uniform(1.0, MOST_LOST) as u64 },
            Self::Emergency { bytes: 0 } => {
                Self::Emergency { bytes: u8::try_from(stream.below(8)).unwrap_or_default() }
            }
            Self::Suspended { .. } => {
                // As many within a period as beyond the watchdogs.
                let share = SHORTEST_SUSPENSION_SHARE.powf(stream.uniform(0.0, 1.0));
                Self::Suspended { duration: LONGEST_SUSPENSION.mul_f64(share) }
            }
            other => other,
        }
    }

    /// The kind in kebab case: what trials are counted by.
    pub const fn kind(self) -> &'static str {
        match self {
            Self::Nothing => "nothing",
            Self::StopRequest => "stop-request",
            Self::Drive(fault) => match fault {
                DriveFault::PowerLost => "power-lost",
                DriveFault::BusDisconnected => "bus-disconnected",
                DriveFault::EncoderJump { .. } => "encoder-jump",
                DriveFault::EncoderStuck => "encoder-stuck",
                DriveFault::EncoderReversed => "encoder-reversed",
                DriveFault::EncoderDrift { .. } => "encoder-drift",
                DriveFault::TorqueReversed => "torque-reversed",
                DriveFault::OverTemperature => "over-temperature",
                DriveFault::BrakeStuckEngaged => "brake-stuck-engaged",
                DriveFault::BrakeStuckReleased => "brake-stuck-released",
                DriveFault::MotorDisconnected => "motor-disconnected",
                _ => "other-drive-fault",
            },
            Self::FeedbackLost { .. } => "feedback-lost",
            Self::FeedbackTwice => "feedback-twice",
            Self::FeedbackShort => "feedback-short",
            Self::Foreign(ForeignFault::Sync) => "foreign-sync",
            Self::Foreign(ForeignFault::Heartbeat) => "foreign-heartbeat",
            Self::Foreign(ForeignFault::Torque) => "foreign-torque",
            Self::Foreign(ForeignFault::NmtStop) => "foreign-nmt-stop",
            Self::Foreign(ForeignFault::NmtReset) => "foreign-nmt-reset",
            Self::BootUp => "boot-up",
            Self::Emergency { .. } => "emergency",
            Self::LinkRefusesOnce => "link-refuses-once",
            Self::LinkDown => "link-down",
            Self::Suspended { .. } => "suspended",
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kind = self.kind();
        match self {
            Self::Drive(DriveFault::EncoderJump { counts }) => write!(formatter, "{kind} of {counts} counts"),
            Self::Drive(DriveFault::EncoderDrift { counts }) => write!(formatter, "{kind} of {counts} counts a cycle"),
            Self::FeedbackLost { cycles } => write!(formatter, "{kind} for {cycles} cycles"),
            Self::Emergency { bytes } => write!(formatter, "{kind} of {bytes} bytes"),
            Self::Suspended { duration } => write!(formatter, "{kind} for {duration:?}"),
            _ => formatter.write_str(kind),
        }
    }
}
