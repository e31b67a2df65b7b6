//! The linear parametrisation F = ΞΦ of the adaptive law (section 4 of the paper).

use nalgebra::{Matrix2x6, SMatrix, SVector, Vector2, Vector6};

use super::dem::ThreeLinkDem;
use super::inertial::InertialParameters;
use crate::scalar::Scalar;

/// How many parameters Φ has.
pub const REGRESSOR_PARAMETERS: usize = 6;

/// The regressor Ξ with ΞΦ = M_mm x_1 + C_mm x_2 for every Φ, as printed in section 4 of the paper.
///
/// `q3` is joint 3's angle in rad, `joint_velocity` = [q̇_2, q̇_3] in rad/s, `x1` = q̈ᵈ − Λ q̃̇ the reference acceleration in
/// rad/s² and `x2` = q̇ᵈ − Λ q̃ the reference velocity in rad/s. Φ stands at
/// [`ThreeLinkDem::regressor_parameters`].
///
/// ```
/// use dem_model::{ThreeLinkDem, regressor};
/// use nalgebra::{Vector2, Vector3};
///
/// let dem = ThreeLinkDem::<f64>::table_2();
/// let (q, velocity) = (Vector3::new(0.0, 0.35, 0.5), Vector3::new(0.0, 0.4, 0.2));
/// let (x1, x2) = (Vector2::new(0.5, 0.3), Vector2::new(0.1, 0.2));
/// let linear = regressor(q.z, &Vector2::new(velocity.y, velocity.z), &x1, &x2) * dem.regressor_parameters();
/// assert!((linear - dem.partition(&q, &velocity).arm_torque(&x1, &x2)).norm() < 1e-15);
/// ```
pub fn regressor<T: Scalar>(
    q3: T,
    joint_velocity: &Vector2<T>,
    x1: &Vector2<T>,
    x2: &Vector2<T>,
) -> SMatrix<T, 2, REGRESSOR_PARAMETERS> {
    let (sin, cos) = q3.sin_cos();
    let both = x1.x + x1.y;
    let x13 = (both + x1.x) * cos - (x2.x * joint_velocity.y + x2.y * (joint_velocity.x + joint_velocity.y)) * sin;
    let x23 = x1.x * cos + x2.x * joint_velocity.x * sin;
    let zero = T::zero();
    Matrix2x6::new(
        x1.x, both, x1.x, both, x1.x, x13, //
        zero, both, zero, both, zero, x23,
    )
}

impl<T: Scalar> ThreeLinkDem<T> {
    /// The nominal Φ = [I_2, I_3, m_2 l_c2², m_3 l_c3², m_3 W_2², m_3 W_2 l_c3] in kg·m² (section 4 of the paper).
    pub fn regressor_parameters(&self) -> SVector<T, REGRESSOR_PARAMETERS> {
        let [second, third] = self.links();
        Vector6::new(
            second.inertia,
            third.inertia,
            second.mass * second.centre_of_mass * second.centre_of_mass,
            third.mass * third.centre_of_mass * third.centre_of_mass,
            third.mass * second.length * second.length,
            third.mass * second.length * third.centre_of_mass,
        )
    }

    /// The inertial parameters with an estimated Φ = `estimate` in kg·m², for M̂_mm, Ĉ_mm, M̄̂ and ĥ of eqs. 20 and 21.
    /// The products that Φ lacks (I_1, m_2 W_1², m_2 W_1 l_c2, m_3 W_1², m_3 W_1 W_2, m_3 W_1 l_c3) stay nominal.
    ///
    /// Nothing is checked: an estimate need not belong to any manipulator, and at Φ = 0 the estimated M_mm is
    /// singular.
    pub fn with_regressor_parameters(&self, estimate: &SVector<T, REGRESSOR_PARAMETERS>) -> InertialParameters<T> {
        InertialParameters {
            second: estimate.x + estimate.z + estimate.a,
            third: estimate.y + estimate.w,
            second_third: estimate.b,
            ..*self.inertial_parameters()
        }
    }
}
