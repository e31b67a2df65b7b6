//! Space manipulators and their dynamically equivalent manipulators (DEM), without `std`, for `f32` and `f64`.
//!
//! A free-floating space manipulator moves its spacecraft whenever it moves its arm. Liang's theorem gives a
//! manipulator on a fixed base, with a passive first joint, whose joints move in exactly the same way: its DEM, which
//! can be built, driven and measured in a laboratory. This crate maps the one to the other and gives the equations of
//! motion that controllers and simulations need.
//!
//! ```
//! use dem_model::nalgebra::Vector3;
//! use dem_model::{PlanarSpaceManipulator, ThreeLinkDem};
//!
//! // The paper's space manipulator (Table 1) and the manipulator that moves like it (Table 2, but unrounded).
//! let dem: ThreeLinkDem<f64> = PlanarSpaceManipulator::table_1().dynamically_equivalent().closed_form()?;
//! assert_eq!(format!("{:.3}", dem.links()[0].mass), "0.850");
//!
//! // Torque on the arm's joints alone turns the base backwards and leaves the angular momentum at zero.
//! let (q, rest) = (Vector3::new(0.0, 0.35, 0.35), Vector3::zeros());
//! let acceleration = dem.forward_dynamics(&q, &rest, &Vector3::new(0.0, 0.05, 0.02));
//! assert!(acceleration.x < 0.0 && acceleration.y > 0.0);
//! assert!(dem.angular_momentum(&q, &acceleration).abs() < 1e-16);
//! # Ok::<(), dem_model::ParameterError>(())
//! ```
//!
//! Source of the equations: Pazelli, Terra, Siqueira, *Experimental investigation on adaptive robust controller designs
//! applied to a free-floating space manipulator*, Control Engineering Practice 19 (2011) 395–408, called "the paper"
//! here. Units are SI throughout; angles are in rad.
//!
//! # Map
//!
//! | where | what |
//! |---|---|
//! | [`PlanarSpaceManipulator`], [`SpatialSpaceManipulator`] | space manipulators of any number of links, and the map (eq. 1) |
//! | [`PlanarDem`], [`SpatialDem`] | what the map gives; in the plane M and C for any number of links |
//! | [`ThreeLinkDem`] | the planar three-link DEM in closed form: M, C, dynamics, energy, momentum, kinematics |
//! | [`SerialManipulator`] | N joints of any axes, revolute or prismatic, on a base of 1, 3 or 6 degrees of freedom: M, C, reduced and recursive dynamics, regressor, generalised Jacobian, Euler angles |
//! | [`Partition`] | M and C cut into base and arm (eq. 3), the torques F and E (eq. 7), base elimination (eqs. 20, 21) |
//! | [`regressor`], [`InertialParameters`] | F = ΞΦ for the adaptive law, and M, C for estimated Φ |
//! | [`ReducedDynamics`] | the arm's dynamics with the cyclic base coordinate removed |
//! | [`ParameterError`] | why parameters are refused: which body, which field, what was found and expected |
//! | [`Scalar`] | the number types `f32` and `f64` |
//! | [`nalgebra`] | the crate of the vectors and matrices in this interface, in the version that it has |
//!
//! # Vocabulary
//!
//! - *Space manipulator*: spacecraft and arm, free-floating. Its parameters are primed in the paper: m'_i, I'_i, L_i, R_i.
//! - *DEM*: the dynamically equivalent manipulator, on a fixed base; its parameters are m_i, I_i, W_i, l_ci.
//! - *Links* count from 1: link 1 is the spacecraft or the DEM's *base*; the *arm* is link 2 onwards. Joint i is inboard
//!   of link i. Joint 1 is *passive*, the others *active*.
//! - *Fixed frame*: origin in joint 1; q = 0 stretches the arm along +x; positive angles turn counter-clockwise. Joint
//!   angles are relative to the link before, q_1 to +x.
//! - *Base acceleration, elimination, reduction*: the arm's torques depend on the base's acceleration. It can be
//!   measured, eliminated by the base's own equation (the base's velocity stays), or reduced (the angular momentum stays).
//!
//! # Not supported
//!
//! - Trees and closed loops of links, flexible links.
//! - Gravity and friction: a simulation adds them as generalised forces
//!   ([`ThreeLinkDem::centre_of_mass_jacobians`] helps with the first).
//! - Planar links whose centre of mass lies off the line through their joints, or beyond one of them.
//!
//! # Numbers
//!
//! Sines and cosines come from `libm` on every target and nothing allocates or panics on the way from a state to a
//! result, so that an x86-64 PC and a Cortex-M compute the same bits. Parameters are checked where they enter; a state
//! that is not finite gives results that are not finite.
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing, clippy::as_conversions)
)]

mod dem;
mod error;
mod geometry;
mod jacobian_sums;
mod scalar;
mod serial;
mod space_manipulator;
mod three_link;

pub use dem::{Dem, DemBase, DemLink, PlanarDem, SpatialDem};
pub use error::{Body, ParameterError, Requirement};
pub use geometry::Distance;
pub use nalgebra;
pub use scalar::Scalar;
pub use serial::{
    BaseFreedom, BaseMotion, EulerAngles, EulerSequence, FreeFloatingManipulator, GeneralisedJacobian, Joint,
    JointMotion, LINK_PARAMETERS, PlanarBaseManipulator, SerialAcceleration, SerialDynamics, SerialManipulator,
    SerialReduced, SerialRegressor, SerialState, SphericalBaseManipulator, ToolPose,
};
pub use space_manipulator::{
    PlanarSpaceManipulator, SpaceLink, SpaceManipulator, SpacecraftBody, SpatialSpaceManipulator,
};
pub use three_link::{
    EliminatedBase, InertialParameters, Partition, Pose, REGRESSOR_PARAMETERS, ReducedDynamics, ThreeLinkDem, regressor,
};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
