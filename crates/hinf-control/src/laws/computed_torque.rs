//! The baseline, not in the paper: PD+ with computed torque (Paden and Panja, International Journal of Control 47 (1988)
//! 1697–1712).
//!
//! τ_m = F(q_m, q̇_m; q̈ᵈ, q̇ᵈ) − K_d q̃̇ − K_p q̃, with F = M_mm q̈ᵈ + C_mm q̇ᵈ, or F̄ for F.
//!
//! It is controller 1 without Λ in the motion that F is computed for. Gains of K_d = R⁻¹ and K_p = R⁻¹Λ
//! ([`PdGains::matching`], for diagonal weights) give it the same feedback, so that what differs is the law.

use super::state::has_no_state;
use crate::NominalForm;
use crate::arm_model::ArmModel;
use crate::gains::PdGains;
use crate::law_definition::{BuildContext, BuildError, CatalogueModel, DerivedWeights, LawDefinition};
use crate::{AdaptationStatus, Command, Controller, Measurement, Reference, Synthesis, TrackingError, is_usable};
use crate::{AuxiliaryMotion, NominalModel};
use crate::{BaseAcceleration, UnsupportedBaseAcceleration};
use dem_model::{Scalar, ThreeLinkDem};

/// Settings of the law for N joints.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Settings<const N: usize = 2> {
    /// F or F̄.
    pub model_form: NominalForm,
}

impl<const N: usize> LawDefinition<N> for Settings<N> {
    const NAME: &'static str = "computed-torque";
    const DESCRIPTION: &'static str = "PD+ with the computed torque of the nominal model (baseline, not in the paper)";

    type Controller<T: Scalar, const B: usize, M: CatalogueModel<T, N, B>> = PdComputedTorque<T, N, B, M>;

    fn derived(_: &DerivedWeights<N>) -> Self {
        Self { model_form: NominalForm::Reduced }
    }

    fn build<T: Scalar, const B: usize, M: CatalogueModel<T, N, B>>(
        &self,
        synthesis: Synthesis<T, N>,
        context: &BuildContext<T, M>,
    ) -> Result<PdComputedTorque<T, N, B, M>, BuildError> {
        let nominal = NominalModel::new(context.model.clone(), self.model_form);
        Ok(PdComputedTorque::new(nominal, PdGains::matching(&synthesis)?))
    }

    fn set_base_acceleration(&mut self, mode: BaseAcceleration) -> Result<(), UnsupportedBaseAcceleration> {
        self.model_form = mode.try_into()?;
        Ok(())
    }
}

/// The PD+ baseline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PdComputedTorque<T: Scalar, const N: usize = 2, const B: usize = 1, M = ThreeLinkDem<T>> {
    nominal: NominalModel<M>,
    gains: PdGains<T, N>,
}

impl<T: Scalar, const N: usize, const B: usize, M: ArmModel<T, N, B>> PdComputedTorque<T, N, B, M> {
    /// The law for a nominal model.
    pub fn new(nominal: NominalModel<M>, gains: PdGains<T, N>) -> Self {
        Self { nominal, gains }
    }
}

impl<T: Scalar, const N: usize, const B: usize, M: ArmModel<T, N, B>> Controller<T, N, B>
    for PdComputedTorque<T, N, B, M>
{
    /// [`Command::control_input`] is −K_d q̃̇ − K_p q̃.
    fn update(&mut self, measurement: &Measurement<T, N, B>, reference: &Reference<T, N>, period: T) -> Command<T, N> {
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

    has_no_state!(T, N);
}
