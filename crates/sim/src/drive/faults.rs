//! What can go wrong with a drive, for tests and demonstrations to bring about.

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
    /// The motor is too hot: EMCY 4210h and fault. A fault reset has no effect before the repair.
    OverTemperature,
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
    pub(super) over_temperature: bool,
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
            DriveFault::OverTemperature => self.over_temperature = true,
            DriveFault::BrakeStuckEngaged => self.brake_stuck_engaged = true,
            DriveFault::BrakeStuckReleased => self.brake_stuck_released = true,
            DriveFault::MotorDisconnected => self.motor_disconnected = true,
        }
    }

    /// Nothing reaches the bus, and nothing comes from it.
    pub(super) const fn off_bus(&self) -> bool {
        self.power_lost || self.bus_disconnected
    }
}
