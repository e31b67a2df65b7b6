//! Where the parts of the DEM are.

use nalgebra::{Matrix2x3, Vector2, Vector3};

use super::dem::ThreeLinkDem;
use crate::scalar::Scalar;

/// Position and orientation in the plane, in the fixed frame: joint 1 is its origin, and q = 0 stretches the arm
/// along +x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose<T> {
    /// Position in m.
    pub position: Vector2<T>,
    /// Orientation in rad from +x, counter-clockwise; not wrapped.
    pub orientation: T,
}

impl<T: Scalar> ThreeLinkDem<T> {
    /// The positions of the joints 1, 2 and 3 in the fixed frame, in m; `q` in rad.
    pub fn joint_positions(&self, q: &Vector3<T>) -> [Vector2<T>; 3] {
        let [base, second, _] = link_directions(q);
        let [second_link, _] = self.links();
        let joint_2 = base * self.base().length;
        [Vector2::zeros(), joint_2, joint_2 + second * second_link.length]
    }

    /// The pose of the end effector, the far end of link 3, in the fixed frame; `q` in rad.
    ///
    /// The end effector of the space manipulator has the same pose as seen from the centre of mass of the whole.
    pub fn end_effector(&self, q: &Vector3<T>) -> Pose<T> {
        let [_, _, joint_3] = self.joint_positions(q);
        let [_, _, third] = link_directions(q);
        let [_, third_link] = self.links();
        Pose { position: joint_3 + third * third_link.length, orientation: q.x + q.y + q.z }
    }

    /// The Jacobian of the end effector's position, in m: the end effector's velocity is J q̇; `q` in rad.
    /// The row for its orientation is all ones.
    pub fn end_effector_jacobian(&self, q: &Vector3<T>) -> Matrix2x3<T> {
        let [_, third] = self.links();
        self.third_link_point_jacobian(q, third.length)
    }

    /// The centres of mass of the links 2 and 3 in the fixed frame, in m; `q` in rad. The base's lies in
    /// joint 1 (l_c1 = 0).
    pub fn centres_of_mass(&self, q: &Vector3<T>) -> [Vector2<T>; 2] {
        let [_, joint_2, joint_3] = self.joint_positions(q);
        let [_, second, third] = link_directions(q);
        let [second_link, third_link] = self.links();
        [joint_2 + second * second_link.centre_of_mass, joint_3 + third * third_link.centre_of_mass]
    }

    /// The Jacobians of the centres of mass of the links 2 and 3 in the fixed frame, in m; `q` in rad.
    ///
    /// A force f_i in N at centre of mass i is the generalised force J_iᵀ f_i; a uniform in-plane acceleration g acts as
    /// f_i = m_i g.
    pub fn centre_of_mass_jacobians(&self, q: &Vector3<T>) -> [Matrix2x3<T>; 2] {
        let [base, second, _] = link_directions(q).map(|direction| quarter_turn(&direction));
        let [second_link, third_link] = self.links();
        let by_second = second * second_link.centre_of_mass;
        let by_base = base * self.base().length + by_second;
        [
            Matrix2x3::from_columns(&[by_base, by_second, Vector2::zeros()]),
            self.third_link_point_jacobian(q, third_link.centre_of_mass),
        ]
    }

    /// The Jacobian of the point of link 3 at `distance` m from joint 3.
    fn third_link_point_jacobian(&self, q: &Vector3<T>, distance: T) -> Matrix2x3<T> {
        let [base, second, third] = link_directions(q).map(|direction| quarter_turn(&direction));
        let [second_link, _] = self.links();
        let by_third = third * distance;
        let by_second = second * second_link.length + by_third;
        let by_base = base * self.base().length + by_second;
        Matrix2x3::from_columns(&[by_base, by_second, by_third])
    }
}

/// Unit vectors along base, link 2 and link 3.
fn link_directions<T: Scalar>(q: &Vector3<T>) -> [Vector2<T>; 3] {
    [q.x, q.x + q.y, q.x + q.y + q.z].map(|angle| {
        let (sin, cos) = angle.sin_cos();
        Vector2::new(cos, sin)
    })
}

/// The derivative of a direction with respect to its angle.
fn quarter_turn<T: Scalar>(direction: &Vector2<T>) -> Vector2<T> {
    Vector2::new(-direction.y, direction.x)
}
