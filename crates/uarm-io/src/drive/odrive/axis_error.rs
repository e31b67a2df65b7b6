//! The axis error of a heartbeat in words.
//!
//! Source: `ODrive.Error` of firmware 0.6, <https://docs.odriverobotics.com/v/latest/fibre_types/com_odriverobotics_ODrive.html>.
//! Firmware 0.5 has other bits.

use core::fmt;

/// Errors of an axis: a bit for each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct AxisError(pub u32);

impl AxisError {
    /// The watchdog was not fed in time.
    pub const WATCHDOG_TIMER_EXPIRED: Self = Self(1 << 24);
    /// Somebody sent the emergency stop message.
    pub const ESTOP_REQUESTED: Self = Self(1 << 25);
    /// The motor is too hot.
    pub const MOTOR_OVER_TEMP: Self = Self(1 << 13);

    /// True if there is no error.
    pub const fn is_none(self) -> bool {
        self.0 == 0
    }

    /// True if it has all bits of `other`.
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
}

const NAMES: [(u32, &str); 22] = [
    (0, "INITIALIZING"),
    (1, "SYSTEM_LEVEL"),
    (2, "TIMING_ERROR"),
    (3, "MISSING_ESTIMATE"),
    (4, "BAD_CONFIG"),
    (5, "DRV_FAULT"),
    (6, "MISSING_INPUT"),
    (8, "DC_BUS_OVER_VOLTAGE"),
    (9, "DC_BUS_UNDER_VOLTAGE"),
    (10, "DC_BUS_OVER_CURRENT"),
    (11, "DC_BUS_OVER_REGEN_CURRENT"),
    (12, "CURRENT_LIMIT_VIOLATION"),
    (13, "MOTOR_OVER_TEMP"),
    (14, "INVERTER_OVER_TEMP"),
    (15, "VELOCITY_LIMIT_VIOLATION"),
    (16, "POSITION_LIMIT_VIOLATION"),
    (24, "WATCHDOG_TIMER_EXPIRED"),
    (25, "ESTOP_REQUESTED"),
    (26, "SPINOUT_DETECTED"),
    (27, "BRAKE_RESISTOR_DISARMED"),
    (28, "THERMISTOR_DISCONNECTED"),
    (30, "CALIBRATION_ERROR"),
];

impl fmt::Display for AxisError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "axis error {:08X}h", self.0)?;
        let named = NAMES.iter().filter(|(bit, _)| self.0 >> bit & 1 == 1);
        for (position, (_, name)) in named.enumerate() {
            let separator = if position == 0 { " " } else { ", " };
            write!(formatter, "{separator}{name}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    /// Numbers and names as `odrivetool` prints them.
    #[test]
    fn errors_are_named_as_the_maker_names_them() {
        assert_eq!(AxisError(16_777_216).to_string(), "axis error 01000000h WATCHDOG_TIMER_EXPIRED");
        assert_eq!(
            AxisError(33_554_432 + 256).to_string(),
            "axis error 02000100h DC_BUS_OVER_VOLTAGE, ESTOP_REQUESTED"
        );
        assert_eq!(AxisError(8_192).to_string(), "axis error 00002000h MOTOR_OVER_TEMP");
        assert_eq!(AxisError(128).to_string(), "axis error 00000080h");
        assert!(AxisError::default().is_none());
        assert!(AxisError(3).contains(AxisError(1)) && !AxisError(2).contains(AxisError(3)));
    }
}
