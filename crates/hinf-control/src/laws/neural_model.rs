//! Controller 4: adaptive neural network nonlinear H∞ control beside the nominal model (paper section 3.2, second
//! approach).
//!
//! E − δ is approximated by H = ΞΦ (eq. 32), with the networks of controller 3, and F is the nominal model's:
//!
//! - Φ̇ = −Z⁻¹Ξᵀ T11ᵀBᵀT0x̃ (eq. 36),
//! - τ_m = F + ΞΦ − T11⁻¹R⁻¹BᵀT0x̃ (eq. 37).
//!
//! With [`NominalForm::Reduced`](crate::NominalForm::Reduced) F̄ stands in the place of F (ours), and the networks are left
//! with what is truly unknown. No base data in either form.

use super::state_is_its_estimators;
use crate::adaptation::{Adaptation, AdaptationWeight, AdaptiveOutput, ParameterEstimator, ScalarWeight};
use crate::{Command, Controller, Measurement, Reference, Synthesis, TrackingError};
use crate::{NETWORK_PARAMETERS, NominalModel, TanhNetworks};
use dem_model::Scalar;

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
