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

use super::state::state_is_its_estimators;
use crate::adaptation::{Adaptation, AdaptationWeight, AdaptiveOutput, ParameterEstimator, ScalarWeight};
use crate::law_definition::{
    AdaptationSettings, BuildContext, BuildError, LawDefinition, PublishedIndices, StateWeights,
};
use crate::{Command, Controller, Measurement, Reference, Synthesis, TrackingError};
use crate::{FUZZY_PARAMETERS, FuzzySystem};
use crate::{Firing, SymmetricWeight};
use dem_model::Scalar;
use nalgebra::SVector;

/// Settings of the law. The default is Table 3.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Settings {
    /// Weight of the velocity error.
    pub q1: SymmetricWeight,
    /// Weight of the position error.
    pub q2: SymmetricWeight,
    /// z of Z = zI, positive.
    pub z: f64,
    /// How far each parameter may go from its start under [`AdaptationGuard::Bounded`](crate::AdaptationGuard::Bounded).
    /// Chosen: several times as far as any goes in the paper's task.
    pub bound: f64,
    /// How the rules fire.
    pub firing: Firing,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            q1: SymmetricWeight::Diagonal([1.0, 1.0]),
            q2: SymmetricWeight::Diagonal([9.0, 7.0]),
            z: 0.8,
            bound: 1.0,
            firing: Firing::Minimum,
        }
    }
}

impl LawDefinition for Settings {
    const NAME: &'static str = "fuzzy";
    const DESCRIPTION: &'static str = "adaptive fuzzy nonlinear H-infinity control, no model";
    const PUBLISHED_INDICES: Option<PublishedIndices> = Some(PublishedIndices { tracking: 0.034, torque: 0.1563 });

    type Controller<T: Scalar> = Fuzzy<T>;

    fn build<T: Scalar>(&self, synthesis: Synthesis<T>, context: &BuildContext<T>) -> Result<Fuzzy<T>, BuildError> {
        let settings = AdaptationSettings { z: self.z, bound: self.bound };
        let adaptation = context.adaptation(SVector::zeros(), settings)?;
        let system = FuzzySystem::new(context.fuzzy_sets, self.firing);
        Ok(Fuzzy::new(synthesis, system, adaptation))
    }

    fn state_weights(&self) -> Option<StateWeights> {
        Some(StateWeights { q1: self.q1, q2: self.q2 })
    }

    fn adaptation(&self) -> Option<AdaptationSettings> {
        Some(AdaptationSettings { z: self.z, bound: self.bound })
    }

    fn firing(&self) -> Option<Firing> {
        Some(self.firing)
    }
}

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
