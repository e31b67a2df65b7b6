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

use crate::spectral::{
    determinant, extreme_eigenvalues, geometric_mean, invert_well_conditioned, square_root, symmetric_part,
};
use crate::{Reference, SynthesisError, TrackingError, WeightReading, Weights};
use dem_model::Scalar;
use nalgebra::{Cholesky, SMatrix, SVector};

/// Symmetry and eq. 9 are checked to this many units of rounding of the largest number involved.
const ROUNDING_ALLOWANCE: f64 = 1e3;

/// The motion that the nominal torque is computed for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AuxiliaryMotion<T: Scalar, const N: usize = 2> {
    /// x1 = q̈_mᵈ − Λq̃̇, rad/s².
    pub acceleration: SVector<T, N>,
    /// x2 = q̇_mᵈ − Λq̃, rad/s.
    pub velocity: SVector<T, N>,
}

/// Q = [Q1ᵀQ1 Q12; Q12ᵀ Q2ᵀQ2] in its blocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateWeight<T: Scalar, const N: usize = 2> {
    /// Q1ᵀQ1, weight of q̃̇.
    pub velocity: SMatrix<T, N, N>,
    /// Q12.
    pub cross: SMatrix<T, N, N>,
    /// Q2ᵀQ2, weight of q̃.
    pub position: SMatrix<T, N, N>,
}

impl<T: Scalar, const N: usize> StateWeight<T, N> {
    /// x̃ᵀQx̃.
    pub fn penalty(&self, error: &TrackingError<T, N>) -> T {
        let mixed = error.velocity.dot(&(self.cross * error.position));
        error.velocity.dot(&(self.velocity * error.velocity))
            + mixed
            + mixed
            + error.position.dot(&(self.position * error.position))
    }

    fn amax(&self) -> T {
        self.velocity.amax().max(self.cross.amax()).max(self.position.amax())
    }

    /// By the Schur complement of Q1ᵀQ1.
    fn is_positive_definite(&self) -> bool {
        Cholesky::new(self.velocity)
            .map(|velocity| self.position - self.cross.tr_mul(&velocity.solve(&self.cross)))
            .is_some_and(|complement| Cholesky::new(complement).is_some())
    }
}

/// A solved design: what the laws need of it, ready to use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Synthesis<T: Scalar, const N: usize = 2> {
    attenuation_level: T,
    control_weight: SMatrix<T, N, N>,
    /// R⁻¹.
    control_gain: SMatrix<T, N, N>,
    state_weight: StateWeight<T, N>,
    t11: SMatrix<T, N, N>,
    t12: SMatrix<T, N, N>,
    t11_inverse: SMatrix<T, N, N>,
    /// Λ = T11⁻¹T12.
    error_rate: SMatrix<T, N, N>,
    storage: SMatrix<T, N, N>,
    residual: T,
}

impl<T: Scalar, const N: usize> Synthesis<T, N> {
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
    pub fn new(weights: &Weights<T, N>) -> Result<Self, SynthesisError> {
        check_numbers(weights)?;
        let (q1, q2) = factors(weights)?;
        let inverse_of_r1_product = control_weight_term(weights)?;
        // Eq. 9's (R⁻¹ − I/γ²)⁻¹ = R1ᵀR1; nalgebra's Cholesky factor is R1ᵀ, lower triangular.
        let r1_transposed = inverse_of_r1_product
            .try_inverse()
            .and_then(Cholesky::new)
            .ok_or(SynthesisError::NotFinite { quantity: "(R⁻¹ − I/γ²)⁻¹" })?
            .l();
        let t11 = r1_transposed * q1;
        let t12 = r1_transposed * q2;
        let singular = SynthesisError::SingularTransformation { determinant: determinant(&t11).to_f64() };
        let t11_inverse = invert_well_conditioned(&t11).ok_or(singular)?;
        let storage = symmetric_part(&(q1.transpose() * q2)) - symmetric_part(&weights.cross);
        let state_weight =
            StateWeight { velocity: q1.transpose() * q1, cross: weights.cross, position: q2.transpose() * q2 };
        let residual = riccati_residual(&t11, &t12, &inverse_of_r1_product, &storage, &state_weight);
        let allowance = state_weight.amax().max(storage.amax()) * rounding();
        if !residual.is_finite() {
            return Err(SynthesisError::NotFinite { quantity: "the residual of equation 9" });
        }
        if residual > allowance {
            return Err(SynthesisError::Unsolvable { residual: residual.to_f64() });
        }
        let smallest_eigenvalue = extreme_eigenvalues(&storage).0.to_f64();
        if smallest_eigenvalue <= 0.0 {
            return Err(SynthesisError::StorageNotPositive { smallest_eigenvalue });
        }
        if !state_weight.is_positive_definite() {
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
    pub fn control_weight(&self) -> &SMatrix<T, N, N> {
        &self.control_weight
    }

    /// R⁻¹.
    pub fn control_gain(&self) -> &SMatrix<T, N, N> {
        &self.control_gain
    }

    /// Q, velocities first.
    pub fn state_weight(&self) -> &StateWeight<T, N> {
        &self.state_weight
    }

    /// T11 of T0 (eq. 6).
    pub fn t11(&self) -> &SMatrix<T, N, N> {
        &self.t11
    }

    /// T12 of T0 (eq. 6).
    pub fn t12(&self) -> &SMatrix<T, N, N> {
        &self.t12
    }

    /// T11⁻¹.
    pub fn t11_inverse(&self) -> &SMatrix<T, N, N> {
        &self.t11_inverse
    }

    /// Λ = T11⁻¹T12 = Q1⁻¹Q2, 1/s: how fast q̃ dies out where q̃̇ + Λq̃ = 0.
    pub fn error_rate(&self) -> &SMatrix<T, N, N> {
        &self.error_rate
    }

    /// K, the part of the storage function that q̃ has.
    pub fn storage(&self) -> &SMatrix<T, N, N> {
        &self.storage
    }

    /// Largest magnitude in the residual of eq. 9: rounding, for a design that was accepted.
    pub fn riccati_residual(&self) -> T {
        self.residual
    }

    /// BᵀT0x̃ = T11 q̃̇ + T12 q̃.
    pub fn transformed_error(&self, error: &TrackingError<T, N>) -> SVector<T, N> {
        self.t11 * error.velocity + self.t12 * error.position
    }

    /// u = −R⁻¹BᵀT0x̃ (eq. 10).
    pub fn control_input(&self, error: &TrackingError<T, N>) -> SVector<T, N> {
        -(self.control_gain * self.transformed_error(error))
    }

    /// T11⁻¹u, N·m: the feedback as torque, −T11⁻¹R⁻¹BᵀT0x̃ of every law.
    pub fn feedback_torque(&self, error: &TrackingError<T, N>) -> SVector<T, N> {
        self.t11_inverse * self.control_input(error)
    }

    /// T11ᵀBᵀT0x̃: what every adaptation law multiplies with −Z⁻¹Ξᵀ (eqs. 18, 30, 36, 42, 45).
    pub fn adaptation_signal(&self, error: &TrackingError<T, N>) -> SVector<T, N> {
        self.t11.transpose() * self.transformed_error(error)
    }

    /// s = q̃̇ + Λq̃ = T11⁻¹BᵀT0x̃, rad/s.
    pub fn filtered_error(&self, error: &TrackingError<T, N>) -> SVector<T, N> {
        error.velocity + self.error_rate * error.position
    }

    /// x1 and x2 of the paper's section 4, the motion that F is computed for.
    pub fn auxiliary_motion(&self, reference: &Reference<T, N>, error: &TrackingError<T, N>) -> AuxiliaryMotion<T, N> {
        AuxiliaryMotion {
            acceleration: reference.acceleration - self.error_rate * error.velocity,
            velocity: reference.velocity - self.error_rate * error.position,
        }
    }
}

fn check_numbers<T: Scalar, const N: usize>(weights: &Weights<T, N>) -> Result<(), SynthesisError> {
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

/// Q1 and Q2.
type Factors<T, const N: usize> = (SMatrix<T, N, N>, SMatrix<T, N, N>);

/// Q1 and Q2 as factors.
fn factors<T: Scalar, const N: usize>(weights: &Weights<T, N>) -> Result<Factors<T, N>, SynthesisError> {
    match weights.reading {
        WeightReading::Factors => Ok((weights.velocity, weights.position)),
        WeightReading::Blocks => {
            check_positive_definite(&weights.velocity, "Q1ᵀQ1")?;
            check_positive_definite(&weights.position, "Q2ᵀQ2")?;
            let q1 = square_root(&weights.velocity);
            let not_finite = SynthesisError::NotFinite { quantity: "the inverse of Q1" };
            let inverse = q1.try_inverse().ok_or(not_finite)?;
            Ok((q1, inverse * geometric_mean(&weights.velocity, &weights.position).ok_or(not_finite)?))
        }
    }
}

/// R⁻¹ − I/γ², checked to be positive definite.
fn control_weight_term<T: Scalar, const N: usize>(weights: &Weights<T, N>) -> Result<SMatrix<T, N, N>, SynthesisError> {
    check_positive_definite(&weights.control, "R")?;
    let attenuation_level_squared = weights.attenuation_level * weights.attenuation_level;
    let largest = extreme_eigenvalues(&weights.control).1;
    if largest >= attenuation_level_squared {
        return Err(SynthesisError::ControlWeightTooLarge {
            largest_eigenvalue: largest.to_f64(),
            attenuation_level_squared: attenuation_level_squared.to_f64(),
        });
    }
    let inverse = weights.control.try_inverse().ok_or(SynthesisError::NotFinite { quantity: "the inverse of R" })?;
    Ok(inverse - SMatrix::identity() / attenuation_level_squared)
}

fn check_positive_definite<T: Scalar, const N: usize>(
    matrix: &SMatrix<T, N, N>,
    quantity: &'static str,
) -> Result<(), SynthesisError> {
    let difference = (matrix - matrix.transpose()).amax();
    if difference > matrix.amax() * rounding() {
        return Err(SynthesisError::NotSymmetric { quantity, difference: difference.to_f64() });
    }
    let smallest = extreme_eigenvalues(matrix).0;
    if smallest > T::zero() {
        Ok(())
    } else {
        Err(SynthesisError::NotPositiveDefinite { quantity, smallest_eigenvalue: smallest.to_f64() })
    }
}

fn rounding<T: Scalar>() -> T {
    T::default_epsilon() * T::constant(ROUNDING_ALLOWANCE)
}

/// Largest magnitude in [0 K; K 0] − T0ᵀB(R⁻¹ − I/γ²)BᵀT0 + Q, block by block.
fn riccati_residual<T: Scalar, const N: usize>(
    t11: &SMatrix<T, N, N>,
    t12: &SMatrix<T, N, N>,
    control_weight_term: &SMatrix<T, N, N>,
    storage: &SMatrix<T, N, N>,
    state_weight: &StateWeight<T, N>,
) -> T {
    let product = |left: &SMatrix<T, N, N>, right: &SMatrix<T, N, N>| left.transpose() * control_weight_term * right;
    let velocity = state_weight.velocity - product(t11, t11);
    let upper = storage - product(t11, t12) + state_weight.cross;
    let lower = storage - product(t12, t11) + state_weight.cross.transpose();
    let position = state_weight.position - product(t12, t12);
    let blocks = [velocity, upper, lower, position];
    if blocks.iter().all(|block| block.iter().all(|element| element.is_finite())) {
        blocks.iter().fold(T::zero(), |largest, block| largest.max(block.amax()))
    } else {
        T::constant(f64::NAN)
    }
}
