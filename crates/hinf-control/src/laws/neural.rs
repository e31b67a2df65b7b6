//! Controller 3: adaptive neural network nonlinear H∞ control without a model (paper section 3.2, first approach).
//!
//! F + E − δ is approximated by H = ΞΦ (eq. 25), Ξ = diag(ξ_1ᵀ, ξ_2ᵀ), ξ_k = tanh(W_k xe + b_k) (eqs. 22–24), over
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
    AdaptationSettings, BuildContext, BuildError, LawDefinition, PublishedIndices, StateWeights,
};
use crate::{Command, Controller, Measurement, Reference, Synthesis, TrackingError};
use crate::{NETWORK_PARAMETERS, TanhNetworks};
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
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            q1: SymmetricWeight::Diagonal([0.64, 0.64]),
            q2: SymmetricWeight::Diagonal([9.0, 7.0]),
            z: 10.0,
            bound: 0.1,
        }
    }
}

impl LawDefinition for Settings {
    const NAME: &'static str = "neural";
    const DESCRIPTION: &'static str = "adaptive neural network nonlinear H-infinity control, no model";
    const PUBLISHED_INDICES: Option<PublishedIndices> = Some(PublishedIndices { tracking: 0.0317, torque: 0.1322 });

    type Controller<T: Scalar> = Neural<T>;

    fn build<T: Scalar>(&self, synthesis: Synthesis<T>, context: &BuildContext<T>) -> Result<Neural<T>, BuildError> {
        let settings = AdaptationSettings { z: self.z, bound: self.bound };
        let adaptation = context.adaptation(SVector::zeros(), settings)?;
        Ok(Neural::new(synthesis, TanhNetworks::paper(), adaptation))
    }

    fn state_weights(&self) -> Option<StateWeights> {
        Some(StateWeights { q1: self.q1, q2: self.q2 })
    }

    fn adaptation(&self) -> Option<AdaptationSettings> {
        Some(AdaptationSettings { z: self.z, bound: self.bound })
    }
}

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
        let Self { synthesis, networks, estimator } = self;
        estimator.cycle(measurement, reference, period, |parameters| {
            let error = TrackingError::new(measurement, reference);
            let regressor = networks.regressor(measurement, reference);
            AdaptiveOutput {
                torque: regressor * parameters + synthesis.feedback_torque(&error),
                control_input: synthesis.control_input(&error),
                gradient: regressor.tr_mul(&synthesis.adaptation_signal(&error)),
                fell_back: false,
            }
        })
    }

    state_is_its_estimators!(T);
}
