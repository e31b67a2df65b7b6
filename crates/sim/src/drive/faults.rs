//! What can go wrong with a drive, for tests and demonstrations to bring about.

use core::time::Duration;

/// A fault that a test injects. They last until they are repaired.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum DriveFault {
    /// The drive loses its supply: it falls silent, its torque is gone and its brake closes.
    PowerLost,
    /// The drive's plug comes off the bus: it hears and says nothing, and goes on by itself.
    BusDisconnected,
    /// The counter jumps once by so many counts.
    EncoderJump {
        /// The jump, counts.
        counts: i32,
    },
    /// The counter stands still.
    EncoderStuck,
    /// From where it is, the counter goes the other way.
    EncoderReversed,
    /// At each SYNC the counter goes so many counts further than the joint.
    EncoderDrift {
        /// Counts per SYNC.
        counts: i32,
    },
    /// At each SYNC the counter is off by so many counts, in turn one way and the other.
    EncoderGlitch {
        /// The error, counts.
        counts: i32,
    },
    /// The motor's torque has the wrong sign.
    TorqueReversed,
    /// So many answers to SYNC are lost.
    FeedbackLost {
        /// The SYNCs that are not answered.
        syncs: u32,
    },
    /// Answers to SYNC come so much later.
    FeedbackLate {
        /// The delay; of answers that overtake each other, only the newest is sent.
        by: Duration,
    },
    /// Each answer to SYNC is preceded by the one before, as if somebody replayed it.
    FeedbackReplayed,
    /// The drive ignores its target torque, stays in *Operation enabled*, and says so in bit 12 of its statusword.
    TargetIgnored,
    /// The motor is too hot: EMCY 4210h and fault. A fault reset has no effect before the repair.
    OverTemperature,
    /// 6079h reads so.
    SupplyVoltage {
        /// The DC link circuit voltage, mV.
        millivolts: u32,
    },
    /// 2010h reads so; the drive does nothing about it.
    Temperature {
        /// Of the motor, 0.1 °C.
        tenths: i16,
    },
    /// The drive answers no SDO request any more.
    SdoSilent,
    /// The brake does not open.
    BrakeStuckEngaged,
    /// The brake does not close.
    BrakeStuckReleased,
    /// The motor's cable is broken: the drive reports its torque, the joint feels none.
    MotorDisconnected,
}

/// The faults that a drive has.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Faults {
    pub(super) power_lost: bool,
    pub(super) bus_disconnected: bool,
    pub(super) encoder_stuck: bool,
    pub(super) encoder_reversed: bool,
    /// The count at which it was reversed.
    pub(super) turning_count: Option<i32>,
    pub(super) encoder_drift: i32,
    /// The error at the next SYNC, counts.
    pub(super) encoder_glitch: i32,
    pub(super) torque_reversed: bool,
    pub(super) feedback_lost: u32,
    pub(super) feedback_late: Duration,
    pub(super) feedback_replayed: bool,
    pub(super) target_ignored: bool,
    pub(super) over_temperature: bool,
    /// mV.
    pub(super) supply_voltage: Option<u32>,
    /// 0.1 °C.
    pub(super) temperature: Option<i16>,
    pub(super) sdo_silent: bool,
    pub(super) brake_stuck_engaged: bool,
    pub(super) brake_stuck_released: bool,
    pub(super) motor_disconnected: bool,
    /// Sum of all jumps, counts.
    pub(super) encoder_offset: i32,
}

impl Faults {
    /// Adds a fault.
    pub(super) fn add(&mut self, fault: DriveFault) {
        match fault {
            DriveFault::PowerLost => self.power_lost = true,
            DriveFault::BusDisconnected => self.bus_disconnected = true,
            DriveFault::EncoderJump { counts } => self.encoder_offset = self.encoder_offset.wrapping_add(counts),
            DriveFault::EncoderStuck => self.encoder_stuck = true,
            DriveFault::EncoderReversed => self.encoder_reversed = true,
            DriveFault::EncoderDrift { counts } => self.encoder_drift = counts,
            DriveFault::EncoderGlitch { counts } => self.encoder_glitch = counts,
            DriveFault::TorqueReversed => self.torque_reversed = true,
            DriveFault::FeedbackLost { syncs } => self.feedback_lost = syncs,
            DriveFault::FeedbackLate { by } => self.feedback_late = by,
            DriveFault::FeedbackReplayed => self.feedback_replayed = true,
            DriveFault::TargetIgnored => self.target_ignored = true,
            DriveFault::OverTemperature => self.over_temperature = true,
            DriveFault::SupplyVoltage { millivolts } => self.supply_voltage = Some(millivolts),
            DriveFault::Temperature { tenths } => self.temperature = Some(tenths),
            DriveFault::SdoSilent => self.sdo_silent = true,
            DriveFault::BrakeStuckEngaged => self.brake_stuck_engaged = true,
            DriveFault::BrakeStuckReleased => self.brake_stuck_released = true,
            DriveFault::MotorDisconnected => self.motor_disconnected = true,
        }
    }

    /// What the counter shows at a SYNC where it should show `counts`.
    pub(super) fn counted(&mut self, counts: i32) -> i32 {
        self.encoder_offset = self.encoder_offset.wrapping_add(self.encoder_drift);
        self.encoder_glitch = self.encoder_glitch.wrapping_neg();
        let counts = counts.wrapping_add(self.encoder_offset).wrapping_add(self.encoder_glitch);
        if !self.encoder_reversed {
            return counts;
        }
        let turned_at = *self.turning_count.get_or_insert(counts);
        turned_at.wrapping_sub(counts.wrapping_sub(turned_at))
    }

    /// Nothing reaches the bus, and nothing comes from it.
    pub(super) const fn off_bus(&self) -> bool {
        self.power_lost || self.bus_disconnected
    }
}
