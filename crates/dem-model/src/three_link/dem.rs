//! The planar three-link DEM: its parameters.

use super::inertial::InertialParameters;
use crate::dem::{DemBase, DemLink, PlanarDem};
use crate::error::{Body, ParameterError};
use crate::scalar::Scalar;

/// How many roundings of M_ii an inertia has to exceed, so that M stays positive definite when it is computed.
///
/// Factorising M loses some tens of roundings of M_ii in the pivot of joint i, whatever the scale of the other joints
/// (the error does not change with D M D, D diagonal), and whichever is eliminated first. With the others free the pivot is at least I_1 for joint 1 and
/// I_a I_b/(I_a + I_b) ≥ ½ min(I_a, I_b) for a joint between links a and b.
const LEAST_INERTIA_IN_ROUNDINGS: f64 = 256.0;

/// The planar three-link DEM in closed form: a base on the passive joint 1 and an arm with active joints 2 and 3.
///
/// Coordinates are q = [q_1, q_2, q_3] in rad: the base's angle from the x axis of the fixed frame, and the relative
/// angles of the joints 2 and 3. Positive angles turn counter-clockwise. There is no gravity in the plane.
///
/// ```
/// use dem_model::ThreeLinkDem;
/// use nalgebra::Vector3;
///
/// let dem = ThreeLinkDem::<f64>::table_2();
/// let (q, velocity) = (Vector3::new(0.0, 0.35, 0.35), Vector3::new(-0.1, 0.4, 0.2));
/// let torque = Vector3::new(0.0, 0.05, 0.02);
/// let acceleration = dem.forward_dynamics(&q, &velocity, &torque);
/// let back = dem.inverse_dynamics(&q, &velocity, &acceleration);
/// assert!((back - torque).norm() < 1e-15);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThreeLinkDem<T> {
    base: DemBase<T>,
    links: [DemLink<T>; 2],
    inertial: InertialParameters<T>,
}

impl<T: Scalar> ThreeLinkDem<T> {
    /// Checks and takes the parameters of the base and of the links 2 and 3.
    ///
    /// # Errors
    /// [`ParameterError::OutOfRange`] names the first value that is not finite or out of the range its field states;
    /// [`ParameterError::InertiaLostInRounding`] an inertia too small beside the others for this number type.
    pub fn new(base: DemBase<T>, links: [DemLink<T>; 2]) -> Result<Self, ParameterError> {
        PlanarDem::new(base, links)?.closed_form()
    }

    /// The DEM of the paper's Table 2, which is the nominal model of the robot UARM.
    pub fn table_2() -> Self {
        let value = T::constant;
        let length = value(0.203);
        let link = |mass, inertia, centre_of_mass| DemLink {
            mass: value(mass),
            inertia: value(inertia),
            length,
            centre_of_mass: value(centre_of_mass),
        };
        Self::from_checked(
            DemBase { inertia: value(0.0153), length },
            [link(0.850, 0.0075, 0.096), link(0.625, 0.0060, 0.077)],
        )
    }

    fn from_checked(base: DemBase<T>, links: [DemLink<T>; 2]) -> Self {
        Self { base, links, inertial: InertialParameters::of(&base, &links) }
    }

    fn require_inertias_above_rounding(&self) -> Result<(), ParameterError> {
        let roundings = T::constant(LEAST_INERTIA_IN_ROUNDINGS) * T::default_epsilon();
        let [second, third] = &self.links;
        let [of_base, of_second, of_third] = self.inertial.largest_diagonal();
        for (body, inertia, largest) in [
            (Body::Base, self.base.inertia, of_base),
            (Body::arm_link(0), second.inertia, of_second),
            (Body::arm_link(1), third.inertia, of_third),
        ] {
            let least = largest * roundings;
            // Written so that a NaN, which the products may overflow to, is refused as well.
            if !(inertia >= least && least.is_finite()) {
                return Err(ParameterError::InertiaLostInRounding {
                    body,
                    found: inertia.to_f64(),
                    least: least.to_f64(),
                });
            }
        }
        Ok(())
    }

    /// The parameters of the base.
    pub fn base(&self) -> &DemBase<T> {
        &self.base
    }

    /// The parameters of the links 2 and 3.
    pub fn links(&self) -> &[DemLink<T>; 2] {
        &self.links
    }

    /// The six numbers that M and C depend on.
    pub fn inertial_parameters(&self) -> &InertialParameters<T> {
        &self.inertial
    }
}

impl<T: Scalar> PlanarDem<T, 2> {
    /// The same manipulator in closed form.
    ///
    /// # Errors
    /// [`ParameterError::InertiaLostInRounding`] for an inertia too small beside the others for this number type.
    pub fn closed_form(&self) -> Result<ThreeLinkDem<T>, ParameterError> {
        let dem = ThreeLinkDem::from_checked(*self.base(), *self.links());
        dem.require_inertias_above_rounding()?;
        Ok(dem)
    }
}
