//! What a base of 1, 3 or 6 degrees of freedom can do.

use nalgebra::{SVector, Vector3};

use super::twist::Twist;
use crate::scalar::Scalar;

/// A base of `B` degrees of freedom. See [`BaseMotion`] for which there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BaseFreedom<const B: usize>;

/// The bases that there are, for a [`BaseFreedom`]:
///
/// | B | base | velocity v_b |
/// |---|---|---|
/// | 1 | turns about the z axis of a fixed joint: an arm in the plane | ω_z in rad/s |
/// | 3 | turns about a fixed spherical joint: the DEM in space | ω in rad/s, base axes |
/// | 6 | floats: a space manipulator as it is | ω in rad/s, then the velocity of its centre of mass in m/s, base axes |
///
/// The trait is sealed: there are no others.
pub trait BaseMotion<T: Scalar, const B: usize>: Columns<T, B> {}

/// What the base's columns are. Private to the crate, so that [`BaseMotion`] is sealed.
pub trait Columns<T: Scalar, const B: usize> {
    /// The twists of unit velocities, about the base's origin.
    fn twists() -> [Twist<T>; B];
}

impl<T: Scalar, const B: usize> BaseMotion<T, B> for BaseFreedom<B> where Self: Columns<T, B> {}

impl<T: Scalar> Columns<T, 1> for BaseFreedom<1> {
    fn twists() -> [Twist<T>; 1] {
        [Twist::turning(Vector3::z())]
    }
}

impl<T: Scalar> Columns<T, 3> for BaseFreedom<3> {
    fn twists() -> [Twist<T>; 3] {
        [Vector3::x(), Vector3::y(), Vector3::z()].map(Twist::turning)
    }
}

impl<T: Scalar> Columns<T, 6> for BaseFreedom<6> {
    fn twists() -> [Twist<T>; 6] {
        let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()];
        let (turning, sliding) = (Twist::turning, Twist::sliding);
        [turning(x), turning(y), turning(z), sliding(x), sliding(y), sliding(z)]
    }
}

/// The twist of a base that moves at `velocity`, in rad/s and m/s.
pub(super) fn base_twist<T: Scalar, const B: usize>(velocity: &SVector<T, B>) -> Twist<T>
where
    BaseFreedom<B>: BaseMotion<T, B>,
{
    let columns = <BaseFreedom<B> as Columns<T, B>>::twists();
    columns.iter().zip(velocity.iter()).fold(Twist::zero(), |sum, (column, rate)| sum + *column * *rate)
}
