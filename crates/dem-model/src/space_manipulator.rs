//! Space manipulators of any number of links, and the DEM map (eq. 1).

use nalgebra::{Matrix3, Vector3};

use crate::dem::{Dem, DemBase, DemLink};
use crate::error::{Body, ParameterError, Requirement, require};
use crate::geometry::{CheckedInertia as _, Distance};
use crate::scalar::Scalar;

/// The spacecraft of a space manipulator: link 1, the free-floating base. In the plane unless the parameters say
/// otherwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpacecraftBody<T, D = T, I = T> {
    /// Mass m'_1 in kg; > 0.
    pub mass: T,
    /// Inertia I'_1 about the centre of mass, in kg·m²; > 0 or positive definite.
    pub inertia: I,
    /// R_1 from the centre of mass to joint 2, in m; ≥ 0, or a vector in the frame of the spacecraft.
    pub centre_of_mass_to_joint: D,
}

/// A link i ≥ 2 of a space manipulator's arm. In the plane unless the parameters say otherwise; joints and centre of
/// mass then lie on one line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpaceLink<T, D = T, I = T> {
    /// Mass m'_i in kg; > 0.
    pub mass: T,
    /// Inertia I'_i about the centre of mass, in kg·m²; > 0 or positive definite.
    pub inertia: I,
    /// L_i from joint i to the centre of mass, in m; ≥ 0, or a vector in the frame of the link.
    pub joint_to_centre_of_mass: D,
    /// R_i from the centre of mass to joint i+1, or to the end effector, in m; ≥ 0, or a vector in the frame of the link.
    pub centre_of_mass_to_joint: D,
}

/// A free-floating space manipulator: a spacecraft and an arm of `LINKS` links in a chain. See
/// [`PlanarSpaceManipulator`] and [`SpatialSpaceManipulator`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpaceManipulator<T, const LINKS: usize, D, I> {
    spacecraft: SpacecraftBody<T, D, I>,
    links: [SpaceLink<T, D, I>; LINKS],
}

/// A space manipulator in the plane.
///
/// ```
/// use dem_model::PlanarSpaceManipulator;
///
/// let dem = PlanarSpaceManipulator::<f64, 2>::table_1().dynamically_equivalent();
/// assert!((dem.links()[0].mass - 0.850).abs() < 0.0005); // Table 2
/// ```
pub type PlanarSpaceManipulator<T, const LINKS: usize> = SpaceManipulator<T, LINKS, T, T>;

/// A space manipulator in space. Which way the joints turn does not enter the map, so the axes are not held here.
///
/// ```
/// use dem_model::nalgebra::{Matrix3, Vector3};
/// use dem_model::{SpaceLink, SpacecraftBody, SpatialSpaceManipulator};
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
pub type SpatialSpaceManipulator<T, const LINKS: usize> = SpaceManipulator<T, LINKS, Vector3<T>, Matrix3<T>>;

impl<T: Scalar, const LINKS: usize, D: Distance<T>> SpaceManipulator<T, LINKS, D, D::Inertia> {
    /// Checks and takes the parameters of the spacecraft and of the arm's links, from the spacecraft outwards.
    ///
    /// # Errors
    /// [`ParameterError::OutOfRange`] names the first value that is not finite or out of the range its field states,
    /// [`ParameterError::InertiaNotPositiveDefinite`] the first inertia tensor that is not symmetric and positive definite.
    pub fn new(
        spacecraft: SpacecraftBody<T, D, D::Inertia>,
        links: [SpaceLink<T, D, D::Inertia>; LINKS],
    ) -> Result<Self, ParameterError> {
        let body = Body::Spacecraft;
        require(body, "mass", spacecraft.mass, Requirement::Positive)?;
        spacecraft.inertia.require_inertia(body)?;
        spacecraft.centre_of_mass_to_joint.require_distance(body, "centre_of_mass_to_joint")?;
        for (index, link) in links.iter().enumerate() {
            let body = Body::arm_link(index);
            require(body, "mass", link.mass, Requirement::Positive)?;
            link.inertia.require_inertia(body)?;
            link.joint_to_centre_of_mass.require_distance(body, "joint_to_centre_of_mass")?;
            link.centre_of_mass_to_joint.require_distance(body, "centre_of_mass_to_joint")?;
        }
        Ok(Self { spacecraft, links })
    }

    /// The mass M_t of spacecraft and arm, in kg.
    pub fn total_mass(&self) -> T {
        self.links.iter().fold(self.spacecraft.mass, |sum, link| sum + link.mass)
    }

    /// The dynamically equivalent manipulator (Liang's theorem, eq. 1): a manipulator on a fixed base whose joints
    /// move as the space manipulator's do under the same joint torques. With M_t the total mass and S_i = Σ_{k≤i} m'_k
    ///
    /// m_i = M_t² m'_i / (S_{i−1} S_i), I_i = I'_i, W_1 = R_1 m'_1 / M_t, W_i = (R_i S_i + L_i S_{i−1}) / M_t,
    /// l_c1 = 0, l_ci = L_i S_{i−1} / M_t.
    ///
    /// Distances are numbers in the plane and vectors in the frames of their links in space.
    pub fn dynamically_equivalent(&self) -> Dem<T, LINKS, D, D::Inertia> {
        let total = self.total_mass();
        let mut inboard = self.spacecraft.mass;
        let base = DemBase {
            inertia: self.spacecraft.inertia,
            length: self.spacecraft.centre_of_mass_to_joint * (inboard / total),
        };
        let links = self.links.map(|link| {
            let with_link = inboard + link.mass;
            let centre_of_mass = link.joint_to_centre_of_mass * (inboard / total);
            let dem_link = DemLink {
                mass: (total / inboard) * (total / with_link) * link.mass,
                inertia: link.inertia,
                length: link.centre_of_mass_to_joint * (with_link / total) + centre_of_mass,
                centre_of_mass,
            };
            inboard = with_link;
            dem_link
        });
        Dem::from_map(base, links)
    }
}

impl<T, const LINKS: usize, D, I> SpaceManipulator<T, LINKS, D, I> {
    /// The parameters of the spacecraft.
    pub fn spacecraft(&self) -> &SpacecraftBody<T, D, I> {
        &self.spacecraft
    }

    /// The parameters of the arm's links, from the spacecraft outwards.
    pub fn links(&self) -> &[SpaceLink<T, D, I>; LINKS] {
        &self.links
    }
}

impl<T: Scalar, const LINKS: usize> PlanarSpaceManipulator<T, LINKS> {
    /// The same manipulator in space: its bodies lie along x while all angles are zero, and its joints turn about z. Inertias
    /// about the other axes, which have no effect then, are set to that about z.
    ///
    /// ```
    /// use dem_model::PlanarSpaceManipulator;
    /// let arm = PlanarSpaceManipulator::<f64, 2>::table_1();
    /// assert_eq!(arm.in_space().total_mass(), arm.total_mass());
    /// ```
    pub fn in_space(&self) -> SpatialSpaceManipulator<T, LINKS> {
        let along = |distance: T| Vector3::new(distance, T::zero(), T::zero());
        let about = Matrix3::<T>::from_diagonal_element;
        SpaceManipulator {
            spacecraft: SpacecraftBody {
                mass: self.spacecraft.mass,
                inertia: about(self.spacecraft.inertia),
                centre_of_mass_to_joint: along(self.spacecraft.centre_of_mass_to_joint),
            },
            links: self.links.map(|link| SpaceLink {
                mass: link.mass,
                inertia: about(link.inertia),
                joint_to_centre_of_mass: along(link.joint_to_centre_of_mass),
                centre_of_mass_to_joint: along(link.centre_of_mass_to_joint),
            }),
        }
    }
}

impl<T: Scalar> PlanarSpaceManipulator<T, 2> {
    /// The space manipulator of the paper's Table 1.
    pub fn table_1() -> Self {
        let value = T::constant;
        let link = |mass, inertia, to_centre_of_mass, to_joint| SpaceLink {
            mass: value(mass),
            inertia: value(inertia),
            joint_to_centre_of_mass: value(to_centre_of_mass),
            centre_of_mass_to_joint: value(to_joint),
        };
        Self {
            spacecraft: SpacecraftBody {
                mass: value(4.816),
                inertia: value(0.0153),
                centre_of_mass_to_joint: value(0.253),
            },
            links: [link(0.618, 0.0075, 0.120, 0.118), link(0.566, 0.0060, 0.085, 0.126)],
        }
    }
}
