//! Controller 6: adaptive fuzzy nonlinear H∞ control beside the nominal model (paper section 3.3, second approach).
//!
//! E − δ is approximated by H = ΞΦ (eq. 44), with the fuzzy systems of controller 5, and F is the nominal model's:
//!
//! - Φ̇ = −Z⁻¹Ξᵀ T11ᵀBᵀT0x̃ (eq. 45),
//! - τ_m = F + ΞΦ − T11⁻¹R⁻¹BᵀT0x̃ (eq. 46).
//!
//! With [`NominalForm::Reduced`] F̄ stands in the place of F (ours). No base data in either
//! form.

use super::state::state_is_its_estimators;
use crate::adaptation::{Adaptation, AdaptationWeight, AdaptiveOutput, ParameterEstimator, ScalarWeight};
use crate::law_definition::{
    AdaptationSettings, BuildContext, BuildError, LawDefinition, LawVariant, PublishedIndices, StateWeights,
    VariantOrigin,
};
use crate::{BaseAcceleration, Firing, NominalForm, SymmetricWeight, UnsupportedBaseAcceleration};
use crate::{Command, Controller, Measurement, Reference, Synthesis, TrackingError};
use crate::{FUZZY_PARAMETERS, FuzzySystem, NominalModel};
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
    /// F or F̄.
    pub model_form: NominalForm,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            q1: SymmetricWeight::Diagonal([4.0, 4.0]),
            q2: SymmetricWeight::Diagonal([25.0, 7.0]),
            z: 20.0,
            bound: 0.3,
            firing: Firing::Minimum,
            model_form: NominalForm::ActiveJoints,
        }
    }
}

impl LawDefinition for Settings {
    const NAME: &'static str = "fuzzy-model";
    const DESCRIPTION: &'static str = "adaptive fuzzy nonlinear H-infinity control beside the nominal model";
    const PUBLISHED_INDICES: Option<PublishedIndices> = Some(PublishedIndices { tracking: 0.0318, torque: 0.1788 });
    const VARIANTS: &'static [LawVariant] = &[LawVariant {
        name: "fuzzy-model-reduced",
        base_acceleration: BaseAcceleration::Reduced,
        origin: VariantOrigin::Extension,
    }];

    type Controller<T: Scalar> = FuzzyModel<T>;

    fn build<T: Scalar>(
        &self,
        synthesis: Synthesis<T>,
        context: &BuildContext<T>,
    ) -> Result<FuzzyModel<T>, BuildError> {
        let settings = AdaptationSettings { z: self.z, bound: self.bound };
        let adaptation = context.adaptation(SVector::zeros(), settings)?;
        let nominal = NominalModel::new(context.model, self.model_form);
        let system = FuzzySystem::new(context.fuzzy_sets, self.firing);
        Ok(FuzzyModel::new(nominal, synthesis, system, adaptation))
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

    fn set_base_acceleration(&mut self, mode: BaseAcceleration) -> Result<(), UnsupportedBaseAcceleration> {
        self.model_form = mode.try_into()?;
        Ok(())
    }
}

/// Controller 6. The paper starts it at Φ = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct FuzzyModel<T: Scalar, Z = ScalarWeight<T>> {
    nominal: NominalModel<T>,
    synthesis: Synthesis<T>,
    system: FuzzySystem<T>,
    estimator: ParameterEstimator<T, FUZZY_PARAMETERS, Z>,
}

impl<T: Scalar, Z: AdaptationWeight<T, FUZZY_PARAMETERS>> FuzzyModel<T, Z> {
    /// The law with these premises beside `nominal`.
    pub fn new(
        nominal: NominalModel<T>,
        synthesis: Synthesis<T>,
        system: FuzzySystem<T>,
        adaptation: Adaptation<T, FUZZY_PARAMETERS, Z>,
    ) -> Self {
        Self { nominal, synthesis, system, estimator: ParameterEstimator::new(adaptation) }
    }
}

impl<T: Scalar, Z: AdaptationWeight<T, FUZZY_PARAMETERS>> Controller<T> for FuzzyModel<T, Z> {
    fn update(&mut self, measurement: &Measurement<T>, reference: &Reference<T>, period: T) -> Command<T> {
        let Self { nominal, synthesis, system, estimator } = self;
        estimator.cycle(measurement, reference, period, |parameters| {
            let error = TrackingError::new(measurement, reference);
            let motion = synthesis.auxiliary_motion(reference, &error);
            let regressor = system.regressor(&error);
            AdaptiveOutput {
                torque: nominal.torque(measurement, &motion)
                    + regressor.matrix * parameters
                    + synthesis.feedback_torque(&error),
                control_input: synthesis.control_input(&error),
                gradient: regressor.matrix.tr_mul(&synthesis.adaptation_signal(&error)),
                fell_back: regressor.fell_back,
            }
        })
    }

    state_is_its_estimators!(T);
}
