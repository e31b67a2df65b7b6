//! Random streams: one for each seed, subject and index, independent of who draws first.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

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

/// A stream of random numbers: `ChaCha8` (Bernstein 2008).
#[derive(Clone, Debug)]
pub struct Stream(ChaCha8Rng);

impl Stream {
    /// The stream of (seed, subject, index): seed and subject are the cipher's key, the index is its stream.
    ///
    /// No two of them share key and stream.
    pub fn new(seed: u64, subject: Subject, index: u64) -> Self {
        let mut key = [0; 32];
        for (byte, word) in key.iter_mut().zip([seed, subject.number()].map(u64::to_le_bytes).as_flattened()) {
            *byte = *word;
        }
        let mut generator = ChaCha8Rng::from_seed(key);
        generator.set_stream(index);
        Self(generator)
    }

    /// A number between `low` and `high`, uniformly: `low` when the two are the same.
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.random::<f64>()
    }

    /// A whole number from 0 to below `limit`, uniformly; 0 if `limit` is.
    pub fn below(&mut self, limit: usize) -> usize {
        let drawn = self.0.random_range(0..u64::try_from(limit).unwrap_or(u64::MAX).max(1));
        usize::try_from(drawn).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_of_the_cipher() {
        // The first two words of 64 bits of ChaCha8's key stream, key (7, 2, 0, 0) and stream 5, by a program of RFC 8439's
        // rounds that gives the published key stream of key and stream 0; their upper 53 bits are the fraction.
        let mut stream = Stream::new(7, Subject::Plant, 5);
        assert_eq!([(); 2].map(|()| stream.uniform(0.0, 1.0)), [0.775_080_552_154_132_5, 0.774_144_970_334_325_5]);
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
