//! From counts to what the laws know of the robot.

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

/// What the encoders tell in one cycle of `J` joints, the passive base first.
#[derive(Clone, Copy, Debug)]
pub struct Estimate<const J: usize> {
    /// Estimated motion of each joint.
    pub joints: [estimator::Estimate<f64>; J],
    /// Their angles as the encoders give them, before any filter, rad.
    pub measured: [f64; J],
}

/// An encoder that cannot be believed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("joint {joint}: {source}")]
pub struct EstimationError {
    /// The joint, counted from 1.
    pub joint: usize,
    /// Why its reading is refused.
    pub source: EncoderError,
}

impl<const J: usize> Estimation<J> {
    /// Encoders and estimators of joints 1 to J.
    pub fn new(joints: [(EncoderConfiguration, AnyEstimator<f64>); J]) -> Self {
        Self {
            joints: joints
                .map(|(configuration, estimator)| JointEstimation { encoder: Encoder::new(configuration), estimator }),
        }
    }

    /// Takes in the counts of one cycle, `period` seconds after the last.
    ///
    /// # Errors
    /// [`EstimationError`] if a count cannot be where a joint has gone.
    pub fn estimate(&mut self, counts: &[i32; J], period: f64) -> Result<Estimate<J>, EstimationError> {
        let elapsed = Duration::try_from_secs_f64(period).unwrap_or(Duration::ZERO);
        let mut estimate = Estimate { joints: [estimator::Estimate::at_rest(0.0); J], measured: [0.0; J] };
        let joints = self.joints.iter_mut().zip(counts).zip(1..);
        let results = estimate.joints.iter_mut().zip(&mut estimate.measured);
        for (((joint, raw), number), (motion, measured)) in joints.zip(results) {
            (*measured, *motion) = joint.update(number, *raw, elapsed, period)?;
        }
        Ok(estimate)
    }

    /// The whole inner state.
    pub fn freeze(&self) -> [JointState; J] {
        self.joints
            .each_ref()
            .map(|joint| JointState { encoder: joint.encoder.freeze(), estimator: joint.estimator.freeze() })
    }

    /// Goes on from a frozen state.
    pub fn thaw(&mut self, states: &[JointState; J]) {
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

    /// Angles of the joints, rad.
    pub fn position(&self) -> [f64; J] {
        self.joints.each_ref().map(|joint| joint.position)
    }

    /// Velocities of the joints, rad/s.
    pub fn velocity(&self) -> [f64; J] {
        self.joints.each_ref().map(|joint| joint.velocity)
    }
}
