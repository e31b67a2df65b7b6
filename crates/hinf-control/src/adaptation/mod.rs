//! Adaptation: the parameters Φ, how they are stepped, and what keeps them where they belong.
//!
//! Every adaptive law learns by Φ̇ = −Z⁻¹Ξᵀ T11ᵀBᵀT0x̃ (paper eqs. 18, 30, 36, 42, 45). [`Adaptation`] holds the choices,
//! [`ParameterEstimator`] the running state. The paper's laws are plain integrators: projection and anti-windup are ours,
//! off unless asked for.

mod bound;
mod choices;
mod estimator;
mod weight;

pub use bound::{Ball, BoundError, ParameterBox, ParameterSet};
pub use choices::{Adaptation, AntiWindup};
pub use estimator::{AdaptiveOutput, ParameterEstimator};
pub use weight::{AdaptationWeight, DiagonalWeight, FullWeight, ScalarWeight, SeparableWeight, WeightError};
