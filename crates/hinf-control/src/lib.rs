//! Nonlinear H∞ control of free-floating space manipulators.
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing, clippy::as_conversions)
)]

pub mod adaptation;
mod attenuation;
mod catalogue;
mod controller;
mod fuzzy_system;
mod indices;
mod laws;
mod limiter;
mod neural_network;
mod reference;
mod small_matrix;
mod synthesis;
mod synthesis_error;
mod tracking_error;
mod weights;

pub use attenuation::ProvenAttenuation;
pub use catalogue::{
    AdaptationWeights, AnyController, BuildError, ControllerOptions, Law, LimitAction, ParameterLimits,
    PublishedIndices,
};
pub use controller::*;
pub use fuzzy_system::{
    BellError, FUZZY_PARAMETERS, Firing, FuzzyRegressor, FuzzySets, FuzzySystem, GeneralisedBell, RULES, SETS,
};
pub use indices::PerformanceIndices;
pub use laws::{
    Adaptive, AdaptiveBaseAcceleration, BaseAcceleration, Fuzzy, FuzzyModel, GainError, Neural, NeuralModel,
    NominalForm, NominalModel, NonlinearHInfinity, PdComputedTorque, PdGains,
};
pub use limiter::{LimitedTorque, TorqueLimitError, TorqueLimiter, TorqueLimits};
pub use neural_network::{NETWORK_INPUTS, NETWORK_PARAMETERS, NEURONS, NetworkError, TanhNetworks};
pub use reference::{QuinticReference, ReferenceError};
pub use synthesis::{AuxiliaryMotion, Synthesis};
pub use synthesis_error::SynthesisError;
pub use tracking_error::TrackingError;
pub use weights::{PAPER_ATTENUATION_LEVEL, WeightReading, Weights};
