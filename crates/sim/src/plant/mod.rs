//! What the emulated drives move.
//!
//! A [`MechanicalPlant`] is a [`Mechanism`] (equations of motion) with state, brakes, disturbance and plant time:
//!
//! | plant | mechanism | coordinates |
//! |---|---|---|
//! | [`DemPlant`] | the dynamically equivalent manipulator, eq. 2 | q1 (base), q2, q3 |
//! | [`UarmPlant`] | the same with friction, tilt, gain, other inertias | q1 (base), q2, q3 |
//! | [`FreeFloatingPlant`] | spacecraft and two links, from Newton and Euler, without the DEM | x, y, θ, q2, q3 |
//!
//! A [`SerialPlant`] is an arm of any number of joints and any axes, on a base that floats, turns in space or in the plane.
//!
//! ```
//! use hinf_control::Disturbance;
//! use nalgebra::Vector3;
//! use uarm_sim::{Brake, DemPlant, Plant};
//! use std::time::Duration;
//!
//! let mut plant = DemPlant::new(dem_model::ThreeLinkDem::table_2()).with_disturbance(Disturbance::Paper);
//! plant.advance(Duration::from_millis(3), &Vector3::new(0.0, 0.05, 0.0), [Brake::Released; 3]);
//! assert!(plant.velocity().y > 0.0 && plant.velocity().x < 0.0, "the base turns against the arm");
//! ```

mod free_floating;
mod held;
mod ideal_dem;
mod integrator;
mod interface;
mod mechanical;
mod serial;
mod uarm;
mod uarm_parameters;

pub use free_floating::{FreeFloatingManipulator, FreeFloatingPlant};
pub use ideal_dem::{DemPlant, IdealDem};
pub use integrator::{Integrable, IntegrationStep, MotionState, runge_kutta_step};
pub use interface::{Brake, Plant};
pub use mechanical::{InertialTerms, InitialState, MechanicalPlant, Mechanism};
pub use serial::{
    BasePose, FloatingPose, FloatingRate, JointImperfections, ParameterScale, PlanarBasePlant, PosedBase, SerialBrakes,
    SerialImperfections, SerialMotion, SerialPlant, SerialRate, SerialSpacePlant, SphericalBasePlant,
};
pub use uarm::{Uarm, UarmPlant};
pub use uarm_parameters::{UarmImperfections, UarmParameterError, UarmPlantParameters};
