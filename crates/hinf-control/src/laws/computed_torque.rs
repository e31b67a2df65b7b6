//! The baseline, not in the paper: PD+ with computed torque (Paden and Panja, International Journal of Control 47 (1988)
//! 1697–1712).
//!
//! τ_m = F(q_m, q̇_m; q̈ᵈ, q̇ᵈ) − K_d q̃̇ − K_p q̃, with F = M_mm q̈ᵈ + C_mm q̇ᵈ, or F̄ for F.
//!
//! It is controller 1 without Λ in the motion that F is computed for. Gains of K_d = R⁻¹ and K_p = R⁻¹Λ
//! ([`PdGains::matching`], for diagonal weights) give it the same feedback, so that what differs is the law.

use super::has_no_state;
use crate::{AdaptationStatus, Command, Controller, Measurement, Reference, Synthesis, TrackingError, is_usable};
use crate::{AuxiliaryMotion, NominalModel};
use dem_model::Scalar;
use nalgebra::{Cholesky, Matrix2};

/// The gains of [`PdComputedTorque`]: their symmetric parts are positive definite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PdGains<T: Scalar> {
    proportional: Matrix2<T>,
    derivative: Matrix2<T>,
}

/// A gain is not finite, or its symmetric part not positive definite.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the {gain} gain is not positive definite")]
pub struct GainError {
    /// Which gain.
    pub gain: &'static str,
}

impl<T: Scalar> PdGains<T> {
    /// K_p (N·m/rad) and K_d (N·m·s/rad).
    ///
    /// # Errors
    /// [`GainError`] unless both are finite and positive definite.
    pub fn new(proportional: Matrix2<T>, derivative: Matrix2<T>) -> Result<Self, GainError> {
        for (matrix, gain) in [(&proportional, "proportional"), (&derivative, "derivative")] {
            let finite = matrix.iter().all(|element| element.is_finite());
            if !finite || Cholesky::new(matrix + matrix.transpose()).is_none() {
                return Err(GainError { gain });
            }
        }
        Ok(Self { proportional, derivative })
    }

    /// The gains of the H∞ feedback: K_d = T11⁻¹R⁻¹T11, K_p = K_d Λ.
    ///
    /// # Errors
    /// [`GainError`] if the weights' off-diagonal elements leave one of them without a positive definite symmetric part.
    pub fn matching(synthesis: &Synthesis<T>) -> Result<Self, GainError> {
        let derivative = synthesis.t11_inverse() * synthesis.control_gain() * synthesis.t11();
        Self::new(derivative * synthesis.error_rate(), derivative)
    }
}

/// The PD+ baseline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PdComputedTorque<T: Scalar> {
    nominal: NominalModel<T>,
    gains: PdGains<T>,
}

impl<T: Scalar> PdComputedTorque<T> {
    /// The law for a nominal model.
    pub fn new(nominal: NominalModel<T>, gains: PdGains<T>) -> Self {
        Self { nominal, gains }
    }
}

impl<T: Scalar> Controller<T> for PdComputedTorque<T> {
    /// [`Command::control_input`] is −K_d q̃̇ − K_p q̃.
    fn update(&mut self, measurement: &Measurement<T>, reference: &Reference<T>, period: T) -> Command<T> {
        let adaptation = AdaptationStatus::default();
        if !is_usable(measurement, reference, period) {
            return Command::fallback(adaptation);
        }
        let error = TrackingError::new(measurement, reference);
        let motion = AuxiliaryMotion { acceleration: reference.acceleration, velocity: reference.velocity };
        let control_input = -(self.gains.derivative * error.velocity + self.gains.proportional * error.position);
        let torque = self.nominal.torque(measurement, &motion) + control_input;
        Command { torque, control_input, adaptation }.or_fallback()
    }

    has_no_state!(T);
}
