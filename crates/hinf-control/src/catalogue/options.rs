//! The choices that a robot file or a command line makes, for any law.

use super::Law;
use crate::adaptation::{
    Adaptation, AntiWindup, Ball, BoundError, DiagonalWeight, ParameterBox, ParameterSet, WeightError,
};
use crate::{BaseAcceleration, Firing, FuzzySets, FuzzySystem, GainError, NominalForm, SynthesisError, TanhNetworks};
use dem_model::Scalar;
use nalgebra::SVector;

/// Z, as a file can hold it. A full Z goes to the law's own type, with
/// [`FullWeight`](crate::adaptation::FullWeight).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AdaptationWeights<'a, T: Scalar> {
    /// Z = zI.
    Scalar(T),
    /// Z = diag(z), as many numbers as the law has parameters.
    Diagonal(&'a [T]),
}

/// The set that Φ should stay in.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ParameterLimits<'a, T: Scalar> {
    /// None, as in the paper.
    #[default]
    None,
    /// All Φ with ‖Φ − Φ(0)‖_Z ≤ radius.
    Ball {
        /// In the metric of Z: for Z = zI, √z times the Euclidean one.
        radius: T,
    },
    /// All Φ between two corners.
    Box {
        /// As many numbers as the law has parameters.
        lower: &'a [T],
        /// As many numbers as the law has parameters.
        upper: &'a [T],
    },
}

/// What happens at the border of that set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LimitAction {
    /// Φ is projected onto the set.
    #[default]
    Project,
    /// Φ goes on, with an alarm.
    Alarm,
}

/// Everything that can be chosen about a law besides the model and the weights. What a law does not have, it ignores, but
/// for a base-acceleration mode that it cannot offer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControllerOptions<'a, T: Scalar> {
    /// For `nonlinear` and `adaptive`.
    pub base_acceleration: BaseAcceleration,
    /// For `neural-model`, `fuzzy-model` and `computed-torque`.
    pub nominal_form: NominalForm,
    /// Z.
    pub adaptation_weights: AdaptationWeights<'a, T>,
    /// Φ(0); `None` for the paper's: nominal for `adaptive`, zero for the others.
    pub initial_parameters: Option<&'a [T]>,
    /// Where Φ should stay.
    pub parameter_limits: ParameterLimits<'a, T>,
    /// What happens where it would not.
    pub limit_action: LimitAction,
    /// Whether Φ stands still while the torque is limited.
    pub anti_windup: AntiWindup,
    /// For `neural` and `neural-model`.
    pub networks: TanhNetworks<T>,
    /// For `fuzzy` and `fuzzy-model`.
    pub fuzzy_system: FuzzySystem<T>,
}

impl<T: Scalar> ControllerOptions<'_, T> {
    /// The paper's choices for `law`: Z of Table 3, no projection, no anti-windup, the base acceleration eliminated, networks
    /// of ones, minimum firing over the untrained sets (the trained ones are lost).
    pub fn paper(law: Law) -> Self {
        // A law that does not adapt never looks at its Z.
        let z = law.published_adaptation_weight().unwrap_or(1.0);
        Self {
            base_acceleration: BaseAcceleration::Eliminated,
            nominal_form: NominalForm::ActiveJoints,
            adaptation_weights: AdaptationWeights::Scalar(T::constant(z)),
            initial_parameters: None,
            parameter_limits: ParameterLimits::None,
            limit_action: LimitAction::Project,
            anti_windup: AntiWindup::Off,
            networks: TanhNetworks::paper(),
            fuzzy_system: FuzzySystem::new(FuzzySets::untrained(), Firing::Minimum),
        }
    }

    /// The adaptation of a law with P parameters that starts at `default` unless told otherwise.
    pub(super) fn adaptation<const P: usize>(
        &self,
        default: SVector<T, P>,
    ) -> Result<Adaptation<T, P, DiagonalWeight<T, P>>, BuildError> {
        let initial = self.initial_parameters.map_or(Ok(default), vector)?;
        let weight = match self.adaptation_weights {
            AdaptationWeights::Scalar(z) => SVector::repeat(z),
            AdaptationWeights::Diagonal(z) => vector(z)?,
        };
        let adaptation = Adaptation::new(initial, DiagonalWeight::new(weight)?)?.with_anti_windup(self.anti_windup);
        let set = match self.parameter_limits {
            ParameterLimits::None => return Ok(adaptation),
            ParameterLimits::Ball { radius } => ParameterSet::Ball(Ball::new(initial, radius)?),
            ParameterLimits::Box { lower, upper } => {
                ParameterSet::Box(ParameterBox::new(vector(lower)?, vector(upper)?)?)
            }
        };
        Ok(match (self.limit_action, set) {
            (LimitAction::Alarm, set) => adaptation.with_alarm_at(set)?,
            (LimitAction::Project, ParameterSet::Ball(ball)) => adaptation.projected_onto_ball(ball)?,
            (LimitAction::Project, ParameterSet::Box(bounds)) => adaptation.projected_onto_box(bounds)?,
        })
    }
}

fn vector<T: Scalar, const P: usize>(values: &[T]) -> Result<SVector<T, P>, BuildError> {
    if values.len() == P {
        Ok(SVector::from_column_slice(values))
    } else {
        Err(BuildError::ParameterCount { expected: P, found: values.len() })
    }
}

/// Why a controller cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// The weights have no solution.
    #[error(transparent)]
    Synthesis(#[from] SynthesisError),
    /// Z is refused.
    #[error(transparent)]
    Weight(#[from] WeightError),
    /// Φ(0) or its set is refused.
    #[error(transparent)]
    Bound(#[from] BoundError),
    /// The weights leave the baseline without gains.
    #[error(transparent)]
    Gain(#[from] GainError),
    /// A list of parameters has the wrong length.
    #[error("found {found} numbers, this law has {expected} parameters")]
    ParameterCount {
        /// Parameters of the law.
        expected: usize,
        /// Numbers found.
        found: usize,
    },
    /// `adaptive` has no reduced form: M̄ is rational in Φ.
    #[error("the adaptive law has no reduced form; expected the base acceleration measured, eliminated or omitted")]
    AdaptiveReduced,
}
