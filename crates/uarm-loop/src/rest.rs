//! Joints must be at rest when their brakes open.

use uarm_io::encoder::EncoderConfiguration;
use uarm_io::time::Duration;

/// How long after the first reading of the counts the second is made.
pub const BETWEEN_READINGS: Duration = Duration::from_millis(50);

/// By so many counts two readings of a joint at rest may differ: each may be off by one.
const COUNTS_OF_TWO_READINGS: f64 = 2.0;

/// The fastest that a joint may turn while brakes are closed, rad/s: above zero, at most 100 degrees per second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestVelocity(f64);

impl RestVelocity {
    /// The largest, degrees per second.
    pub const LARGEST_DEGREES: f64 = 100.0;

    /// A velocity, degrees per second; `None` outside the range.
    pub fn from_degrees(degrees_per_second: f64) -> Option<Self> {
        let is_allowed = degrees_per_second > 0.0 && degrees_per_second <= Self::LARGEST_DEGREES;
        is_allowed.then(|| Self(degrees_per_second.to_radians()))
    }

    /// The velocity, rad/s.
    pub const fn get(self) -> f64 {
        self.0
    }
}

impl Default for RestVelocity {
    /// One degree per second: a brake that holds lets no joint turn, so that only noise of the encoder must be borne.
    fn default() -> Self {
        Self(1.0_f64.to_radians())
    }
}

/// A joint turns while its brake is closed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "joint {joint} turned {:.2} deg in {} ms with its brake closed, expected at most {:.2} deg: does the brake hold?",
    .turned.to_degrees(), BETWEEN_READINGS.as_millis(), .allowed.to_degrees()
)]
pub struct NotAtRest {
    /// The joint, counted from 1.
    pub joint: usize,
    /// By how much it turned, rad.
    pub turned: f64,
    /// What is borne, rad.
    pub allowed: f64,
}

/// Checks that each joint stood still from the counts `before` to `now`, [`BETWEEN_READINGS`] later.
///
/// # Errors
/// [`NotAtRest`] for the first joint that did not.
pub fn check<const J: usize>(
    encoders: [EncoderConfiguration; J],
    limit: RestVelocity,
    before: [i32; J],
    now: [i32; J],
) -> Result<(), NotAtRest> {
    for (((encoder, before), now), joint) in encoders.iter().zip(before).zip(now).zip(1..) {
        let turned = encoder.turned(before, now);
        let resolution = encoder.counts_per_revolution.resolution();
        let allowed = limit.get() * BETWEEN_READINGS.as_secs_f64() + COUNTS_OF_TWO_READINGS * resolution;
        if turned.abs() > allowed {
            return Err(NotAtRest { joint, turned, allowed });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, TAU};

    use uarm_io::encoder::{CounterWidth, CountsPerRevolution, Direction, JumpLimit};

    use super::*;

    /// 36000 counts in a revolution, a counter of 16 bits.
    fn encoder() -> EncoderConfiguration {
        EncoderConfiguration {
            counts_per_revolution: CountsPerRevolution::new(36_000).unwrap(),
            counter_width: CounterWidth::new(16).unwrap(),
            direction: Direction::Negative,
            zero: 100,
            jump_limit: JumpLimit::new(10.0, 1).unwrap(),
        }
    }

    /// At 1 deg/s a joint turns 5 counts of 0.01 deg in 50 ms; two more are borne.
    #[test]
    fn seven_counts_are_rest_and_eight_are_not_across_the_counters_end_too() {
        let check = |before, now| check([encoder(); 2], RestVelocity::default(), [0, before], [0, now]);
        for (before, at_rest, turns) in [(0, 7, 8), (0, -7, -8), (32_767, -32_762, -32_761)] {
            assert_eq!(check(before, at_rest), Ok(()), "{before} {at_rest}");
            let error = check(before, turns).unwrap_err();
            assert_eq!(error.joint, 2);
            assert!((error.turned.abs() - 8.0 * TAU / 36_000.0).abs() < 1e-12, "{error}");
        }
        let text = check(0, 8).unwrap_err().to_string();
        assert_eq!(
            text,
            "joint 2 turned -0.08 deg in 50 ms with its brake closed, expected at most 0.07 deg: does the brake hold?"
        );
    }

    #[test]
    fn a_velocity_of_rest_has_a_range() {
        for refused in [0.0, -1.0, 100.1, f64::NAN, f64::INFINITY] {
            assert_eq!(RestVelocity::from_degrees(refused), None, "{refused}");
        }
        assert_eq!(RestVelocity::from_degrees(180.0 / 2.0), Some(RestVelocity(FRAC_PI_2)));
    }
}
