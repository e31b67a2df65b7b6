//! Whether counts can be where a joint has gone: a window around where its last two counts lead.
//!
//! A joint that went from q₁ to q₂ in the time T₁ is at q₂ + (q₂ − q₁)/T₁ · T after the time T, but for what its acceleration
//! adds: at most a (T² + T T₁)/2, since the mean velocity over T₁ is that at some instant of it. To this come rounding of three
//! angles, at most two counts where T = T₁, and what is not known of the instants of sampling.

use uarm_io::encoder::EncoderReading;

/// The largest acceleration of a joint, from the nominal model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccelerationBound {
    /// By the largest torques of all joints, rad/s².
    pub by_torque: f64,
    /// By Coriolis and centrifugal torques, rad/s² for each (rad/s)² of the fastest joint.
    pub by_velocity: f64,
}

/// How much more than the nominal model's acceleration is believed: for masses that are wrong, friction and disturbances.
const MODEL_MARGIN: f64 = 2.0;
/// Rounding of the three angles, in counts of the encoder, and one more for an encoder whose edges are not exact.
const ROUNDING: f64 = 3.0;
/// How far the instants of sampling may be off, as a share of the period: drives that sample in a cycle of their own.
const SAMPLING_SHARE: f64 = 0.25;

/// How a joint went between its last two counts that were believed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Trend {
    /// Mean velocity, counts per second.
    pub velocity: f64,
    /// The time between them, s; zero before the second.
    pub span: f64,
    /// How far that time may be from the true one, s.
    pub time_error: f64,
}

/// The time of a cycle since the one before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elapsed {
    /// As estimators and laws are told, s.
    pub period: f64,
    /// How far that is from the time between the two SYNCs, s.
    pub error: f64,
}

impl Elapsed {
    /// Exactly `period` seconds.
    pub const fn exactly(period: f64) -> Self {
        Self { period, error: 0.0 }
    }
}

/// What is believed of a joint's next count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Counts from the last one that was believed, as predicted.
    pub expected: f64,
    /// How far from that it may be, counts.
    pub tolerance: f64,
}

impl AccelerationBound {
    /// Where the next count may be, `time` seconds after the last, of a joint of which one count is `resolution` rad, while the
    /// fastest joint turns with `fastest` rad/s.
    pub fn window(&self, trend: &Trend, time: f64, time_error: f64, resolution: f64, fastest: f64) -> Window {
        let acceleration = MODEL_MARGIN * (self.by_torque + self.by_velocity * fastest * fastest);
        let moved = acceleration * time * (time + trend.span) / 2.0 / resolution;
        let times = if trend.span > 0.0 { time / trend.span } else { 0.0 };
        let sampling = SAMPLING_SHARE * time + time_error + trend.time_error * times;
        Window {
            expected: trend.velocity * time,
            // Rounding of the velocity grows with the time for which it is taken on.
            tolerance: moved + ROUNDING.max(ROUNDING * times) + trend.velocity.abs() * sampling,
        }
    }
}

impl Trend {
    /// The trend after this one from one reading to the next, `span` seconds later, or `time_error` off that. After a late cycle two
    /// SYNCs may be next to each other, which tells nothing of the velocity: then the old one goes on to be believed.
    #[must_use]
    pub fn next(&self, from: &EncoderReading, to: &EncoderReading, span: f64, time_error: f64) -> Self {
        let change: f64 = nalgebra::convert(to.count.saturating_sub(from.count));
        if self.span > 0.0 && time_error > SAMPLING_SHARE * span {
            let (span, time_error) = (self.span + span, self.time_error + time_error);
            return Self { velocity: self.velocity, span, time_error };
        }
        if span > 0.0 { Self { velocity: change / span, span, time_error } } else { Self::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use uarm_io::time::Duration;

    /// 0.01 rad a count, 100 counts per second over 0.1 s, 5 rad/s² twice: 10 rad/s² over (0.1² + 0.1²)/2 s² are 0.1 rad.
    #[test]
    fn a_window_is_what_acceleration_rounding_and_sampling_allow() {
        let bound = AccelerationBound { by_torque: 3.0, by_velocity: 0.5 };
        let trend = Trend { velocity: 100.0, span: 0.1, time_error: 0.0 };
        let window = bound.window(&trend, 0.1, 0.0, 0.01, 2.0);
        assert!((window.expected - 10.0).abs() < 1e-12);
        assert!((window.tolerance - (10.0 + 3.0 + 2.5)).abs() < 1e-9, "{window:?}");
        let late = bound.window(&trend, 0.1, 0.02, 0.01, 2.0);
        assert!((late.tolerance - window.tolerance - 2.0).abs() < 1e-9, "100 counts per second for 20 ms");
    }

    const NO_ACCELERATION: AccelerationBound = AccelerationBound { by_torque: 0.0, by_velocity: 0.0 };

    /// Three times as long as the trend took: its rounding, 3 counts, and the 10 ms by which it may be off count three times. At 100
    /// counts per second these are 9 counts and 3, and a quarter of 0.3 s is another 7.5.
    #[test]
    fn a_trend_that_goes_on_for_longer_is_believed_less() {
        let trend = Trend { velocity: 100.0, span: 0.1, time_error: 0.01 };
        let window = NO_ACCELERATION.window(&trend, 0.3, 0.0, 0.01, 2.0);
        assert!((window.expected - 30.0).abs() < 1e-9, "{window:?}");
        assert!((window.tolerance - (9.0 + 3.0 + 7.5)).abs() < 1e-9, "{window:?}");
        // 5 rad/s² twice over 0.3 s (0.3 s + 0.1 s)/2 are 0.6 rad.
        let bound = AccelerationBound { by_torque: 3.0, by_velocity: 0.5 };
        let driven = bound.window(&trend, 0.3, 0.0, 0.01, 2.0);
        assert!((driven.tolerance - window.tolerance - 60.0).abs() < 1e-9, "{driven:?}");
    }

    #[test]
    fn before_the_second_count_a_joint_is_believed_to_stand() {
        let window = NO_ACCELERATION.window(&Trend::default(), 0.3, 0.01, 0.01, 0.0);
        assert_eq!(window, Window { expected: 0.0, tolerance: 3.0 });
    }

    /// The trend after one of 100 counts per second over 0.5 s that is 62.5 ms off: 30 counts later.
    fn after(span: f64, time_error: f64) -> Trend {
        let reading = |count| EncoderReading { raw: 0, count, age: Duration::ZERO };
        Trend { velocity: 100.0, span: 0.5, time_error: 0.0625 }.next(&reading(10), &reading(40), span, time_error)
    }

    #[test]
    fn a_trend_is_that_of_the_last_two_counts() {
        assert_eq!(after(0.25, 0.0), Trend { velocity: 120.0, span: 0.25, time_error: 0.0 });
        assert_eq!(after(0.0, 0.0), Trend::default());
        let reading = |count| EncoderReading { raw: 0, count, age: Duration::ZERO };
        let first = Trend::default().next(&reading(0), &reading(-30), 0.25, 0.125);
        assert_eq!(first, Trend { velocity: -120.0, span: 0.25, time_error: 0.125 }, "there is no older one");
    }

    /// A quarter of the span is the most by which its time may be off.
    #[test]
    fn two_counts_whose_time_is_not_known_do_not_change_the_velocity() {
        assert_eq!(after(0.25, 0.0625), Trend { velocity: 120.0, span: 0.25, time_error: 0.0625 });
        assert_eq!(after(0.25, 0.125), Trend { velocity: 100.0, span: 0.75, time_error: 0.1875 });
    }

    /// A joint that turns with 10 counts a millisecond and cannot accelerate, in a loop of 3 ms whose SYNCs come at these instants, ms.
    fn is_believed(syncs: &[f64]) -> bool {
        let count = |at: f64| (10.0 * at).round() as i64;
        let reading = |at: f64| EncoderReading { raw: 0, count: count(at), age: Duration::ZERO };
        let mut trend = Trend::default();
        syncs.windows(2).all(|pair| {
            let time_error = (pair[1] - pair[0] - 3.0).abs() * 1e-3;
            let (from, to) = (reading(pair[0]), reading(pair[1]));
            let window = NO_ACCELERATION.window(&trend, 3e-3, time_error, 1e-3, 0.0);
            let is_first = trend.span == 0.0;
            trend = trend.next(&from, &to, 3e-3, time_error);
            is_first || ((to.count - from.count) as f64 - window.expected).abs() <= window.tolerance
        })
    }

    #[test]
    fn late_cycles_do_not_make_a_count_implausible() {
        assert!(is_believed(&[0.0, 3.0, 6.0, 9.0, 12.0]));
        for late in [0.5, 1.0, 2.0, 2.9, 3.06, 5.0] {
            let next = f64::max(12.0, 9.0 + late + 0.08);
            assert!(is_believed(&[0.0, 3.0, 6.0, 9.0 + late, next, 15.0, 18.0, 21.0]), "{late} ms late");
        }
    }
}
