//! Space manipulators and their dynamically equivalent manipulators (DEM).
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing, clippy::as_conversions)
)]

mod error;
mod link;
pub mod planar;
mod scalar;
mod three_link;

pub use error::{Body, ParameterError, Requirement};
pub use link::{DemBase, DemLink};
pub use scalar::Scalar;
pub use three_link::{
    EliminatedBase, InertialParameters, Partition, Pose, REGRESSOR_PARAMETERS, ReducedDynamics, ThreeLinkDem, regressor,
};
