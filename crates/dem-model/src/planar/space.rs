//! The space manipulator's parameters in the plane, and the DEM map (eq. 1).

use super::PlanarDem;
use crate::Scalar;
use crate::error::{Body, ParameterError, Requirement, require};
use crate::link::{DemBase, DemLink};
use crate::mass_chain::MassChain;

/// The spacecraft of a planar space manipulator: link 1, the free-floating base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpacecraftBody<T> {
    /// Mass m'_1 in kg; > 0.
    pub mass: T,
    /// Moment of inertia I'_1 about the centre of mass, in kg·m²; > 0.
    pub inertia: T,
    /// Distance R_1 from the centre of mass to joint 2, in m; ≥ 0.
    pub centre_of_mass_to_joint: T,
}

/// A link i ≥ 2 of a planar space manipulator's arm. The joints and the centre of mass lie on one line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpaceLink<T> {
    /// Mass m'_i in kg; > 0.
    pub mass: T,
    /// Moment of inertia I'_i about the centre of mass, in kg·m²; > 0.
    pub inertia: T,
    /// Distance L_i from joint i to the centre of mass, in m; ≥ 0.
    pub joint_to_centre_of_mass: T,
    /// Distance R_i from the centre of mass to joint i+1, or to the end effector, in m; ≥ 0.
    pub centre_of_mass_to_joint: T,
}

/// A free-floating space manipulator in the plane: a spacecraft and an arm of `LINKS` links in a chain.
///
/// ```
/// use dem_model::planar::PlanarSpaceManipulator;
///
/// let dem = PlanarSpaceManipulator::<f64, 2>::table_1().dynamically_equivalent();
/// assert!((dem.links()[0].mass - 0.850).abs() < 0.0005); // Table 2
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanarSpaceManipulator<T, const LINKS: usize> {
    spacecraft: SpacecraftBody<T>,
    links: [SpaceLink<T>; LINKS],
}

impl<T: Scalar, const LINKS: usize> PlanarSpaceManipulator<T, LINKS> {
    /// Checks and takes the parameters of the spacecraft and of the arm's links, from the spacecraft outwards.
    ///
    /// # Errors
    /// [`ParameterError::OutOfRange`] names the first value that is not finite or out of the range its field states.
    pub fn new(spacecraft: SpacecraftBody<T>, links: [SpaceLink<T>; LINKS]) -> Result<Self, ParameterError> {
        let distance = |body, field, value| require(body, field, value, Requirement::NotNegative);
        let positive = |body, field, value| require(body, field, value, Requirement::Positive);
        positive(Body::Spacecraft, "mass", spacecraft.mass)?;
        positive(Body::Spacecraft, "inertia", spacecraft.inertia)?;
        distance(Body::Spacecraft, "centre_of_mass_to_joint", spacecraft.centre_of_mass_to_joint)?;
        for (index, link) in links.iter().enumerate() {
            let body = Body::arm_link(index);
            positive(body, "mass", link.mass)?;
            positive(body, "inertia", link.inertia)?;
            distance(body, "joint_to_centre_of_mass", link.joint_to_centre_of_mass)?;
            distance(body, "centre_of_mass_to_joint", link.centre_of_mass_to_joint)?;
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

    /// The dynamically equivalent manipulator (Liang's theorem, eq. 1): a manipulator on a fixed base whose joints
    /// move as the space manipulator's do under the same joint torques. With M_t the total mass and S_i = Σ_{k≤i} m'_k
    ///
    /// m_i = M_t² m'_i / (S_{i−1} S_i), I_i = I'_i, W_1 = R_1 m'_1 / M_t, W_i = (R_i S_i + L_i S_{i−1}) / M_t,
    /// l_c1 = 0, l_ci = L_i S_{i−1} / M_t.
    pub fn dynamically_equivalent(&self) -> PlanarDem<T, LINKS> {
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
        PlanarDem::from_map(base, links)
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
