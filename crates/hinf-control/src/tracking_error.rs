//! The state tracking error x̃ = [q̃̇; q̃] (paper eq. 4).

use crate::{Measurement, Reference};
use dem_model::Scalar;
use nalgebra::{Vector2, Vector4};

/// Measured minus desired motion of the active joints: x̃ of eq. 4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackingError<T: Scalar> {
    /// q̃̇ = q̇_m − q̇_mᵈ, rad/s.
    pub rate: Vector2<T>,
    /// q̃ = q_m − q_mᵈ, rad.
    pub position: Vector2<T>,
}

impl<T: Scalar> TrackingError<T> {
    /// The error of `measurement` against `reference`.
    pub fn new(measurement: &Measurement<T>, reference: &Reference<T>) -> Self {
        Self { rate: measurement.rate - reference.rate, position: measurement.position - reference.position }
    }

    /// x̃ as one vector, rates first.
    pub fn state(&self) -> Vector4<T> {
        Vector4::new(self.rate.x, self.rate.y, self.position.x, self.position.y)
    }

    /// ‖x̃‖², rad²/s² and rad² summed as the paper does.
    pub fn norm_squared(&self) -> T {
        self.rate.norm_squared() + self.position.norm_squared()
    }
}
