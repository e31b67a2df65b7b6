//! Forward and inverse dynamics, energy and momentum (eq. 2).

use nalgebra::{Matrix3, Vector3};

use super::dem::ThreeLinkDem;
use super::inertial::coriolis_from;
use crate::scalar::Scalar;

impl<T: Scalar> ThreeLinkDem<T> {
    /// The inertia matrix M(q) of the appendix, in kg·m², symmetric and positive definite; `q` in rad.
    pub fn mass_matrix(&self, q: &Vector3<T>) -> Matrix3<T> {
        self.inertial_parameters().mass_matrix(q)
    }

    /// The Coriolis matrix C(q, q̇) by Christoffel symbols, in kg·m²/s; `q` in rad, `velocity` in rad/s. Ṁ − 2C is skew.
    /// Its entries stand at [`InertialParameters::coriolis_matrix`](super::InertialParameters::coriolis_matrix).
    pub fn coriolis_matrix(&self, q: &Vector3<T>, velocity: &Vector3<T>) -> Matrix3<T> {
        self.inertial_parameters().coriolis_matrix(q, velocity)
    }

    /// [`mass_matrix`](Self::mass_matrix) and [`coriolis_matrix`](Self::coriolis_matrix) of one state, the same bits with half
    /// of the sines and cosines.
    pub fn mass_and_coriolis(&self, q: &Vector3<T>, velocity: &Vector3<T>) -> (Matrix3<T>, Matrix3<T>) {
        let terms = self.inertial_parameters().coupling_terms(q.y, q.z);
        (self.inertial_parameters().mass_from(&terms), coriolis_from(&terms, velocity))
    }

    /// The acceleration q̈ = M⁻¹(f − C q̇) in rad/s² (eq. 2), for `generalised_force` f = [on the base, joint 2,
    /// joint 3] in N·m, `q` in rad and `velocity` in rad/s.
    ///
    /// M is positive definite for every finite `q`, as [`new`](Self::new) makes sure. Where `q`, `velocity` or the force
    /// is not finite, neither is the result.
    pub fn forward_dynamics(
        &self,
        q: &Vector3<T>,
        velocity: &Vector3<T>,
        generalised_force: &Vector3<T>,
    ) -> Vector3<T> {
        let (mass, coriolis) = self.mass_and_coriolis(q, velocity);
        solve_positive_definite(&mass, &(generalised_force - coriolis * velocity))
    }

    /// The generalised force M q̈ + C q̇ in N·m, [on the base, joint 2, joint 3], that gives `acceleration` q̈ in rad/s²
    /// (eq. 2); `q` in rad and `velocity` in rad/s.
    pub fn inverse_dynamics(&self, q: &Vector3<T>, velocity: &Vector3<T>, acceleration: &Vector3<T>) -> Vector3<T> {
        let (mass, coriolis) = self.mass_and_coriolis(q, velocity);
        mass * acceleration + coriolis * velocity
    }

    /// The kinetic energy ½ q̇ᵀ M q̇ in J; `q` in rad and `velocity` in rad/s. It is that of the space manipulator in the
    /// frame of its centre of mass.
    pub fn kinetic_energy(&self, q: &Vector3<T>, velocity: &Vector3<T>) -> T {
        T::constant(0.5) * velocity.dot(&(self.mass_matrix(q) * velocity))
    }

    /// The angular momentum p = M_b* q̇ about joint 1 in kg·m²/s, which is the space manipulator's about its centre of
    /// mass; `q` in rad and `velocity` in rad/s. Its time derivative is the torque on the base.
    pub fn angular_momentum(&self, q: &Vector3<T>, velocity: &Vector3<T>) -> T {
        (self.mass_matrix(q) * velocity).x
    }
}

/// x of M x = b by M = LᵀDL, eliminated from joint 3 to joint 1: M_33 is the same in every configuration, so that its reciprocal
/// is there before the cosines are. Backward stable for a positive definite M, as Cholesky's factors are, without their roots.
fn solve_positive_definite<T: Scalar>(mass: &Matrix3<T>, right: &Vector3<T>) -> Vector3<T> {
    let third = T::one() / mass.m33;
    let (l31, l32) = (mass.m13 * third, mass.m23 * third);
    let m12 = mass.m12 - l31 * mass.m23;
    let second = T::one() / (mass.m22 - l32 * mass.m23);
    let l21 = m12 * second;
    let b2 = right.y - l32 * right.z;
    let x1 = (right.x - l31 * right.z - l21 * b2) / (mass.m11 - l31 * mass.m13 - l21 * m12);
    let x2 = b2 * second - l21 * x1;
    Vector3::new(x1, x2, right.z * third - l31 * x1 - l32 * x2)
}
