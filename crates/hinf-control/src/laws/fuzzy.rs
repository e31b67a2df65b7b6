//! Controller 5: adaptive fuzzy nonlinear H∞ control without a model (paper section 3.3, first approach).
//!
//! F + E − δ is approximated by H = ΞΦ (eq. 41), Ξ = diag(ξ_1ᵀ, ξ_2ᵀ), ξ_k the firing strengths of nine Takagi–Sugeno rules
//! over (q̃̇_k, q̃_k), each times [1, q̃̇_k, q̃_k] (eqs. 38–40):
//!
//! - Φ̇ = −Z⁻¹Ξᵀ T11ᵀBᵀT0x̃ (eq. 42),
//! - τ_m = ΞΦ − T11⁻¹R⁻¹BᵀT0x̃ (eq. 43).
//!
//! No base data. Inequality 12 holds where F + E is ΞΦ* exactly; elsewhere the error of approximation is part of ω. Where
//! no rule fires, all nine count the same, and the status says so.

use super::state_is_its_estimators;
use crate::adaptation::{Adaptation, AdaptationWeight, AdaptiveOutput, ParameterEstimator, ScalarWeight};
use crate::{Command, Controller, Measurement, Reference, Synthesis, TrackingError};
use crate::{FUZZY_PARAMETERS, FuzzySystem};
use dem_model::Scalar;

/// Controller 5. The paper starts it at Φ = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Fuzzy<T: Scalar, Z = ScalarWeight<T>> {
    synthesis: Synthesis<T>,
    system: FuzzySystem<T>,
    estimator: ParameterEstimator<T, FUZZY_PARAMETERS, Z>,
}

impl<T: Scalar, Z: AdaptationWeight<T, FUZZY_PARAMETERS>> Fuzzy<T, Z> {
    /// The law with these premises.
    pub fn new(
        synthesis: Synthesis<T>,
        system: FuzzySystem<T>,
        adaptation: Adaptation<T, FUZZY_PARAMETERS, Z>,
    ) -> Self {
        Self { synthesis, system, estimator: ParameterEstimator::new(adaptation) }
    }
}

impl<T: Scalar, Z: AdaptationWeight<T, FUZZY_PARAMETERS>> Controller<T> for Fuzzy<T, Z> {
    fn update(&mut self, measurement: &Measurement<T>, reference: &Reference<T>, period: T) -> Command<T> {
        let Self { synthesis, system, estimator } = self;
        estimator.cycle(measurement, reference, period, |parameters| {
            let error = TrackingError::new(measurement, reference);
            let regressor = system.regressor(&error);
            AdaptiveOutput {
                torque: regressor.matrix * parameters + synthesis.feedback_torque(&error),
                control_input: synthesis.control_input(&error),
                gradient: regressor.matrix.tr_mul(&synthesis.adaptation_signal(&error)),
                fell_back: regressor.fell_back,
            }
        })
    }

    state_is_its_estimators!(T);
}
