//! What the counts of a joint that somebody turns tell: which way it counts, how far it went, where its counter wraps.

use serde::Serialize;
use uarm_io::encoder::{CounterWidth, Direction};

/// Fewer counts than these are the encoder's own noise, not a joint that was turned.
const LEAST_TURN: i64 = 8;
/// A hand does not turn a joint so many times as far as between the two readings before, or so many times this far from
/// rest; a counter that wraps does.
const SUDDEN: i64 = 16;
const FROM_REST: i64 = 64;

/// The counts of a joint that is turned by hand.
#[derive(Clone, Debug, Default)]
pub struct Turning {
    first: Option<i32>,
    last: i32,
    /// Counts between the last two readings.
    step: i64,
    /// Counts from the first reading, wraps taken out.
    travelled: i64,
    least: i64,
    most: i64,
    /// The jump that looked like a wrap, from and to.
    wrap: Option<(i32, i32)>,
    readings: u32,
}

/// Where a counter wrapped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Wrap {
    /// The reading before.
    pub from: i32,
    /// The reading after.
    pub to: i32,
    /// Bits of a counter that wraps there; absent if no width fits.
    pub counter_bits: Option<u8>,
}

impl Turning {
    /// Takes a reading of 6064h.
    pub fn note(&mut self, position: i32) {
        self.readings += 1;
        if self.first.is_none() {
            self.first = Some(position);
            self.last = position;
            return;
        }
        let step = i64::from(position) - i64::from(self.last);
        let sudden = step.abs() > SUDDEN * self.step.abs().max(FROM_REST);
        let step = match width_of_jump(step) {
            Some(bits) if sudden => {
                self.wrap = Some((self.last, position));
                step - step.signum() * (1_i64 << bits)
            }
            _ => step,
        };
        self.step = step;
        self.last = position;
        self.travelled += step;
        self.least = self.least.min(self.travelled);
        self.most = self.most.max(self.travelled);
    }

    /// The first reading.
    pub fn first(&self) -> Option<i32> {
        self.first
    }

    /// The last reading.
    pub const fn last(&self) -> i32 {
        self.last
    }

    /// How many readings there were.
    pub const fn readings(&self) -> u32 {
        self.readings
    }

    /// Counts from the first reading to the last, wraps taken out.
    pub const fn travelled(&self) -> i64 {
        self.travelled
    }

    /// The furthest that it was from the first reading either way.
    pub const fn extremes(&self) -> [i64; 2] {
        [self.least, self.most]
    }

    /// The direction of a joint that was turned counter-clockwise; `None` if it was not turned.
    pub fn direction(&self) -> Option<Direction> {
        match self.travelled {
            LEAST_TURN.. => Some(Direction::Positive),
            counts if counts <= -LEAST_TURN => Some(Direction::Negative),
            _ => None,
        }
    }

    /// Where the counter wrapped, if it did.
    pub fn wrap(&self) -> Option<Wrap> {
        let (from, to) = self.wrap?;
        let counter_bits = width_of_jump(i64::from(to) - i64::from(from));
        Some(Wrap { from, to, counter_bits })
    }
}

/// The width of a counter for which `step` is a wrap: the smallest one whose range is a little more than the step.
fn width_of_jump(step: i64) -> Option<u8> {
    let distance = step.abs();
    // Narrow counters are left out: a hand goes through half of their range between two readings.
    let widths = 16..=CounterWidth::FULL.get();
    let bits = widths.into_iter().find(|bits| 1_i64 << bits >= distance)?;
    let range = 1_i64 << bits;
    // The way across the end is a short one.
    let across = range - distance;
    (across < range / 16).then_some(bits)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turned(readings: &[i32]) -> Turning {
        let mut turning = Turning::default();
        readings.iter().for_each(|reading| turning.note(*reading));
        turning
    }

    #[test]
    fn the_sign_of_the_way_is_the_direction() {
        assert_eq!(turned(&[100, 150, 210]).direction(), Some(Direction::Positive));
        assert_eq!(turned(&[100, 50, -210]).direction(), Some(Direction::Negative));
        assert_eq!(turned(&[100, 104, 99, 103]).direction(), None, "noise");
        assert_eq!(turned(&[]).direction(), None);
    }

    #[test]
    fn the_way_is_counted_back_and_forth() {
        let turning = turned(&[0, 500, -300, 200]);
        assert_eq!((turning.travelled(), turning.extremes()), (200, [-300, 500]));
    }

    /// A 16-bit counter, sign-extended, ends at 32767; a 32-bit one at 2^31 - 1.
    #[test]
    fn a_counter_that_wraps_is_noticed_and_taken_out() {
        let up = turned(&[32_700, 32_760, -32_700]);
        assert_eq!(up.travelled(), 60 + 76);
        assert_eq!(up.wrap(), Some(Wrap { from: 32_760, to: -32_700, counter_bits: Some(16) }));
        let down = turned(&[i32::MIN + 10, i32::MAX - 9]);
        assert_eq!(down.travelled(), -20);
        assert_eq!(down.wrap().unwrap().counter_bits, Some(32));
        // A counter within one revolution of 65 536 counts, from 0.
        let unsigned = turned(&[65_530, 10]);
        assert_eq!((unsigned.travelled(), unsigned.wrap().unwrap().counter_bits), (16, Some(16)));
    }

    #[test]
    fn a_fast_turn_is_no_wrap() {
        // An encoder of 24 bits, turned faster and faster; 65 000 is nearly the range of 16 bits.
        let turning = turned(&[0, 900, 10_000, 75_000]);
        assert_eq!((turning.travelled(), turning.wrap()), (75_000, None));
    }
}
