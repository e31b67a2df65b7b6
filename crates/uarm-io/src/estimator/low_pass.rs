//! Differentiation with a first-order low-pass: what the paper's robot does.

use super::estimate::{Estimate, EstimationMethod, EstimatorError, Real, positive};

/// The backward difference of the angle through a first-order low-pass of cutoff ω_c, from rest:
///
/// q̇_k = q̇_{k−1} + α ((q_k − q_{k−1}) / T_k − q̇_{k−1}), α = 1 − exp(−ω_c T_k).
///
/// α is the exact discretisation for an input that is constant over the step, so that a longer step weighs its
/// difference more. The acceleration is the backward difference of the filtered velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LowPassDerivative<T: Real> {
    cutoff: T,
}

impl<T: Real> LowPassDerivative<T> {
    /// A filter with its cutoff at `cutoff` rad/s.
    ///
    /// # Errors
    /// [`EstimatorError::NotPositive`].
    pub fn new(cutoff: f64) -> Result<Self, EstimatorError> {
        Ok(Self { cutoff: positive("low-pass cutoff (rad/s)", cutoff)? })
    }
}

impl<T: Real> EstimationMethod<T> for LowPassDerivative<T> {
    fn step(&self, last: &Estimate<T>, position: T, period: T) -> Estimate<T> {
        let smoothing = T::one() - (-self.cutoff * period).exp();
        let difference = (position - last.position) / period;
        let velocity = last.velocity + smoothing * (difference - last.velocity);
        Estimate { position, velocity, acceleration: (velocity - last.velocity) / period }
    }
}
