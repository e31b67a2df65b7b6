//! From the counts of an incremental encoder to joint angles.
//!
//! A drive reports a counter that wraps. The encoder unwraps it exactly, in both directions, refuses a change that the
//! joint cannot have made, and gives the angle `count · D` with D = 2π / N, N the counts per
//! revolution of the joint: a ratio of whole numbers, for behind a gear they need not be whole. The count of a
//! shaft at angle q is `floor(q/D + 1/2)`.

use crate::gear::GearRatio;
use core::f64::consts::TAU;
use core::time::Duration;

/// Counts of the drive's counter in a revolution of the joint: an exact ratio, since a gear need not make them whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CountsPerRevolution {
    /// So many counts …
    counts: u64,
    /// … in so many revolutions of the joint.
    revolutions: u32,
}

impl CountsPerRevolution {
    /// At least 4, one period of a quadrature encoder, and at most 2³⁰, so that a 32-bit counter holds four revolutions.
    pub const RANGE: core::ops::RangeInclusive<u32> = 4..=1 << 30;

    /// `counts` per revolution.
    ///
    /// # Errors
    /// [`EncoderError::CountsPerRevolution`] outside [`CountsPerRevolution::RANGE`].
    pub fn new(counts: u32) -> Result<Self, EncoderError> {
        if Self::RANGE.contains(&counts) {
            Ok(Self { counts: counts.into(), revolutions: 1 })
        } else {
            Err(EncoderError::CountsPerRevolution { counts: counts.into() })
        }
    }

    /// The encoder of a motor with `counts` in each of its revolutions, behind `gear`.
    ///
    /// # Errors
    /// [`EncoderError::CountsPerRevolution`] if `counts`, or the counts in a revolution of the joint, are outside
    /// [`CountsPerRevolution::RANGE`].
    pub fn behind(counts: u32, gear: GearRatio) -> Result<Self, EncoderError> {
        Self::new(counts)?;
        let (counts, revolutions) = (u64::from(counts) * u64::from(gear.motor()), u64::from(gear.joint()));
        let whole = counts / revolutions;
        if !u32::try_from(whole).is_ok_and(|whole| Self::RANGE.contains(&whole)) {
            return Err(EncoderError::CountsPerRevolution { counts: whole });
        }
        let divisor = greatest_common_divisor(counts, revolutions);
        let revolutions = u32::try_from(revolutions / divisor).unwrap_or(u32::MAX);
        Ok(Self { counts: counts / divisor, revolutions })
    }

    /// The ratio as counts in a number of revolutions, without a common divisor.
    pub const fn ratio(self) -> (u64, u32) {
        (self.counts, self.revolutions)
    }

    /// Counts in a revolution, N, to the nearest number that f64 holds.
    #[allow(clippy::as_conversions)] // below 2^50, since both factors are in their ranges
    pub fn per_revolution(self) -> f64 {
        self.counts as f64 / f64::from(self.revolutions)
    }

    /// Counts in a revolution of the motor behind `gear`: what was given to [`CountsPerRevolution::behind`].
    pub fn of_motor(self, gear: GearRatio) -> Option<u32> {
        let counts = self.counts.checked_mul(gear.joint().into())?;
        let revolutions = u64::from(self.revolutions).checked_mul(gear.motor().into())?;
        u32::try_from(counts.checked_div(revolutions)?).ok()
    }

    /// One count as an angle: D = 2π / N, rad.
    #[allow(clippy::as_conversions)] // below 2^50, since both factors are in their ranges
    pub fn resolution(self) -> f64 {
        TAU * f64::from(self.revolutions) / self.counts as f64
    }

    /// The count of a shaft at `angle` rad: `floor(angle/D + 1/2)`, saturated at the ends of `i64`.
    #[allow(clippy::as_conversions)] // float to integer `as` saturates, and there is no other conversion in core
    pub fn count_at(self, angle: f64) -> i64 {
        libm_floor(angle / self.resolution() + 0.5) as i64
    }
}

fn greatest_common_divisor(mut one: u64, mut other: u64) -> u64 {
    while other != 0 {
        (one, other) = (other, one % other);
    }
    one.max(1)
}

fn libm_floor(value: f64) -> f64 {
    nalgebra::ComplexField::floor(value)
}

/// Bits of a drive's position counter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CounterWidth(u8);

impl CounterWidth {
    /// Widths that exist: 8 to 32 bits.
    pub const RANGE: core::ops::RangeInclusive<u8> = 8..=32;

    /// The width of object 6064h where the drive uses all of it.
    pub const FULL: Self = Self(32);

    /// A counter of `bits` bits.
    ///
    /// # Errors
    /// [`EncoderError::CounterWidth`] outside [`CounterWidth::RANGE`].
    pub fn new(bits: u8) -> Result<Self, EncoderError> {
        if Self::RANGE.contains(&bits) { Ok(Self(bits)) } else { Err(EncoderError::CounterWidth { bits }) }
    }

    /// The number of bits.
    pub const fn get(self) -> u8 {
        self.0
    }

    /// Half of the counter's range: changes of this size or more cannot be told from their complement.
    fn half_range(self) -> i64 {
        1_i64 << (self.0 - 1)
    }

    /// The shortest way from `from` to `to` on the counter's circle, in −2^(w−1) … 2^(w−1) − 1.
    fn difference(self, to: i32, from: i32) -> i32 {
        let unused = 32 - u32::from(self.0);
        // Shifting left drops the bits above the width, shifting back extends the sign.
        (to.wrapping_sub(from) << unused) >> unused
    }
}

/// Which way a drive is mounted on its joint: the sign between the drive's counts and torques and the joint's.
///
/// With the feature `serde` it is the text `"positive"` or `"negative"`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum Direction {
    /// Counts grow when the joint turns in its positive direction, and a positive torque turns it that way.
    #[default]
    Positive,
    /// Counts fall when the joint turns in its positive direction, and a positive torque turns it the other way.
    Negative,
}

impl Direction {
    /// `value` with the direction's sign: unchanged for [`Direction::Positive`], negated for [`Direction::Negative`].
    pub fn apply<V: core::ops::Neg<Output = V>>(self, value: V) -> V {
        match self {
            Self::Positive => value,
            Self::Negative => -value,
        }
    }
}

/// How fast a joint can turn, as far as the plausibility of its counts goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JumpLimit {
    velocity: f64,
    margin: u32,
}

impl JumpLimit {
    /// A change of up to `velocity` rad/s × elapsed time, plus `margin` counts, is believed.
    ///
    /// # Errors
    /// [`EncoderError::JumpVelocity`] unless `velocity` is finite and above zero.
    pub fn new(velocity: f64, margin: u32) -> Result<Self, EncoderError> {
        if velocity.is_finite() && velocity > 0.0 {
            Ok(Self { velocity, margin })
        } else {
            Err(EncoderError::JumpVelocity { velocity })
        }
    }

    #[allow(clippy::as_conversions)] // float to integer `as` saturates
    fn counts(self, resolution: f64, elapsed: Duration) -> i64 {
        let turned = libm_floor(self.velocity * elapsed.as_secs_f64() / resolution) as i64;
        turned.saturating_add(i64::from(self.margin))
    }
}

/// What has to be known of an encoder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EncoderConfiguration {
    /// Counts in a revolution of the joint.
    pub counts_per_revolution: CountsPerRevolution,
    /// Bits of the counter.
    pub counter_width: CounterWidth,
    /// Which way it counts when the joint turns in its positive direction.
    pub direction: Direction,
    /// The counter's value where the joint angle is zero.
    pub zero: i32,
    /// Which changes are believed.
    pub jump_limit: JumpLimit,
}

impl EncoderConfiguration {
    /// This configuration with `zero` chosen such that the counter value `raw` reads as `angle` rad, to the nearest
    /// count: for incremental encoders that start anywhere, in a pose that is known.
    #[must_use]
    #[allow(clippy::as_conversions)] // keeps the low 32 bits, which is what a wrapping counter does
    pub fn referenced(self, raw: i32, angle: f64) -> Self {
        let count = self.direction.apply(self.counts_per_revolution.count_at(angle)) as i32;
        Self { zero: raw.wrapping_sub(count), ..self }
    }
}

impl EncoderConfiguration {
    /// By how much the joint turned from one value of the counter to another, the shorter way, rad.
    pub fn turned(&self, from: i32, to: i32) -> f64 {
        let counts = self.direction.apply(self.counter_width.difference(to, from).into());
        Encoder::new(*self).angle_of(counts)
    }
}

/// What is wrong with an encoder's configuration or with what it reports.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum EncoderError {
    /// See [`CountsPerRevolution::RANGE`].
    #[error("{counts} counts per revolution, expected {} to {}", CountsPerRevolution::RANGE.start(), CountsPerRevolution::RANGE.end())]
    CountsPerRevolution {
        /// The counts per revolution that were asked for.
        counts: u64,
    },
    /// See [`CounterWidth::RANGE`].
    #[error("a counter of {bits} bits, expected {} to {}", CounterWidth::RANGE.start(), CounterWidth::RANGE.end())]
    CounterWidth {
        /// The width that was asked for, bits.
        bits: u8,
    },
    /// See [`JumpLimit::new`].
    #[error("a greatest joint velocity of {velocity} rad/s, expected a finite one above zero")]
    JumpVelocity {
        /// The velocity that was asked for, rad/s.
        velocity: f64,
    },
    /// The counter changed by more than the joint can have turned.
    #[error("the counter went by {change} counts in {elapsed:?}, the joint cannot turn more than {limit}")]
    Jump {
        /// Counts by which it changed since the last reading that was believed.
        change: i64,
        /// Counts that would have been believed.
        limit: i64,
        /// Time since that reading.
        elapsed: Duration,
    },
    /// In the time since the last reading the joint may have turned half of the counter's range.
    #[error(
        "{elapsed:?} without a reading: the joint may have turned {limit} counts, a {bits}-bit counter tells less than {half_range}"
    )]
    Ambiguous {
        /// Counts that the joint may have turned.
        limit: i64,
        /// Half of the counter's range.
        half_range: i64,
        /// Width of the counter.
        bits: u8,
        /// Time since the last reading.
        elapsed: Duration,
    },
}

/// An encoder's state: plain data, a copy of it is a snapshot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encoder {
    configuration: EncoderConfiguration,
    last: Option<EncoderReading>,
}

/// The last reading that was believed: all that an encoder remembers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EncoderReading {
    /// The counter's value.
    pub raw: i32,
    /// Counts from the joint's zero, in the joint's direction.
    pub count: i64,
    /// Time since then in which there was none, or readings were refused.
    pub age: Duration,
}

impl Encoder {
    /// An encoder that has read nothing yet.
    pub const fn new(configuration: EncoderConfiguration) -> Self {
        Self { configuration, last: None }
    }

    /// What the encoder was built with.
    pub const fn configuration(&self) -> &EncoderConfiguration {
        &self.configuration
    }

    /// Takes the counter's value, `elapsed` after the previous call, and gives the count from the joint's zero in the
    /// joint's direction.
    ///
    /// The first reading is taken as the one nearest to the zero. A reading that is refused leaves the encoder as it
    /// was, and its time counts towards the next.
    ///
    /// # Errors
    /// [`EncoderError::Jump`], [`EncoderError::Ambiguous`].
    pub fn update(&mut self, raw: i32, elapsed: Duration) -> Result<i64, EncoderError> {
        let EncoderConfiguration { counter_width: width, direction, zero, jump_limit, .. } = self.configuration;
        let count = match &mut self.last {
            None => direction.apply(i64::from(width.difference(raw, zero))),
            Some(last) => {
                last.age = last.age.saturating_add(elapsed);
                let elapsed = last.age;
                let limit = jump_limit.counts(self.configuration.counts_per_revolution.resolution(), elapsed);
                let half_range = width.half_range();
                if limit >= half_range {
                    return Err(EncoderError::Ambiguous { limit, half_range, bits: width.get(), elapsed });
                }
                let change = i64::from(width.difference(raw, last.raw));
                if change.abs() > limit {
                    return Err(EncoderError::Jump { change, limit, elapsed });
                }
                last.count.saturating_add(direction.apply(change))
            }
        };
        self.last = Some(EncoderReading { raw, count, age: Duration::ZERO });
        Ok(count)
    }

    /// Lets `elapsed` pass without a reading; it counts towards the next.
    pub const fn skip(&mut self, elapsed: Duration) {
        if let Some(last) = &mut self.last {
            last.age = last.age.saturating_add(elapsed);
        }
    }

    /// The whole state, to be put back with [`Encoder::thaw`].
    pub const fn freeze(&self) -> Option<EncoderReading> {
        self.last
    }

    /// Goes on from a frozen state.
    pub const fn thaw(&mut self, state: Option<EncoderReading>) {
        self.last = state;
    }

    /// The angle of a count: `count · D`, rad.
    pub fn angle_of(&self, count: i64) -> f64 {
        let count: f64 = nalgebra::convert(count);
        count * self.configuration.counts_per_revolution.resolution()
    }

    /// The angle after the last reading that was believed, rad.
    pub fn angle(&self) -> Option<f64> {
        self.last.map(|last| self.angle_of(last.count))
    }
}

#[cfg(test)]
mod tests;
