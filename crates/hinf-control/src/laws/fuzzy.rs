//! Controller 5: adaptive fuzzy nonlinear H∞ control without a model (paper section 3.3, first approach).
//!
//! F + E − δ is approximated by H = ΞΦ (eq. 41), Ξ = diag(ξ_1ᵀ, …, ξ_Nᵀ), ξ_k the firing strengths of nine Takagi–Sugeno rules
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
    AdaptationSettings, BuildContext, BuildError, CatalogueModel, DerivedWeights, LawDefinition, PaperArm,
    PaperWeights, PublishedIndices, StateWeights,
};
use crate::{Command, Controller, Measurement, Reference, Synthesis, TrackingError};
use crate::{FUZZY_PARAMETERS, FuzzyRegressor, FuzzySystem};
use crate::{Firing, SymmetricWeight};
use dem_model::Scalar;
use nalgebra::SMatrix;

/// Settings of the law. The default is Table 3.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Settings<const N: usize = 2> {
    /// Weight of the velocity error.
    pub q1: SymmetricWeight<N>,
    /// Weight of the position error.
    pub q2: SymmetricWeight<N>,
    /// z of Z = zI, positive.
    pub z: f64,
    /// How far each parameter may go from its start under [`AdaptationGuard::Bounded`](crate::AdaptationGuard::Bounded).
    /// Chosen: several times as far as any goes in the paper's task.
    pub bound: f64,
    /// How the rules fire.
    pub firing: Firing,
}

impl<const N: usize> Default for Settings<N>
where
    PaperArm: PaperWeights<N>,
{
    fn default() -> Self {
        Self {
            q1: PaperArm::diagonal([1.0, 1.0]),
            q2: PaperArm::diagonal([9.0, 7.0]),
            z: 0.8,
            bound: 1.0,
            firing: Firing::Minimum,
        }
    }
}

impl<const N: usize> LawDefinition<N> for Settings<N> {
    const NAME: &'static str = "fuzzy";
    const DESCRIPTION: &'static str = "adaptive fuzzy nonlinear H-infinity control, no model";
    const PUBLISHED_INDICES: Option<PublishedIndices> = Some(PublishedIndices { tracking: 0.034, torque: 0.1563 });

    type Controller<T: Scalar, const B: usize, M: CatalogueModel<T, N, B>> = Fuzzy<T, N, B>;

    fn derived(weights: &DerivedWeights<N>) -> Self {
        let AdaptationSettings { z, bound } = weights.rules;
        Self { q1: weights.state.q1, q2: weights.state.q2, z, bound, firing: Firing::Minimum }
    }

    fn build<T: Scalar, const B: usize, M: CatalogueModel<T, N, B>>(
        &self,
        synthesis: Synthesis<T, N>,
        context: &BuildContext<T, M>,
    ) -> Result<Fuzzy<T, N, B>, BuildError> {
        let settings = AdaptationSettings { z: self.z, bound: self.bound };
        let adaptation = context.adaptation(SMatrix::zeros(), settings)?;
        let system = FuzzySystem::new(context.fuzzy_sets, self.firing);
        Ok(Fuzzy::new(synthesis, system, adaptation))
    }

    fn state_weights(&self) -> Option<StateWeights<N>> {
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
pub struct Fuzzy<T: Scalar, const N: usize = 2, const B: usize = 1, Z = ScalarWeight<T>> {
    synthesis: Synthesis<T, N>,
    system: FuzzySystem<T>,
    estimator: ParameterEstimator<T, FUZZY_PARAMETERS, N, Z>,
}

impl<T: Scalar, const N: usize, const B: usize, Z: AdaptationWeight<T, FUZZY_PARAMETERS, N>> Fuzzy<T, N, B, Z> {
    /// The law with these premises.
    pub fn new(
        synthesis: Synthesis<T, N>,
        system: FuzzySystem<T>,
        adaptation: Adaptation<T, FUZZY_PARAMETERS, N, Z>,
    ) -> Self {
        Self { synthesis, system, estimator: ParameterEstimator::new(adaptation) }
    }
}

impl<T: Scalar, const N: usize, const B: usize, Z: AdaptationWeight<T, FUZZY_PARAMETERS, N>> Controller<T, N, B>
    for Fuzzy<T, N, B, Z>
{
    fn update(&mut self, measurement: &Measurement<T, N, B>, reference: &Reference<T, N>, period: T) -> Command<T, N> {
        let Self { synthesis, system, estimator } = self;
        estimator.cycle(measurement, reference, period, |parameters| {
            let error = TrackingError::new(measurement, reference);
            let FuzzyRegressor { regressor, fell_back } = system.regressor(&error);
            AdaptiveOutput {
                torque: regressor.torque(parameters) + synthesis.feedback_torque(&error),
                control_input: synthesis.control_input(&error),
                gradient: regressor.gradient(&synthesis.adaptation_signal(&error)),
                fell_back,
            }
        })
    }

    state_is_its_estimators!(T, N);
}
