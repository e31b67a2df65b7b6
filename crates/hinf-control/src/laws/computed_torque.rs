//! The baseline, not in the paper: PD+ with computed torque (Paden and Panja, International Journal of Control 47 (1988)
//! 1697–1712).
//!
//! τ_m = F(q_m, q̇_m; q̈ᵈ, q̇ᵈ) − K_d q̃̇ − K_p q̃, with F = M_mm q̈ᵈ + C_mm q̇ᵈ, or F̄ for F.
//!
//! It is controller 1 without Λ in the motion that F is computed for. Gains of K_d = R⁻¹ and K_p = R⁻¹Λ
//! ([`PdGains::matching`], for diagonal weights) give it the same feedback, so that what differs is the law.

use super::state::has_no_state;
use crate::NominalForm;
use crate::gains::PdGains;
use crate::law_definition::{BuildContext, BuildError, LawDefinition};
use crate::{AdaptationStatus, Command, Controller, Measurement, Reference, Synthesis, TrackingError, is_usable};
use crate::{AuxiliaryMotion, NominalModel};
use dem_model::Scalar;

/// Settings of the law.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Settings {
    /// F or F̄.
    pub model_form: NominalForm,
}

impl LawDefinition for Settings {
    const NAME: &'static str = "computed-torque";
    const DESCRIPTION: &'static str = "PD+ with the computed torque of the nominal model (baseline, not in the paper)";

    type Controller<T: Scalar> = PdComputedTorque<T>;

    fn build<T: Scalar>(
        &self,
        synthesis: Synthesis<T>,
        context: &BuildContext<T>,
    ) -> Result<PdComputedTorque<T>, BuildError> {
        let nominal = NominalModel::new(context.model, self.model_form);
        Ok(PdComputedTorque::new(nominal, PdGains::matching(&synthesis)?))
    }
}

/// The PD+ baseline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PdComputedTorque<T: Scalar> {
    nominal: NominalModel<T>,
    gains: PdGains<T>,
}

impl<T: Scalar> PdComputedTorque<T> {
    /// The law for a nominal model.
    pub fn new(nominal: NominalModel<T>, gains: PdGains<T>) -> Self {
        Self { nominal, gains }
    }
}

impl<T: Scalar> Controller<T> for PdComputedTorque<T> {
    /// [`Command::control_input`] is −K_d q̃̇ − K_p q̃.
    fn update(&mut self, measurement: &Measurement<T>, reference: &Reference<T>, period: T) -> Command<T> {
        let adaptation = AdaptationStatus::default();
        if !is_usable(measurement, reference, period) {
            return Command::fallback(adaptation);
        }
        let error = TrackingError::new(measurement, reference);
        let motion = AuxiliaryMotion { acceleration: reference.acceleration, velocity: reference.velocity };
        let control_input = -(self.gains.derivative() * error.velocity + self.gains.proportional() * error.position);
        let torque = self.nominal.torque(measurement, &motion) + control_input;
        Command { torque, control_input, adaptation }.or_fallback()
    }

    has_no_state!(T);
}
