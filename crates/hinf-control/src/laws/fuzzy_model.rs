//! Controller 6: adaptive fuzzy nonlinear H∞ control beside the nominal model (paper section 3.3, second approach).
//!
//! E − δ is approximated by H = ΞΦ (eq. 44), with the fuzzy systems of controller 5, and F is the nominal model's:
//!
//! - Φ̇ = −Z⁻¹Ξᵀ T11ᵀBᵀT0x̃ (eq. 45),
//! - τ_m = F + ΞΦ − T11⁻¹R⁻¹BᵀT0x̃ (eq. 46).
//!
//! With [`NominalForm::Reduced`] F̄ stands in the place of F (ours), without base data either; with
//! [`NominalForm::ReducedMomentum`] it takes the momentum from the base velocity.

use super::state::state_is_its_estimators;
use crate::adaptation::{Adaptation, AdaptationWeight, AdaptiveOutput, ParameterEstimator, ScalarWeight};
use crate::arm_model::ArmModel;
use crate::law_definition::{
    AdaptationSettings, BuildContext, BuildError, CatalogueModel, DerivedWeights, LawDefinition, LawVariant, PaperArm,
    PaperWeights, PublishedIndices, StateWeights, VariantOrigin,
};
use crate::{BaseAcceleration, Firing, NominalForm, SymmetricWeight, UnsupportedBaseAcceleration};
use crate::{Command, Controller, Measurement, Reference, Synthesis, TrackingError};
use crate::{FUZZY_PARAMETERS, FuzzyRegressor, FuzzySystem, NominalModel};
use dem_model::{Scalar, ThreeLinkDem};
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
    /// F or F̄.
    pub model_form: NominalForm,
}

impl<const N: usize> Default for Settings<N>
where
    PaperArm: PaperWeights<N>,
{
    fn default() -> Self {
        Self {
            q1: PaperArm::diagonal([4.0, 4.0]),
            q2: PaperArm::diagonal([25.0, 7.0]),
            z: 20.0,
            bound: 0.3,
            firing: Firing::Minimum,
            model_form: NominalForm::ActiveJoints,
        }
    }
}

impl<const N: usize> LawDefinition<N> for Settings<N> {
    const NAME: &'static str = "fuzzy-model";
    const DESCRIPTION: &'static str = "adaptive fuzzy nonlinear H-infinity control beside the nominal model";
    const PUBLISHED_INDICES: Option<PublishedIndices> = Some(PublishedIndices { tracking: 0.0318, torque: 0.1788 });
    const VARIANTS: &'static [LawVariant] = &[LawVariant {
        name: "fuzzy-model-reduced",
        base_acceleration: BaseAcceleration::Reduced,
        origin: VariantOrigin::Extension,
    }];

    type Controller<T: Scalar, const B: usize, M: CatalogueModel<T, N, B>> = FuzzyModel<T, N, B, M>;

    fn derived(weights: &DerivedWeights<N>) -> Self {
        let AdaptationSettings { z, bound } = weights.rules;
        Self {
            q1: weights.state.q1,
            q2: weights.state.q2,
            z,
            bound,
            firing: Firing::Minimum,
            model_form: NominalForm::Reduced,
        }
    }

    fn build<T: Scalar, const B: usize, M: CatalogueModel<T, N, B>>(
        &self,
        synthesis: Synthesis<T, N>,
        context: &BuildContext<T, M>,
    ) -> Result<FuzzyModel<T, N, B, M>, BuildError> {
        let settings = AdaptationSettings { z: self.z, bound: self.bound };
        let adaptation = context.adaptation(SMatrix::zeros(), settings)?;
        let nominal = NominalModel::new(context.model.clone(), self.model_form);
        let system = FuzzySystem::new(context.fuzzy_sets, self.firing);
        Ok(FuzzyModel::new(nominal, synthesis, system, adaptation))
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

    fn set_base_acceleration(&mut self, mode: BaseAcceleration) -> Result<(), UnsupportedBaseAcceleration> {
        self.model_form = mode.try_into()?;
        Ok(())
    }
}

/// Controller 6. The paper starts it at Φ = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct FuzzyModel<T: Scalar, const N: usize = 2, const B: usize = 1, M = ThreeLinkDem<T>, Z = ScalarWeight<T>> {
    nominal: NominalModel<M>,
    synthesis: Synthesis<T, N>,
    system: FuzzySystem<T>,
    estimator: ParameterEstimator<T, FUZZY_PARAMETERS, N, Z>,
}

impl<T: Scalar, const N: usize, const B: usize, M, Z> FuzzyModel<T, N, B, M, Z>
where
    M: ArmModel<T, N, B>,
    Z: AdaptationWeight<T, FUZZY_PARAMETERS, N>,
{
    /// The law with these premises beside `nominal`.
    pub fn new(
        nominal: NominalModel<M>,
        synthesis: Synthesis<T, N>,
        system: FuzzySystem<T>,
        adaptation: Adaptation<T, FUZZY_PARAMETERS, N, Z>,
    ) -> Self {
        Self { nominal, synthesis, system, estimator: ParameterEstimator::new(adaptation) }
    }
}

impl<T: Scalar, const N: usize, const B: usize, M, Z> Controller<T, N, B> for FuzzyModel<T, N, B, M, Z>
where
    M: ArmModel<T, N, B>,
    Z: AdaptationWeight<T, FUZZY_PARAMETERS, N>,
{
    fn update(&mut self, measurement: &Measurement<T, N, B>, reference: &Reference<T, N>, period: T) -> Command<T, N> {
        let Self { nominal, synthesis, system, estimator } = self;
        estimator.cycle(measurement, reference, period, |parameters| {
            let error = TrackingError::new(measurement, reference);
            let motion = synthesis.auxiliary_motion(reference, &error);
            let FuzzyRegressor { regressor, fell_back } = system.regressor(&error);
            AdaptiveOutput {
                torque: nominal.torque(measurement, &motion)
                    + regressor.torque(parameters)
                    + synthesis.feedback_torque(&error),
                control_input: synthesis.control_input(&error),
                gradient: regressor.gradient(&synthesis.adaptation_signal(&error)),
                fell_back,
            }
        })
    }

    state_is_its_estimators!(T, N);
}
