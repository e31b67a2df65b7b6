//! Inertia and Coriolis matrices of a planar chain as sums over Jacobians.
//!
//! With c_i the centre of mass of link i, J_i = ∂c_i/∂q and ω_i = Σ_{k≤i} q̇_k,
//! M = Σ m_i J_iᵀ J_i + I_i 1_i 1_iᵀ and C = Σ m_i J_iᵀ J̇_i. As Γ_{j,kl} = ∂c/∂q_j · ∂²c/∂q_k∂q_l are the Christoffel
//! symbols of the metric that c pulls back from the plane, this C is the Christoffel one: Ṁ − 2C is skew.

use nalgebra::{RowSVector, SMatrix, SVector, Vector2};

use crate::dem::PlanarDem;
use crate::scalar::Scalar;

/// Where the next joint of a walk along the chain is, how fast it moves, and how both change with the coordinates.
struct Walk<T, const JOINTS: usize> {
    /// Orientation of the current link, in rad from +x.
    angle: T,
    /// Angular velocity of the current link, in rad/s.
    velocity: T,
    /// ∂angle/∂q: ones up to the current joint.
    angle_gradient: RowSVector<T, JOINTS>,
    /// ∂position/∂q of the current joint, in m.
    jacobian: SMatrix<T, 2, JOINTS>,
    /// Its time derivative, in m/s.
    jacobian_derivative: SMatrix<T, 2, JOINTS>,
}

impl<T: Scalar, const JOINTS: usize> Walk<T, JOINTS> {
    fn from_fixed_base() -> Self {
        Self {
            angle: T::zero(),
            velocity: T::zero(),
            angle_gradient: RowSVector::zeros(),
            jacobian: SMatrix::zeros(),
            jacobian_derivative: SMatrix::zeros(),
        }
    }

    /// Turns into the link whose joint is number `joint` of the coordinates.
    fn turn(&mut self, joint: usize, angle: T, velocity: T) {
        self.angle += angle;
        self.velocity += velocity;
        self.angle_gradient = RowSVector::from_fn(|_, column| if column <= joint { T::one() } else { T::zero() });
    }

    /// Jacobian and its time derivative of the point at `distance` along the current link.
    fn point(&self, distance: T) -> (SMatrix<T, 2, JOINTS>, SMatrix<T, 2, JOINTS>) {
        let (sin, cos) = self.angle.sin_cos();
        let tangent = Vector2::new(-sin, cos) * distance;
        let tangent_derivative = Vector2::new(-cos, -sin) * (distance * self.velocity);
        (
            self.jacobian + tangent * self.angle_gradient,
            self.jacobian_derivative + tangent_derivative * self.angle_gradient,
        )
    }

    /// Goes to the joint at the end of the current link.
    fn advance(&mut self, length: T) {
        (self.jacobian, self.jacobian_derivative) = self.point(length);
    }
}

impl<T: Scalar, const LINKS: usize> PlanarDem<T, LINKS> {
    /// The inertia matrix M(q), in kg·m². `q` holds the base's angle and the relative joint angles in rad, so that
    /// `JOINTS` is `LINKS` + 1 (checked when it is compiled).
    ///
    /// ```
    /// use dem_model::PlanarSpaceManipulator;
    /// use nalgebra::Vector3;
    ///
    /// let dem = PlanarSpaceManipulator::<f64, 2>::table_1().dynamically_equivalent();
    /// let mass = dem.mass_matrix(&Vector3::new(0.0, 0.3, -0.2));
    /// assert!(mass.cholesky().is_some());
    /// ```
    pub fn mass_matrix<const JOINTS: usize>(&self, q: &SVector<T, JOINTS>) -> SMatrix<T, JOINTS, JOINTS> {
        self.mass_and_coriolis(q, &SVector::zeros()).0
    }

    /// The Coriolis matrix C(q, q̇) by Christoffel symbols, in kg·m²/s; `q` in rad and `velocity` in rad/s as in
    /// [`mass_matrix`](Self::mass_matrix).
    pub fn coriolis_matrix<const JOINTS: usize>(
        &self,
        q: &SVector<T, JOINTS>,
        velocity: &SVector<T, JOINTS>,
    ) -> SMatrix<T, JOINTS, JOINTS> {
        self.mass_and_coriolis(q, velocity).1
    }

    fn mass_and_coriolis<const JOINTS: usize>(
        &self,
        q: &SVector<T, JOINTS>,
        velocity: &SVector<T, JOINTS>,
    ) -> (SMatrix<T, JOINTS, JOINTS>, SMatrix<T, JOINTS, JOINTS>) {
        const { assert!(JOINTS == LINKS + 1, "one coordinate for the base and one for each link of the arm") };
        let mut walk = Walk::<T, JOINTS>::from_fixed_base();
        walk.turn(0, q[0], velocity[0]);
        let mut mass: SMatrix<T, JOINTS, JOINTS> =
            walk.angle_gradient.transpose() * walk.angle_gradient * self.base().inertia;
        let mut coriolis = SMatrix::<T, JOINTS, JOINTS>::zeros();
        walk.advance(self.base().length);
        for (index, link) in self.links().iter().enumerate() {
            let joint = index + 1;
            walk.turn(joint, q[joint], velocity[joint]);
            let (jacobian, jacobian_derivative) = walk.point(link.centre_of_mass);
            mass += jacobian.transpose() * jacobian * link.mass
                + walk.angle_gradient.transpose() * walk.angle_gradient * link.inertia;
            coriolis += jacobian.transpose() * jacobian_derivative * link.mass;
            walk.advance(link.length);
        }
        (mass, coriolis)
    }
}
