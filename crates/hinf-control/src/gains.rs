//! Gains of a PD feedback.

use crate::Synthesis;
use dem_model::Scalar;
use nalgebra::{Cholesky, SMatrix};

/// The gains of [`PdComputedTorque`](crate::PdComputedTorque): their symmetric parts are positive definite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PdGains<T: Scalar, const N: usize = 2> {
    proportional: SMatrix<T, N, N>,
    derivative: SMatrix<T, N, N>,
}

/// A gain is not finite, or its symmetric part not positive definite.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the {gain} gain is not positive definite")]
pub struct GainError {
    /// Which gain.
    pub gain: &'static str,
}

impl<T: Scalar, const N: usize> PdGains<T, N> {
    /// K_p (N·m/rad) and K_d (N·m·s/rad).
    ///
    /// # Errors
    /// [`GainError`] unless both are finite and positive definite.
    pub fn new(proportional: SMatrix<T, N, N>, derivative: SMatrix<T, N, N>) -> Result<Self, GainError> {
        for (matrix, gain) in [(&proportional, "proportional"), (&derivative, "derivative")] {
            let finite = matrix.iter().all(|element| element.is_finite());
            if !finite || Cholesky::new(matrix + matrix.transpose()).is_none() {
                return Err(GainError { gain });
            }
        }
        Ok(Self { proportional, derivative })
    }

    /// K_p, N·m/rad.
    pub fn proportional(&self) -> &SMatrix<T, N, N> {
        &self.proportional
    }

    /// K_d, N·m·s/rad.
    pub fn derivative(&self) -> &SMatrix<T, N, N> {
        &self.derivative
    }

    /// The gains of the H∞ feedback: K_d = T11⁻¹R⁻¹T11, K_p = K_d Λ.
    ///
    /// # Errors
    /// [`GainError`] if the weights' off-diagonal elements leave one of them without a positive definite symmetric part.
    pub fn matching(synthesis: &Synthesis<T, N>) -> Result<Self, GainError> {
        let derivative = synthesis.t11_inverse() * synthesis.control_gain() * synthesis.t11();
        Self::new(derivative * synthesis.error_rate(), derivative)
    }
}
