//! The arm's dynamics with the cyclic base coordinate removed.
//!
//! Nothing depends on the base's angle, so that p = M_b* q̇, the angular momentum, is constant unless a torque τ_b acts
//! on the base. With w = p / M_bb = q̇_1 + A q̇_m and A = M_bb⁻¹ M_bm the arm moves by
//!
//! M̄ q̈_m + C̄ q̇_m + p G q̇_m + p² g = τ_m − Aᵀ τ_b
//!
//! where C̄ is the Christoffel matrix of M̄ itself (M̄̇ − 2C̄ is skew) and G is skew. For p = 0 no base data is needed.
//! This goes beyond the paper, whose eqs. 20 and 21 eliminate the base acceleration but keep the base velocity.

use nalgebra::{Matrix2, Matrix2x3, Matrix3, RowVector2, Vector2, Vector3};

use super::dem::ThreeLinkDem;
use super::inertial::InertialParameters;
use super::inertial::{CouplingTerms, coriolis_from};
use crate::scalar::Scalar;

/// The matrices of the arm's reduced dynamics in one state:
/// M̄ q̈_m + C̄ q̇_m + p G q̇_m + p² g = τ_m − Aᵀ τ_b, with p the angular momentum in kg·m²/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReducedDynamics<T> {
    /// The generalised inertia M̄ = M_mm − M_mb A in kg·m², symmetric and positive definite.
    pub mass: Matrix2<T>,
    /// C̄ in kg·m²/s: the Christoffel matrix of M̄, so that M̄̇ − 2C̄ is skew.
    pub coriolis: Matrix2<T>,
    /// A = M_bb⁻¹ M_bm: without momentum the base turns at −A q̇_m.
    pub base_coupling: RowVector2<T>,
    /// M_bb in kg·m².
    pub mass_bb: T,
    /// G = 2 (b A_2 − a A_3 − t_4) / M_11 · [[0, 1], [−1, 0]], skew; p G is in kg·m²/s.
    pub gyroscopic: Matrix2<T>,
    /// g = [a; b] / M_11², the gradient of 1/(2 M_11) in q_m; p² g is in N·m.
    pub momentum_gradient: Vector2<T>,
}

impl<T: Scalar> ReducedDynamics<T> {
    /// C̄ + p G in kg·m²/s for the angular `momentum` p in kg·m²/s.
    pub fn coriolis_with_momentum(&self, momentum: T) -> Matrix2<T> {
        self.coriolis + self.gyroscopic * momentum
    }

    /// p² g in N·m for the angular `momentum` p in kg·m²/s.
    pub fn momentum_torque(&self, momentum: T) -> Vector2<T> {
        self.momentum_gradient * (momentum * momentum)
    }

    /// F̄ = M̄ x_1 + (C̄ + p G) x_2 + p² g in N·m: the reduced form of [`Partition::arm_torque`](super::Partition::arm_torque)
    /// for `x1` in rad/s² and `x2` in rad/s.
    pub fn arm_torque(&self, x1: &Vector2<T>, x2: &Vector2<T>, momentum: T) -> Vector2<T> {
        self.mass * x1 + self.coriolis_with_momentum(momentum) * x2 + self.momentum_torque(momentum)
    }

    /// The base velocity (p − M_bm q̇_m) / M_bb in rad/s that belongs to the angular `momentum` p.
    pub fn base_velocity(&self, joint_velocity: &Vector2<T>, momentum: T) -> T {
        momentum / self.mass_bb - (self.base_coupling * joint_velocity).x
    }
}

/// Nᵀ C N with N = [−A; I], where C is the full Coriolis matrix at a base velocity that the reduction prescribes.
fn project<T: Scalar>(coriolis: &Matrix3<T>, coupling: &RowVector2<T>) -> Matrix2<T> {
    let one = T::one();
    let zero = T::zero();
    let transposed = Matrix2x3::new(-coupling.x, one, zero, -coupling.y, zero, one);
    transposed * coriolis * transposed.transpose()
}

/// M̄, A and M_bb, which depend on the configuration alone.
struct ReducedInertia<T> {
    mass: Matrix2<T>,
    coupling: RowVector2<T>,
    mass_bb: T,
    terms: CouplingTerms<T>,
}

impl<T: Scalar> InertialParameters<T> {
    fn reduced_inertia(&self, q: &Vector3<T>) -> ReducedInertia<T> {
        let terms = self.coupling_terms(q.y, q.z);
        let full = self.mass_from(&terms);
        let coupling = RowVector2::new(full.m12, full.m13) / full.m11;
        // Written out, so that M̄ is symmetric to the last bit.
        let off_diagonal = full.m23 - full.m12 * coupling.y;
        let mass = Matrix2::new(
            full.m22 - full.m12 * coupling.x,
            off_diagonal,
            off_diagonal,
            full.m33 - full.m13 * coupling.y,
        );
        ReducedInertia { mass, coupling, mass_bb: full.m11, terms }
    }
}

impl<T: Scalar> ThreeLinkDem<T> {
    /// The arm's reduced dynamics; `q` in rad, of which the base's angle has no effect, `joint_velocity` = [q̇_2, q̇_3] in
    /// rad/s.
    ///
    /// ```
    /// use dem_model::ThreeLinkDem;
    /// use nalgebra::{Vector2, Vector3};
    ///
    /// let dem = ThreeLinkDem::<f64>::table_2();
    /// let (q, joint_velocity) = (Vector3::new(0.0, 0.35, 0.5), Vector2::new(0.4, 0.2));
    /// let reduced = dem.reduced(&q, &joint_velocity);
    /// // A base without momentum turns against the arm.
    /// let velocity = Vector3::new(reduced.base_velocity(&joint_velocity, 0.0), joint_velocity.x, joint_velocity.y);
    /// assert!(velocity.x < 0.0 && dem.angular_momentum(&q, &velocity).abs() < 1e-15);
    /// ```
    pub fn reduced(&self, q: &Vector3<T>, joint_velocity: &Vector2<T>) -> ReducedDynamics<T> {
        let ReducedInertia { mass, coupling, mass_bb, terms } = self.inertial_parameters().reduced_inertia(q);
        let base_velocity = -(coupling * joint_velocity).x;
        let coriolis = coriolis_from(&terms, &Vector3::new(base_velocity, joint_velocity.x, joint_velocity.y));
        let CouplingTerms { a, b, t4, .. } = terms;
        let half = (b * coupling.x - a * coupling.y - t4) / mass_bb;
        let gyroscopic = half + half;
        ReducedDynamics {
            mass,
            coriolis: project(&coriolis, &coupling),
            base_coupling: coupling,
            mass_bb,
            gyroscopic: Matrix2::new(T::zero(), gyroscopic, -gyroscopic, T::zero()),
            momentum_gradient: Vector2::new(a, b) / (mass_bb * mass_bb),
        }
    }

    /// C̄ + p G in kg·m²/s at once: the full C taken at the base velocity −A q̇_m + 2 p / M_bb, reduced. Independent of G as
    /// [`reduced`](Self::reduced) computes it; arguments as there, `momentum` p in kg·m²/s.
    pub fn reduced_coriolis(&self, q: &Vector3<T>, joint_velocity: &Vector2<T>, momentum: T) -> Matrix2<T> {
        let ReducedInertia { coupling, mass_bb, terms, .. } = self.inertial_parameters().reduced_inertia(q);
        let momentum_velocity = momentum / mass_bb;
        let base_velocity = momentum_velocity + momentum_velocity - (coupling * joint_velocity).x;
        let coriolis = coriolis_from(&terms, &Vector3::new(base_velocity, joint_velocity.x, joint_velocity.y));
        project(&coriolis, &coupling)
    }
}
