//! Where the end effector is, and how the joints move it while the base reacts.

use nalgebra::{Rotation3, SMatrix, SVector, Vector3};

use super::base::{BaseFreedom, BaseMotion, Columns};
use super::frame::Frame;
use super::manipulator::SerialManipulator;
use super::matrices::SerialState;
use super::twist::Twist;
use crate::scalar::Scalar;

/// The place and attitude of the end effector in base axes. The origin is the base's: the joint of a DEM's base, which
/// stands for the centre of mass of the whole space manipulator, or with B = 6 the spacecraft's centre of mass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolPose<T: Scalar> {
    /// In m.
    pub place: Vector3<T>,
    /// From the last link's frame to base axes.
    pub rotation: Rotation3<T>,
}

/// Rows 1 to 3 angular velocity of the end effector in rad/s, rows 4 to 6 its velocity in m/s, base axes; columns joints.
pub type GeneralisedJacobian<T, const N: usize> = SMatrix<T, 6, N>;

/// Angular velocity, and the velocity of the point at `place`.
fn at<T: Scalar>(twist: &Twist<T>, place: &Vector3<T>) -> [T; 6] {
    let velocity = twist.linear + twist.angular.cross(place);
    [twist.angular.x, twist.angular.y, twist.angular.z, velocity.x, velocity.y, velocity.z]
}

impl<T: Scalar, const N: usize, const B: usize> SerialManipulator<T, N, B>
where
    BaseFreedom<B>: BaseMotion<T, B>,
{
    /// Where the end effector is for joints at `position`.
    pub fn tool(&self, position: &SVector<T, N>) -> ToolPose<T> {
        let base = Frame::of_base(&Twist::zero());
        let end = self.walk(&base, position, &SVector::zeros(), |_, _, _| {});
        ToolPose { place: end.place, rotation: end.rotation }
    }

    /// The generalised Jacobian J* = J_m − J_b A (Umetani and Yoshida, *Resolved motion rate control of space manipulators
    /// with generalized Jacobian matrix*, 1989): how the joints move the end effector in inertial space when momentum is
    /// zero and nothing acts on the base. None if `position` is not finite.
    pub fn generalised_jacobian(&self, position: &SVector<T, N>) -> Option<GeneralisedJacobian<T, N>> {
        let state = SerialState { position: *position, velocity: SVector::zeros(), base_velocity: SVector::zeros() };
        let coupling = self.dynamics(&state).base_coupling()?;
        let mut columns = [Twist::zero(); N];
        let mut places = columns.iter_mut();
        let base = Frame::of_base(&Twist::zero());
        let end = self.walk(&base, position, &state.velocity, |_, _, column| {
            if let Some(place) = places.next() {
                *place = column.twist;
            }
        });
        let of_joints = matrix(columns.map(|column| at(&column, &end.place)));
        let of_base = matrix(<BaseFreedom<B> as Columns<T, B>>::twists().map(|column| at(&column, &end.place)));
        Some(of_joints - of_base * coupling)
    }
}

fn matrix<T: Scalar, const COLUMNS: usize>(columns: [[T; 6]; COLUMNS]) -> SMatrix<T, 6, COLUMNS> {
    SMatrix::from_data(nalgebra::ArrayStorage(columns))
}
