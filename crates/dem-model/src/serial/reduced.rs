//! The arm's dynamics with the base removed, for N joints.
//!
//! Without torque on the base the inertial angular momentum is constant. With h = M_bb v_b + M_bm q̇_m in base axes,
//! A = M_bb⁻¹ M_bm, N = [−A; I] and Ω = M_bb⁻¹ h the true velocity is v = N q̇_m + [Ω; 0], and the arm moves by
//!
//! M̄ q̈_m + C̃ q̇_m + c_h = τ_m − Aᵀ τ_b with M̄ = Nᵀ M N, C̃ = Nᵀ C(q, v) N, c_h = Nᵀ C(q, v) [Ω; 0].
//!
//! M̄̇ − 2C̃ is skew. In space, h turns in base axes: ḣ = h × ω_b + τ_b. For three links in the plane see
//! [`ReducedDynamics`](crate::ReducedDynamics).

use nalgebra::{SMatrix, SVector};

use super::base::{BaseFreedom, BaseMotion};
use super::manipulator::SerialManipulator;
use super::matrices::{SerialDynamics, SerialState};
use super::recursive::SerialAcceleration;
use crate::scalar::Scalar;

/// The matrices of the arm's reduced dynamics in one state: M̄ q̈_m + C̃ q̇_m + c_h = τ_m − Aᵀ τ_b.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SerialReduced<T: Scalar, const N: usize, const B: usize> {
    /// The generalised inertia M̄ in kg·m², symmetric and positive definite.
    pub mass: SMatrix<T, N, N>,
    /// C̃ in kg·m²/s; M̄̇ − 2C̃ is skew.
    pub coriolis: SMatrix<T, N, N>,
    /// c_h in N·m; zero without momentum.
    pub momentum_torque: SVector<T, N>,
    /// A: without momentum the base moves at −A q̇_m.
    pub base_coupling: SMatrix<T, B, N>,
    /// v_b = Ω − A q̇_m in rad/s (and m/s), base axes.
    pub base_velocity: SVector<T, B>,
}

impl<T: Scalar, const N: usize, const B: usize> SerialDynamics<T, N, B> {
    /// A = M_bb⁻¹ M_bm; none if M_bb is not positive definite, which only a state that is not finite makes it.
    pub fn base_coupling(&self) -> Option<SMatrix<T, B, N>> {
        Some(self.mass_bb.cholesky()?.solve(&self.mass_bm))
    }

    /// M̄ = M_mm − M_mb A in kg·m², symmetric to the last bit.
    pub fn generalised_inertia(&self, base_coupling: &SMatrix<T, B, N>) -> SMatrix<T, N, N> {
        let mut mass = self.mass_mm - self.mass_bm.tr_mul(base_coupling);
        mass.fill_lower_triangle_with_upper_triangle();
        mass
    }

    /// The arm's reduced dynamics in `state`, with Ω as a function of A.
    fn reduced(
        &self,
        state: &SerialState<T, N, B>,
        drift: impl FnOnce(&SMatrix<T, B, N>) -> SVector<T, B>,
    ) -> Option<SerialReduced<T, N, B>> {
        let coupling = self.base_coupling()?;
        // NᵀC, its columns of the base and of the arm.
        let of_base = self.coriolis_mb - coupling.tr_mul(&self.coriolis_bb);
        let of_arm = self.coriolis_mm - coupling.tr_mul(&self.coriolis_bm);
        Some(SerialReduced {
            mass: self.generalised_inertia(&coupling),
            coriolis: of_arm - of_base * coupling,
            momentum_torque: of_base * drift(&coupling),
            base_coupling: coupling,
            base_velocity: state.base_velocity,
        })
    }
}

impl<T: Scalar, const N: usize, const B: usize> SerialManipulator<T, N, B>
where
    BaseFreedom<B>: BaseMotion<T, B>,
{
    /// The arm's reduced dynamics for joints at `position` and `velocity` (rad and rad/s; m and m/s where they slide) and
    /// the `momentum` h in N·m·s, base axes: zero if all started from rest. None if a value is not finite.
    pub fn reduced(
        &self,
        position: &SVector<T, N>,
        velocity: &SVector<T, N>,
        momentum: &SVector<T, B>,
    ) -> Option<SerialReduced<T, N, B>> {
        let mut state = SerialState { position: *position, velocity: *velocity, base_velocity: SVector::zeros() };
        let locked = self.dynamics(&state);
        let base_inertia = locked.mass_bb.cholesky()?;
        let drift = base_inertia.solve(momentum);
        state.base_velocity = drift - base_inertia.solve(&locked.mass_bm) * velocity;
        self.dynamics(&state).reduced(&state, |_| drift)
    }

    /// The arm's reduced dynamics in a `state`, at the momentum that its base velocity tells. None if a value is not finite.
    pub fn reduced_at(&self, state: &SerialState<T, N, B>) -> Option<SerialReduced<T, N, B>> {
        self.dynamics(state).reduced(state, |coupling| state.base_velocity + coupling * state.velocity)
    }

    /// The acceleration [v̇_b; q̈_m] under the torques τ_b on the base and τ_m on the joints: M v̇ = τ − C v. v̇_b is the
    /// rate of the components in base axes. None if a value is not finite.
    pub fn forward_dynamics(
        &self,
        state: &SerialState<T, N, B>,
        base_torque: &SVector<T, B>,
        torque: &SVector<T, N>,
    ) -> Option<SerialAcceleration<T, N, B>> {
        let dynamics = self.dynamics(state);
        let (base_coriolis, coriolis) = dynamics.coriolis_torque(&state.base_velocity, &state.velocity);
        let base_inertia = dynamics.mass_bb.cholesky()?;
        let coupling = base_inertia.solve(&dynamics.mass_bm);
        let on_base = base_torque - base_coriolis;
        let arm =
            dynamics.generalised_inertia(&coupling).cholesky()?.solve(&(torque - coriolis - coupling.tr_mul(&on_base)));
        Some(SerialAcceleration { base: base_inertia.solve(&on_base) - coupling * arm, joints: arm })
    }
}
