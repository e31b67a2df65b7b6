//! The state tracking error x̃ = [q̃̇; q̃] (paper eq. 4).

use crate::{Measurement, Reference};
use dem_model::Scalar;
use nalgebra::SVector;

/// Measured minus desired motion of the active joints: x̃ of eq. 4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackingError<T: Scalar, const N: usize = 2> {
    /// q̃̇ = q̇_m − q̇_mᵈ, rad/s.
    pub velocity: SVector<T, N>,
    /// q̃ = q_m − q_mᵈ, rad.
    pub position: SVector<T, N>,
}

impl<T: Scalar, const N: usize> TrackingError<T, N> {
    /// The error of `measurement` against `reference`.
    pub fn new<const B: usize>(measurement: &Measurement<T, N, B>, reference: &Reference<T, N>) -> Self {
        Self {
            velocity: measurement.velocity - reference.velocity,
            position: measurement.position - reference.position,
        }
    }

    /// ‖x̃‖², rad²/s² and rad² summed as the paper does.
    pub fn norm_squared(&self) -> T {
        self.velocity.norm_squared() + self.position.norm_squared()
    }
}
