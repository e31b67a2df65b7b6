//! Levant's exact differentiator.

use super::estimate::{Estimate, EstimationMethod, EstimatorError, Real, positive};

/// Levant's second-order differentiator, exact without noise for signals whose third derivative stays below L.
///
/// With e = z0 − q, in the form without recursion:
///
/// ż0 = z1 − 2 L^(1/3) |e|^(2/3) sgn e, ż1 = z2 − 1.5 √2 L^(2/3) |e|^(1/3) sgn e, ż2 = −1.1 L sgn e
///
/// (parameters 1.1, 1.5, 2: A. Levant, Int. J. Control 76 (2003) 924–941). One explicit Euler step would lose the
/// accuracy of the continuous form; the homogeneous discretisation (M. Livne, A. Levant, Automatica 50 (2014)
/// 2061–2068) adds the Taylor terms of the state: z0 += T²/2 · z2, and keeps |e| ~ L T³, velocity error ~ L T²,
/// acceleration error ~ L T. Noise of size ε gives a velocity error ~ L^(1/3) ε^(2/3). The correction of z0 over one step
/// is held to the innovation itself, so that a long period does not overshoot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevantDifferentiator<T: Real> {
    /// L.
    jerk_bound: T,
    /// L^(1/3).
    cube_root: T,
}

/// λ2, λ1 √λ2, λ0 of the form without recursion.
const GAINS: [f64; 3] = [2.0, 1.5 * core::f64::consts::SQRT_2, 1.1];

impl<T: Real> LevantDifferentiator<T> {
    /// A differentiator for angles whose third derivative stays below `jerk_bound` rad/s³.
    ///
    /// # Errors
    /// [`EstimatorError::NotPositive`].
    pub fn new(jerk_bound: f64) -> Result<Self, EstimatorError> {
        let jerk_bound: T = positive("jerk bound (rad/s³)", jerk_bound)?;
        Ok(Self { jerk_bound, cube_root: jerk_bound.cbrt() })
    }
}

impl<T: Real> EstimationMethod<T> for LevantDifferentiator<T> {
    fn step(&self, last: &Estimate<T>, position: T, period: T) -> Estimate<T> {
        let [lambda2, lambda1, lambda0] = GAINS.map(T::constant);
        let predicted = last.predict(period);
        let error = predicted.position - position;
        let magnitude = error.abs();
        let sign = if error == T::zero() { T::zero() } else { error.signum() };
        let root = magnitude.cbrt();
        let correction = (lambda2 * self.cube_root * root * root * period).min(magnitude);
        Estimate {
            position: predicted.position - correction * sign,
            velocity: predicted.velocity - lambda1 * self.cube_root * self.cube_root * root * period * sign,
            acceleration: predicted.acceleration - lambda0 * self.jerk_bound * period * sign,
        }
    }
}
