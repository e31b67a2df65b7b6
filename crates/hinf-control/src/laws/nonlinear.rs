//! Controller 1: nonlinear H∞ control with the nominal model (paper section 2.3).
//!
//! With x1 = q̈ᵈ − Λq̃̇, x2 = q̇ᵈ − Λq̃, Λ = T11⁻¹T12:
//!
//! - u = −R⁻¹BᵀT0x̃ (eq. 10),
//! - F = M_mm x1 + C_mm x2, E = M_mb q̈_b + C_mb q̇_b (eq. 7),
//! - τ_m = T11⁻¹u + F + E (eq. 11).
//!
//! E needs the base acceleration, which a robot has only by differentiating. [`BaseAcceleration`] says what is done. With
//! τ̄ = T11⁻¹u + F:
//!
//! - `measured`: τ_m = τ̄ + E,
//! - `eliminated`: τ_m = M̄ q̈_m + h̄ with q̈_m = M_mm⁻¹(τ̄ − C_mm q̇_m) (eqs. 20, 21),
//! - `omitted`: τ_m = τ̄,
//! - `reduced`: τ_m = T11⁻¹u + M̄ x1 + C̄ x2,
//! - `reduced-momentum`: τ_m = T11⁻¹u + M̄ x1 + (C̄ + pG) x2 + p²g; in space τ_m = T11⁻¹u + M̄ x1 + C̃ x2 + c_h.
//!
//! The last two are ours. Without gravity the base coordinate is cyclic, so that its momentum p = M_b* q̇ is constant, and
//! M̄ q̈_m + C̄ q̇_m + pG q̇_m + p²g = τ_m is the whole motion of the arm, with M̄̇ − 2C̄ and G skew. The
//! paper's bound then holds with what a robot can measure: see [`ProvenAttenuation`](crate::ProvenAttenuation). With
//! `eliminated` it does not: the ratio of eq. 8 reaches about 190 at γ² = 4.

use super::state::has_no_state;
use crate::AuxiliaryMotion;
use crate::arm_model::{ArmModel, Momentum};
use crate::law_definition::{
    BuildContext, BuildError, CatalogueModel, DerivedWeights, LawDefinition, LawVariant, PaperArm, PaperWeights,
    PublishedIndices, StateWeights, VariantOrigin,
};
use crate::{AdaptationStatus, Command, Controller, Measurement, Reference, Synthesis, TrackingError, is_usable};
use crate::{BaseAcceleration, SymmetricWeight, UnsupportedBaseAcceleration};
use dem_model::{Scalar, ThreeLinkDem};
use nalgebra::SVector;

/// Settings of the law. The default is Table 3.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Settings<const N: usize = 2> {
    /// Weight of the velocity error.
    pub q1: SymmetricWeight<N>,
    /// Weight of the position error.
    pub q2: SymmetricWeight<N>,
    /// How the base acceleration that eq. 11 needs is had.
    pub base_acceleration: BaseAcceleration,
}

impl<const N: usize> Default for Settings<N>
where
    PaperArm: PaperWeights<N>,
{
    fn default() -> Self {
        Self {
            q1: PaperArm::diagonal([0.64, 0.64]),
            q2: PaperArm::diagonal([9.0, 7.0]),
            base_acceleration: BaseAcceleration::Eliminated,
        }
    }
}

impl<const N: usize> Settings<N> {
    /// Q1 and Q2.
    pub fn weights(&self) -> StateWeights<N> {
        StateWeights { q1: self.q1, q2: self.q2 }
    }
}

impl<const N: usize> LawDefinition<N> for Settings<N> {
    const NAME: &'static str = "nonlinear";
    const DESCRIPTION: &'static str = "nonlinear H-infinity control with the nominal model";
    const PUBLISHED_INDICES: Option<PublishedIndices> = Some(PublishedIndices { tracking: 0.0778, torque: 0.1419 });
    const VARIANTS: &'static [LawVariant] = &[
        LawVariant {
            name: "nonlinear-measured",
            base_acceleration: BaseAcceleration::Measured,
            origin: VariantOrigin::Reading,
        },
        LawVariant {
            name: "nonlinear-omitted",
            base_acceleration: BaseAcceleration::Omitted,
            origin: VariantOrigin::Reading,
        },
        LawVariant {
            name: "nonlinear-reduced",
            base_acceleration: BaseAcceleration::Reduced,
            origin: VariantOrigin::Extension,
        },
        LawVariant {
            name: "nonlinear-reduced-momentum",
            base_acceleration: BaseAcceleration::ReducedMomentum,
            origin: VariantOrigin::Extension,
        },
    ];

    type Controller<T: Scalar, const B: usize, M: CatalogueModel<T, N, B>> = NonlinearHInfinity<T, N, B, M>;

    fn derived(weights: &DerivedWeights<N>) -> Self {
        Self { q1: weights.state.q1, q2: weights.state.q2, base_acceleration: BaseAcceleration::Reduced }
    }

    fn build<T: Scalar, const B: usize, M: CatalogueModel<T, N, B>>(
        &self,
        synthesis: Synthesis<T, N>,
        context: &BuildContext<T, M>,
    ) -> Result<NonlinearHInfinity<T, N, B, M>, BuildError> {
        Ok(NonlinearHInfinity::new(context.model.clone(), synthesis, self.base_acceleration))
    }

    fn state_weights(&self) -> Option<StateWeights<N>> {
        Some(self.weights())
    }

    fn set_base_acceleration(&mut self, mode: BaseAcceleration) -> Result<(), UnsupportedBaseAcceleration> {
        self.base_acceleration = mode;
        Ok(())
    }
}

/// Controller 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NonlinearHInfinity<T: Scalar, const N: usize = 2, const B: usize = 1, M = ThreeLinkDem<T>> {
    model: M,
    synthesis: Synthesis<T, N>,
    base_acceleration: BaseAcceleration,
}

impl<T: Scalar, const N: usize, const B: usize, M: ArmModel<T, N, B>> NonlinearHInfinity<T, N, B, M> {
    /// The law for a nominal `model`.
    pub fn new(model: M, synthesis: Synthesis<T, N>, base_acceleration: BaseAcceleration) -> Self {
        Self { model, synthesis, base_acceleration }
    }

    /// F + E or what stands for it, N·m, given the feedback T11⁻¹u.
    fn torque(
        &self,
        measurement: &Measurement<T, N, B>,
        motion: &AuxiliaryMotion<T, N>,
        feedback: SVector<T, N>,
    ) -> Option<SVector<T, N>> {
        let model = &self.model;
        let arm_torque = || feedback + model.arm_torque(measurement, motion);
        let reduced = |momentum| Some(feedback + model.reduced_torque(measurement, motion, momentum)?);
        match self.base_acceleration {
            BaseAcceleration::Measured => Some(arm_torque() + model.base_reaction(measurement)),
            BaseAcceleration::Eliminated => model.base_compensated_torque(measurement, &arm_torque()),
            BaseAcceleration::Omitted => Some(arm_torque()),
            BaseAcceleration::Reduced => reduced(Momentum::Zero),
            BaseAcceleration::ReducedMomentum => reduced(Momentum::Measured),
        }
    }
}

impl<T: Scalar, const N: usize, const B: usize, M: ArmModel<T, N, B>> Controller<T, N, B>
    for NonlinearHInfinity<T, N, B, M>
{
    fn update(&mut self, measurement: &Measurement<T, N, B>, reference: &Reference<T, N>, period: T) -> Command<T, N> {
        let adaptation = AdaptationStatus::default();
        if !is_usable(measurement, reference, period) {
            return Command::fallback(adaptation);
        }
        let error = TrackingError::new(measurement, reference);
        let motion = self.synthesis.auxiliary_motion(reference, &error);
        let control_input = self.synthesis.control_input(&error);
        let feedback = self.synthesis.t11_inverse() * control_input;
        match self.torque(measurement, &motion, feedback) {
            Some(torque) => Command { torque, control_input, adaptation }.or_fallback(),
            None => Command::fallback(adaptation),
        }
    }

    has_no_state!(T, N);
}
