//! The α-β-γ tracking loop.

use super::estimate::{Estimate, EstimationMethod, EstimatorError, Real, positive};

/// A loop that tracks angle, velocity and acceleration, and corrects all three by the innovation r = q − q̂:
///
/// q̂ += α r, q̇̂ += β r / T, q̈̂ += 2γ r / T².
///
/// All three poles lie at θ = exp(−ω T), which is critical damping (Benedict–Bordner's fading memory):
/// α = 1 − θ³, β = 3/2 (1 − θ)² (1 + θ), 2γ = (1 − θ)³. The gains follow the period of each step, so that the loop is
/// the sampled image of one continuous loop with a triple pole at −ω. A constant acceleration is tracked without error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackingLoop<T: Real> {
    bandwidth: T,
}

impl<T: Real> TrackingLoop<T> {
    /// A loop with its poles at −`bandwidth` rad/s.
    ///
    /// # Errors
    /// [`EstimatorError::NotPositive`].
    pub fn new(bandwidth: f64) -> Result<Self, EstimatorError> {
        Ok(Self { bandwidth: positive("tracking bandwidth (rad/s)", bandwidth)? })
    }
}

impl<T: Real> EstimationMethod<T> for TrackingLoop<T> {
    fn step(&self, last: &Estimate<T>, position: T, period: T) -> Estimate<T> {
        let one = T::one();
        let pole = (-self.bandwidth * period).exp();
        let decay = one - pole;
        let predicted = last.predict(period);
        let innovation = position - predicted.position;
        let alpha = one - pole * pole * pole;
        let beta = T::constant(1.5) * decay * decay * (one + pole);
        let two_gamma = decay * decay * decay;
        Estimate {
            position: predicted.position + alpha * innovation,
            velocity: predicted.velocity + beta * innovation / period,
            acceleration: predicted.acceleration + two_gamma * innovation / (period * period),
        }
    }
}
