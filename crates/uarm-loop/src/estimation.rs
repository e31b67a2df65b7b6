//! From counts to what the laws know of the robot.
//!
//! A count that did not come is replaced, for at most [`MOST_PREDICTED`] cycles in a row: the joint is taken to have gone on
//! from its last count with its estimated velocity. The estimator takes that angle as if it were measured.

use hinf_control::{BaseMeasurement, Measurement};
use uarm_io::encoder::{Encoder, EncoderConfiguration, EncoderError, EncoderReading};
use uarm_io::estimator::{self, AnyEstimator, EstimatorState};
use uarm_io::time::Duration;

use crate::dimensions;

/// The encoders and the velocity estimators of `J` joints.
#[derive(Clone, Copy, Debug)]
pub struct Estimation<const J: usize> {
    joints: [JointEstimation; J],
}

/// In how many cycles in a row a joint's angle may be predicted; one more ends the run.
pub const MOST_PREDICTED: u32 = 2;

#[derive(Clone, Copy, Debug)]
struct JointEstimation {
    encoder: Encoder,
    estimator: AnyEstimator<f64>,
    /// For how many cycles in a row the angle was predicted.
    predicted: u32,
}

/// Where the angle of a joint in one cycle comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AngleSource {
    /// From the count of this cycle.
    #[default]
    Measured,
    /// Predicted: no count came in time.
    Missing,
}

/// The inner state of one joint's encoder and estimator.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointState {
    /// What the encoder last read; nothing before the first reading.
    pub encoder: Option<EncoderReading>,
    /// What the estimator last gave; nothing before the first measurement.
    pub estimator: EstimatorState<f64>,
    /// For how many cycles in a row the angle was predicted.
    pub predicted: u32,
}

/// What the encoders tell in one cycle of `J` joints, the passive base first.
#[derive(Clone, Copy, Debug)]
pub struct Estimate<const J: usize> {
    /// Estimated motion of each joint.
    pub joints: [estimator::Estimate<f64>; J],
    /// Their angles as the encoders give them, or as they are predicted, before any filter, rad.
    pub measured: [f64; J],
    /// Where these angles come from.
    pub sources: [AngleSource; J],
    /// The drives' counts that they come from: of a predicted angle, the last one that was believed.
    pub counts: [i32; J],
}

/// A joint of which it is not known where it is.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("joint {joint}: {source}")]
pub struct EstimationError {
    /// The joint, counted from 1.
    pub joint: usize,
    /// Why it is not known.
    pub source: AngleError,
}

/// Why the angle of a joint is not known.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum AngleError {
    /// A count that cannot be where the joint has gone.
    #[error(transparent)]
    Encoder(#[from] EncoderError),
    /// No count came in the first cycle: there is nothing to predict from.
    #[error("its drive sent no position in the first cycle")]
    NoneYet,
    /// No count came in too many cycles.
    #[error("its drive sent no position in {cycles} cycles in a row, expected one in {} at least", MOST_PREDICTED + 1)]
    Missing {
        /// The cycles without one.
        cycles: u32,
    },
}

impl<const J: usize> Estimation<J> {
    /// Encoders and estimators of joints 1 to J.
    pub fn new(joints: [(EncoderConfiguration, AnyEstimator<f64>); J]) -> Self {
        Self {
            joints: joints.map(|(configuration, estimator)| JointEstimation {
                encoder: Encoder::new(configuration),
                estimator,
                predicted: 0,
            }),
        }
    }

    /// Takes in the counts of one cycle, `period` seconds after the last; nothing of a joint whose drive sent none.
    ///
    /// # Errors
    /// [`EstimationError`] if a count cannot be where a joint has gone, or is missing for too long.
    pub fn estimate(&mut self, counts: &[Option<i32>; J], period: f64) -> Result<Estimate<J>, EstimationError> {
        let elapsed = Duration::try_from_secs_f64(period).unwrap_or(Duration::ZERO);
        let mut estimate = Estimate::default();
        let joints = self.joints.iter_mut().zip(counts).zip(1..);
        let angles = estimate.measured.iter_mut().zip(&mut estimate.sources);
        let results = estimate.joints.iter_mut().zip(&mut estimate.counts).zip(angles);
        for (((joint, raw), number), ((motion, count), (measured, source))) in joints.zip(results) {
            *source = joint.read(*raw, elapsed).map_err(|source| EstimationError { joint: number, source })?;
            *measured = joint.angle();
            *motion = joint.estimator.update(*measured, period);
            *count = joint.encoder.freeze().map_or(0, |last| last.raw);
        }
        Ok(estimate)
    }

    /// The angles of the last cycle, measured or predicted, rad; none before the first.
    pub fn angles(&self) -> [Option<f64>; J] {
        self.joints.each_ref().map(|joint| joint.encoder.freeze().map(|_| joint.angle()))
    }

    /// The whole inner state.
    pub fn freeze(&self) -> [JointState; J] {
        self.joints.each_ref().map(|joint| JointState {
            encoder: joint.encoder.freeze(),
            estimator: joint.estimator.freeze(),
            predicted: joint.predicted,
        })
    }

    /// Goes on from a frozen state.
    pub fn thaw(&mut self, states: &[JointState; J]) {
        for (joint, state) in self.joints.iter_mut().zip(states) {
            joint.encoder.thaw(state.encoder);
            joint.estimator.thaw(state.estimator);
            joint.predicted = state.predicted;
        }
    }
}

impl JointEstimation {
    /// Takes in the count of this cycle, if one came.
    fn read(&mut self, raw: Option<i32>, elapsed: Duration) -> Result<AngleSource, AngleError> {
        let Some(raw) = raw else { return self.miss(elapsed) };
        self.encoder.update(raw, elapsed)?;
        self.predicted = 0;
        Ok(AngleSource::Measured)
    }

    /// Bears a cycle without a count.
    fn miss(&mut self, elapsed: Duration) -> Result<AngleSource, AngleError> {
        if self.encoder.freeze().is_none() {
            return Err(AngleError::NoneYet);
        }
        self.encoder.skip(elapsed);
        self.predicted = self.predicted.saturating_add(1);
        if self.predicted > MOST_PREDICTED {
            return Err(AngleError::Missing { cycles: self.predicted });
        }
        Ok(AngleSource::Missing)
    }

    /// The angle at this cycle: of its count, or of the last one, moved on with the estimated velocity.
    fn angle(&self) -> f64 {
        let Some(last) = self.encoder.freeze() else { return 0.0 };
        let angle = self.encoder.angle_of(last.count);
        if last.age.is_zero() {
            return angle;
        }
        let velocity = self.estimator.freeze().map_or(0.0, |estimate| estimate.velocity);
        angle + velocity * last.age.as_secs_f64()
    }
}

impl<const J: usize> Default for Estimate<J> {
    /// All joints at zero, at rest, measured.
    fn default() -> Self {
        Self {
            joints: [estimator::Estimate::at_rest(0.0); J],
            measured: [0.0; J],
            sources: [AngleSource::default(); J],
            counts: [0; J],
        }
    }
}

impl<const J: usize> Estimate<J> {
    /// What the laws see: the motion of the base and of the `N` active joints.
    pub fn measurement<const N: usize>(&self) -> Measurement<f64, N> {
        Measurement {
            position: dimensions::active(&self.position()),
            velocity: dimensions::active(&self.velocity()),
            base: BaseMeasurement {
                position: dimensions::base(&self.position()),
                velocity: dimensions::base(&self.velocity()),
                acceleration: dimensions::base(&self.joints.each_ref().map(|joint| joint.acceleration)),
            },
        }
    }

    /// Whether the angle of some joint is predicted.
    pub fn is_predicted(&self) -> bool {
        self.sources.iter().any(|source| *source != AngleSource::Measured)
    }

    /// Angles of the joints, rad.
    pub fn position(&self) -> [f64; J] {
        self.joints.each_ref().map(|joint| joint.position)
    }

    /// Velocities of the joints, rad/s.
    pub fn velocity(&self) -> [f64; J] {
        self.joints.each_ref().map(|joint| joint.velocity)
    }
}
