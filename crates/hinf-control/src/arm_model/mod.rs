//! What a law asks of the model of an arm of N joints on a base of B degrees of freedom.
//!
//! M and C are those of the free-floating arm's dynamically equivalent manipulator, cut into base (b) and arm (m):
//! M v̇ + C v = [0; τ_m] with v = [v_b; q̇_m], v_b in base axes. C_mm is taken at v_b = 0, so that F is that of the arm on a
//! locked base; C_mb takes up what it leaves out. For three links in the plane this is the paper's partition.

mod serial;
mod three_link;

use crate::{AuxiliaryMotion, Measurement};
use dem_model::Scalar;
use nalgebra::{SMatrix, SVector};

/// Which momentum of the whole the reduced dynamics are taken at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Momentum {
    /// None: all started from rest. Reads nothing of the base.
    Zero,
    /// What the measured base velocity tells: h = M_bb v_b + M_bm q̇_m.
    Measured,
}

/// The nominal model of an arm of `N` joints on a base of `B` degrees of freedom.
pub trait ArmModel<T: Scalar, const N: usize, const B: usize>: Clone {
    /// F = M_mm x1 + C_mm x2 in N·m (paper eq. 7). Reads nothing of the base.
    fn arm_torque(&self, measurement: &Measurement<T, N, B>, motion: &AuxiliaryMotion<T, N>) -> SVector<T, N>;

    /// E = M_mb v̇_b + C_mb v_b in N·m (paper eq. 7), with the base's velocity and acceleration as measured.
    fn base_reaction(&self, measurement: &Measurement<T, N, B>) -> SVector<T, N>;

    /// τ = M̄ q̈_m + h̄ in N·m with q̈_m = M_mm⁻¹(τ̄ − C_mm q̇_m) (paper eqs. 20 and 21) for τ̄ = `arm_torque`. Reads the base's
    /// velocity. None where M_mm or M_bb is not positive definite or a number not finite.
    fn base_compensated_torque(
        &self,
        measurement: &Measurement<T, N, B>,
        arm_torque: &SVector<T, N>,
    ) -> Option<SVector<T, N>>;

    /// F̄ = M̄ x1 + C̃ x2 + c_h in N·m: the reduced form of F, at that `momentum`. None where a number is not finite.
    fn reduced_torque(
        &self,
        measurement: &Measurement<T, N, B>,
        motion: &AuxiliaryMotion<T, N>,
        momentum: Momentum,
    ) -> Option<SVector<T, N>>;

    /// M̄ = M_mm − M_mb M_bb⁻¹ M_bm in kg·m² for joints at `position`. None where a number is not finite.
    fn generalised_inertia(&self, position: &SVector<T, N>) -> Option<SMatrix<T, N, N>>;
}

/// A model whose F is linear in G groups of K parameters: F = Σ Ξ_g Φ_g.
pub trait LinearModel<T: Scalar, const N: usize, const B: usize, const K: usize, const G: usize>:
    ArmModel<T, N, B>
{
    /// The nominal Φ.
    fn parameters(&self) -> SMatrix<T, K, G>;

    /// Ξ in its blocks, one for each group.
    fn regressor(&self, measurement: &Measurement<T, N, B>, motion: &AuxiliaryMotion<T, N>) -> [SMatrix<T, N, K>; G];

    /// [`ArmModel::base_compensated_torque`] with the estimate `parameters` in the place of the nominal Φ. What Φ lacks stays
    /// nominal. None where an estimated matrix is not positive definite: the estimate need not belong to any manipulator.
    fn estimated_compensation(
        &self,
        parameters: &SMatrix<T, K, G>,
        measurement: &Measurement<T, N, B>,
        arm_torque: &SVector<T, N>,
    ) -> Option<SVector<T, N>>;
}
