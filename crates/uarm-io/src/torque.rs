//! From joint torques to the per mille of rated torque that a drive takes, and back.

use crate::encoder::Direction;
use crate::gear::Transmission;

/// The unit in which a drive counts its rated torque 6076h: mN·m as CiA 402 says, or µN·m as some makers have it.
///
/// With the feature `serde` it is the text `"mNm"` or `"uNm"`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum TorqueUnit {
    /// mN·m.
    #[default]
    #[cfg_attr(feature = "serde", serde(rename = "mNm"))]
    MillinewtonMetre,
    /// µN·m.
    #[cfg_attr(feature = "serde", serde(rename = "uNm"))]
    MicronewtonMetre,
}

impl TorqueUnit {
    /// The unit in N·m.
    pub const fn newton_metres(self) -> f64 {
        match self {
            Self::MillinewtonMetre => 1e-3,
            Self::MicronewtonMetre => 1e-6,
        }
    }

    /// `count` of the unit in N·m: the number next to the decimal one, so that it is printed as such.
    pub fn in_newton_metres(self, count: u32) -> f64 {
        let per_newton_metre = match self {
            Self::MillinewtonMetre => 1e3,
            Self::MicronewtonMetre => 1e6,
        };
        f64::from(count) / per_newton_metre
    }
}

/// A motor's rated torque as object 6076h holds it: a whole number of a unit, above zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RatedTorque {
    value: u32,
    unit: TorqueUnit,
}

impl RatedTorque {
    /// A rated torque of `value` units.
    ///
    /// # Errors
    /// [`TorqueError::RatedTorque`] for zero.
    pub const fn new(value: u32, unit: TorqueUnit) -> Result<Self, TorqueError> {
        if value == 0 { Err(TorqueError::RatedTorque) } else { Ok(Self { value, unit }) }
    }

    /// A rated torque of `millinewton_metres` mN·m.
    ///
    /// # Errors
    /// [`TorqueError::RatedTorque`] for zero.
    pub const fn from_millinewton_metres(millinewton_metres: u32) -> Result<Self, TorqueError> {
        Self::new(millinewton_metres, TorqueUnit::MillinewtonMetre)
    }

    /// The value of 6076h.
    pub const fn object_value(self) -> u32 {
        self.value
    }

    /// The unit of 6076h.
    pub const fn unit(self) -> TorqueUnit {
        self.unit
    }

    /// The rated torque in N·m.
    pub fn newton_metres(self) -> f64 {
        f64::from(self.value) * self.unit.newton_metres()
    }

    /// One per mille of it, the step in which torque is commanded, N·m.
    pub fn per_mille(self) -> f64 {
        self.newton_metres() * 1e-3
    }
}

/// The most that is ever asked of a drive, per mille of its rated torque: 1 to 32767.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TorqueCeiling(i16);

impl TorqueCeiling {
    /// The rated torque itself.
    pub const RATED: Self = Self(1000);

    /// A ceiling of `per_mille` of the rated torque.
    ///
    /// # Errors
    /// [`TorqueError::Ceiling`] below 1.
    pub const fn new(per_mille: i16) -> Result<Self, TorqueError> {
        if per_mille < 1 { Err(TorqueError::Ceiling { per_mille }) } else { Ok(Self(per_mille)) }
    }

    /// The ceiling, per mille of the rated torque.
    pub const fn per_mille(self) -> i16 {
        self.0
    }
}

/// What is wrong with a torque or its scale.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum TorqueError {
    /// A rated torque of zero.
    #[error("a rated torque of 0, expected at least 1 mN·m or µN·m")]
    RatedTorque,
    /// A torque ceiling below 1 per mille.
    #[error("a torque ceiling of {per_mille} per mille, expected 1 to 32767")]
    Ceiling {
        /// The ceiling that was asked for, per mille of the rated torque.
        per_mille: i16,
    },
    /// A torque that is not finite: nothing may be sent.
    #[error("a torque of {torque} N·m cannot be sent")]
    NotFinite {
        /// The torque, N·m.
        torque: f64,
    },
}

/// A torque as it goes to the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TargetTorque {
    /// Object 6071h.
    pub per_mille: i16,
    /// Whether it is all that was asked for.
    pub saturation: Saturation,
}

/// Whether a torque was cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Saturation {
    /// It is within the ceiling.
    Within,
    /// It was cut to the ceiling.
    Cut,
}

/// The scale between a joint's torque and its drive's per mille.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueScale {
    /// The motor's rated torque: 1000 per mille.
    pub rated_torque: RatedTorque,
    /// Which way a positive torque of the drive turns the joint.
    pub direction: Direction,
    /// The most that is sent, in both directions.
    pub ceiling: TorqueCeiling,
    /// The gear between motor and joint.
    pub transmission: Transmission,
}

impl TorqueScale {
    /// One per mille at the joint, N·m. A gear's efficiency is that of a motor that drives its joint; while the joint drives
    /// the motor, more torque acts than was asked for.
    pub fn per_mille(&self) -> f64 {
        self.rated_torque.per_mille() * self.transmission.torque_factor()
    }

    /// The target for `torque` N·m at the joint: rounded to the nearest per mille, halves away from zero, and cut at
    /// the ceiling, which is reported.
    ///
    /// The controller's own limiter comes before this one; it should never have to cut.
    ///
    /// # Errors
    /// [`TorqueError::NotFinite`].
    pub fn to_drive(&self, torque: f64) -> Result<TargetTorque, TorqueError> {
        if !torque.is_finite() {
            return Err(TorqueError::NotFinite { torque });
        }
        let asked = nalgebra::ComplexField::round(self.direction.apply(torque) / self.per_mille());
        let ceiling = f64::from(self.ceiling.0);
        let sent = asked.clamp(-ceiling, ceiling);
        let saturation = if asked.abs() > ceiling { Saturation::Cut } else { Saturation::Within };
        Ok(TargetTorque { per_mille: whole(sent), saturation })
    }

    /// The joint's torque at `per_mille`, N·m.
    pub fn to_joint(&self, per_mille: i16) -> f64 {
        self.direction.apply(f64::from(per_mille)) * self.per_mille()
    }
}

/// A whole number within ±32767.
#[allow(clippy::as_conversions)] // the caller has clamped it, and `as` saturates
fn whole(value: f64) -> i16 {
    value as i16
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn scale(millinewton_metres: u32, direction: Direction) -> TorqueScale {
        let rated_torque = RatedTorque::from_millinewton_metres(millinewton_metres).unwrap();
        TorqueScale { rated_torque, direction, ceiling: TorqueCeiling::RATED, transmission: Transmission::DIRECT }
    }

    #[test]
    fn halves_round_away_from_zero() {
        let scale = scale(1000, Direction::Positive);
        let per_mille = [0.0004, 0.0005, -0.0005, 0.0706, -0.0706].map(|t| scale.to_drive(t).unwrap().per_mille);
        assert_eq!(per_mille, [0, 1, -1, 71, -71]);
    }

    #[test]
    fn a_negative_direction_negates_torque() {
        // 0.1 N·m are half of 200 mN·m.
        let mounted = |direction| scale(200, direction);
        assert_eq!(mounted(Direction::Positive).to_drive(0.1).unwrap().per_mille, 500);
        assert_eq!(mounted(Direction::Negative).to_drive(0.1).unwrap().per_mille, -500);
        assert!((mounted(Direction::Positive).to_joint(500) - 0.1).abs() < 1e-15);
        assert!((mounted(Direction::Negative).to_joint(500) + 0.1).abs() < 1e-15);
    }

    #[test]
    fn per_mille_of_0_and_1() {
        // One per mille of 2 N·m is 2 mN·m.
        let scale = scale(2000, Direction::Positive);
        assert_eq!([-1, 0, 1].map(|per_mille| scale.to_joint(per_mille)), [-0.002, 0.0, 0.002]);
        let sent = [-0.0011, -0.0009, 0.0, 0.0009, 0.0011].map(|torque| scale.to_drive(torque).unwrap().per_mille);
        assert_eq!(sent, [-1, 0, 0, 0, 1]);
    }

    /// Half of what a motor of 200 mN·m gives through 50 to 1 at 80 %: 4 N·m.
    #[test]
    fn a_gear_scales_the_torque() {
        let ratio = crate::gear::GearRatio::new(50, 1).unwrap();
        let transmission = Transmission::new(ratio, 0.8).unwrap();
        let scale = TorqueScale { transmission, ..scale(200, Direction::Positive) };
        assert_eq!(scale.to_drive(4.0).unwrap().per_mille, 500);
        assert!((scale.to_joint(500) - 4.0).abs() < 1e-12);
    }

    #[test]
    fn a_count_of_a_unit_is_printed_as_the_decimal_that_it_is() {
        let printed = |unit: TorqueUnit, count| std::format!("{}", unit.in_newton_metres(count));
        assert_eq!(printed(TorqueUnit::MillinewtonMetre, 350), "0.35");
        assert_eq!(printed(TorqueUnit::MicronewtonMetre, 1_150_003), "1.150003");
    }

    #[test]
    fn a_rated_torque_can_count_micronewton_metres() {
        let rated = RatedTorque::new(12_340, TorqueUnit::MicronewtonMetre).unwrap();
        assert!((rated.newton_metres() - 0.012_34).abs() < 1e-15);
        assert_eq!(rated.object_value(), 12_340);
    }

    #[test]
    fn a_torque_is_cut_above_the_ceiling_and_not_at_it() {
        for (ceiling, at, above) in [(1, 0.001, 0.0016), (300, 0.3, 0.301), (i16::MAX, 32.767, 32.768)] {
            let scale =
                TorqueScale { ceiling: TorqueCeiling::new(ceiling).unwrap(), ..scale(1000, Direction::Positive) };
            for sign in [1_i16, -1] {
                let torque = |magnitude: f64| scale.to_drive(f64::from(sign) * magnitude).unwrap();
                let per_mille = sign * ceiling;
                assert_eq!(torque(at), TargetTorque { per_mille, saturation: Saturation::Within });
                assert_eq!(torque(above), TargetTorque { per_mille, saturation: Saturation::Cut });
            }
        }
        assert_eq!(TorqueCeiling::new(-1), Err(TorqueError::Ceiling { per_mille: -1 }));
        assert_eq!(TorqueCeiling::new(1).unwrap().per_mille(), 1);
        assert_eq!(RatedTorque::from_millinewton_metres(1).unwrap().object_value(), 1);
    }

    #[test]
    fn what_is_no_number_is_refused() {
        for torque in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(matches!(scale(200, Direction::Positive).to_drive(torque), Err(TorqueError::NotFinite { .. })));
        }
        assert_eq!(RatedTorque::from_millinewton_metres(0), Err(TorqueError::RatedTorque));
        assert_eq!(TorqueCeiling::new(0), Err(TorqueError::Ceiling { per_mille: 0 }));
    }

    proptest! {
        #[test]
        fn torques_come_back_to_half_a_step(torque in -0.2_f64..0.2, reversed in any::<bool>()) {
            let scale = scale(200, if reversed { Direction::Negative } else { Direction::Positive });
            let target = scale.to_drive(torque).unwrap();
            prop_assert_eq!(target.saturation, Saturation::Within);
            let half_step = 0.5 * scale.rated_torque.per_mille();
            prop_assert!((scale.to_joint(target.per_mille) - torque).abs() <= half_step * (1.0 + 1e-12));
        }

        #[test]
        fn every_per_mille_survives(per_mille in -1000_i16..=1000, rated in 1_u32..1_000_000, reversed in any::<bool>()) {
            let scale = scale(rated, if reversed { Direction::Negative } else { Direction::Positive });
            prop_assert_eq!(scale.to_drive(scale.to_joint(per_mille)).unwrap().per_mille, per_mille);
        }

        #[test]
        fn nothing_exceeds_the_ceiling(torque in any::<f64>(), ceiling in 1_i16..=i16::MAX) {
            let scale = TorqueScale { ceiling: TorqueCeiling::new(ceiling).unwrap(), ..scale(7, Direction::Positive) };
            match scale.to_drive(torque) {
                Ok(target) => prop_assert!(i32::from(target.per_mille).abs() <= i32::from(ceiling)),
                Err(_) => prop_assert!(!torque.is_finite()),
            }
        }
    }
}
