//! Space manipulators in space and the DEM map of their parameters (eq. 1), for any number of links.
//!
//! Vectors and inertia matrices are given in the frame of their own link. Which way the joints turn does not enter the
//! map, so the axes are not held here.

use nalgebra::{Matrix3, Vector3};

use crate::Scalar;
use crate::error::{Body, ParameterError, Requirement, require};
use crate::mass_chain::MassChain;

/// The spacecraft of a space manipulator: link 1, the free-floating base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpacecraftBody<T> {
    /// Mass m'_1 in kg; > 0.
    pub mass: T,
    /// Inertia tensor I'_1 about the centre of mass, in kg·m²; symmetric, positive definite.
    pub inertia: Matrix3<T>,
    /// R_1 from the centre of mass to joint 2, in m.
    pub centre_of_mass_to_joint: Vector3<T>,
}

/// A link i ≥ 2 of a space manipulator's arm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpaceLink<T> {
    /// Mass m'_i in kg; > 0.
    pub mass: T,
    /// Inertia tensor I'_i about the centre of mass, in kg·m²; symmetric, positive definite.
    pub inertia: Matrix3<T>,
    /// L_i from joint i to the centre of mass, in m.
    pub joint_to_centre_of_mass: Vector3<T>,
    /// R_i from the centre of mass to joint i+1, or to the end effector, in m.
    pub centre_of_mass_to_joint: Vector3<T>,
}

/// The base of a DEM in space. Its centre of mass lies in the passive spherical joint 1, so that it has no mass that
/// could have an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DemBase<T> {
    /// Inertia tensor I_1 about joint 1, in kg·m².
    pub inertia: Matrix3<T>,
    /// W_1 from joint 1 to joint 2, in m.
    pub length: Vector3<T>,
}

/// A link i ≥ 2 of a DEM in space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DemLink<T> {
    /// Mass m_i in kg.
    pub mass: T,
    /// Inertia tensor I_i about the centre of mass, in kg·m².
    pub inertia: Matrix3<T>,
    /// W_i from joint i to joint i+1, or to the end effector, in m.
    pub length: Vector3<T>,
    /// l_ci from joint i to the centre of mass, in m.
    pub centre_of_mass: Vector3<T>,
}

/// The parameters of a dynamically equivalent manipulator in space with an arm of `LINKS` links.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpatialDem<T, const LINKS: usize> {
    base: DemBase<T>,
    links: [DemLink<T>; LINKS],
}

impl<T: Scalar, const LINKS: usize> SpatialDem<T, LINKS> {
    /// The base.
    pub fn base(&self) -> &DemBase<T> {
        &self.base
    }

    /// The arm's links, from the base outwards.
    pub fn links(&self) -> &[DemLink<T>; LINKS] {
        &self.links
    }
}

/// A free-floating space manipulator: a spacecraft and an arm of `LINKS` links in a chain.
///
/// ```
/// use dem_model::spatial::{SpaceLink, SpacecraftBody, SpatialSpaceManipulator};
/// use nalgebra::{Matrix3, Vector3};
///
/// let spacecraft = SpacecraftBody {
///     mass: 75.0,
///     inertia: Matrix3::from_diagonal_element(10.0),
///     centre_of_mass_to_joint: Vector3::new(0.5, 0.0, 0.25),
/// };
/// let link = SpaceLink {
///     mass: 25.0,
///     inertia: Matrix3::from_diagonal_element(0.5),
///     joint_to_centre_of_mass: Vector3::new(0.4, 0.0, 0.0),
///     centre_of_mass_to_joint: Vector3::new(0.6, 0.0, 0.0),
/// };
/// let dem = SpatialSpaceManipulator::new(spacecraft, [link])?.dynamically_equivalent();
/// assert_eq!(dem.base().length, Vector3::new(0.375, 0.0, 0.1875));
/// # Ok::<(), dem_model::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpatialSpaceManipulator<T, const LINKS: usize> {
    spacecraft: SpacecraftBody<T>,
    links: [SpaceLink<T>; LINKS],
}

impl<T: Scalar, const LINKS: usize> SpatialSpaceManipulator<T, LINKS> {
    /// Checks and takes the parameters of the spacecraft and of the arm's links, from the spacecraft outwards.
    ///
    /// # Errors
    /// [`ParameterError::OutOfRange`] names the first value that is not finite or out of the range its field states,
    /// [`ParameterError::InertiaNotPositiveDefinite`] the first inertia tensor that is not one.
    pub fn new(spacecraft: SpacecraftBody<T>, links: [SpaceLink<T>; LINKS]) -> Result<Self, ParameterError> {
        let body = Body::Spacecraft;
        require(body, "mass", spacecraft.mass, Requirement::Positive)?;
        require_inertia(body, &spacecraft.inertia)?;
        require_finite(body, "centre_of_mass_to_joint", &spacecraft.centre_of_mass_to_joint)?;
        for (index, link) in links.iter().enumerate() {
            let body = Body::arm_link(index);
            require(body, "mass", link.mass, Requirement::Positive)?;
            require_inertia(body, &link.inertia)?;
            require_finite(body, "joint_to_centre_of_mass", &link.joint_to_centre_of_mass)?;
            require_finite(body, "centre_of_mass_to_joint", &link.centre_of_mass_to_joint)?;
        }
        Ok(Self { spacecraft, links })
    }

    /// The spacecraft.
    pub fn spacecraft(&self) -> &SpacecraftBody<T> {
        &self.spacecraft
    }

    /// The arm's links, from the spacecraft outwards.
    pub fn links(&self) -> &[SpaceLink<T>; LINKS] {
        &self.links
    }

    /// The mass M_t of spacecraft and arm, in kg.
    pub fn total_mass(&self) -> T {
        self.links.iter().fold(self.spacecraft.mass, |sum, link| sum + link.mass)
    }

    /// The parameters of the dynamically equivalent manipulator (eq. 1); see
    /// [`PlanarSpaceManipulator::dynamically_equivalent`](crate::planar::PlanarSpaceManipulator::dynamically_equivalent),
    /// whose distances are vectors here.
    pub fn dynamically_equivalent(&self) -> SpatialDem<T, LINKS> {
        let mut chain = MassChain::new(self.spacecraft.mass, self.total_mass());
        let base = DemBase {
            inertia: self.spacecraft.inertia,
            length: self.spacecraft.centre_of_mass_to_joint * chain.spacecraft_share(),
        };
        let links = self.links.map(|link| {
            let masses = chain.next_link(link.mass);
            let centre_of_mass = link.joint_to_centre_of_mass * masses.inboard_share;
            DemLink {
                mass: masses.dem_mass,
                inertia: link.inertia,
                length: link.centre_of_mass_to_joint * masses.share_with_link + centre_of_mass,
                centre_of_mass,
            }
        });
        SpatialDem { base, links }
    }
}

fn require_finite<T: Scalar>(body: Body, field: &'static str, vector: &Vector3<T>) -> Result<(), ParameterError> {
    vector.iter().try_for_each(|entry| require(body, field, *entry, Requirement::Finite))
}

fn require_inertia<T: Scalar>(body: Body, inertia: &Matrix3<T>) -> Result<(), ParameterError> {
    inertia.iter().try_for_each(|entry| require(body, "inertia", *entry, Requirement::Finite))?;
    // Tensors that were rotated into the link's frame are symmetric but for rounding.
    let rounding = T::default_epsilon().sqrt() * inertia.amax();
    let symmetric = (inertia - inertia.transpose()).amax() <= rounding;
    if symmetric && inertia.cholesky().is_some() {
        Ok(())
    } else {
        Err(ParameterError::InertiaNotPositiveDefinite { body })
    }
}
