//! Nonlinear H∞ control of free-floating space manipulators: six laws of one family, what they are designed with, and what
//! keeps them safe. `no_std`, no allocation, generic over `f32` and `f64`.
//!
//! Paper: Pazelli, Terra, Siqueira, *Experimental investigation on adaptive robust controller designs applied to a free-floating
//! space manipulator*, Control Engineering Practice 19 (2011) 395–408. Equation numbers are the paper's.
//!
//! # One step of a closed loop
//!
//! ```
//! use dem_model::ThreeLinkDem;
//! use hinf_control::{
//!     BaseAcceleration, BaseMeasurement, Controller, ControllerSettings, Law, Measurement, NonlinearHInfinity,
//!     QuinticReference, Synthesis, TorqueLimiter, TorqueLimits,
//! };
//! use nalgebra::Vector2;
//!
//! // Design, once: every reason to refuse comes out here.
//! let weights = ControllerSettings::default().weights(Law::Nonlinear);
//! let synthesis = Synthesis::new(&weights)?;
//! let mut law = NonlinearHInfinity::new(ThreeLinkDem::<f64>::table_2(), synthesis, BaseAcceleration::Reduced);
//! let mut limiter = TorqueLimiter::new(TorqueLimits::new(Vector2::new(0.3, 0.3))?);
//! let reference = QuinticReference::paper();
//!
//! // Each cycle: nothing here allocates or reads a clock; only a torque that is no number is an error.
//! let (time, period) = (0.003, 0.003);
//! let measurement = Measurement {
//!     position: *reference.start(),
//!     velocity: Vector2::zeros(),
//!     base: BaseMeasurement::at_rest(),
//! };
//! let command = law.update(&measurement, &reference.at(time), period);
//! let torque = limiter.limit(command.torque, period)?;
//! law.limited(torque.limited);
//! assert_eq!(torque.applied, command.torque);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Map
//!
//! | to | there is |
//! |---|---|
//! | say where to go | [`QuinticReference`] (eq. 47) |
//! | choose weights | [`Weights`], [`WeightReading`], the paper's in [`ControllerSettings`] |
//! | solve for the feedback | [`Synthesis`] (eqs. 6, 9, 10), [`SynthesisError`] |
//! | know what is proven | [`Synthesis::proven_attenuation_level`] |
//! | control with a model | [`NonlinearHInfinity`] (controller 1), [`PdComputedTorque`] (baseline) |
//! | control and learn | [`Adaptive`] (2), [`Neural`] (3), [`NeuralModel`] (4), [`Fuzzy`] (5), [`FuzzyModel`] (6) |
//! | shape what is learnt | [`adaptation`], [`TanhNetworks`], [`FuzzySystem`] |
//! | choose a law at run time | [`Law`], [`ControllerSettings`], [`AnyController`] |
//! | limit torques | [`TorqueLimiter`] |
//! | disturb a run as the paper does | [`Disturbance`] (eq. 48) |
//! | judge a run | [`PerformanceIndices`] (section 4) |
//! | replay a run | [`Controller::freeze`], [`Controller::thaw`] |
//!
//! # Vocabulary
//!
//! - *Active joints*, m: those of the arm, which have motors; joints 2 and 3 of the paper's. *Base*, b: the spacecraft, joint 1
//!   of its dynamically equivalent manipulator, which has none. N active joints, B degrees of freedom of the base.
//! - *Tracking error* x̃ = [q̃̇; q̃]: measured minus desired, velocities first ([`TrackingError`]).
//! - *Attenuation level* γ: the penalty ∫ x̃ᵀQx̃ + uᵀRu stays below γ² times the disturbance's ∫ ωᵀω, ω = T11 d (eq. 8).
//! - *Control input* u = −R⁻¹BᵀT0x̃ (eq. 10): what the criterion weighs. The torque adds what the model or Φ supplies.
//! - Λ = T11⁻¹T12: the *error rate*; s = q̃̇ + Λq̃: the *filtered error*; x1 = q̈ᵈ − Λq̃̇ and x2 = q̇ᵈ − Λq̃: the
//!   *auxiliary motion*.
//! - F: the torque of the arm's own inertia along the auxiliary motion; E: the base's part of it (eq. 7).
//! - Φ, Ξ, Z: *parameters*, *regressor* and *adaptation weight* of an adaptive law.
//!
//! # What the base does to the arm
//!
//! The paper's laws need E, and with it the base acceleration, or leave it to be learnt. [`BaseAcceleration`] makes the way
//! explicit. Its two `reduced` modes, and [`NominalForm::Reduced`], are ours: from rest they need no data of the base, and keep
//! the bound that elimination (eqs. 20, 21) loses. They restore the guarantee; with friction they are not the best in L2.
//!
//! # Adding a law
//!
//! 1. Write `laws/yours.rs`. Open it with the equations. It has the law, which implements [`Controller`], and its `Settings`,
//!    which implement [`LawDefinition`]. A law that learns holds a [`adaptation::ParameterEstimator`] and works in its
//!    `cycle`: `laws/neural.rs` is the shortest example. One that does not checks its inputs with [`is_usable`] and ends
//!    with [`Command::or_fallback`]: `laws/computed_torque.rs`.
//! 2. Add a line to the list in `laws/mod.rs`.
//! 3. The tests of `tests/every_law.rs` run over [`Law::ALL`] and take it in: finite outputs, freezing, f32. If theory promises
//!    a level, `tests/dissipation.rs` shows how to check it.
//!
//! # Not here
//!
//! Estimating velocities from encoder counts (`uarm-io`), training fuzzy sets (`anfis`), plants (`uarm-sim`).
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing, clippy::as_conversions)
)]

pub mod adaptation;
mod arm_model;
mod attenuation;
mod base_acceleration;
mod catalogue;
mod controller;
mod derived_weights;
mod disturbance;
mod fuzzy_system;
mod gains;
mod indices;
mod joint_regressor;
mod law_definition;
pub mod laws;
mod limiter;
mod neural_network;
mod nominal_model;
mod reference;
mod spectral;
mod symmetric_weight;
mod synthesis;
mod synthesis_error;
mod tracking_error;
mod weights;

pub use dem_model;
pub use nalgebra;

pub use arm_model::{ArmModel, LinearModel, Momentum};
pub use attenuation::ProvenAttenuation;
pub use base_acceleration::{AdaptiveBaseAcceleration, BaseAcceleration, UnsupportedBaseAcceleration};
pub use controller::*;
pub use derived_weights::{BOUND_ACCELERATION, ERROR_RATE, FASTEST_POLE, NoDerivedWeights};
pub use disturbance::Disturbance;
pub use fuzzy_system::{
    BellError, BellShape, FUZZY_PARAMETERS, Firing, FuzzyRegressor, FuzzySets, FuzzySystem, GeneralisedBell, RULES,
    SETS,
};
pub use gains::{GainError, PdGains};
pub use indices::PerformanceIndices;
pub use joint_regressor::JointRegressor;
pub use law_definition::{
    AdaptationGuard, AdaptationSettings, BuildContext, BuildError, CatalogueModel, DerivedWeights, InertialScale,
    LawDefinition, LawVariant, PaperArm, PaperWeights, PublishedIndices, StateWeights, VariantOrigin,
};
pub use laws::adaptive::{Adaptive, SerialAdaptive};
pub use laws::computed_torque::PdComputedTorque;
pub use laws::fuzzy::Fuzzy;
pub use laws::fuzzy_model::FuzzyModel;
pub use laws::neural::Neural;
pub use laws::neural_model::NeuralModel;
pub use laws::nonlinear::NonlinearHInfinity;
pub use laws::{AnyController, ControllerSettings, Law};
pub use limiter::{LimitedTorque, TorqueLimitError, TorqueLimiter, TorqueLimits, TorqueNotFinite};
pub use neural_network::{HiddenLayer, NETWORK_QUANTITIES, NEURONS, NetworkError, TanhNetworks};
pub use nominal_model::{NominalForm, NominalModel};
pub use reference::{QuinticReference, ReferenceError};
pub use spectral::MOST_JOINTS;
pub use symmetric_weight::SymmetricWeight;
pub use synthesis::{AuxiliaryMotion, StateWeight, Synthesis};
pub use synthesis_error::SynthesisError;
pub use tracking_error::TrackingError;
pub use weights::{PAPER_ATTENUATION_LEVEL, WeightReading, Weights};

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
