//! The paper's arm: two joints in the plane, in closed form.

use super::{ArmModel, LinearModel, Momentum};
use crate::{AuxiliaryMotion, Measurement};
use dem_model::{Partition, REGRESSOR_PARAMETERS, ReducedDynamics, Scalar, ThreeLinkDem, regressor};
use nalgebra::{Matrix2, SMatrix, SVector, Vector2, Vector3};

/// q for the model. The base's own angle has no effect on M or C and is left zero.
fn configuration<T: Scalar>(position: &Vector2<T>) -> Vector3<T> {
    Vector3::new(T::zero(), position.x, position.y)
}

/// M and C with the base's velocity as measured.
fn partition<T: Scalar>(model: &ThreeLinkDem<T>, measurement: &Measurement<T>) -> Partition<T> {
    model.partition(&configuration(&measurement.position), &velocities(measurement))
}

fn velocities<T: Scalar>(measurement: &Measurement<T>) -> Vector3<T> {
    Vector3::new(measurement.base.velocity.x, measurement.velocity.x, measurement.velocity.y)
}

fn reduced<T: Scalar>(model: &ThreeLinkDem<T>, measurement: &Measurement<T>) -> ReducedDynamics<T> {
    model.reduced(&configuration(&measurement.position), &measurement.velocity)
}

impl<T: Scalar> ArmModel<T, 2, 1> for ThreeLinkDem<T> {
    fn arm_torque(&self, measurement: &Measurement<T>, motion: &AuxiliaryMotion<T>) -> Vector2<T> {
        // M_mm and C_mm do not depend on the base velocity.
        let velocities = Vector3::new(T::zero(), measurement.velocity.x, measurement.velocity.y);
        let parts = self.partition(&configuration(&measurement.position), &velocities);
        parts.arm_torque(&motion.acceleration, &motion.velocity)
    }

    fn base_reaction(&self, measurement: &Measurement<T>) -> Vector2<T> {
        let base = &measurement.base;
        partition(self, measurement).base_reaction(base.acceleration.x, base.velocity.x)
    }

    fn base_compensated_torque(&self, measurement: &Measurement<T>, arm_torque: &Vector2<T>) -> Option<Vector2<T>> {
        let parts = partition(self, measurement);
        parts.base_compensated_torque(arm_torque, measurement.base.velocity.x, &measurement.velocity)
    }

    fn reduced_torque(
        &self,
        measurement: &Measurement<T>,
        motion: &AuxiliaryMotion<T>,
        momentum: Momentum,
    ) -> Option<Vector2<T>> {
        let reduced = reduced(self, measurement);
        let momentum = match momentum {
            Momentum::Zero => T::zero(),
            // p = M_bb (q̇_b + A q̇_m)
            Momentum::Measured => {
                let moved = (reduced.base_coupling * measurement.velocity).x;
                reduced.mass_bb * (measurement.base.velocity.x + moved)
            }
        };
        Some(reduced.arm_torque(&motion.acceleration, &motion.velocity, momentum))
    }

    fn generalised_inertia(&self, position: &Vector2<T>) -> Option<Matrix2<T>> {
        Some(self.reduced(&configuration(position), &Vector2::zeros()).mass)
    }
}

/// Φ of eq. 13, one group.
impl<T: Scalar> LinearModel<T, 2, 1, REGRESSOR_PARAMETERS, 1> for ThreeLinkDem<T> {
    fn parameters(&self) -> SVector<T, REGRESSOR_PARAMETERS> {
        self.regressor_parameters()
    }

    fn regressor(
        &self,
        measurement: &Measurement<T>,
        motion: &AuxiliaryMotion<T>,
    ) -> [SMatrix<T, 2, REGRESSOR_PARAMETERS>; 1] {
        let Measurement { position, velocity, .. } = measurement;
        [regressor(position.y, velocity, &motion.acceleration, &motion.velocity)]
    }

    fn estimated_compensation(
        &self,
        parameters: &SVector<T, REGRESSOR_PARAMETERS>,
        measurement: &Measurement<T>,
        arm_torque: &Vector2<T>,
    ) -> Option<Vector2<T>> {
        let estimate = self.with_regressor_parameters(parameters);
        let parts = estimate.partition(&configuration(&measurement.position), &velocities(measurement));
        parts.base_compensated_torque(arm_torque, measurement.base.velocity.x, &measurement.velocity)
    }
}
