//! The drive's quadrature encoder: a true angle becomes the count that 6064h shows.

use nalgebra::ComplexField;
use uarm_io::encoder::Direction;

/// How an encoder is built, as plain numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EncoderDescription {
    /// Quadrature counts per revolution of the joint; 4 ..= 2²⁴.
    pub counts_per_revolution: u32,
    /// Width of the counter, bits; 8 ..= 32. A narrower counter's value is sign-extended to the 32 bits of 6064h.
    pub counter_bits: u8,
    /// What it shows at the model's angle zero, counts.
    pub zero_offset: i32,
}

/// Why an encoder is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EncoderError {
    /// The resolution is out of range.
    #[error("the encoder has {found} counts per revolution, expected 4 to 16777216")]
    CountsPerRevolution {
        /// What was asked for.
        found: u32,
    },
    /// The counter's width is out of range.
    #[error("the encoder's counter has {found} bits, expected 8 to 32")]
    CounterBits {
        /// What was asked for.
        found: u8,
    },
}

/// An encoder: counts = ±⌊q/D + ½⌋ + offset with D = 2π / counts per revolution, wrapped to the counter's width.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Encoder {
    description: EncoderDescription,
    direction: Direction,
}

impl Encoder {
    /// An encoder as `description` says, on a drive that is mounted in `direction`.
    ///
    /// # Errors
    /// [`EncoderError`] if a number is out of the range that its field states.
    pub fn new(description: EncoderDescription, direction: Direction) -> Result<Self, EncoderError> {
        let EncoderDescription { counts_per_revolution, counter_bits, .. } = description;
        if !(4..=1 << 24).contains(&counts_per_revolution) {
            return Err(EncoderError::CountsPerRevolution { found: counts_per_revolution });
        }
        if !(8..=32).contains(&counter_bits) {
            return Err(EncoderError::CounterBits { found: counter_bits });
        }
        Ok(Self { description, direction })
    }

    /// How it is built.
    pub const fn description(&self) -> &EncoderDescription {
        &self.description
    }

    /// The sign of its counts against the joint's angle.
    pub const fn direction(&self) -> Direction {
        self.direction
    }

    /// The counter's value at `angle`, rad; at an angle that is not finite the counter shows its zero offset.
    pub fn counts(&self, angle: f64) -> i32 {
        let per_count = core::f64::consts::TAU / f64::from(self.description.counts_per_revolution);
        let steps = whole(ComplexField::floor(angle / per_count + 0.5));
        let counted = match self.direction {
            Direction::Positive => steps,
            Direction::Negative => steps.wrapping_neg(),
        };
        sign_extended(counted.wrapping_add(i64::from(self.description.zero_offset)), self.description.counter_bits)
    }

    /// `counts` as a counter of this width shows them.
    pub(super) fn wrapped(&self, counts: i32) -> i32 {
        sign_extended(counts.into(), self.description.counter_bits)
    }
}

/// The whole part of a number as an integer; saturates, zero for what is not a number.
#[expect(clippy::as_conversions, reason = "the only way from f64 to i64; it saturates, which is what is wanted")]
pub(super) const fn whole(value: f64) -> i64 {
    value as i64
}

/// The low `bits` of `value`, read as a two's complement number.
#[expect(clippy::as_conversions, reason = "after the shifts the value fits: bits is at most 32")]
const fn sign_extended(value: i64, bits: u8) -> i32 {
    let unused = 64_u32.saturating_sub(bits as u32);
    (value.wrapping_shl(unused) >> unused) as i32
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;
    use proptest::prelude::*;

    fn encoder(counter_bits: u8, direction: Direction, zero_offset: i32) -> Encoder {
        let description = EncoderDescription { counts_per_revolution: 33_739, counter_bits, zero_offset };
        Encoder::new(description, direction).unwrap()
    }

    #[test]
    fn counts_change_half_way_between_two_angles() {
        let encoder = encoder(32, Direction::Positive, 0);
        let per_count = TAU / 33_739.0;
        assert_eq!(encoder.counts(0.499 * per_count), 0);
        assert_eq!(encoder.counts(0.501 * per_count), 1);
        assert_eq!(encoder.counts(-0.499 * per_count), 0);
        assert_eq!(encoder.counts(-0.501 * per_count), -1);
        assert_eq!(encoder.counts(f64::NAN), 0);
    }

    #[test]
    fn a_negative_direction_negates_the_count_but_not_the_offset() {
        let encoder = encoder(32, Direction::Negative, 1_000);
        assert_eq!(encoder.counts(TAU), 1_000 - 33_739);
        assert_eq!(encoder.counts(-TAU), 1_000 + 33_739);
    }

    #[test]
    fn a_narrow_counter_wraps() {
        let encoder = encoder(16, Direction::Positive, 32_767);
        assert_eq!(encoder.counts(0.0), 32_767);
        assert_eq!(encoder.counts(1.1 * TAU / 33_739.0), -32_768);
    }

    #[test]
    fn what_no_encoder_has_is_refused() {
        let description = *encoder(32, Direction::Positive, 0).description();
        let none = Encoder::new(EncoderDescription { counts_per_revolution: 0, ..description }, Direction::Positive);
        assert_eq!(none, Err(EncoderError::CountsPerRevolution { found: 0 }));
        let wide = Encoder::new(EncoderDescription { counter_bits: 33, ..description }, Direction::Positive);
        assert_eq!(wide, Err(EncoderError::CounterBits { found: 33 }));
    }

    proptest! {
        /// Direction and offset undone, the count stands for the angle to half a count.
        #[test]
        fn counts_stand_for_the_angle(angle in -50.0..50.0_f64, offset in -1_000_000..1_000_000_i32, positive in any::<bool>()) {
            let (direction, sign) = if positive { (Direction::Positive, 1.0) } else { (Direction::Negative, -1.0) };
            let counts = encoder(32, direction, offset).counts(angle);
            let read = sign * f64::from(counts - offset) * TAU / 33_739.0;
            prop_assert!((read - angle).abs() <= 0.5 * TAU / 33_739.0 + 1e-12);
        }

        /// Two counters of different width agree in the bits that both have.
        #[test]
        fn widths_agree_in_their_low_bits(angle in -500.0..500.0_f64, bits in 8_u8..=31) {
            let wide = encoder(32, Direction::Positive, 5).counts(angle);
            let narrow = encoder(bits, Direction::Positive, 5).counts(angle);
            prop_assert_eq!(i64::from(wide ^ narrow) & ((1_i64 << bits) - 1), 0);
        }
    }
}
