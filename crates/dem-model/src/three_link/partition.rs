//! The paper's partition into the passive base b = {1} and the active joints m = {2, 3} (eq. 3).

use nalgebra::{Matrix2, Matrix3, RowVector2, Vector2, Vector3};

use super::dem::ThreeLinkDem;
use super::inertial::CouplingTerms;
use super::inertial::InertialParameters;
use crate::scalar::Scalar;

/// M and C cut into base (b) and active joints (m), eq. 3:
///
/// M_bb q̈_b + M_bm q̈_m + C_bb q̇_b + C_bm q̇_m = τ_b, M_mb q̈_b + M_mm q̈_m + C_mb q̇_b + C_mm q̇_m = τ_m.
///
/// C_mm depends on q_m and q̇_m alone, as the paper's laws need it (F = ΞΦ holds only then): it is the Christoffel block
/// at base velocity zero. What that leaves out stands in C_mb, so that the sums above are those of the full C.
/// N_mm = Ṁ_mm − 2C_mm is skew.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Partition<T> {
    /// M_bb in kg·m².
    pub mass_bb: T,
    /// M_bm in kg·m².
    pub mass_bm: RowVector2<T>,
    /// M_mb in kg·m².
    pub mass_mb: Vector2<T>,
    /// M_mm in kg·m².
    pub mass_mm: Matrix2<T>,
    /// C_bb in kg·m²/s.
    pub coriolis_bb: T,
    /// C_bm in kg·m²/s.
    pub coriolis_bm: RowVector2<T>,
    /// C_mb in kg·m²/s, with what C_mm leaves out: [a q̇_1 − 2 t_4 q̇_3; b q̇_1 + 2 t_4 q̇_2].
    pub coriolis_mb: Vector2<T>,
    /// C_mm in kg·m²/s at base velocity zero.
    pub coriolis_mm: Matrix2<T>,
}

/// The arm's equation after the base acceleration was eliminated by the base's own: M̄ q̈_m + h̄ = τ_m (eq. 21), for a
/// base without torque.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EliminatedBase<T> {
    /// M̄ = M_mm − M_mb M_bb⁻¹ M_bm in kg·m².
    pub mass: Matrix2<T>,
    /// h̄ = (C_mb − M_mb M_bb⁻¹ C_bb) q̇_b + (C_mm − M_mb M_bb⁻¹ C_bm) q̇_m in N·m.
    pub bias: Vector2<T>,
}

impl<T: Scalar> Partition<T> {
    fn from_parts(mass: &Matrix3<T>, terms: &CouplingTerms<T>, velocity: &Vector3<T>) -> Self {
        let CouplingTerms { a, b, t4, .. } = *terms;
        let arm_velocity = velocity.y + velocity.z;
        let twice_t4 = t4 + t4;
        Self {
            mass_bb: mass.m11,
            mass_bm: RowVector2::new(mass.m12, mass.m13),
            mass_mb: Vector2::new(mass.m21, mass.m31),
            mass_mm: Matrix2::new(mass.m22, mass.m23, mass.m32, mass.m33),
            coriolis_bb: -a * velocity.y - b * velocity.z,
            coriolis_bm: RowVector2::new(
                -a * (velocity.x + velocity.y) - b * velocity.z,
                -b * (velocity.x + arm_velocity),
            ),
            coriolis_mb: Vector2::new(a * velocity.x - twice_t4 * velocity.z, b * velocity.x + twice_t4 * velocity.y),
            coriolis_mm: Matrix2::new(-t4 * velocity.z, -t4 * arm_velocity, t4 * velocity.y, T::zero()),
        }
    }

    /// F = M_mm x_1 + C_mm x_2 in N·m (eq. 7): the torques that the arm's own inertia takes for the reference
    /// acceleration `x1` in rad/s² and the reference velocity `x2` in rad/s.
    pub fn arm_torque(&self, x1: &Vector2<T>, x2: &Vector2<T>) -> Vector2<T> {
        self.mass_mm * x1 + self.coriolis_mm * x2
    }

    /// E = M_mb q̈_b + C_mb q̇_b in N·m (eq. 7): the torques that the motion of the base asks of the arm;
    /// `base_acceleration` in rad/s², `base_velocity` in rad/s.
    pub fn base_reaction(&self, base_acceleration: T, base_velocity: T) -> Vector2<T> {
        self.mass_mb * base_acceleration + self.coriolis_mb * base_velocity
    }

    /// M̄ and h̄ of eq. 21, for velocities in rad/s. Where M_bb is zero, as estimated parameters can make it, they are not
    /// finite.
    pub fn eliminate_base(&self, base_velocity: T, joint_velocity: &Vector2<T>) -> EliminatedBase<T> {
        let per_base = self.mass_mb / self.mass_bb;
        EliminatedBase {
            mass: self.mass_mm - per_base * self.mass_bm,
            bias: (self.coriolis_mb - per_base * self.coriolis_bb) * base_velocity
                + (self.coriolis_mm - per_base * self.coriolis_bm) * joint_velocity,
        }
    }

    /// The joint torque τ = M̄ q̈_m + h̄ in N·m with q̈_m = M_mm⁻¹(τ̄ − C_mm q̇_m) (eqs. 20 and 21), which puts the base's
    /// effect on to the torque τ̄ = `arm_torque` in N·m of a law that knows the arm only; velocities in rad/s.
    ///
    /// `None` where M_mm or M_bb is not positive definite, beyond rounding, or something is not finite. That cannot happen to
    /// a [`ThreeLinkDem`] in a finite state, but to estimated parameters.
    pub fn base_compensated_torque(
        &self,
        arm_torque: &Vector2<T>,
        base_velocity: T,
        joint_velocity: &Vector2<T>,
    ) -> Option<Vector2<T>> {
        if !(self.mass_bb > T::zero() && is_positive_definite(&self.mass_mm)) {
            return None;
        }
        let EliminatedBase { mass, bias } = self.eliminate_base(base_velocity, joint_velocity);
        let acceleration = self.mass_mm.lu().solve(&(arm_torque - self.coriolis_mm * joint_velocity))?;
        let torque = mass * acceleration + bias;
        (torque.x.is_finite() && torque.y.is_finite()).then_some(torque)
    }
}

/// Roundings of the product of the diagonal that a determinant has to exceed: it is a difference of such products.
const ROUNDINGS: f64 = 16.0;

/// Whether a symmetric matrix is positive definite, and not by rounding alone. Free of the scale of each joint.
fn is_positive_definite<T: Scalar>(matrix: &Matrix2<T>) -> bool {
    let diagonal = matrix.m11 * matrix.m22;
    let margin = T::default_epsilon() * T::constant(ROUNDINGS);
    matrix.m11 > T::zero() && matrix.m22 > T::zero() && diagonal - matrix.m12 * matrix.m21 > diagonal * margin
}

impl<T: Scalar> InertialParameters<T> {
    /// M and C cut into base and active joints (eq. 3); `q` in rad, `velocity` in rad/s.
    pub fn partition(&self, q: &Vector3<T>, velocity: &Vector3<T>) -> Partition<T> {
        let terms = self.coupling_terms(q.y, q.z);
        Partition::from_parts(&self.mass_from(&terms), &terms, velocity)
    }
}

impl<T: Scalar> ThreeLinkDem<T> {
    /// M and C cut into base and active joints (eq. 3); `q` in rad, `velocity` in rad/s.
    ///
    /// ```
    /// use dem_model::ThreeLinkDem;
    /// use nalgebra::{Vector2, Vector3};
    ///
    /// let dem = ThreeLinkDem::<f64>::table_2();
    /// let parts = dem.partition(&Vector3::new(0.0, 0.35, 0.35), &Vector3::zeros());
    /// let torque = parts.arm_torque(&Vector2::new(0.5, 0.3), &Vector2::zeros());
    /// assert!(torque.x > torque.y);
    /// ```
    pub fn partition(&self, q: &Vector3<T>, velocity: &Vector3<T>) -> Partition<T> {
        self.inertial_parameters().partition(q, velocity)
    }
}
