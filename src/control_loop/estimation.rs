//! From counts to what the laws know of the robot.

use hinf_control::{BaseMeasurement, Measurement};
use nalgebra::Vector2;
use uarm_io::encoder::{Encoder, EncoderConfiguration, EncoderError, EncoderReading};
use uarm_io::estimator::{self, AnyEstimator, EstimatorState};
use uarm_io::time::Duration;

use super::JOINTS;

/// The encoders and the rate estimators of a robot.
#[derive(Clone, Copy, Debug)]
pub struct Estimation {
    joints: [JointEstimation; JOINTS],
}

#[derive(Clone, Copy, Debug)]
struct JointEstimation {
    encoder: Encoder,
    estimator: AnyEstimator<f64>,
}

/// The inner state of one joint's encoder and estimator.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointState {
    /// What the encoder last read; nothing before the first reading.
    pub encoder: Option<EncoderReading>,
    /// What the estimator last gave; nothing before the first measurement.
    pub estimator: EstimatorState<f64>,
}

/// What the encoders tell in one cycle.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    /// Joints 1 to 3.
    pub joints: [estimator::Estimate<f64>; JOINTS],
    /// Their angles as the encoders give them, before any filter, rad.
    pub measured: [f64; JOINTS],
}

/// An encoder that cannot be believed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("joint {joint}: {source}")]
pub struct EstimationError {
    /// The joint, 1 to 3.
    pub joint: usize,
    /// Why.
    pub source: EncoderError,
}

impl Estimation {
    /// Encoders and estimators of joints 1 to 3.
    pub fn new(joints: [(EncoderConfiguration, AnyEstimator<f64>); JOINTS]) -> Self {
        Self {
            joints: joints
                .map(|(configuration, estimator)| JointEstimation { encoder: Encoder::new(configuration), estimator }),
        }
    }

    /// Takes in the counts of one cycle, `period` seconds after the last.
    ///
    /// # Errors
    /// [`EstimationError`] if a count cannot be where a joint has gone.
    pub fn estimate(&mut self, counts: &[i32; JOINTS], period: f64) -> Result<Estimate, EstimationError> {
        let elapsed = Duration::try_from_secs_f64(period).unwrap_or(Duration::ZERO);
        let [first, second, third] = &mut self.joints;
        let [one, two, three] = *counts;
        let one = first.update(1, one, elapsed, period)?;
        let two = second.update(2, two, elapsed, period)?;
        let three = third.update(3, three, elapsed, period)?;
        Ok(Estimate { joints: [one.1, two.1, three.1], measured: [one.0, two.0, three.0] })
    }

    /// The whole inner state.
    pub fn freeze(&self) -> [JointState; JOINTS] {
        self.joints
            .each_ref()
            .map(|joint| JointState { encoder: joint.encoder.freeze(), estimator: joint.estimator.freeze() })
    }

    /// Goes on from a frozen state.
    pub fn thaw(&mut self, states: &[JointState; JOINTS]) {
        for (joint, state) in self.joints.iter_mut().zip(states) {
            joint.encoder.thaw(state.encoder);
            joint.estimator.thaw(state.estimator);
        }
    }
}

impl JointEstimation {
    /// The angle as measured, and the estimate.
    fn update(
        &mut self,
        joint: usize,
        raw: i32,
        elapsed: Duration,
        period: f64,
    ) -> Result<(f64, estimator::Estimate<f64>), EstimationError> {
        let count = self.encoder.update(raw, elapsed).map_err(|source| EstimationError { joint, source })?;
        let measured = self.encoder.angle_of(count);
        Ok((measured, self.estimator.update(measured, period)))
    }
}

impl Estimate {
    /// What the laws see.
    pub fn measurement(&self) -> Measurement<f64> {
        let [base, second, third] = &self.joints;
        Measurement {
            position: Vector2::new(second.position, third.position),
            rate: Vector2::new(second.velocity, third.velocity),
            base: BaseMeasurement { position: base.position, rate: base.velocity, acceleration: base.acceleration },
        }
    }

    /// Angles of joints 1 to 3, rad.
    pub fn position(&self) -> [f64; JOINTS] {
        self.joints.each_ref().map(|joint| joint.position)
    }

    /// Rates of joints 1 to 3, rad/s.
    pub fn rate(&self) -> [f64; JOINTS] {
        self.joints.each_ref().map(|joint| joint.velocity)
    }
}
