//! The time from the latch of the counts to the torque that they lead to.

use uarm_io::time::Duration;

use crate::period::Period;

/// From the SYNC that latches the counts until the torque made of them acts, in cycles: 0 to [`TransportDelay::LONGEST`].
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct TransportDelay(f64);

/// A delay that cannot be analysed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("a delay of {found} cycles, expected 0 to {}", TransportDelay::LONGEST)]
pub struct DelayError {
    /// The delay, cycles.
    pub found: f64,
}

impl TransportDelay {
    /// The longest delay, cycles. The paper's loop is unstable long before.
    pub const LONGEST: f64 = 3.0;
    /// No delay.
    pub const NONE: Self = Self(0.0);

    /// A delay of `cycles`.
    ///
    /// # Errors
    /// [`DelayError`] outside 0 to [`TransportDelay::LONGEST`].
    pub fn cycles(cycles: f64) -> Result<Self, DelayError> {
        if (0.0..=Self::LONGEST).contains(&cycles) { Ok(Self(cycles)) } else { Err(DelayError { found: cycles }) }
    }

    /// A delay of `time` in a loop of `period`.
    ///
    /// # Errors
    /// As [`TransportDelay::cycles`].
    pub fn of(time: Duration, period: Period) -> Result<Self, DelayError> {
        Self::cycles(time.as_secs_f64() / period.seconds(1))
    }

    /// Cycles.
    pub const fn get(self) -> f64 {
        self.0
    }

    /// The part of a cycle in which the torque that was computed `age` cycles before acts, as begin and end within 0 to 1.
    pub(super) fn share(self, age: f64) -> [f64; 2] {
        let begin = self.0 - age;
        [begin.clamp(0.0, 1.0), (begin + 1.0).clamp(0.0, 1.0)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_instant_of_a_cycle_has_one_torque() {
        for (cycles, expected) in [
            (0.0, [[0.0, 1.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]]),
            (0.25, [[0.25, 1.0], [0.0, 0.25], [0.0, 0.0], [0.0, 0.0]]),
            (1.0, [[1.0, 1.0], [0.0, 1.0], [0.0, 0.0], [0.0, 0.0]]),
            (2.5, [[1.0, 1.0], [1.0, 1.0], [0.5, 1.0], [0.0, 0.5]]),
            (3.0, [[1.0, 1.0], [1.0, 1.0], [1.0, 1.0], [0.0, 1.0]]),
        ] {
            let delay = TransportDelay::cycles(cycles).unwrap();
            assert_eq!([0.0, 1.0, 2.0, 3.0].map(|age| delay.share(age)), expected, "{cycles}");
        }
    }

    #[test]
    fn delays_out_of_range_cannot_be_built() {
        for cycles in [-0.1, 3.1, f64::NAN] {
            assert!(TransportDelay::cycles(cycles).is_err(), "{cycles}");
        }
        let period = Period::new(Duration::from_millis(3)).unwrap();
        let delay = TransportDelay::of(Duration::from_micros(4_500), period).unwrap();
        assert!((delay.get() - 1.5).abs() < 1e-12);
    }
}
