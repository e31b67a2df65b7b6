//! The ideal plant: the dynamically equivalent manipulator and nothing else.

use super::integrator::MotionState;
use super::mechanical::{InertialTerms, MechanicalPlant, Mechanism};
use dem_model::ThreeLinkDem;
use nalgebra::Vector3;

/// The planar three-link DEM (eq. 2) without friction, tilt or gain error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IdealDem(ThreeLinkDem<f64>);

/// The ideal plant.
pub type DemPlant = MechanicalPlant<IdealDem, 3>;

impl DemPlant {
    /// The manipulator `dem` in the paper's initial state, undisturbed.
    pub fn new(dem: ThreeLinkDem<f64>) -> Self {
        Self::from_mechanism(IdealDem(dem))
    }
}

impl Mechanism<3> for IdealDem {
    const JOINTS: [usize; 3] = [0, 1, 2];

    fn inertial_terms(&self, state: &MotionState<3>) -> InertialTerms<3> {
        let (mass, coriolis) = self.0.mass_and_coriolis(&state.position, &state.velocity);
        InertialTerms { mass, velocity_force: coriolis * state.velocity }
    }

    fn applied_force(&self, _state: &MotionState<3>, motor: &Vector3<f64>, disturbance: &Vector3<f64>) -> Vector3<f64> {
        motor + disturbance
    }

    fn place(&self, position: &Vector3<f64>, velocity: &Vector3<f64>) -> MotionState<3> {
        MotionState { position: *position, velocity: *velocity }
    }
}
