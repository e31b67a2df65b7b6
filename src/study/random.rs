//! Random streams: one for each seed, subject and index, independent of who draws first.

use oorandom::Rand64;

/// What a stream is drawn for. Subjects have streams of their own, so that drawing more for one changes no other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// The start of an experiment.
    Start,
    /// The parameters of a plant.
    Plant,
    /// A fault, and when it happens.
    Fault,
}

impl Subject {
    const fn number(self) -> u64 {
        match self {
            Self::Start => 1,
            Self::Plant => 2,
            Self::Fault => 3,
        }
    }
}

/// A stream of random numbers (PCG, O'Neill 2014).
#[derive(Clone, Debug)]
pub struct Stream(Rand64);

/// 2⁶⁴ over the golden ratio, odd: the increment of SplitMix64 (Steele, Lea, Flood 2014).
const GOLDEN_GAMMA: u64 = 0x9e37_79b9_7f4a_7c15;

impl Stream {
    /// The stream of (seed, subject, index).
    ///
    /// The three are mixed into the generator's 128 bits of state, since neighbouring states of a PCG give related numbers.
    pub fn new(seed: u64, subject: Subject, index: u64) -> Self {
        let subject_key = mix(mix(seed).wrapping_add(subject.number().wrapping_mul(GOLDEN_GAMMA)));
        let high = mix(subject_key.wrapping_add(index.wrapping_mul(GOLDEN_GAMMA)));
        let low = mix(high.wrapping_add(GOLDEN_GAMMA));
        Self(Rand64::new((u128::from(high) << 64) | u128::from(low)))
    }

    /// A number between `low` and `high`, uniformly: `low` when the two are the same.
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.rand_float()
    }

    /// A whole number from 0 to below `limit`, uniformly; 0 if `limit` is.
    pub fn below(&mut self, limit: usize) -> usize {
        let drawn = self.0.rand_range(0..u64::try_from(limit).unwrap_or(u64::MAX).max(1));
        usize::try_from(drawn).unwrap_or_default()
    }
}

/// The output function of SplitMix64: each bit of the input flips each bit of the output half of the time.
const fn mix(value: u64) -> u64 {
    let value = (value ^ (value >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let value = (value ^ (value >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    value ^ (value >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mixes_as_the_published_generator_does() {
        // The first outputs of SplitMix64 from state 0, that of the reference implementation (Vigna).
        assert_eq!(mix(GOLDEN_GAMMA), 0xe220_a839_7b1d_cdaf);
        assert_eq!(mix(GOLDEN_GAMMA.wrapping_mul(2)), 0x6e78_9e6a_a1b9_65f4);
    }

    #[test]
    fn streams_are_reproducible_and_differ_in_each_of_the_three() {
        let first = |seed, subject, index| Stream::new(seed, subject, index).uniform(0.0, 1.0);
        let one = first(1, Subject::Start, 0);
        assert_eq!(one, first(1, Subject::Start, 0));
        assert_ne!(one, first(2, Subject::Start, 0));
        assert_ne!(one, first(1, Subject::Plant, 0));
        assert_ne!(one, first(1, Subject::Start, 1));
    }

    #[test]
    fn first_numbers_of_neighbouring_streams_are_uniform() {
        // Chi-square over 16 bins of 16000 draws has 15 degrees of freedom: above 37.7 in one of 1000 cases.
        let mut bins = [0_u32; 16];
        for index in 0..16_000 {
            let value = Stream::new(7, Subject::Plant, index).uniform(0.0, 16.0);
            bins[value as usize] += 1;
        }
        let chi_square: f64 = bins.iter().map(|count| (f64::from(*count) - 1000.0).powi(2) / 1000.0).sum();
        assert!(chi_square < 37.7, "chi-square {chi_square}");
    }
}
