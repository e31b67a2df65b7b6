//! The nominal torque F, or its reduced form F̄, that a law can be given beside what it learns.
//!
//! - `active-joints`: F = M_mm x1 + C_mm x2 (paper eq. 7), the arm as if its base stood still.
//! - `reduced`: F̄ = M̄ x1 + C̄ x2, the arm on a base that floats with zero momentum, the generalised inertia
//!   M̄ = M_mm − M_mb M_bb⁻¹ M_bm and its own Coriolis matrix C̄. Beyond the paper; from rest it is exact.
//! - `reduced-momentum`: F̄ = M̄ x1 + C̃ x2 + c_h at the momentum that the base velocity tells; in the plane
//!   C̃ = C̄ + pG and c_h = p²g. Exact with any momentum.
//!
//! The first two read nothing of the base.

use crate::arm_model::{ArmModel, Momentum};
use crate::base_acceleration::{BaseAcceleration, UnsupportedBaseAcceleration};
use crate::{AuxiliaryMotion, Measurement};
use dem_model::Scalar;
use nalgebra::SVector;

/// Which nominal torque is meant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum NominalForm {
    /// F of the paper.
    #[default]
    #[cfg_attr(feature = "serde", serde(alias = "paper"))]
    ActiveJoints,
    /// F̄ without momentum, our extension.
    Reduced,
    /// F̄ at the measured momentum, our extension.
    ReducedMomentum,
}

impl TryFrom<BaseAcceleration> for NominalForm {
    type Error = UnsupportedBaseAcceleration;

    /// Without base acceleration F is what is left, and F̄ is the reduced form.
    fn try_from(mode: BaseAcceleration) -> Result<Self, UnsupportedBaseAcceleration> {
        match mode {
            BaseAcceleration::Omitted => Ok(Self::ActiveJoints),
            BaseAcceleration::Reduced => Ok(Self::Reduced),
            BaseAcceleration::ReducedMomentum => Ok(Self::ReducedMomentum),
            found @ (BaseAcceleration::Measured | BaseAcceleration::Eliminated) => Err(UnsupportedBaseAcceleration {
                found,
                expected: "omitted, reduced or reduced-momentum: the law reads no base acceleration",
            }),
        }
    }
}

/// A manipulator's nominal parameters, and the form in which a law uses them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NominalModel<M> {
    model: M,
    form: NominalForm,
}

impl<M> NominalModel<M> {
    /// `model` in `form`.
    pub fn new(model: M, form: NominalForm) -> Self {
        Self { model, form }
    }

    /// The nominal torque for `motion`, N·m. Not finite where what it reads is not.
    pub fn torque<T: Scalar, const N: usize, const B: usize>(
        &self,
        measurement: &Measurement<T, N, B>,
        motion: &AuxiliaryMotion<T, N>,
    ) -> SVector<T, N>
    where
        M: ArmModel<T, N, B>,
    {
        let reduced = |momentum| {
            let torque = self.model.reduced_torque(measurement, motion, momentum);
            torque.unwrap_or_else(|| SVector::repeat(T::constant(f64::NAN)))
        };
        match self.form {
            NominalForm::ActiveJoints => self.model.arm_torque(measurement, motion),
            NominalForm::Reduced => reduced(Momentum::Zero),
            NominalForm::ReducedMomentum => reduced(Momentum::Measured),
        }
    }
}
