//! Positions in turns, as `f32`, to the counts of the encoder stage.
//!
//! The encoder stage ([`crate::encoder`]) works on integer counts: it unwraps them and refuses jumps. A position in turns is
//! put on the grid of `counts_per_revolution` counts per turn, `⌊turns · N + ½⌋`, and wraps at 32 bits as a counter does.
//!
//! An `f32` has 24 significant bits, so its steps grow with the distance from zero: 2⁻²³ turns between 1 and 2 turns,
//! 2⁻²³⁺ᵏ between 2ᵏ and 2ᵏ⁺¹. Beyond the distance where a step is more than one count, counts would be left out, and
//! the position is refused: at 256 turns for N = 33 739, at 2048 for 8192, at 16 for 2²⁰.

use crate::encoder::CountsPerRevolution;

/// Why a position has no count.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum TurnsError {
    /// It is not a number, or infinite.
    #[error("a position of {turns} turns is no position")]
    NotFinite {
        /// What was reported, turns.
        turns: f32,
    },
    /// There a step of `f32` is more than one count.
    #[error(
        "at {turns} turns a step of the reported position is {step} counts, expected at most one: set the drive's position nearer to zero"
    )]
    Coarse {
        /// What was reported, turns.
        turns: f32,
        /// The step, counts.
        step: f64,
    },
}

/// The count of a position of `turns`, of `resolution` counts per turn; it wraps at 32 bits.
///
/// # Errors
/// [`TurnsError`] if the position is not finite, or so far from zero that its resolution is worse than a count.
pub fn counts(turns: f32, resolution: CountsPerRevolution) -> Result<i32, TurnsError> {
    if !turns.is_finite() {
        return Err(TurnsError::NotFinite { turns });
    }
    let counts_per_turn = resolution.per_revolution();
    let distance = turns.abs();
    let next = f32::from_bits(distance.to_bits().saturating_add(1));
    let step = (f64::from(next) - f64::from(distance)) * counts_per_turn;
    if step > 1.0 {
        return Err(TurnsError::Coarse { turns, step });
    }
    Ok(wrapped(nalgebra::ComplexField::floor(f64::from(turns) * counts_per_turn + 0.5)))
}

/// The low 32 bits of a whole number.
#[allow(clippy::as_conversions)] // float to integer saturates, and the low bits are what a wrapping counter keeps
fn wrapped(whole: f64) -> i32 {
    whole as i64 as i32
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn resolution(counts: u32) -> CountsPerRevolution {
        CountsPerRevolution::new(counts).unwrap()
    }

    #[test]
    fn a_turn_is_its_counts_and_halves_round_up() {
        let of = |turns| counts(turns, resolution(8_192)).unwrap();
        assert_eq!([of(0.0), of(1.0), of(-1.0), of(0.25), of(-2.5)], [0, 8_192, -8_192, 2_048, -20_480]);
        // Half a count is 2^-14 turns.
        assert_eq!([of(0.5 / 8_192.0), of(-0.5 / 8_192.0), of(0.499 / 8_192.0)], [1, 0, 0]);
    }

    #[test]
    fn where_a_step_is_more_than_a_count_the_position_is_refused() {
        for (counts_per_turn, first_refused) in [(33_739, 256.0_f32), (8_192, 2_048.0), (1 << 20, 16.0)] {
            let last = f32::from_bits(first_refused.to_bits() - 1);
            assert!(counts(last, resolution(counts_per_turn)).is_ok(), "{counts_per_turn}");
            for sign in [1.0, -1.0] {
                let refused = counts(sign * first_refused, resolution(counts_per_turn));
                assert!(matches!(refused, Err(TurnsError::Coarse { step, .. }) if step > 1.0), "{counts_per_turn}");
            }
        }
    }

    #[test]
    fn what_is_no_number_is_refused() {
        for turns in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert!(matches!(counts(turns, resolution(8_192)), Err(TurnsError::NotFinite { .. })));
        }
        assert!(counts(f32::MAX, resolution(4)).is_err());
    }

    #[test]
    fn counts_wrap_at_32_bits() {
        // 4 turns of 2^30 counts are a whole round of the counter; at 2^30 counts only the first turns/2^7 are fine enough.
        assert!(counts(4.0, resolution(1 << 30)).is_err());
        assert_eq!(wrapped(4.0 * 1_073_741_824.0 + 5.0), 5);
        assert_eq!(wrapped(2_147_483_648.0), i32::MIN);
    }

    proptest! {
        /// A count that an axis sends as turns comes back, as long as it is not refused.
        #[test]
        fn counts_survive_the_turns(count in -8_000_000_i32..8_000_000, counts_per_turn in 64_u32..40_000) {
            #[allow(clippy::cast_possible_truncation)]
            let turns = (f64::from(count) / f64::from(counts_per_turn)) as f32;
            if let Ok(read) = counts(turns, resolution(counts_per_turn)) {
                prop_assert!((read - count).abs() <= 1, "{read} of {count}");
                // Within half the distance at which it is refused no count is lost.
                if f64::from(count).abs() < 4_000_000.0 {
                    prop_assert_eq!(read, count);
                }
            }
        }

        #[test]
        fn any_bits_are_read_or_refused(bits in any::<u32>(), counts_per_turn in 4_u32..=1 << 30) {
            let _ = counts(f32::from_bits(bits), resolution(counts_per_turn));
        }
    }
}
