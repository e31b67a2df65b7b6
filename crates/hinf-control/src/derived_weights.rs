//! Weights made for a model, so that an unknown arm does not run with the paper's.
//!
//! Around its start an arm under a law obeys M̄ ṡ = −R⁻¹ s + d, s = q̃̇ + Λ q̃. With D the diagonal of M̄ at the start pose:
//!
//! - R⁻¹ = κD: each joint is braked in proportion to what it has to move. κ = ω λ_min(D^−½ M̄ D^−½) makes the fastest pole
//!   λ_max(M̄⁻¹R⁻¹) equal to ω = [`FASTEST_POLE`], which a loop of 3 ms samples some twice in a time constant.
//! - γ² = max R_i / 0.625, as in the paper's design (2.5 of 4).
//! - Q1ᵀQ1 = R⁻¹ − I/γ² makes T11 = I, so that the theorem holds with γ itself, also for laws whose joints share parameters.
//! - Q2ᵀQ2 = λ² Q1ᵀQ1 makes Λ = λI with λ = [`ERROR_RATE`].
//! - An estimate that follows Φ̇ = −Z⁻¹Ξᵀs closes a loop M̄ s̈ + R⁻¹ ṡ + ΞΞᵀ/z s = 0. Z = zI with z = 4 ‖Ξ‖²/(κ² min D_i)
//!   keeps it from overshooting in every joint: ‖Ξ‖² at most 7 for networks, about 1 for fuzzy rules, and for inertial
//!   parameters that of 1 rad/s² in all joints.
//! - Under a bound, networks and rules may learn what moves the heaviest joint at [`BOUND_ACCELERATION`], and an inertial
//!   parameter may go as far as the largest of them is.
//!
//! Chosen; a robot's own weights may be better.

use crate::law_definition::{AdaptationSettings, CatalogueModel, DerivedWeights, StateWeights};
use crate::spectral::extreme_eigenvalues;
use crate::{ControllerSettings, NEURONS, SymmetricWeight};
use nalgebra::{ComplexField, SMatrix, SVector};

/// ω, 1/s: Δt ω = 0.48 at 3 ms, a quarter of what an undelayed sampled loop bears.
pub const FASTEST_POLE: f64 = 160.0;
/// λ, 1/s: between the paper's 3.3 and 3.75 for controller 1.
pub const ERROR_RATE: f64 = 3.5;
/// What networks and rules may learn under a bound, rad/s².
pub const BOUND_ACCELERATION: f64 = 10.0;
/// max R_i over γ².
const CONTROL_SHARE: f64 = 0.625;
/// The most that Σ ξ² of a network's neurons is, each within ±1.
#[allow(clippy::as_conversions)] // Exact.
const NEURONS_SQUARED: f64 = NEURONS as f64;
/// Damping ratio 1 of a second-order system: c² = 4 k m.
const CRITICAL: f64 = 4.0;

/// The generalised inertia of the model at the start pose is not finite or not positive definite.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the generalised inertia at the start pose is not positive definite: no weights can be derived from it")]
pub struct NoDerivedWeights;

impl<const N: usize> ControllerSettings<N> {
    /// Settings of every law with weights made for `model` at the pose `start` (rad): see [`ERROR_RATE`] and
    /// [`FASTEST_POLE`]. Laws with a model have it in its reduced form.
    ///
    /// ```
    /// use dem_model::{PlanarBaseManipulator, PlanarSpaceManipulator};
    /// use hinf_control::nalgebra::Vector2;
    /// use hinf_control::{ControllerSettings, Law, Synthesis};
    /// let arm = PlanarBaseManipulator::planar(&PlanarSpaceManipulator::<f64, 2>::table_1().dynamically_equivalent());
    /// let settings = ControllerSettings::derived(&arm, &Vector2::new(0.35, 0.35))?;
    /// let design = Synthesis::new(&settings.weights::<f64>(Law::Nonlinear))?;
    /// assert!((design.error_rate().m11 - 3.5).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`NoDerivedWeights`] if the model has no positive definite inertia at `start`.
    pub fn derived<const B: usize, M>(model: &M, start: &SVector<f64, N>) -> Result<Self, NoDerivedWeights>
    where
        M: CatalogueModel<f64, N, B>,
    {
        Ok(Self::from_derived(&derived_weights(model, start).ok_or(NoDerivedWeights)?))
    }
}

fn derived_weights<const N: usize, const B: usize, M>(model: &M, start: &SVector<f64, N>) -> Option<DerivedWeights<N>>
where
    M: CatalogueModel<f64, N, B>,
{
    let inertia = model.generalised_inertia(start)?;
    let diagonal = inertia.diagonal();
    let positive = diagonal.iter().all(|entry| *entry > 0.0 && entry.is_finite());
    if !positive || !inertia.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    let scale = SMatrix::<f64, N, N>::from_diagonal(&diagonal.map(|entry| ComplexField::sqrt(entry).recip()));
    let smallest = extreme_eigenvalues(&(scale * inertia * scale)).0;
    let rate = FASTEST_POLE * Some(smallest).filter(|smallest| *smallest > 0.0)?;
    let control = diagonal.map(|entry| (rate * entry).recip());
    let level_squared = control.max() / CONTROL_SHARE;
    let velocity = control.map(|control| control.recip() - level_squared.recip());
    let adapts = |regressor_squared: f64, bound: f64| AdaptationSettings {
        z: CRITICAL * regressor_squared / (rate * rate * diagonal.min()),
        bound,
    };
    let scale = model.inertial_scale(start);
    let learnt_torque = BOUND_ACCELERATION * diagonal.max();
    let weight = |values: SVector<f64, N>| SymmetricWeight::Diagonal(values.into());
    Some(DerivedWeights {
        attenuation_level: ComplexField::sqrt(level_squared),
        r: weight(control),
        state: StateWeights { q1: weight(velocity), q2: weight(velocity * (ERROR_RATE * ERROR_RATE)) },
        inertial: adapts(scale.regressor_squared, scale.largest_parameter),
        networks: adapts(NEURONS_SQUARED, learnt_torque),
        rules: adapts(1.0, learnt_torque),
    })
}
