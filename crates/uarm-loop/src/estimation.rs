//! From counts to what the laws know of the robot.
//!
//! A count that did not come is replaced, for at most [`MOST_PREDICTED`] cycles in a row: the joint is taken to have gone on
//! from its last count with its estimated velocity. The estimator takes that angle as if it were measured.

use hinf_control::{BaseMeasurement, Measurement};
use uarm_io::encoder::{Encoder, EncoderConfiguration, EncoderError, EncoderReading};
use uarm_io::estimator::{self, AnyEstimator, EstimatorState};
use uarm_io::time::Duration;

use crate::dimensions;
use crate::plausibility::{AccelerationBound, Elapsed, Trend, Window};

/// The encoders and the velocity estimators of `J` joints.
#[derive(Clone, Copy, Debug)]
pub struct Estimation<const J: usize> {
    joints: [JointEstimation; J],
    bounds: Option<[AccelerationBound; J]>,
}

/// How many counts in a row may be refused; one more ends the run.
pub const MOST_REFUSED: u32 = 1;
/// In how many cycles in a row a joint's angle may be predicted; one more ends the run.
pub const MOST_PREDICTED: u32 = 2;

#[derive(Clone, Copy, Debug)]
struct JointEstimation {
    encoder: Encoder,
    estimator: AnyEstimator<f64>,
    /// For how many cycles in a row the angle was predicted.
    predicted: u32,
    /// How many counts in a row were refused.
    refused: u32,
    trend: Trend,
    /// How far the time since the last count may be from the true one, s.
    time_error: f64,
}

/// Where the angle of a joint in one cycle comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AngleSource {
    /// From the count of this cycle.
    #[default]
    Measured,
    /// Predicted: no count came in time.
    Missing,
    /// Predicted: the count that came cannot be where the joint is.
    Refused,
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
    /// How many counts in a row were refused.
    pub refused: u32,
    /// How the joint went between its last two counts.
    pub trend: Trend,
    /// How far the time since the last count may be from the true one, s.
    pub time_error: f64,
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
    /// Counts that are not where the joint's motion leads, with all the acceleration that it can have.
    #[error(
        "the counter went by {change} counts in {elapsed:?}, expected {expected:.1} with a tolerance of {tolerance:.1}: the joint cannot accelerate like that"
    )]
    Implausible {
        /// Counts by which it changed since the last one that was believed.
        change: i64,
        /// Counts that were expected.
        expected: f64,
        /// How far from that is believed, counts.
        tolerance: f64,
        /// Time since that count.
        elapsed: Duration,
    },
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
            bounds: None,
            joints: joints.map(|(configuration, estimator)| JointEstimation {
                encoder: Encoder::new(configuration),
                estimator,
                predicted: 0,
                refused: 0,
                trend: Trend::default(),
                time_error: 0.0,
            }),
        }
    }

    /// The same, which refuses counts that need more acceleration than `bounds`.
    #[must_use]
    pub const fn within(self, bounds: Option<[AccelerationBound; J]>) -> Self {
        Self { bounds, ..self }
    }

    /// Takes in the counts of one cycle, `elapsed` after the last; nothing of a joint whose drive sent none.
    ///
    /// # Errors
    /// [`EstimationError`] if a count cannot be where a joint has gone, or is missing for too long.
    pub fn estimate(&mut self, counts: &[Option<i32>; J], elapsed: Elapsed) -> Result<Estimate<J>, EstimationError> {
        let fastest = self.joints.iter().map(JointEstimation::speed).fold(0.0, f64::max);
        let bounds = self.bounds.map_or([None; J], |bounds| bounds.map(Some));
        let mut estimate = Estimate::default();
        let joints = self.joints.iter_mut().zip(counts).zip(bounds).zip(1..);
        let angles = estimate.measured.iter_mut().zip(&mut estimate.sources);
        let results = estimate.joints.iter_mut().zip(&mut estimate.counts).zip(angles);
        for ((((joint, raw), bound), number), ((motion, count), (measured, source))) in joints.zip(results) {
            *source = joint
                .read(*raw, elapsed, bound, fastest)
                .map_err(|source| EstimationError { joint: number, source })?;
            *measured = joint.angle();
            *motion = joint.estimator.update(*measured, elapsed.period);
            *count = joint.encoder.freeze().map_or(0, |last| last.raw);
        }
        Ok(estimate)
    }

    /// The angles after the last readings that were believed, rad; none before the first.
    pub fn angles(&self) -> [Option<f64>; J] {
        self.joints.each_ref().map(|joint| joint.encoder.angle())
    }

    /// The whole inner state.
    pub fn freeze(&self) -> [JointState; J] {
        self.joints.each_ref().map(|joint| JointState {
            encoder: joint.encoder.freeze(),
            estimator: joint.estimator.freeze(),
            predicted: joint.predicted,
            refused: joint.refused,
            trend: joint.trend,
            time_error: joint.time_error,
        })
    }

    /// Goes on from a frozen state.
    pub fn thaw(&mut self, states: &[JointState; J]) {
        for (joint, state) in self.joints.iter_mut().zip(states) {
            joint.encoder.thaw(state.encoder);
            joint.estimator.thaw(state.estimator);
            joint.predicted = state.predicted;
            joint.refused = state.refused;
            joint.trend = state.trend;
            joint.time_error = state.time_error;
        }
    }
}

impl JointEstimation {
    /// How fast it went between its last two counts, rad/s.
    fn speed(&self) -> f64 {
        self.trend.velocity.abs() * self.encoder.angle_of(1)
    }

    /// Takes in the count of this cycle, if one came.
    fn read(
        &mut self,
        raw: Option<i32>,
        elapsed: Elapsed,
        bound: Option<AccelerationBound>,
        fastest: f64,
    ) -> Result<AngleSource, AngleError> {
        self.time_error += elapsed.error;
        let period = Duration::try_from_secs_f64(elapsed.period).unwrap_or(Duration::ZERO);
        let Some(raw) = raw else {
            return self.predict(period, AngleSource::Missing);
        };
        match self.believed(raw, period, bound, fastest) {
            Ok((encoder, trend)) => {
                (self.encoder, self.trend, self.time_error) = (encoder, trend, 0.0);
                (self.predicted, self.refused) = (0, 0);
                Ok(AngleSource::Measured)
            }
            Err(error @ AngleError::Encoder(EncoderError::Ambiguous { .. })) => Err(error),
            Err(error) => {
                self.refused = self.refused.saturating_add(1);
                if self.refused > MOST_REFUSED { Err(error) } else { self.predict(period, AngleSource::Refused) }
            }
        }
    }

    /// The encoder with this count, and how the joint came there, if both can be.
    fn believed(
        &self,
        raw: i32,
        period: Duration,
        bound: Option<AccelerationBound>,
        fastest: f64,
    ) -> Result<(Encoder, Trend), AngleError> {
        let mut encoder = self.encoder;
        encoder.update(raw, period)?;
        let (Some(from), Some(to)) = (self.encoder.freeze(), encoder.freeze()) else {
            return Ok((encoder, Trend::default()));
        };
        let elapsed = from.age.saturating_add(period);
        let span = elapsed.as_secs_f64();
        if let Some(bound) = bound {
            let window = bound.window(&self.trend, span, self.time_error, encoder.angle_of(1), fastest);
            let change = to.count.saturating_sub(from.count);
            let off: f64 = nalgebra::convert::<i64, f64>(change) - window.expected;
            if off.abs() > window.tolerance {
                let Window { expected, tolerance } = window;
                return Err(AngleError::Implausible { change, expected, tolerance, elapsed });
            }
        }
        Ok((encoder, self.trend.next(&from, &to, span, self.time_error)))
    }

    /// Bears a cycle without a count that can be believed.
    fn predict(&mut self, elapsed: Duration, why: AngleSource) -> Result<AngleSource, AngleError> {
        if self.encoder.freeze().is_none() {
            return Err(AngleError::NoneYet);
        }
        self.encoder.skip(elapsed);
        self.predicted = self.predicted.saturating_add(1);
        if self.predicted > MOST_PREDICTED {
            return Err(AngleError::Missing { cycles: self.predicted });
        }
        Ok(why)
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
            base: BaseMeasurement::planar(
                dimensions::base::<_, J, N>(&self.velocity()),
                dimensions::base::<_, J, N>(&self.joints.each_ref().map(|joint| joint.acceleration)),
            ),
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
