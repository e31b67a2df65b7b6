//! Controller 3: adaptive neural network nonlinear H∞ control without a model (paper section 3.2, first approach).
//!
//! F + E − δ is approximated by H = ΞΦ (eq. 25), Ξ = diag(ξ_1ᵀ, …, ξ_Nᵀ), ξ_k = tanh(W_k xe + b_k) (eqs. 22–24), over
//! xe = [q_m, q̇_m, qᵈ, q̇ᵈ, q̈ᵈ] (eq. 26):
//!
//! - Φ̇ = −Z⁻¹Ξᵀ T11ᵀBᵀT0x̃ (eq. 30),
//! - τ_m = ΞΦ − T11⁻¹R⁻¹BᵀT0x̃ (eq. 31).
//!
//! No base data. Inequality 12 holds where F + E is ΞΦ* exactly; elsewhere the error of approximation is part of ω.

use super::state::state_is_its_estimators;
use crate::SymmetricWeight;
use crate::adaptation::{Adaptation, AdaptationWeight, AdaptiveOutput, ParameterEstimator, ScalarWeight};
use crate::law_definition::{
    AdaptationSettings, BuildContext, BuildError, CatalogueModel, DerivedWeights, LawDefinition, PaperArm,
    PaperWeights, PublishedIndices, StateWeights,
};
use crate::{Command, Controller, Measurement, Reference, Synthesis, TrackingError};
use crate::{NEURONS, TanhNetworks};
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
}

impl<const N: usize> Default for Settings<N>
where
    PaperArm: PaperWeights<N>,
{
    fn default() -> Self {
        Self { q1: PaperArm::diagonal([0.64, 0.64]), q2: PaperArm::diagonal([9.0, 7.0]), z: 10.0, bound: 0.1 }
    }
}

impl<const N: usize> LawDefinition<N> for Settings<N> {
    const NAME: &'static str = "neural";
    const DESCRIPTION: &'static str = "adaptive neural network nonlinear H-infinity control, no model";
    const PUBLISHED_INDICES: Option<PublishedIndices> = Some(PublishedIndices { tracking: 0.0317, torque: 0.1322 });

    type Controller<T: Scalar, const B: usize, M: CatalogueModel<T, N, B>> = Neural<T, N, B>;

    fn derived(weights: &DerivedWeights<N>) -> Self {
        let AdaptationSettings { z, bound } = weights.networks;
        Self { q1: weights.state.q1, q2: weights.state.q2, z, bound }
    }

    fn build<T: Scalar, const B: usize, M: CatalogueModel<T, N, B>>(
        &self,
        synthesis: Synthesis<T, N>,
        context: &BuildContext<T, M>,
    ) -> Result<Neural<T, N, B>, BuildError> {
        let settings = AdaptationSettings { z: self.z, bound: self.bound };
        let adaptation = context.adaptation(SMatrix::zeros(), settings)?;
        Ok(Neural::new(synthesis, TanhNetworks::paper(), adaptation))
    }

    fn state_weights(&self) -> Option<StateWeights<N>> {
        Some(StateWeights { q1: self.q1, q2: self.q2 })
    }

    fn adaptation(&self) -> Option<AdaptationSettings> {
        Some(AdaptationSettings { z: self.z, bound: self.bound })
    }
}

/// Controller 3. The paper starts it at Φ = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Neural<T: Scalar, const N: usize = 2, const B: usize = 1, Z = ScalarWeight<T>> {
    synthesis: Synthesis<T, N>,
    networks: TanhNetworks<T, N>,
    estimator: ParameterEstimator<T, NEURONS, N, Z>,
}

impl<T: Scalar, const N: usize, const B: usize, Z: AdaptationWeight<T, NEURONS, N>> Neural<T, N, B, Z> {
    /// The law with these hidden layers.
    pub fn new(
        synthesis: Synthesis<T, N>,
        networks: TanhNetworks<T, N>,
        adaptation: Adaptation<T, NEURONS, N, Z>,
    ) -> Self {
        Self { synthesis, networks, estimator: ParameterEstimator::new(adaptation) }
    }
}

impl<T: Scalar, const N: usize, const B: usize, Z: AdaptationWeight<T, NEURONS, N>> Controller<T, N, B>
    for Neural<T, N, B, Z>
{
    fn update(&mut self, measurement: &Measurement<T, N, B>, reference: &Reference<T, N>, period: T) -> Command<T, N> {
        let Self { synthesis, networks, estimator } = self;
        estimator.cycle(measurement, reference, period, |parameters| {
            let error = TrackingError::new(measurement, reference);
            let regressor = networks.regressor(measurement, reference);
            AdaptiveOutput {
                torque: regressor.torque(parameters) + synthesis.feedback_torque(&error),
                control_input: synthesis.control_input(&error),
                gradient: regressor.gradient(&synthesis.adaptation_signal(&error)),
                fell_back: false,
            }
        })
    }

    state_is_its_estimators!(T, N);
}
