//! The control period.

use uarm_io::time::Duration;

/// The control period: 100 µs to 100 ms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Period(Duration);

impl Period {
    /// The shortest period, below which one worst-case frame per joint no longer fits a 1 Mbit/s bus.
    pub const SHORTEST: Duration = Duration::from_micros(100);
    /// The longest period: beyond it the paper's task has fewer than 30 samples.
    pub const LONGEST: Duration = Duration::from_millis(100);

    /// A period; `None` outside [`Period::SHORTEST`] to [`Period::LONGEST`].
    pub fn new(period: Duration) -> Option<Self> {
        (Self::SHORTEST..=Self::LONGEST).contains(&period).then_some(Self(period))
    }

    /// The period as a duration.
    pub const fn duration(self) -> Duration {
        self.0
    }

    /// `ticks` periods in nanoseconds.
    pub fn nanoseconds(self, ticks: u64) -> u64 {
        u64::from(self.0.subsec_nanos()).saturating_mul(ticks)
    }

    /// `ticks` periods in seconds, correctly rounded.
    #[allow(clippy::as_conversions, clippy::cast_precision_loss, reason = "exact below 2^53 ns, which is 104 days")]
    pub fn seconds(self, ticks: u64) -> f64 {
        self.nanoseconds(ticks) as f64 / 1e9
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_are_correctly_rounded() {
        let period = Period::new(Duration::from_millis(3)).unwrap();
        assert_eq!(period.seconds(1), 0.003);
        assert_eq!(period.seconds(1_000), 3.0);
    }

    #[test]
    fn periods_out_of_range_cannot_be_built() {
        assert_eq!(Period::new(Duration::ZERO), None);
        assert_eq!(Period::new(Duration::from_secs(1)), None);
    }
}
