//! The nominal torque F, or its reduced form F̄, that a law can be given beside what it learns.
//!
//! - `active-joints`: F = M_mm x1 + C_mm x2 (paper eq. 7), the arm as if its base stood still.
//! - `reduced`: F̄ = M̄ x1 + C̄ x2, the arm on a base that floats with zero angular momentum, the generalised inertia
//!   M̄ = M_mm − M_mb M_bb⁻¹ M_bm and its own Christoffel matrix C̄. Beyond the paper; from rest it is exact.
//!
//! Neither reads anything of the base.

use crate::base_acceleration::{BaseAcceleration, UnsupportedBaseAcceleration};
use crate::model_coordinates::{arm_velocities, configuration};
use crate::{AuxiliaryMotion, Measurement};
use dem_model::{Scalar, ThreeLinkDem};
use nalgebra::Vector2;

/// Which nominal torque is meant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum NominalForm {
    /// F of the paper.
    #[default]
    #[cfg_attr(feature = "serde", serde(alias = "paper"))]
    ActiveJoints,
    /// F̄, our extension.
    Reduced,
}

impl TryFrom<BaseAcceleration> for NominalForm {
    type Error = UnsupportedBaseAcceleration;

    /// Without base acceleration F is what is left, and F̄ is the reduced form.
    fn try_from(mode: BaseAcceleration) -> Result<Self, UnsupportedBaseAcceleration> {
        match mode {
            BaseAcceleration::Omitted => Ok(Self::ActiveJoints),
            BaseAcceleration::Reduced => Ok(Self::Reduced),
            found => {
                Err(UnsupportedBaseAcceleration { found, expected: "omitted or reduced: the law reads no base data" })
            }
        }
    }
}

/// A manipulator's nominal parameters, and the form in which a law uses them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NominalModel<T: Scalar> {
    model: ThreeLinkDem<T>,
    form: NominalForm,
}

impl<T: Scalar> NominalModel<T> {
    /// `model` in `form`.
    pub fn new(model: ThreeLinkDem<T>, form: NominalForm) -> Self {
        Self { model, form }
    }

    /// The nominal torque for `motion`, N·m.
    pub fn torque(&self, measurement: &Measurement<T>, motion: &AuxiliaryMotion<T>) -> Vector2<T> {
        let q = configuration(measurement);
        match self.form {
            NominalForm::ActiveJoints => self
                .model
                .partition(&q, &arm_velocities(measurement))
                .arm_torque(&motion.acceleration, &motion.velocity),
            NominalForm::Reduced => {
                let no_momentum = T::zero();
                self.model.reduced(&q, &measurement.velocity).arm_torque(
                    &motion.acceleration,
                    &motion.velocity,
                    no_momentum,
                )
            }
        }
    }
}
