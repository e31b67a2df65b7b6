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
//!     BaseAcceleration, BaseMeasurement, Controller, Law, Measurement, NonlinearHInfinity, QuinticReference, Synthesis,
//!     TorqueLimiter, TorqueLimits, WeightReading, Weights,
//! };
//! use nalgebra::Vector2;
//!
//! // Design, once: every reason to refuse comes out here.
//! let weights = Weights::table_3(Law::Nonlinear, WeightReading::Blocks);
//! let synthesis = Synthesis::new(&weights)?;
//! let mut law = NonlinearHInfinity::new(ThreeLinkDem::<f64>::table_2(), synthesis, BaseAcceleration::Reduced);
//! let mut limiter = TorqueLimiter::new(TorqueLimits::new(Vector2::new(0.3, 0.3))?);
//! let reference = QuinticReference::paper();
//!
//! // Each cycle: nothing here fails, allocates or reads a clock.
//! let (time, period) = (0.003, 0.003);
//! let measurement = Measurement {
//!     position: *reference.start(),
//!     velocity: Vector2::zeros(),
//!     base: BaseMeasurement { position: 0.0, velocity: 0.0, acceleration: 0.0 },
//! };
//! let command = law.update(&measurement, &reference.at(time), period);
//! let torque = limiter.limit(command.torque, period);
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
//! | choose weights | [`Weights`], [`WeightReading`], the paper's in [`Weights::table_3`] |
//! | solve for the feedback | [`Synthesis`] (eqs. 6, 9, 10), [`SynthesisError`] |
//! | know what is proven | [`Synthesis::proven_attenuation_level`] |
//! | control with a model | [`NonlinearHInfinity`] (controller 1), [`PdComputedTorque`] (baseline) |
//! | control and learn | [`Adaptive`] (2), [`Neural`] (3), [`NeuralModel`] (4), [`Fuzzy`] (5), [`FuzzyModel`] (6) |
//! | shape what is learnt | [`adaptation`], [`TanhNetworks`], [`FuzzySystem`] |
//! | choose a law at run time | [`Law`], [`AnyController`], [`ControllerOptions`] |
//! | limit torques | [`TorqueLimiter`] |
//! | disturb a run as the paper does | [`Disturbance`] (eq. 48) |
//! | judge a run | [`PerformanceIndices`] (section 4) |
//! | replay a run | [`Controller::freeze`], [`Controller::thaw`] |
//!
//! # Vocabulary
//!
//! - *Active joints*, m: joints 2 and 3, which have motors. *Base*, b: the spacecraft, joint 1 of its dynamically equivalent
//!   manipulator, which has none.
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
//! 1. Write `laws/yours.rs`. Open it with the equations. Implement [`Controller`]: check inputs with [`is_usable`], end with
//!    [`Command::or_fallback`]. A law that learns holds a [`adaptation::ParameterEstimator`] and gets stepping, projection,
//!    anti-windup and freezing from it: `step`, use `parameters`, `learn`. `laws/neural.rs` is the shortest example,
//!    `laws/computed_torque.rs` the one without learning.
//! 2. Add a variant to [`Law`]. The compiler then names each match of the module `catalogue` that has to know it.
//! 3. The tests of `tests/every_law.rs` run over [`Law::ALL`] and take it in: finite outputs, freezing, f32. If theory promises
//!    a level, `tests/dissipation.rs` shows how to check it.
//!
//! # Not here
//!
//! Estimating velocities from encoder counts (`uarm-io`), training fuzzy sets (`anfis`), plants (`uarm-sim`), arms of other than two active
//! joints.
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
mod disturbance;
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
pub use disturbance::Disturbance;
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
