//! Known convex sets for Φ: what is projected onto, and why inequality 12 survives it.
//!
//! The laws as printed are integrators: a bounded disturbance, friction or saturation makes Φ drift. Let Φ* lie in a closed
//! convex set S, and let P be the projection onto S in the metric of Z, P(Φ) = argmin_{φ∈S} ‖φ − Φ‖_Z with
//! ‖v‖²_Z = vᵀZv. Each step replaces Φ⁺ = Φ + Δt Φ̇ by P(Φ⁺).
//!
//! *Inequality 12 survives.* The storage function is V = V_x̃ + ½κ‖Φ − Φ*‖²_Z, and only its second term sees the projection.
//! For every point y of S, the projection x = P(Φ⁺) satisfies ⟨Φ⁺ − x, y − x⟩_Z ≤ 0: otherwise a short way from x to
//! y would lead nearer to Φ⁺ while staying in the convex S. With y = Φ*:
//!
//! ‖Φ⁺ − Φ*‖²_Z = ‖Φ⁺ − x‖²_Z + ‖x − Φ*‖²_Z − 2⟨Φ⁺ − x, Φ* − x⟩_Z ≥ ‖x − Φ*‖²_Z.
//!
//! So P never raises V: whatever bound the unprojected step meets, the projected one meets too, sample by sample, and
//! with Δt → 0 along the motion.
//!
//! *The metric matters*: it must be that of V, and a projection in another one can raise V.
//!
//! - Clamping to a [`ParameterBox`] minimises each term of Σ z_i(φ_i − Φ⁺_i)² by itself, and so is the projection in every
//!   diagonal metric at once. It is offered for a [`SeparableWeight`](super::SeparableWeight) only: with a full Z the
//!   argument fails.
//! - A [`Ball`] is a ball *in the metric of Z*: its projection is radial, Φ = c + (Φ⁺ − c)·r/‖Φ⁺ − c‖_Z, for any Z. For
//!   Z = zI it is the Euclidean ball of radius r/√z.
//! - Where T11 = diag(t_k) is not tI, the neural and fuzzy laws, whose joints have parameters of their own, have the
//!   storage ½Σ_k (c/t_k²)‖Φ_k − Φ_k*‖²_Z, a metric other than that of Z. The box is covered, one ball over both
//!   joints is not. Table 3 is such a case: take the box there.
//!
//! If Φ* lies outside S, what is proven holds with the nearest point of S in its place, and the difference is part of the
//! disturbance.

use super::weight::AdaptationWeight;
use dem_model::Scalar;
use nalgebra::SMatrix;

/// Why a set, or a Φ(0) for it, is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BoundError {
    /// A radius is not a positive finite number.
    #[error("the radius of the parameter ball is {found}, expected a positive finite number")]
    Radius {
        /// What was found.
        found: f64,
    },
    /// A centre, lower or upper bound is NaN or infinite.
    #[error("the bounds of a parameter set must be finite numbers")]
    NotFinite,
    /// A lower bound lies above its upper bound.
    #[error("parameter {index} has a lower bound above its upper bound")]
    Empty {
        /// Which parameter, from 0.
        index: usize,
    },
    /// Φ(0) is not in the set.
    #[error("the initial parameters lie outside their set")]
    InitialOutside,
}

/// All Φ with ‖Φ − c‖_Z ≤ r: a ball in the metric of Z, an ellipsoid in that of Euclid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball<T: Scalar, const K: usize, const G: usize = 1> {
    centre: SMatrix<T, K, G>,
    radius: T,
}

impl<T: Scalar, const K: usize, const G: usize> Ball<T, K, G> {
    /// The ball with that centre and that radius in the metric of Z.
    ///
    /// # Errors
    /// [`BoundError::Radius`] or [`BoundError::NotFinite`].
    pub fn new(centre: SMatrix<T, K, G>, radius: T) -> Result<Self, BoundError> {
        if !(radius.is_finite() && radius > T::zero()) {
            return Err(BoundError::Radius { found: radius.to_f64() });
        }
        if !is_finite(&centre) {
            return Err(BoundError::NotFinite);
        }
        Ok(Self { centre, radius })
    }

    /// Its centre.
    pub fn centre(&self) -> &SMatrix<T, K, G> {
        &self.centre
    }

    /// Its radius in the metric of Z.
    pub fn radius(&self) -> T {
        self.radius
    }
}

/// All Φ with lower ≤ Φ ≤ upper, element by element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterBox<T: Scalar, const K: usize, const G: usize = 1> {
    lower: SMatrix<T, K, G>,
    upper: SMatrix<T, K, G>,
}

impl<T: Scalar, const K: usize, const G: usize> ParameterBox<T, K, G> {
    /// The box between two corners.
    ///
    /// # Errors
    /// [`BoundError::Empty`] or [`BoundError::NotFinite`].
    pub fn new(lower: SMatrix<T, K, G>, upper: SMatrix<T, K, G>) -> Result<Self, BoundError> {
        if !(is_finite(&lower) && is_finite(&upper)) {
            return Err(BoundError::NotFinite);
        }
        match lower.iter().zip(upper.iter()).position(|(lower, upper)| lower > upper) {
            Some(index) => Err(BoundError::Empty { index }),
            None => Ok(Self { lower, upper }),
        }
    }

    /// The smallest allowed parameters.
    pub fn lower(&self) -> &SMatrix<T, K, G> {
        &self.lower
    }

    /// The largest allowed parameters.
    pub fn upper(&self) -> &SMatrix<T, K, G> {
        &self.upper
    }
}

/// A closed convex set of parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParameterSet<T: Scalar, const K: usize, const G: usize = 1> {
    /// A ball in the metric of Z.
    Ball(Ball<T, K, G>),
    /// A box.
    Box(ParameterBox<T, K, G>),
}

impl<T: Scalar, const K: usize, const G: usize> ParameterSet<T, K, G> {
    /// Whether the set, border and all, holds `parameters`.
    pub fn contains(&self, parameters: &SMatrix<T, K, G>, weight: &impl AdaptationWeight<T, K, G>) -> bool {
        match self {
            Self::Ball(ball) => weight.norm_squared(&(parameters - ball.centre)) <= ball.radius * ball.radius,
            Self::Box(bounds) => bounds.all(parameters, |lower, value, upper| lower <= value && value <= upper),
        }
    }

    /// Whether the inside of the set holds `parameters`.
    pub fn contains_inside(&self, parameters: &SMatrix<T, K, G>, weight: &impl AdaptationWeight<T, K, G>) -> bool {
        match self {
            Self::Ball(ball) => weight.norm_squared(&(parameters - ball.centre)) < ball.radius * ball.radius,
            Self::Box(bounds) => bounds.all(parameters, |lower, value, upper| lower < value && value < upper),
        }
    }

    /// Moves `parameters` to the nearest point of the set in the metric of Z; tells whether they were elsewhere. For a box, Z
    /// must be separable.
    pub(super) fn project(&self, parameters: &mut SMatrix<T, K, G>, weight: &impl AdaptationWeight<T, K, G>) -> bool {
        match self {
            Self::Ball(ball) => {
                let before = core::mem::replace(parameters, ball.nearest(parameters, weight));
                before != *parameters
            }
            Self::Box(bounds) => bounds.clamp(parameters),
        }
    }
}

impl<T: Scalar, const K: usize, const G: usize> Ball<T, K, G> {
    fn nearest(&self, parameters: &SMatrix<T, K, G>, weight: &impl AdaptationWeight<T, K, G>) -> SMatrix<T, K, G> {
        let offset = parameters - self.centre;
        let distance = weight.norm_squared(&offset).sqrt();
        if distance > self.radius { self.centre + offset * (self.radius / distance) } else { *parameters }
    }
}

impl<T: Scalar, const K: usize, const G: usize> ParameterBox<T, K, G> {
    /// Whether every element and its bounds are as `holds` wants them. Looks at all, so that it is compiled for several at a time.
    fn all(&self, parameters: &SMatrix<T, K, G>, holds: impl Fn(T, T, T) -> bool) -> bool {
        let corners = self.lower.as_slice().iter().zip(self.upper.as_slice());
        let elements = corners.zip(parameters.as_slice());
        elements.fold(true, |all, ((lower, upper), value)| all & holds(*lower, *value, *upper))
    }

    /// True if that changed an element.
    fn clamp(&self, parameters: &mut SMatrix<T, K, G>) -> bool {
        let corners = self.lower.as_slice().iter().zip(self.upper.as_slice());
        let elements = parameters.as_mut_slice().iter_mut().zip(corners);
        elements.fold(false, |moved, (element, (lower, upper))| {
            let raised = if *element < *lower { *lower } else { *element };
            let nearest = if raised > *upper { *upper } else { raised };
            moved | (core::mem::replace(element, nearest) != nearest)
        })
    }
}

pub(super) fn is_finite<T: Scalar, const K: usize, const G: usize>(parameters: &SMatrix<T, K, G>) -> bool {
    // Without branches, so that it is compiled for several elements at a time.
    parameters.as_slice().iter().fold(true, |finite, parameter| finite & parameter.is_finite())
}
