//! Differentiation with a first-order low-pass: what the paper's robot does.

use super::{Estimate, EstimatorError, EstimatorState, RateEstimator, positive};
use crate::real::Real;

/// The backward difference of the angle through a first-order low-pass of corner ω_c, from rest:
///
/// q̇_k = q̇_{k−1} + α ((q_k − q_{k−1}) / T_k − q̇_{k−1}), α = 1 − exp(−ω_c T_k).
///
/// α is the exact discretisation for an input that is constant over the step, so that a longer step weighs its
/// difference more. The acceleration is the backward difference of the filtered rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LowPassDerivative<T: Real> {
    corner: T,
    state: EstimatorState<T>,
}

impl<T: Real> LowPassDerivative<T> {
    /// A filter with its corner at `corner` rad/s.
    ///
    /// # Errors
    /// [`EstimatorError::NotPositive`].
    pub fn new(corner: f64) -> Result<Self, EstimatorError> {
        Ok(Self { corner: positive("low-pass corner (rad/s)", corner)?, state: None })
    }
}

impl<T: Real> RateEstimator<T> for LowPassDerivative<T> {
    fn update(&mut self, position: T, period: T) -> Estimate<T> {
        let estimate = match self.state {
            None => Estimate::at_rest(position),
            Some(last) if period.is_positive_finite() => {
                let smoothing = T::one() - (-self.corner * period).exp();
                let difference = (position - last.position) / period;
                let rate = last.rate + smoothing * (difference - last.rate);
                Estimate { position, rate, acceleration: (rate - last.rate) / period }
            }
            // Without time there is no difference; keeping the old angle puts the whole of it into the next step.
            Some(last) => last,
        };
        self.state = Some(estimate);
        estimate
    }

    fn freeze(&self) -> EstimatorState<T> {
        self.state
    }

    fn thaw(&mut self, state: EstimatorState<T>) {
        self.state = state;
    }
}
