//! The steady-state Kalman filter.

use super::estimate::{Estimate, EstimationMethod, EstimatorError, Real, positive};
use nalgebra::{Matrix3, Vector3};

/// What the filter is told of the motion and of the measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KalmanSettings {
    /// Spectral density of the jerk, (rad/s³)² s.
    pub jerk_density: f64,
    /// Standard deviation of a measured angle, rad: D/√12 for a quantisation step D.
    pub measurement_deviation: f64,
    /// The period for which the Riccati equation is solved, s.
    pub nominal_period: f64,
}

/// A Kalman filter for constant acceleration driven by white jerk, in its steady state.
///
/// x = [q, q̇, q̈]ᵀ, F(T) the Taylor matrix, Q(T) = S ∫ F(t) e₃ e₃ᵀ Fᵀ(t) dt, H = [1 0 0]. At construction the discrete
/// Riccati equation at the nominal period is solved for the covariance P⁺ after a measurement. A step of any period T
/// then uses the gain K(T) = P⁻Hᵀ / (P⁻₁₁ + σ²) with P⁻ = F(T) P⁺ Fᵀ(T) + Q(T): at the nominal period the steady gain,
/// and for a single other period among nominal ones exactly the gain of the full filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KalmanFilter<T: Real> {
    /// P⁺ in units of σ² and of the nominal period.
    covariance: Matrix3<T>,
    /// S T₀⁵ / σ².
    jerk_ratio: T,
    nominal_period: T,
}

impl<T: Real> KalmanFilter<T> {
    /// A filter in its steady state.
    ///
    /// # Errors
    /// [`EstimatorError::NotPositive`], [`EstimatorError::Riccati`].
    pub fn new(settings: &KalmanSettings) -> Result<Self, EstimatorError> {
        let jerk_density: f64 = positive("jerk density ((rad/s³)² s)", settings.jerk_density)?;
        let deviation: f64 = positive("measurement deviation (rad)", settings.measurement_deviation)?;
        let period: f64 = positive("nominal period (s)", settings.nominal_period)?;
        let squared = period * period;
        let jerk_ratio = jerk_density * squared * squared * period / (deviation * deviation);
        let refused = EstimatorError::Riccati { tracking_index: nalgebra::ComplexField::sqrt(jerk_ratio) };
        let prior = solve_riccati(jerk_ratio).ok_or(refused)?;
        let posterior = prior - prior.column(0) * prior.row(0) / (prior.m11 + 1.0);
        Ok(Self {
            covariance: posterior.map(T::constant),
            jerk_ratio: T::constant(jerk_ratio),
            nominal_period: T::constant(period),
        })
    }

    /// K(T) for a step of `period` s: angle, velocity (1/s) and acceleration (1/s²) per rad of innovation.
    pub fn gain(&self, period: T) -> Vector3<T> {
        let steps = period / self.nominal_period;
        let transition = transition(steps);
        let noise = process_noise(steps) * self.jerk_ratio;
        let prior = transition * self.covariance * transition.transpose() + noise;
        let dimensionless = prior.column(0) / (prior.m11 + T::one());
        let velocity_unit = T::one() / self.nominal_period;
        dimensionless.component_mul(&Vector3::new(T::one(), velocity_unit, velocity_unit * velocity_unit))
    }
}

/// F over `t` nominal periods.
fn transition<T: Real>(t: T) -> Matrix3<T> {
    let (zero, one) = (T::zero(), T::one());
    Matrix3::new(one, t, t * t * T::constant(0.5), zero, one, t, zero, zero, one)
}

/// ∫₀ᵗ F e₃ e₃ᵀ Fᵀ over `t` nominal periods.
fn process_noise<T: Real>(t: T) -> Matrix3<T> {
    let part = |divisor: f64, power: i32| t.powi(power) / T::constant(divisor);
    let (pp, pr, pa, rr, ra, aa) = (part(20.0, 5), part(8.0, 4), part(6.0, 3), part(3.0, 3), part(2.0, 2), t);
    Matrix3::new(pp, pr, pa, pr, rr, ra, pa, ra, aa)
}

/// The covariance before a measurement, P = F (P − P Hᵀ H P / (P₁₁ + 1)) Fᵀ + Q, for unit period and unit measurement
/// variance, by the structure-preserving doubling algorithm; `None` if it does not settle.
fn solve_riccati(jerk_ratio: f64) -> Option<Matrix3<f64>> {
    /// Doubling squares the closed loop's contraction each time: 60 cover any that differs from 1 in `f64`.
    const DOUBLINGS: u32 = 60;
    let mut a = transition(1.0_f64).transpose();
    let mut g = Matrix3::from_diagonal(&Vector3::new(1.0, 0.0, 0.0));
    let mut h = process_noise(1.0) * jerk_ratio;
    for _ in 0..DOUBLINGS {
        let inverse = (Matrix3::identity() + g * h).try_inverse()?;
        let step = a.transpose() * h * inverse * a;
        g += a * inverse * g * a.transpose();
        a = a * inverse * a;
        h += step;
        h = (h + h.transpose()) * 0.5;
        if !h.iter().all(|entry| entry.is_finite()) {
            return None;
        }
        if step.norm() <= f64::EPSILON * h.norm() {
            return Some(h);
        }
    }
    None
}

impl<T: Real> EstimationMethod<T> for KalmanFilter<T> {
    fn step(&self, last: &Estimate<T>, position: T, period: T) -> Estimate<T> {
        let gain = self.gain(period);
        let predicted = last.predict(period);
        let innovation = position - predicted.position;
        Estimate {
            position: predicted.position + gain.x * innovation,
            velocity: predicted.velocity + gain.y * innovation,
            acceleration: predicted.acceleration + gain.z * innovation,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn prior_after(posterior: &Matrix3<f64>, steps: f64, jerk_ratio: f64) -> Matrix3<f64> {
        let f = transition(steps);
        f * posterior * f.transpose() + process_noise(steps) * jerk_ratio
    }

    fn measured(prior: &Matrix3<f64>) -> Matrix3<f64> {
        // Joseph's form: shares nothing with the subtraction used above.
        let gain = prior.column(0) / (prior.m11 + 1.0);
        let keep = Matrix3::identity() - gain * nalgebra::RowVector3::new(1.0, 0.0, 0.0);
        keep * prior * keep.transpose() + gain * gain.transpose()
    }

    /// A constant acceleration of 1 takes the angle by t²/2.
    #[test]
    fn a_state_is_taken_on_by_its_taylor_matrix() {
        assert_eq!(transition(2.0), Matrix3::new(1.0, 2.0, 2.0, 0.0, 1.0, 2.0, 0.0, 0.0, 1.0));
        assert_eq!(transition(0.5), Matrix3::new(1.0, 0.5, 0.125, 0.0, 1.0, 0.5, 0.0, 0.0, 1.0));
    }

    /// The doubling against the plain recursion of the filter, run until it stands.
    #[test]
    fn the_riccati_solution_is_where_the_recursion_ends() {
        for jerk_ratio in [1e-6, 1e-3, 1.0, 1e3] {
            let solution = solve_riccati(jerk_ratio).unwrap();
            let mut prior = Matrix3::identity() * 10.0;
            for _ in 0..20_000 {
                prior = prior_after(&measured(&prior), 1.0, jerk_ratio);
            }
            // The recursion rounds 20 000 times, the doubling some ten times.
            assert_relative_eq!(solution, prior, max_relative = 1e-9);
        }
    }

    #[test]
    fn one_long_step_has_the_gain_of_the_full_filter() {
        let settings = KalmanSettings { jerk_density: 50.0, measurement_deviation: 2e-4, nominal_period: 0.003 };
        let filter = KalmanFilter::<f64>::new(&settings).unwrap();
        let jerk_ratio = 50.0 * 0.003_f64.powi(5) / 4e-8;
        let mut posterior = Matrix3::identity();
        for _ in 0..20_000 {
            posterior = measured(&prior_after(&posterior, 1.0, jerk_ratio));
        }
        let prior = prior_after(&posterior, 2.5, jerk_ratio);
        let full = prior.column(0) / (prior.m11 + 1.0);
        let gain = filter.gain(0.0075);
        assert_relative_eq!(gain.x, full.x, max_relative = 1e-9);
        assert_relative_eq!(gain.y, full.y / 0.003, max_relative = 1e-9);
        assert_relative_eq!(gain.z, full.z / 0.003 / 0.003, max_relative = 1e-9);
    }
}
