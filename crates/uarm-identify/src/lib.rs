//! What is not ideal in a robot, from recorded angles and torques: an output-error fit by multiple shooting.
//!
//! ```
//! use uarm_identify::{Gain, Sample, Uarm, UarmParameter, identify};
//! use dem_model::ThreeLinkDem;
//! use uarm_sim::{Brake, Plant, UarmPlant, UarmPlantParameters};
//! use core::time::Duration;
//!
//! // A second of a robot that turns its joints to and fro, recorded every 5 ms.
//! let nominal = ThreeLinkDem::table_2();
//! let mut plant = UarmPlant::new(&nominal, UarmPlantParameters::fitted()).unwrap();
//! let mut samples = Vec::new();
//! for cycle in 0..200_u32 {
//!     let at = 0.005 * f64::from(cycle);
//!     let torque = [0.0, 0.15 * (12.0 * at).sin(), 0.1 * (17.0 * at).cos()];
//!     let position = plant.position().into();
//!     samples.push(Sample { at, position, torque_before: torque, torque, torque_at: at, disturbance: [0.0; 3] });
//!     plant.advance(Duration::from_millis(5) * (cycle + 1), &torque.into(), [Brake::Released; 3]);
//! }
//! let resolution = [1e-6; 3];
//! let found = identify(&Uarm::new(nominal, Gain::Known(1.0022)), &[samples], resolution, |_| ()).unwrap();
//! let friction = found.estimate(UarmParameter::Viscous(1)).unwrap();
//! assert!((friction.value - 0.01192).abs() < 1e-4, "{friction:?}");
//! ```
//!
//! # Method
//!
//! The recording is cut into windows of [`WINDOW`]. In each the robot is simulated from a start of its own, under the torques that it
//! was given, and its angles are compared with those of the encoders: nothing is differentiated, and an encoder's rounding stays the
//! noise that it is. Parameters θ of all windows and the start (q, q̇) of each are found together by Levenberg and Marquardt's method
//! (Marquardt 1963); the starts leave the normal equations by their Schur complements, as in bundle adjustment (Triggs et al. 2000,
//! section 6), so that these stay as small as θ is. Standard errors are those of least squares, σ² S⁻¹ with the reduced normal matrix S
//! and σ² of the residuals, widened by the residuals' correlation from sample to sample, (1 + ρ)/(1 − ρ).
//!
//! Without a known torque that is not the motors', the equations of motion say nothing of the scale: twice the inertia, friction and
//! gain make the same motion. The gain must then be [known](Gain::Known).
//!
//! # Map
//!
//! | where | what |
//! |---|---|
//! | [`Sample`] | a cycle of a recording |
//! | [`Model`], [`Uarm`] | what is simulated with which parameters; the paper's robot |
//! | [`identify`], [`Identified`], [`Estimate`], [`SearchEnd`] | the fit, and what it found |
//! | [`IdentifyError`] | why there is none |
#![forbid(unsafe_code)]

mod estimate;
mod fit;
mod model;
mod sample;
mod shooting;
mod uarm;

pub use estimate::{Estimate, Identified, SearchEnd, Told};
pub use fit::{IdentifyError, MOST_STEPS, identify};
pub use model::{Model, Parameter};
pub use sample::{Sample, WINDOW};
pub use uarm::{Gain, Uarm, UarmParameter};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
