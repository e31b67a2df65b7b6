//! The choices of an adaptive law.

use super::bound::{Ball, BoundError, ParameterBox, ParameterSet, is_finite};
use super::weight::{AdaptationWeight, ScalarWeight, SeparableWeight};
use dem_model::Scalar;
use nalgebra::SMatrix;

/// Whether Φ stands still while the torque is limited.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AntiWindup {
    /// Φ goes on, as in the paper.
    #[default]
    Off,
    /// Φ is not stepped over a cycle in which a joint's torque was limited: what the error says then is that the torque is
    /// short, not that Φ is wrong.
    FreezeWhileLimited,
}

/// What is done about the set that Φ should stay in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Bound<T: Scalar, const K: usize, const G: usize> {
    None,
    Alarm(ParameterSet<T, K, G>),
    Project(ParameterSet<T, K, G>),
}

/// The choices of an adaptive law: Φ(0), Z, bounds, anti-windup. Φ has G groups of K parameters, one below the other: a group
/// for each joint, or for each link; with G = 1 it is a plain vector.
///
/// ```
/// use hinf_control::adaptation::{Adaptation, AntiWindup, Ball, ScalarWeight};
/// use nalgebra::SVector;
/// let ball = Ball::new(SVector::zeros(), 2.0)?;
/// let adaptation = Adaptation::new(SVector::<f64, 14>::zeros(), ScalarWeight::new(10.0)?)?
///     .projected_onto_ball(ball)?
///     .with_anti_windup(AntiWindup::FreezeWhileLimited);
/// assert_eq!(adaptation.initial().norm(), 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Adaptation<T: Scalar, const K: usize, const G: usize = 1, Z = ScalarWeight<T>> {
    pub(super) initial: SMatrix<T, K, G>,
    pub(super) weight: Z,
    pub(super) bound: Bound<T, K, G>,
    pub(super) anti_windup: AntiWindup,
}

impl<T: Scalar, const K: usize, const G: usize, Z: AdaptationWeight<T, K, G>> Adaptation<T, K, G, Z> {
    /// The paper's: integration from Φ(0) = `initial` with the weight Z, nothing else.
    ///
    /// # Errors
    /// [`BoundError::NotFinite`] if `initial` is not finite.
    pub fn new(initial: SMatrix<T, K, G>, weight: Z) -> Result<Self, BoundError> {
        if is_finite(&initial) {
            Ok(Self { initial, weight, bound: Bound::None, anti_windup: AntiWindup::Off })
        } else {
            Err(BoundError::NotFinite)
        }
    }

    /// Raises [`at_bound`](crate::AdaptationStatus::at_bound) when Φ is on or beyond the border of `set`, and lets it go on.
    ///
    /// # Errors
    /// [`BoundError::InitialOutside`] if Φ(0) is not in `set`.
    pub fn with_alarm_at(self, set: ParameterSet<T, K, G>) -> Result<Self, BoundError> {
        self.check_initial(&set)?;
        Ok(Self { bound: Bound::Alarm(set), ..self })
    }

    /// Keeps Φ in `ball`. [`Ball`] is a ball in the metric of Z, so that inequality 12 survives where T11 = tI.
    ///
    /// # Errors
    /// [`BoundError::InitialOutside`] if Φ(0) is not in `ball`.
    pub fn projected_onto_ball(self, ball: Ball<T, K, G>) -> Result<Self, BoundError> {
        let set = ParameterSet::Ball(ball);
        self.check_initial(&set)?;
        Ok(Self { bound: Bound::Project(set), ..self })
    }

    /// Keeps Φ in `bounds`. Only for a Z without off-diagonal elements, so that inequality 12 survives, for any diagonal T11.
    ///
    /// # Errors
    /// [`BoundError::InitialOutside`] if Φ(0) is not in `bounds`.
    pub fn projected_onto_box(self, bounds: ParameterBox<T, K, G>) -> Result<Self, BoundError>
    where
        Z: SeparableWeight<T, K, G>,
    {
        let set = ParameterSet::Box(bounds);
        self.check_initial(&set)?;
        Ok(Self { bound: Bound::Project(set), ..self })
    }

    /// The same with or without anti-windup.
    #[must_use]
    pub fn with_anti_windup(self, anti_windup: AntiWindup) -> Self {
        Self { anti_windup, ..self }
    }

    /// Φ(0).
    pub fn initial(&self) -> &SMatrix<T, K, G> {
        &self.initial
    }

    /// Z.
    pub fn weight(&self) -> &Z {
        &self.weight
    }

    fn check_initial(&self, set: &ParameterSet<T, K, G>) -> Result<(), BoundError> {
        if set.contains(&self.initial, &self.weight) { Ok(()) } else { Err(BoundError::InitialOutside) }
    }
}
