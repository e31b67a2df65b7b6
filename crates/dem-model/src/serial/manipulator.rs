//! The parameters of a serial arm on its base.

use nalgebra::{Matrix3, Vector3};

use super::composite::Moments;
use super::joint::{Joint, JointMotion};
use crate::dem::{PlanarDem, SpatialDem};
use crate::error::{Body, ParameterError};
use crate::scalar::Scalar;
use crate::space_manipulator::SpatialSpaceManipulator;

/// A link, in its own frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Link<T: Scalar> {
    /// How far the link moves for one unit of a prismatic joint's coordinate: 1, or less in a DEM.
    pub stroke: T,
    /// What it weighs.
    pub moments: Moments<T>,
    /// From the joint to the next joint or the end effector, in m.
    pub length: Vector3<T>,
}

/// A serial arm of `N` joints, revolute or prismatic, with any axes, on a base of `B` degrees of freedom (1, 3 or 6: see
/// [`BaseMotion`](super::BaseMotion)).
///
/// Link i's frame is parallel to that of the link before while the joint's coordinate is zero. With B = 6 it is the
/// free-floating space manipulator itself; with B = 3 and 1 its dynamically equivalent manipulator in space and in the
/// plane, whose base does not move off its joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SerialManipulator<T: Scalar, const N: usize, const B: usize> {
    /// About its origin, which is its centre of mass. The mass has an effect with B = 6 only.
    pub(super) base: Moments<T>,
    /// To the first joint, in m.
    pub(super) base_length: Vector3<T>,
    pub(super) joints: [Joint<T>; N],
    pub(super) links: [Link<T>; N],
}

/// The DEM in the plane as a serial arm.
pub type PlanarBaseManipulator<T, const N: usize> = SerialManipulator<T, N, 1>;
/// The DEM in space: its base turns about a passive spherical joint.
pub type SphericalBaseManipulator<T, const N: usize> = SerialManipulator<T, N, 3>;
/// The space manipulator as it is: its spacecraft floats.
pub type FreeFloatingManipulator<T, const N: usize> = SerialManipulator<T, N, 6>;

impl<T: Scalar, const N: usize, const B: usize> SerialManipulator<T, N, B> {
    /// The joints, from the base outwards.
    pub fn joints(&self) -> [Joint<T>; N] {
        self.joints
    }
}

impl<T: Scalar, const N: usize> FreeFloatingManipulator<T, N> {
    /// The space manipulator itself, simulated with its spacecraft's translation: the base's velocity is that of the
    /// spacecraft's centre of mass.
    pub fn free_floating(manipulator: &SpatialSpaceManipulator<T, N>, joints: [Joint<T>; N]) -> Self {
        let spacecraft = manipulator.spacecraft();
        Self {
            base: Moments::new(spacecraft.mass, &Vector3::zeros(), &spacecraft.inertia),
            base_length: spacecraft.centre_of_mass_to_joint,
            joints,
            links: manipulator.links().map(|link| Link {
                stroke: T::one(),
                moments: Moments::new(link.mass, &link.joint_to_centre_of_mass, &link.inertia),
                length: link.joint_to_centre_of_mass + link.centre_of_mass_to_joint,
            }),
        }
    }
}

impl<T: Scalar, const N: usize> SphericalBaseManipulator<T, N> {
    /// The dynamically equivalent manipulator of a space manipulator with these joints (Liang's theorem, eq. 1).
    ///
    /// A prismatic joint moves its link in the DEM by S_{i−1}/M_t of its coordinate, S_{i−1} being the mass inboard of the
    /// joint: R_{i−1} grows with the coordinate, and W_{i−1} with it.
    pub fn dynamically_equivalent(manipulator: &SpatialSpaceManipulator<T, N>, joints: [Joint<T>; N]) -> Self {
        let mut serial = Self::revolute(&manipulator.dynamically_equivalent(), joints);
        let total = manipulator.total_mass();
        let mut inboard = manipulator.spacecraft().mass;
        for (equivalent, link) in serial.links.iter_mut().zip(manipulator.links()) {
            equivalent.stroke = inboard / total;
            inboard += link.mass;
        }
        serial
    }

    /// A DEM of known parameters whose joints are all revolute.
    ///
    /// # Errors
    /// [`ParameterError::PrismaticDem`] for a prismatic joint: how far it moves a DEM's link follows from the space
    /// manipulator alone; see [`SerialManipulator::dynamically_equivalent`].
    pub fn new(dem: &SpatialDem<T, N>, joints: [Joint<T>; N]) -> Result<Self, ParameterError> {
        match joints.iter().position(|joint| joint.motion() == JointMotion::Prismatic) {
            Some(index) => Err(ParameterError::PrismaticDem { body: Body::arm_link(index) }),
            None => Ok(Self::revolute(dem, joints)),
        }
    }

    fn revolute(dem: &SpatialDem<T, N>, joints: [Joint<T>; N]) -> Self {
        let base = dem.base();
        Self {
            base: Moments::new(T::zero(), &Vector3::zeros(), &base.inertia),
            base_length: base.length,
            joints,
            links: dem.links().map(|link| Link {
                stroke: T::one(),
                moments: Moments::new(link.mass, &link.centre_of_mass, &link.inertia),
                length: link.length,
            }),
        }
    }
}

impl<T: Scalar, const N: usize> PlanarBaseManipulator<T, N> {
    /// A DEM in the plane: its links lie along x while all coordinates are zero, and turn about z.
    ///
    pub fn planar(dem: &PlanarDem<T, N>) -> Self {
        let along = |distance: T| Vector3::new(distance, T::zero(), T::zero());
        let about = Matrix3::<T>::from_diagonal_element;
        let base = dem.base();
        Self {
            base: Moments::new(T::zero(), &Vector3::zeros(), &about(base.inertia)),
            base_length: along(base.length),
            joints: [Joint::about_z(); N],
            links: dem.links().map(|link| Link {
                stroke: T::one(),
                moments: Moments::new(link.mass, &along(link.centre_of_mass), &about(link.inertia)),
                length: along(link.length),
            }),
        }
    }
}
