//! What a drive remembers of its homing: method, phase, and what it sees of index and switches.

use super::speed_loop::SpeedLoop;
use uarm_io::drive::cia402::Statusword;
use uarm_io::time::Instant;

/// A direction, as the drive counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    Negative,
    Positive,
}

impl Way {
    pub(super) const fn sign(self) -> f64 {
        match self {
            Self::Negative => -1.0,
            Self::Positive => 1.0,
        }
    }

    pub(super) const fn back(self) -> Self {
        match self {
            Self::Negative => Self::Positive,
            Self::Positive => Self::Negative,
        }
    }
}

/// A homing method (CiA 402-2, 6098h).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum HomingMethod {
    /// 17, 18: the inner edge of the limit switch on this side.
    LimitSwitch(Way),
    /// 33, 34: the next index this way.
    Index(Way),
    /// 35, 37: where the joint stands.
    Here,
}

impl HomingMethod {
    /// The method with this number; `None` for one that the emulation does not know.
    pub(super) const fn of(number: i128) -> Option<Self> {
        Some(match number {
            17 => Self::LimitSwitch(Way::Negative),
            18 => Self::LimitSwitch(Way::Positive),
            33 => Self::Index(Way::Negative),
            34 => Self::Index(Way::Positive),
            35 | 37 => Self::Here,
            _ => return None,
        })
    }
}

/// What the motor's surroundings show, as the drive counts.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sight {
    /// The counter, without its origin.
    pub(super) counts: i32,
    /// Whole revolutions of the motor from its angle zero: where they change is the index.
    pub(super) revolution: i64,
    /// The limit switches: negative, positive.
    pub(super) switches: [bool; 2],
}

/// How far it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Phase {
    #[default]
    Idle,
    /// Towards the switch.
    SeekSwitch(Way),
    /// Off the switch, which is on this side.
    LeaveSwitch(Way),
    /// Towards the index; the revolution in which it began.
    SeekIndex(Way, i64),
    Done,
    Failed,
}

impl Phase {
    pub(super) const fn moves(self) -> bool {
        matches!(self, Self::SeekSwitch(_) | Self::LeaveSwitch(_) | Self::SeekIndex(..))
    }
}

/// A homing procedure, and the loop that moves the motor for it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Homing {
    pub(super) phase: Phase,
    pub(super) speed: SpeedLoop,
    /// Since when the motor stands though it should turn.
    pub(super) stalled_since: Option<Instant>,
}

impl Homing {
    /// Per mille of the rated torque.
    pub(super) const fn torque(&self) -> i16 {
        self.speed.torque()
    }

    /// Bits 10, 12 and 13 of the statusword.
    pub(super) const fn status(&self) -> u16 {
        let stands = if self.speed.stands() { Statusword::TARGET_REACHED } else { 0 };
        match self.phase {
            Phase::Idle => Statusword::TARGET_REACHED,
            Phase::SeekSwitch(_) | Phase::LeaveSwitch(_) | Phase::SeekIndex(..) => 0,
            Phase::Done => Statusword::HOMING_ATTAINED | stands,
            Phase::Failed => Statusword::HOMING_ERROR | stands,
        }
    }
}
