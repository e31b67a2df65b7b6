//! Controller 6: adaptive fuzzy nonlinear H∞ control beside the nominal model (paper section 3.3, second approach).
//!
//! E − δ is approximated by H = ΞΦ (eq. 44), with the fuzzy systems of controller 5, and F is the nominal model's:
//!
//! - Φ̇ = −Z⁻¹Ξᵀ T11ᵀBᵀT0x̃ (eq. 45),
//! - τ_m = F + ΞΦ − T11⁻¹R⁻¹BᵀT0x̃ (eq. 46).
//!
//! With [`NominalForm::Reduced`](crate::NominalForm::Reduced) F̄ stands in the place of F (ours). No base data in either
//! form.

use super::state_is_its_estimators;
use crate::adaptation::{Adaptation, AdaptationWeight, AdaptiveOutput, ParameterEstimator, ScalarWeight};
use crate::{Command, Controller, Measurement, Reference, Synthesis, TrackingError};
use crate::{FUZZY_PARAMETERS, FuzzySystem, NominalModel};
use dem_model::Scalar;

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
