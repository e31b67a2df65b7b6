//! Synthesis of the H∞ feedback: from weights to T0, K and u (paper eqs. 6, 9, 10).
//!
//! With x̃ = [q̃̇; q̃] and B = [I; 0]:
//!
//! - R1ᵀR1 = (R⁻¹ − I/γ²)⁻¹ (Cholesky, R1 upper triangular), which needs R < γ²I,
//! - T0 = [T11 T12; 0 I], T11 = R1ᵀQ1, T12 = R1ᵀQ2,
//! - K = ½(Q1ᵀQ2 + Q2ᵀQ1) − ½(Q12ᵀ + Q12) > 0,
//! - [0 K; K 0] − T0ᵀB(R⁻¹ − I/γ²)BᵀT0 + Q = 0 (eq. 9), whose residual is reported,
//! - u = −R⁻¹BᵀT0x̃ = −R⁻¹(T11 q̃̇ + T12 q̃) (eq. 10).
//!
//! The off-diagonal block of eq. 9 is K − Q1ᵀQ2 + Q12, so the equation can only hold where Q1ᵀQ2 − Q12 is symmetric. With
//! [`WeightReading::Blocks`] the factors are ours to choose: Q1 = √(Q1ᵀQ1) and Q2 = Q1⁻¹(Q1ᵀQ1 # Q2ᵀQ2), # being the
//! geometric mean of positive definite matrices, give a symmetric Q1ᵀQ2 whatever the blocks. For diagonal blocks these
//! are the plain square roots.

use crate::small_matrix::{block_matrix, eigenvalues, geometric_mean, invert_well_conditioned, square_root};
use crate::{Reference, SynthesisError, TrackingError, WeightReading, Weights};
use dem_model::Scalar;
use nalgebra::{Matrix2, Matrix4, Vector2};

/// Symmetry and eq. 9 are checked to this many units of rounding of the largest number involved.
const ROUNDING_ALLOWANCE: f64 = 1e3;

/// The motion that the nominal torque is computed for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AuxiliaryMotion<T: Scalar> {
    /// x1 = q̈_mᵈ − Λq̃̇, rad/s².
    pub acceleration: Vector2<T>,
    /// x2 = q̇_mᵈ − Λq̃, rad/s.
    pub velocity: Vector2<T>,
}

/// A solved design: what the laws need of it, ready to use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Synthesis<T: Scalar> {
    attenuation_level: T,
    control_weight: Matrix2<T>,
    /// R⁻¹.
    control_gain: Matrix2<T>,
    state_weight: Matrix4<T>,
    t11: Matrix2<T>,
    t12: Matrix2<T>,
    t11_inverse: Matrix2<T>,
    /// Λ = T11⁻¹T12.
    error_rate: Matrix2<T>,
    storage: Matrix2<T>,
    residual: T,
}

impl<T: Scalar> Synthesis<T> {
    /// Solves eq. 9 for `weights`.
    ///
    /// # Errors
    /// [`SynthesisError`], one variant for each reason why a design is refused.
    ///
    /// ```
    /// use hinf_control::{ControllerSettings, Law, Synthesis};
    /// let weights = ControllerSettings::default().weights::<f64>(Law::Nonlinear);
    /// let design = Synthesis::new(&weights)?;
    /// assert!(design.riccati_residual() < 1e-12);
    /// # Ok::<(), hinf_control::SynthesisError>(())
    /// ```
    pub fn new(weights: &Weights<T>) -> Result<Self, SynthesisError> {
        check_numbers(weights)?;
        let (q1, q2) = factors(weights)?;
        let inverse_of_r1_product = control_weight_term(weights)?;
        // Eq. 9's (R⁻¹ − I/γ²)⁻¹ = R1ᵀR1; nalgebra's Cholesky factor is R1ᵀ, lower triangular.
        let r1_transposed = inverse_of_r1_product
            .try_inverse()
            .and_then(nalgebra::Cholesky::new)
            .ok_or(SynthesisError::NotFinite { quantity: "(R⁻¹ − I/γ²)⁻¹" })?
            .l();
        let t11 = r1_transposed * q1;
        let t12 = r1_transposed * q2;
        let singular = SynthesisError::SingularTransformation { determinant: t11.determinant().to_f64() };
        let t11_inverse = invert_well_conditioned(&t11).ok_or(singular)?;
        let symmetric_part = |matrix: Matrix2<T>| (matrix + matrix.transpose()) * T::constant(0.5);
        let storage = symmetric_part(q1.transpose() * q2) - symmetric_part(weights.cross);
        let state_weight =
            block_matrix(&(q1.transpose() * q1), &weights.cross, &weights.cross.transpose(), &(q2.transpose() * q2));
        let residual = riccati_residual(&t11, &t12, &inverse_of_r1_product, &storage, &state_weight);
        let allowance = state_weight.amax().max(storage.amax()) * rounding();
        if !residual.is_finite() {
            return Err(SynthesisError::NotFinite { quantity: "the residual of equation 9" });
        }
        if residual > allowance {
            return Err(SynthesisError::Unsolvable { residual: residual.to_f64() });
        }
        let smallest_eigenvalue = eigenvalues(&storage).0.to_f64();
        if smallest_eigenvalue <= 0.0 {
            return Err(SynthesisError::StorageNotPositive { smallest_eigenvalue });
        }
        if nalgebra::Cholesky::new(state_weight).is_none() {
            return Err(SynthesisError::StateWeightNotPositive);
        }
        let control_gain =
            weights.control.try_inverse().ok_or(SynthesisError::NotFinite { quantity: "the inverse of R" })?;
        let design = Self {
            attenuation_level: weights.attenuation_level,
            control_weight: weights.control,
            control_gain,
            state_weight,
            t11,
            t12,
            t11_inverse,
            error_rate: t11_inverse * t12,
            storage,
            residual,
        };
        design.check_finite()
    }

    fn check_finite(self) -> Result<Self, SynthesisError> {
        let matrices = [&self.control_gain, &self.t11, &self.t12, &self.t11_inverse, &self.error_rate, &self.storage];
        let finite = matrices.iter().all(|matrix| matrix.iter().all(|element| element.is_finite()));
        if finite && self.residual.is_finite() { Ok(self) } else { Err(SynthesisError::NotFinite { quantity: "T0" }) }
    }

    /// γ.
    pub fn attenuation_level(&self) -> T {
        self.attenuation_level
    }

    /// R.
    pub fn control_weight(&self) -> &Matrix2<T> {
        &self.control_weight
    }

    /// R⁻¹.
    pub fn control_gain(&self) -> &Matrix2<T> {
        &self.control_gain
    }

    /// Q, velocities first.
    pub fn state_weight(&self) -> &Matrix4<T> {
        &self.state_weight
    }

    /// T11 of T0 (eq. 6).
    pub fn t11(&self) -> &Matrix2<T> {
        &self.t11
    }

    /// T12 of T0 (eq. 6).
    pub fn t12(&self) -> &Matrix2<T> {
        &self.t12
    }

    /// T11⁻¹.
    pub fn t11_inverse(&self) -> &Matrix2<T> {
        &self.t11_inverse
    }

    /// Λ = T11⁻¹T12 = Q1⁻¹Q2, 1/s: how fast q̃ dies out where q̃̇ + Λq̃ = 0.
    pub fn error_rate(&self) -> &Matrix2<T> {
        &self.error_rate
    }

    /// T0 = [T11 T12; 0 I] (eq. 6).
    pub fn transformation(&self) -> Matrix4<T> {
        block_matrix(&self.t11, &self.t12, &Matrix2::zeros(), &Matrix2::identity())
    }

    /// K, the part of the storage function that q̃ has.
    pub fn storage(&self) -> &Matrix2<T> {
        &self.storage
    }

    /// Largest magnitude in the residual of eq. 9: rounding, for a design that was accepted.
    pub fn riccati_residual(&self) -> T {
        self.residual
    }

    /// BᵀT0x̃ = T11 q̃̇ + T12 q̃.
    pub fn transformed_error(&self, error: &TrackingError<T>) -> Vector2<T> {
        self.t11 * error.velocity + self.t12 * error.position
    }

    /// u = −R⁻¹BᵀT0x̃ (eq. 10).
    pub fn control_input(&self, error: &TrackingError<T>) -> Vector2<T> {
        -(self.control_gain * self.transformed_error(error))
    }

    /// T11⁻¹u, N·m: the feedback as torque, −T11⁻¹R⁻¹BᵀT0x̃ of every law.
    pub fn feedback_torque(&self, error: &TrackingError<T>) -> Vector2<T> {
        self.t11_inverse * self.control_input(error)
    }

    /// T11ᵀBᵀT0x̃: what every adaptation law multiplies with −Z⁻¹Ξᵀ (eqs. 18, 30, 36, 42, 45).
    pub fn adaptation_signal(&self, error: &TrackingError<T>) -> Vector2<T> {
        self.t11.transpose() * self.transformed_error(error)
    }

    /// s = q̃̇ + Λq̃ = T11⁻¹BᵀT0x̃, rad/s.
    pub fn filtered_error(&self, error: &TrackingError<T>) -> Vector2<T> {
        error.velocity + self.error_rate * error.position
    }

    /// x1 and x2 of the paper's section 4, the motion that F is computed for.
    pub fn auxiliary_motion(&self, reference: &Reference<T>, error: &TrackingError<T>) -> AuxiliaryMotion<T> {
        AuxiliaryMotion {
            acceleration: reference.acceleration - self.error_rate * error.velocity,
            velocity: reference.velocity - self.error_rate * error.position,
        }
    }
}

fn check_numbers<T: Scalar>(weights: &Weights<T>) -> Result<(), SynthesisError> {
    let named =
        [(&weights.velocity, "Q1"), (&weights.position, "Q2"), (&weights.cross, "Q12"), (&weights.control, "R")];
    for (matrix, quantity) in named {
        if !matrix.iter().all(|element| element.is_finite()) {
            return Err(SynthesisError::NotFinite { quantity });
        }
    }
    if !weights.attenuation_level.is_finite() {
        return Err(SynthesisError::NotFinite { quantity: "γ" });
    }
    if weights.attenuation_level <= T::zero() {
        return Err(SynthesisError::AttenuationLevelNotPositive { found: weights.attenuation_level.to_f64() });
    }
    Ok(())
}

/// Q1 and Q2 as factors.
fn factors<T: Scalar>(weights: &Weights<T>) -> Result<(Matrix2<T>, Matrix2<T>), SynthesisError> {
    match weights.reading {
        WeightReading::Factors => Ok((weights.velocity, weights.position)),
        WeightReading::Blocks => {
            check_positive_definite(&weights.velocity, "Q1ᵀQ1")?;
            check_positive_definite(&weights.position, "Q2ᵀQ2")?;
            let q1 = square_root(&weights.velocity);
            let inverse = q1.try_inverse().ok_or(SynthesisError::NotFinite { quantity: "the inverse of Q1" })?;
            Ok((q1, inverse * geometric_mean(&weights.velocity, &weights.position)))
        }
    }
}

/// R⁻¹ − I/γ², checked to be positive definite.
fn control_weight_term<T: Scalar>(weights: &Weights<T>) -> Result<Matrix2<T>, SynthesisError> {
    check_positive_definite(&weights.control, "R")?;
    let attenuation_level_squared = weights.attenuation_level * weights.attenuation_level;
    let largest = eigenvalues(&weights.control).1;
    if largest >= attenuation_level_squared {
        return Err(SynthesisError::ControlWeightTooLarge {
            largest_eigenvalue: largest.to_f64(),
            attenuation_level_squared: attenuation_level_squared.to_f64(),
        });
    }
    let inverse = weights.control.try_inverse().ok_or(SynthesisError::NotFinite { quantity: "the inverse of R" })?;
    Ok(inverse - Matrix2::identity() / attenuation_level_squared)
}

fn check_positive_definite<T: Scalar>(matrix: &Matrix2<T>, quantity: &'static str) -> Result<(), SynthesisError> {
    let difference = (matrix.m12 - matrix.m21).abs();
    if difference > matrix.amax() * rounding() {
        return Err(SynthesisError::NotSymmetric { quantity, difference: difference.to_f64() });
    }
    let smallest = eigenvalues(matrix).0;
    if smallest > T::zero() {
        Ok(())
    } else {
        Err(SynthesisError::NotPositiveDefinite { quantity, smallest_eigenvalue: smallest.to_f64() })
    }
}

fn rounding<T: Scalar>() -> T {
    T::default_epsilon() * T::constant(ROUNDING_ALLOWANCE)
}

/// Largest magnitude in [0 K; K 0] − T0ᵀB(R⁻¹ − I/γ²)BᵀT0 + Q.
fn riccati_residual<T: Scalar>(
    t11: &Matrix2<T>,
    t12: &Matrix2<T>,
    control_weight_term: &Matrix2<T>,
    storage: &Matrix2<T>,
    state_weight: &Matrix4<T>,
) -> T {
    let product = |left: &Matrix2<T>, right: &Matrix2<T>| left.transpose() * control_weight_term * right;
    let quadratic = block_matrix(&product(t11, t11), &product(t11, t12), &product(t12, t11), &product(t12, t12));
    let storage_rate = block_matrix(&Matrix2::zeros(), storage, storage, &Matrix2::zeros());
    (storage_rate - quadratic + state_weight).amax()
}
