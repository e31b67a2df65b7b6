//! What the supervision must know of a manipulator: its generalised momentum and what changes it beside torques.

use std::fmt;

use hinf_control::dem_model::ThreeLinkDem;
use nalgebra::Vector3;

/// A model of the whole manipulator, the passive base as joint 1: M(q) q̈ + C(q, q̇) q̇ = τ. Angles in rad.
pub trait MomentumModel<const J: usize>: fmt::Debug + Send + Sync {
    /// M(q) by rows, kg·m²: symmetric and positive definite.
    fn inertia(&self, position: &[f64; J]) -> [[f64; J]; J];

    /// Cᵀ q̇, N·m, for velocities in rad/s: what changes the momentum p = M q̇ beside torques, ṗ = τ + Cᵀ q̇, since Ṁ = C + Cᵀ.
    fn velocity_torque(&self, position: &[f64; J], velocity: &[f64; J]) -> [f64; J];
}

impl MomentumModel<3> for ThreeLinkDem<f64> {
    fn inertia(&self, position: &[f64; 3]) -> [[f64; 3]; 3] {
        // By columns, which are the rows of a symmetric matrix.
        self.mass_matrix(&Vector3::from(*position)).into()
    }

    fn velocity_torque(&self, position: &[f64; 3], velocity: &[f64; 3]) -> [f64; 3] {
        let velocity = Vector3::from(*velocity);
        self.coriolis_matrix(&Vector3::from(*position), &velocity).tr_mul(&velocity).into()
    }
}
