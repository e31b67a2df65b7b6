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
mod ideal_dem;
mod integrator;
mod mechanical;
mod uarm;
mod uarm_parameters;

pub use free_floating::{FreeFloatingManipulator, FreeFloatingPlant};
pub use ideal_dem::{DemPlant, IdealDem};
pub use integrator::{IntegrationStep, MotionState, runge_kutta_step};
pub use mechanical::{InertialTerms, InitialState, MechanicalPlant, Mechanism};
pub use uarm::{Uarm, UarmPlant};
pub use uarm_parameters::{UarmImperfections, UarmParameterError, UarmPlantParameters};

use core::time::Duration;
use nalgebra::Vector3;

/// A three-joint robot: joint 1 is the free base, joints 2 and 3 are driven.
///
/// Deterministic: the same calls give the same bits. Plant time is counted in whole nanoseconds from zero.
pub trait Plant {
    /// Plant time.
    fn time(&self) -> Duration;

    /// True joint angles, rad.
    fn position(&self) -> Vector3<f64>;

    /// True joint velocities, rad/s.
    fn velocity(&self) -> Vector3<f64>;

    /// Moves on to `until` with `torque` (N·m at the motors) held and the joints in `brakes` held still.
    /// Steps exactly onto `until` and onto every instant at which a disturbance starts.
    fn advance(&mut self, until: Duration, torque: &Vector3<f64>, brakes: [Brake; 3]);
}

/// A joint's holding brake.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Brake {
    /// The joint is held.
    Engaged,
    /// The joint is free.
    Released,
}
