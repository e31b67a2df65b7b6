//! Dynamically equivalent manipulators of any number of links.

use nalgebra::{Matrix3, Vector3};

use crate::error::{Body, ParameterError, Requirement, require};
use crate::geometry::{CheckedDistance, CheckedInertia, Distance};
use crate::scalar::Scalar;

/// The base of a DEM: link 1, which turns about the passive joint 1. In the plane unless the parameters say otherwise.
///
/// It has no mass: its centre of mass lies in joint 1 (l_c1 = 0, eq. 1), so that m_1 neither follows from the map nor
/// has any effect on the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DemBase<D, I = D> {
    /// Inertia I_1 about the centre of mass, which is joint 1, in kg·m²; > 0 or positive definite.
    pub inertia: I,
    /// W_1 from joint 1 to joint 2, in m; ≥ 0, or a vector in the frame of the base.
    pub length: D,
}

/// A link i ≥ 2 of a DEM. In the plane unless the parameters say otherwise; distances are then measured along the link,
/// from its own joint outwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DemLink<T, D = T, I = T> {
    /// Mass m_i in kg; > 0.
    pub mass: T,
    /// Inertia I_i about the centre of mass, in kg·m²; > 0 or positive definite.
    pub inertia: I,
    /// W_i from joint i to joint i+1, or to the end effector, in m; ≥ 0, or a vector in the frame of the link.
    pub length: D,
    /// l_ci from joint i to the centre of mass, in m; ≥ 0, or a vector in the frame of the link.
    pub centre_of_mass: D,
}

/// A dynamically equivalent manipulator: a base that turns about the fixed, passive joint 1, and an arm of `LINKS`
/// links in a chain. See [`PlanarDem`] and [`SpatialDem`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dem<T, const LINKS: usize, D, I> {
    base: DemBase<D, I>,
    links: [DemLink<T, D, I>; LINKS],
}

/// A DEM in the plane.
///
/// Its inertia and Coriolis matrices are sums over Jacobians, for any number of links; they share no code with the
/// closed form of [`ThreeLinkDem`](crate::ThreeLinkDem).
pub type PlanarDem<T, const LINKS: usize> = Dem<T, LINKS, T, T>;

/// The parameters of a DEM in space, whose passive joint 1 is spherical. Which way the other joints turn does not enter
/// the map, so the axes are not held here.
pub type SpatialDem<T, const LINKS: usize> = Dem<T, LINKS, Vector3<T>, Matrix3<T>>;

impl<D: CheckedDistance, I: CheckedInertia> DemBase<D, I> {
    pub(crate) fn require(&self) -> Result<(), ParameterError> {
        self.inertia.require_inertia(Body::Base)?;
        self.length.require_distance(Body::Base, "length")
    }
}

impl<T: Scalar, D: CheckedDistance, I: CheckedInertia> DemLink<T, D, I> {
    pub(crate) fn require(&self, body: Body) -> Result<(), ParameterError> {
        require(body, "mass", self.mass, Requirement::Positive)?;
        self.inertia.require_inertia(body)?;
        self.length.require_distance(body, "length")?;
        self.centre_of_mass.require_distance(body, "centre_of_mass")
    }
}

impl<T: Scalar, const LINKS: usize, D: Distance<T>> Dem<T, LINKS, D, D::Inertia> {
    /// Checks and takes the parameters of the base and of the arm's links, from the base outwards.
    ///
    /// # Errors
    /// [`ParameterError::OutOfRange`] names the first value that is not finite or out of the range its field states,
    /// [`ParameterError::InertiaNotPositiveDefinite`] the first inertia tensor that is not symmetric and positive definite.
    pub fn new(
        base: DemBase<D, D::Inertia>,
        links: [DemLink<T, D, D::Inertia>; LINKS],
    ) -> Result<Self, ParameterError> {
        base.require()?;
        links.iter().enumerate().try_for_each(|(index, link)| link.require(Body::arm_link(index)))?;
        Ok(Self { base, links })
    }

    /// What the map makes of a checked space manipulator.
    pub(crate) fn from_map(base: DemBase<D, D::Inertia>, links: [DemLink<T, D, D::Inertia>; LINKS]) -> Self {
        Self { base, links }
    }
}

impl<T, const LINKS: usize, D, I> Dem<T, LINKS, D, I> {
    /// The parameters of the base.
    pub fn base(&self) -> &DemBase<D, I> {
        &self.base
    }

    /// The parameters of the arm's links, from the base outwards.
    pub fn links(&self) -> &[DemLink<T, D, I>; LINKS] {
        &self.links
    }
}
