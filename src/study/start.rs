//! What differs between the repetitions of an experiment on a robot: where exactly it starts.

use nalgebra::SVector;
use serde::{Deserialize, Serialize};

use super::random::{Stream, Subject};
use crate::robot::Robot;

/// How far from its nominal start each joint may be put, either way: 0.1 deg, about nine counts of the UARM's fitted
/// encoders. Chosen; the paper does not say how its robot was put back.
pub const LARGEST_START_ERROR: f64 = 0.1 * std::f64::consts::PI / 180.0;

/// What differs from repetition to repetition.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum StartVariation {
    /// Nothing: every repetition is the experiment of `uarm run --virtual-time`, bit for bit
    None,
    /// Where within a count each joint's true angle lies at the start: uniform over one count
    EncoderPhase,
    /// The encoder phase, and how well the robot was put to its start: uniform within 0.1 deg at each joint
    #[default]
    Full,
}

impl StartVariation {
    /// How far the joints' true angles are from the nominal start in experiment `index` of `seed`, rad.
    ///
    /// Encoders count from a grid that is fixed to the nominal angles; a phase of the grid is hence a part of a count by
    /// which the true angle is off.
    pub fn offset<const J: usize, const N: usize>(self, robot: &Robot<J, N>, seed: u64, index: u64) -> SVector<f64, J> {
        let mut stream = Stream::new(seed, Subject::Start, index);
        let half_count = SVector::from(
            robot.description.joints.each_ref().map(|joint| 0.5 * joint.encoder.counts_per_revolution.resolution()),
        );
        // Phases first: with and without start errors they are the same.
        let phase = half_count.map(|half| stream.uniform(-half, half));
        let error = SVector::<f64, J>::repeat(LARGEST_START_ERROR).map(|largest| stream.uniform(-largest, largest));
        match self {
            Self::None => SVector::zeros(),
            Self::EncoderPhase => phase,
            Self::Full => phase + error,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_stay_in_their_range_and_fill_it() {
        let robot = Robot::load(None).unwrap();
        let half_count = std::f64::consts::PI / 33_739.0;
        let largest = |variation: StartVariation| {
            (0..2_000).map(|index| variation.offset(&robot, 3, index).amax()).fold(0.0, f64::max)
        };
        assert_eq!(largest(StartVariation::None), 0.0);
        let phase = largest(StartVariation::EncoderPhase);
        assert!(phase <= half_count && phase > 0.99 * half_count, "{phase}");
        let full = largest(StartVariation::Full);
        assert!(full <= LARGEST_START_ERROR + half_count && full > 0.97 * LARGEST_START_ERROR, "{full}");
    }
}
