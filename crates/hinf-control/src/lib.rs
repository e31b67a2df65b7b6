//! Nonlinear H∞ control of free-floating space manipulators.
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing, clippy::as_conversions)
)]

mod attenuation;
mod catalogue;
mod controller;
mod indices;
mod limiter;
mod reference;
mod synthesis;
mod tracking_error;
mod weights;

pub use attenuation::ProvenAttenuation;
pub use catalogue::{Law, PublishedIndices};
pub use controller::*;
pub use indices::PerformanceIndices;
pub use limiter::{LimitedTorque, TorqueLimitError, TorqueLimiter, TorqueLimits};
pub use reference::{QuinticReference, ReferenceError};
pub use synthesis::{Synthesis, SynthesisError};
pub use tracking_error::TrackingError;
pub use weights::{PAPER_ATTENUATION_LEVEL, WeightReading, Weights};

/// The number nearest to `value`, for constants.
pub(crate) fn number<T: dem_model::Scalar>(value: f64) -> T {
    nalgebra::convert(value)
}
