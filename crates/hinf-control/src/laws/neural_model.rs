//! Controller 4: adaptive neural network nonlinear H∞ control beside the nominal model (paper section 3.2, second
//! approach).
//!
//! E − δ is approximated by H = ΞΦ (eq. 32), with the networks of controller 3, and F is the nominal model's:
//!
//! - Φ̇ = −Z⁻¹Ξᵀ T11ᵀBᵀT0x̃ (eq. 36),
//! - τ_m = F + ΞΦ − T11⁻¹R⁻¹BᵀT0x̃ (eq. 37).
//!
//! With [`NominalForm::Reduced`] F̄ stands in the place of F (ours), and the networks are left
//! with what is truly unknown. No base data in either form.

use super::state::state_is_its_estimators;
use crate::adaptation::{Adaptation, AdaptationWeight, AdaptiveOutput, ParameterEstimator, ScalarWeight};
use crate::law_definition::{
    AdaptationSettings, BuildContext, BuildError, LawDefinition, LawVariant, PublishedIndices, StateWeights,
    VariantOrigin,
};
use crate::{BaseAcceleration, NominalForm, SymmetricWeight, UnsupportedBaseAcceleration};
use crate::{Command, Controller, Measurement, Reference, Synthesis, TrackingError};
use crate::{NETWORK_PARAMETERS, NominalModel, TanhNetworks};
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
    /// F or F̄.
    pub model_form: NominalForm,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            q1: SymmetricWeight::Diagonal([4.0, 4.0]),
            q2: SymmetricWeight::Diagonal([9.0, 7.0]),
            z: 100.0,
            bound: 0.1,
            model_form: NominalForm::ActiveJoints,
        }
    }
}

impl LawDefinition for Settings {
    const NAME: &'static str = "neural-model";
    const DESCRIPTION: &'static str = "adaptive neural network nonlinear H-infinity control beside the nominal model";
    const PUBLISHED_INDICES: Option<PublishedIndices> = Some(PublishedIndices { tracking: 0.0292, torque: 0.1406 });
    const VARIANTS: &'static [LawVariant] = &[LawVariant {
        name: "neural-model-reduced",
        base_acceleration: BaseAcceleration::Reduced,
        origin: VariantOrigin::Extension,
    }];

    type Controller<T: Scalar> = NeuralModel<T>;

    fn build<T: Scalar>(
        &self,
        synthesis: Synthesis<T>,
        context: &BuildContext<T>,
    ) -> Result<NeuralModel<T>, BuildError> {
        let settings = AdaptationSettings { z: self.z, bound: self.bound };
        let adaptation = context.adaptation(SVector::zeros(), settings)?;
        let nominal = NominalModel::new(context.model, self.model_form);
        Ok(NeuralModel::new(nominal, synthesis, TanhNetworks::paper(), adaptation))
    }

    fn state_weights(&self) -> Option<StateWeights> {
        Some(StateWeights { q1: self.q1, q2: self.q2 })
    }

    fn adaptation(&self) -> Option<AdaptationSettings> {
        Some(AdaptationSettings { z: self.z, bound: self.bound })
    }

    fn set_base_acceleration(&mut self, mode: BaseAcceleration) -> Result<(), UnsupportedBaseAcceleration> {
        self.model_form = mode.try_into()?;
        Ok(())
    }
}

/// Controller 4. The paper starts it at Φ = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct NeuralModel<T: Scalar, Z = ScalarWeight<T>> {
    nominal: NominalModel<T>,
    synthesis: Synthesis<T>,
    networks: TanhNetworks<T>,
    estimator: ParameterEstimator<T, NETWORK_PARAMETERS, Z>,
}

impl<T: Scalar, Z: AdaptationWeight<T, NETWORK_PARAMETERS>> NeuralModel<T, Z> {
    /// The law with these hidden layers beside `nominal`.
    pub fn new(
        nominal: NominalModel<T>,
        synthesis: Synthesis<T>,
        networks: TanhNetworks<T>,
        adaptation: Adaptation<T, NETWORK_PARAMETERS, Z>,
    ) -> Self {
        Self { nominal, synthesis, networks, estimator: ParameterEstimator::new(adaptation) }
    }
}

impl<T: Scalar, Z: AdaptationWeight<T, NETWORK_PARAMETERS>> Controller<T> for NeuralModel<T, Z> {
    fn update(&mut self, measurement: &Measurement<T>, reference: &Reference<T>, period: T) -> Command<T> {
        let Self { nominal, synthesis, networks, estimator } = self;
        estimator.cycle(measurement, reference, period, |parameters| {
            let error = TrackingError::new(measurement, reference);
            let motion = synthesis.auxiliary_motion(reference, &error);
            let regressor = networks.regressor(measurement, reference);
            AdaptiveOutput {
                torque: nominal.torque(measurement, &motion)
                    + regressor * parameters
                    + synthesis.feedback_torque(&error),
                control_input: synthesis.control_input(&error),
                gradient: regressor.tr_mul(&synthesis.adaptation_signal(&error)),
                fell_back: false,
            }
        })
    }

    state_is_its_estimators!(T);
}
