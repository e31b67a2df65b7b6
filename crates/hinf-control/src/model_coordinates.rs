//! From what is measured to the coordinates of the model: base, joint 2, joint 3.

use crate::Measurement;
use dem_model::Scalar;
use nalgebra::Vector3;

/// q for the model. The base's own angle has no effect on M or C and is left zero.
pub(crate) fn configuration<T: Scalar>(measurement: &Measurement<T>) -> Vector3<T> {
    Vector3::new(T::zero(), measurement.position.x, measurement.position.y)
}

/// q̇ for the model, with the base velocity as measured.
pub(crate) fn velocities<T: Scalar>(measurement: &Measurement<T>) -> Vector3<T> {
    Vector3::new(measurement.base.velocity, measurement.velocity.x, measurement.velocity.y)
}

/// q̇ for the model by a law that knows nothing of the base. M_mm and C_mm do not depend on the base velocity.
pub(crate) fn arm_velocities<T: Scalar>(measurement: &Measurement<T>) -> Vector3<T> {
    Vector3::new(T::zero(), measurement.velocity.x, measurement.velocity.y)
}
