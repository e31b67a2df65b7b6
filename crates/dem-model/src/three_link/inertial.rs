//! M and C of the three-link DEM as functions of its six inertial parameters.

use nalgebra::{Matrix3, Vector3};

use crate::dem::{DemBase, DemLink};
use crate::scalar::Scalar;

/// The least set of numbers that M and C of the three-link DEM depend on; both are linear in them.
///
/// The closed form of the appendix in these numbers, with s and c for sine and cosine of the angles in the index:
/// M_11 = base + second + third + 2 (base_second c_2 + second_third c_3 + base_third c_23) and so on. They need not
/// belong to a physical manipulator: an adaptive law puts its estimates here
/// (see [`ThreeLinkDem::with_regressor_parameters`](crate::ThreeLinkDem::with_regressor_parameters)).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InertialParameters<T> {
    /// I_1 + (m_2 + m_3) W_1², in kg·m².
    pub base: T,
    /// I_2 + m_2 l_c2² + m_3 W_2², in kg·m².
    pub second: T,
    /// I_3 + m_3 l_c3², in kg·m².
    pub third: T,
    /// m_2 W_1 l_c2 + m_3 W_1 W_2, in kg·m²: what couples base and link 2.
    pub base_second: T,
    /// m_3 W_1 l_c3, in kg·m²: what couples base and link 3.
    pub base_third: T,
    /// m_3 W_2 l_c3, in kg·m²: what couples links 2 and 3.
    pub second_third: T,
}

/// Cosines and sines of a configuration, multiplied with the inertial parameters.
pub(super) struct CouplingTerms<T> {
    /// base_second · cos q_2.
    pub(super) base_second_cos: T,
    /// base_third · cos(q_2 + q_3).
    pub(super) base_third_cos: T,
    /// second_third · cos q_3.
    pub(super) second_third_cos: T,
    /// a = t_1 + t_2 + t_3 of the appendix.
    pub(super) a: T,
    /// b = t_3 + t_4 of the appendix.
    pub(super) b: T,
    /// t_4 of the appendix.
    pub(super) t4: T,
}

impl<T: Scalar> InertialParameters<T> {
    pub(super) fn of(base: &DemBase<T>, [second, third]: &[DemLink<T>; 2]) -> Self {
        let third_at_second_tip = third.mass * second.length;
        Self {
            base: base.inertia + (second.mass + third.mass) * base.length * base.length,
            second: second.inertia
                + second.mass * second.centre_of_mass * second.centre_of_mass
                + third_at_second_tip * second.length,
            third: third.inertia + third.mass * third.centre_of_mass * third.centre_of_mass,
            base_second: (second.mass * second.centre_of_mass + third_at_second_tip) * base.length,
            base_third: third.mass * base.length * third.centre_of_mass,
            second_third: third_at_second_tip * third.centre_of_mass,
        }
    }

    /// M_11, M_22 and M_33 of the stretched arm in kg·m²: the largest that they are in any configuration.
    pub(super) fn largest_diagonal(&self) -> [T; 3] {
        let arm = self.second + self.third + self.second_third + self.second_third;
        let couplings = self.base_second + self.base_third;
        [self.base + arm + couplings + couplings, arm, self.third]
    }

    pub(super) fn coupling_terms(&self, q2: T, q3: T) -> CouplingTerms<T> {
        let (sin_2, cos_2) = q2.sin_cos();
        let (sin_3, cos_3) = q3.sin_cos();
        let (sin_23, cos_23) = (q2 + q3).sin_cos();
        let t3 = self.base_third * sin_23;
        let t4 = self.second_third * sin_3;
        CouplingTerms {
            base_second_cos: self.base_second * cos_2,
            base_third_cos: self.base_third * cos_23,
            second_third_cos: self.second_third * cos_3,
            a: self.base_second * sin_2 + t3,
            b: t3 + t4,
            t4,
        }
    }

    pub(super) fn mass_from(&self, terms: &CouplingTerms<T>) -> Matrix3<T> {
        let m33 = self.third;
        let m23 = m33 + terms.second_third_cos;
        let m22 = self.second + m23 + terms.second_third_cos;
        let m13 = m23 + terms.base_third_cos;
        let m12 = m22 + terms.base_second_cos + terms.base_third_cos;
        let m11 = self.base + m12 + terms.base_second_cos + terms.base_third_cos;
        Matrix3::new(
            m11, m12, m13, //
            m12, m22, m23, //
            m13, m23, m33,
        )
    }

    /// The inertia matrix M(q) of the appendix, in kg·m²; `q` in rad.
    pub fn mass_matrix(&self, q: &Vector3<T>) -> Matrix3<T> {
        self.mass_from(&self.coupling_terms(q.y, q.z))
    }

    /// The Coriolis matrix C(q, q̇) by Christoffel symbols, in kg·m²/s; `q` in rad, `velocity` in rad/s. Ṁ − 2C is skew.
    ///
    /// The appendix's own printing of it is lost; with its t_1 … t_4, a = t_1 + t_2 + t_3 and b = t_3 + t_4:
    /// C_11 = −a q̇_2 − b q̇_3, C_12 = −a (q̇_1 + q̇_2) − b q̇_3, C_13 = −b (q̇_1 + q̇_2 + q̇_3),
    /// C_21 = a q̇_1 − t_4 q̇_3, C_22 = −t_4 q̇_3, C_23 = −t_4 (q̇_1 + q̇_2 + q̇_3),
    /// C_31 = b q̇_1 + t_4 q̇_2, C_32 = t_4 (q̇_1 + q̇_2), C_33 = 0.
    pub fn coriolis_matrix(&self, q: &Vector3<T>, velocity: &Vector3<T>) -> Matrix3<T> {
        coriolis_from(&self.coupling_terms(q.y, q.z), velocity)
    }
}

pub(super) fn coriolis_from<T: Scalar>(terms: &CouplingTerms<T>, velocity: &Vector3<T>) -> Matrix3<T> {
    let CouplingTerms { a, b, t4, .. } = *terms;
    let two = velocity.x + velocity.y;
    let three = two + velocity.z;
    Matrix3::new(
        -a * velocity.y - b * velocity.z,
        -a * two - b * velocity.z,
        -b * three, //
        a * velocity.x - t4 * velocity.z,
        -t4 * velocity.z,
        -t4 * three, //
        b * velocity.x + t4 * velocity.y,
        t4 * two,
        T::zero(),
    )
}
