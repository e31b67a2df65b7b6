//! From counts to what the laws know of the robot.

use hinf_control::{BaseMeasurement, Measurement};
use nalgebra::Vector2;
use uarm_io::encoder::{Encoder, EncoderConfiguration, EncoderError};
use uarm_io::estimator::{self, AnyEstimator, RateEstimator};
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

/// What the encoders tell in one cycle.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    /// Joints 1 to 3.
    pub joints: [estimator::Estimate<f64>; JOINTS],
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
        Ok(Estimate {
            joints: [
                first.update(1, one, elapsed, period)?,
                second.update(2, two, elapsed, period)?,
                third.update(3, three, elapsed, period)?,
            ],
        })
    }
}

impl JointEstimation {
    fn update(
        &mut self,
        joint: usize,
        raw: i32,
        elapsed: Duration,
        period: f64,
    ) -> Result<estimator::Estimate<f64>, EstimationError> {
        let count = self.encoder.update(raw, elapsed).map_err(|source| EstimationError { joint, source })?;
        Ok(self.estimator.update(self.encoder.angle_of(count), period))
    }
}

impl Estimate {
    /// What the laws see.
    pub fn measurement(&self) -> Measurement<f64> {
        let [base, second, third] = &self.joints;
        Measurement {
            position: Vector2::new(second.position, third.position),
            rate: Vector2::new(second.rate, third.rate),
            base: BaseMeasurement { position: base.position, rate: base.rate, acceleration: base.acceleration },
        }
    }

    /// Angles of joints 1 to 3, rad.
    pub fn position(&self) -> [f64; JOINTS] {
        self.joints.each_ref().map(|joint| joint.position)
    }

    /// Rates of joints 1 to 3, rad/s.
    pub fn rate(&self) -> [f64; JOINTS] {
        self.joints.each_ref().map(|joint| joint.rate)
    }
}
