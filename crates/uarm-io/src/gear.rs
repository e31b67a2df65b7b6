//! The gear between a motor and its joint: an exact ratio, and what it takes of the torque.

/// Motor revolutions over joint revolutions, exact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GearRatio {
    motor: u32,
    joint: u32,
}

impl GearRatio {
    /// No gear: the motor turns as its joint does.
    pub const DIRECT: Self = Self { motor: 1, joint: 1 };
    /// Numerators and denominators that gears have.
    pub const RANGE: core::ops::RangeInclusive<u32> = 1..=1_000_000;

    /// `motor` revolutions of the motor in `joint` revolutions of the joint.
    ///
    /// # Errors
    /// [`GearError::Ratio`] outside [`GearRatio::RANGE`].
    pub fn new(motor: u32, joint: u32) -> Result<Self, GearError> {
        if Self::RANGE.contains(&motor) && Self::RANGE.contains(&joint) {
            Ok(Self { motor, joint })
        } else {
            Err(GearError::Ratio { motor, joint })
        }
    }

    /// Revolutions of the motor.
    pub const fn motor(self) -> u32 {
        self.motor
    }

    /// Revolutions of the joint in the same time.
    pub const fn joint(self) -> u32 {
        self.joint
    }

    /// How much faster the motor turns; 1 without a gear.
    pub fn factor(self) -> f64 {
        f64::from(self.motor) / f64::from(self.joint)
    }
}

/// A gear as the torque sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transmission {
    ratio: GearRatio,
    efficiency: f64,
}

impl Transmission {
    /// No gear.
    pub const DIRECT: Self = Self { ratio: GearRatio::DIRECT, efficiency: 1.0 };

    /// A gear of `ratio` that passes on `efficiency` of the motor's torque while the motor drives the joint.
    ///
    /// # Errors
    /// [`GearError::Efficiency`] unless it is above 0 and at most 1.
    pub fn new(ratio: GearRatio, efficiency: f64) -> Result<Self, GearError> {
        if efficiency > 0.0 && efficiency <= 1.0 {
            Ok(Self { ratio, efficiency })
        } else {
            Err(GearError::Efficiency { efficiency })
        }
    }

    /// Its ratio.
    pub const fn ratio(self) -> GearRatio {
        self.ratio
    }

    /// The part of the motor's torque that it passes on.
    pub const fn efficiency(self) -> f64 {
        self.efficiency
    }

    /// Torque at the joint over torque of the motor: ratio · efficiency; exactly 1 without a gear.
    pub fn torque_factor(self) -> f64 {
        self.ratio.factor() * self.efficiency
    }
}

impl Default for Transmission {
    fn default() -> Self {
        Self::DIRECT
    }
}

/// A gear that cannot be.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum GearError {
    /// See [`GearRatio::RANGE`].
    #[error("a gear of {motor} to {joint}, expected numbers from {} to {}", GearRatio::RANGE.start(), GearRatio::RANGE.end())]
    Ratio {
        /// Revolutions of the motor.
        motor: u32,
        /// Revolutions of the joint.
        joint: u32,
    },
    /// See [`Transmission::new`].
    #[error("an efficiency of {efficiency}, expected above 0 and at most 1")]
    Efficiency {
        /// The efficiency that was asked for.
        efficiency: f64,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_gear_nothing_changes() {
        assert_eq!(GearRatio::DIRECT.factor(), 1.0);
        assert_eq!(Transmission::DIRECT.torque_factor(), 1.0);
    }

    /// 80 to 1 at 70 %: 0.1 N·m of the motor are 5.6 N·m at the joint.
    #[test]
    fn a_gear_multiplies_torque_and_loses_some() {
        let gear = Transmission::new(GearRatio::new(80, 1).unwrap(), 0.7).unwrap();
        assert!((0.1 * gear.torque_factor() - 5.6).abs() < 1e-12);
    }

    #[test]
    fn what_no_gear_has_is_refused() {
        assert_eq!(GearRatio::new(0, 1), Err(GearError::Ratio { motor: 0, joint: 1 }));
        assert!(GearRatio::new(1, 1_000_001).is_err());
        for efficiency in [0.0, -0.5, 1.01, f64::NAN] {
            assert!(Transmission::new(GearRatio::DIRECT, efficiency).is_err());
        }
    }
}
