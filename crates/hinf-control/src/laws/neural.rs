//! Controller 3: adaptive neural network nonlinear H∞ control without a model (paper section 3.2, first approach).
//!
//! F + E − δ is approximated by H = ΞΦ (eq. 25), Ξ = diag(ξ_1ᵀ, ξ_2ᵀ), ξ_k = tanh(W_k xe + b_k) (eqs. 22–24), over
//! xe = [q_m, q̇_m, qᵈ, q̇ᵈ, q̈ᵈ] (eq. 26):
//!
//! - Φ̇ = −Z⁻¹Ξᵀ T11ᵀBᵀT0x̃ (eq. 30),
//! - τ_m = ΞΦ − T11⁻¹R⁻¹BᵀT0x̃ (eq. 31).
//!
//! No base data. Inequality 12 holds where F + E is ΞΦ* exactly; elsewhere the error of approximation is part of ω.

use super::state_is_its_estimators;
use crate::adaptation::{Adaptation, AdaptationWeight, ParameterEstimator, ScalarWeight};
use crate::{Command, Controller, Measurement, Reference, Synthesis, TrackingError, is_usable};
use crate::{NETWORK_PARAMETERS, TanhNetworks};
use dem_model::Scalar;

/// Controller 3. The paper starts it at Φ = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Neural<T: Scalar, Z = ScalarWeight<T>> {
    synthesis: Synthesis<T>,
    networks: TanhNetworks<T>,
    estimator: ParameterEstimator<T, NETWORK_PARAMETERS, Z>,
}

impl<T: Scalar, Z: AdaptationWeight<T, NETWORK_PARAMETERS>> Neural<T, Z> {
    /// The law with these hidden layers.
    pub fn new(
        synthesis: Synthesis<T>,
        networks: TanhNetworks<T>,
        adaptation: Adaptation<T, NETWORK_PARAMETERS, Z>,
    ) -> Self {
        Self { synthesis, networks, estimator: ParameterEstimator::new(adaptation) }
    }
}

impl<T: Scalar, Z: AdaptationWeight<T, NETWORK_PARAMETERS>> Controller<T> for Neural<T, Z> {
    fn update(&mut self, measurement: &Measurement<T>, reference: &Reference<T>, period: T) -> Command<T> {
        if !is_usable(measurement, reference, period) {
            return self.estimator.fall_back();
        }
        let mut status = self.estimator.step(period);
        let error = TrackingError::new(measurement, reference);
        let regressor = self.networks.regressor(measurement, reference);
        let torque = regressor * self.estimator.parameters() + self.synthesis.feedback_torque(&error);
        self.estimator.learn(&regressor.tr_mul(&self.synthesis.adaptation_signal(&error)), &mut status);
        let control_input = self.synthesis.control_input(&error);
        Command { torque, control_input, adaptation: status }.or_fallback()
    }

    state_is_its_estimators!(T);
}
