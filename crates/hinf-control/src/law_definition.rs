//! What a law tells the catalogue of itself, and what it is built with.

use crate::adaptation::{Adaptation, AntiWindup, BoundError, ParameterBox, ScalarWeight, WeightError};
use crate::arm_model::ArmModel;
use crate::base_acceleration::{AdaptiveBaseAcceleration, BaseAcceleration, UnsupportedBaseAcceleration};
use crate::{Controller, Firing, FuzzySets, GainError, SymmetricWeight, Synthesis, SynthesisError};
use dem_model::{Scalar, ThreeLinkDem};
use nalgebra::{SMatrix, SVector};

/// The paper's performance indices of one law (Table 4): means of five experiments on the UARM.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PublishedIndices {
    /// L2 of the state tracking error.
    pub tracking: f64,
    /// E, the summed torque, N·m·s.
    pub torque: f64,
}

/// Q1 and Q2, or their blocks, of one law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateWeights<const N: usize = 2> {
    /// Weight of the velocity error: Q1 or Q1ᵀQ1.
    pub q1: SymmetricWeight<N>,
    /// Weight of the position error: Q2 or Q2ᵀQ2.
    pub q2: SymmetricWeight<N>,
}

/// How a law adapts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptationSettings {
    /// z of Z = zI, positive.
    pub z: f64,
    /// How far each parameter may go from its start under [`AdaptationGuard::Bounded`], positive.
    pub bound: f64,
}

/// What keeps the parameters of an adaptive law from drifting. The laws as printed are pure integrators.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AdaptationGuard {
    /// As printed in the paper: nothing.
    #[default]
    None,
    /// Φ is kept in a box around Φ(0), [`AdaptationSettings::bound`] to each side, and stands still while the torque is
    /// limited. A box, not a ball: clamping keeps inequality 12 for every diagonal Z and design.
    Bounded,
}

/// A law in another form than its default: a row of its own in a comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LawVariant {
    /// The name on command lines and in tables.
    pub name: &'static str,
    /// The mode to set.
    pub base_acceleration: BaseAcceleration,
    /// Where the form comes from.
    pub origin: VariantOrigin,
}

/// Where a form of a law comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VariantOrigin {
    /// Another reading of the paper.
    Reading,
    /// Ours, beyond the paper.
    Extension,
}

/// What is known when a law is built, besides its settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuildContext<T: Scalar, M = ThreeLinkDem<T>> {
    /// The nominal model.
    pub model: M,
    /// The premises of the fuzzy laws.
    pub fuzzy_sets: FuzzySets<T>,
    /// What keeps the parameters of adaptive laws from drifting.
    pub adaptation_guard: AdaptationGuard,
}

impl<T: Scalar, M> BuildContext<T, M> {
    /// `model` with untrained fuzzy sets and no guard.
    pub fn new(model: M) -> Self {
        Self { model, fuzzy_sets: FuzzySets::untrained(), adaptation_guard: AdaptationGuard::None }
    }

    /// The adaptation of a law that starts at `initial`, with the guard of this context.
    ///
    /// # Errors
    /// [`BuildError::Weight`] or [`BuildError::Bound`] unless z and the bound are positive finite numbers.
    pub fn adaptation<const K: usize, const G: usize>(
        &self,
        initial: SMatrix<T, K, G>,
        settings: AdaptationSettings,
    ) -> Result<Adaptation<T, K, G>, BuildError> {
        let adaptation = Adaptation::new(initial, ScalarWeight::new(T::constant(settings.z))?)?;
        match self.adaptation_guard {
            AdaptationGuard::None => Ok(adaptation),
            AdaptationGuard::Bounded => {
                let corner = |distance: f64| initial.add_scalar(T::constant(distance));
                let bounds = ParameterBox::new(corner(-settings.bound), corner(settings.bound))?;
                Ok(adaptation.projected_onto_box(bounds)?.with_anti_windup(AntiWindup::FreezeWhileLimited))
            }
        }
    }
}

/// A model that every law of the catalogue can be built for.
pub trait CatalogueModel<T: Scalar, const N: usize, const B: usize>:
    ArmModel<T, N, B> + PartialEq + core::fmt::Debug
{
    /// Controller 2 with the parameters of this model.
    type Adaptive: Controller<T, N, B> + Clone + PartialEq + core::fmt::Debug;

    /// How large Ξ is for 1 rad/s² in all joints at rest at `position`, and Φ.
    fn inertial_scale(&self, position: &SVector<T, N>) -> InertialScale<T>;

    /// Controller 2, started at the nominal parameters.
    ///
    /// # Errors
    /// [`BuildError`] if a setting is refused.
    fn adaptive(
        synthesis: Synthesis<T, N>,
        mode: AdaptiveBaseAcceleration,
        context: &BuildContext<T, Self>,
        settings: AdaptationSettings,
    ) -> Result<Self::Adaptive, BuildError>;
}

/// How large the numbers are that controller 2 works with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InertialScale<T: Scalar> {
    /// ‖Ξ‖², the sum of the squares of its elements.
    pub regressor_squared: T,
    /// The largest magnitude in Φ.
    pub largest_parameter: T,
}

/// The arm that the paper's weights are for.
#[derive(Clone, Copy, Debug)]
pub struct PaperArm;

/// Says for how many joints there are weights in the paper.
pub trait PaperWeights<const N: usize> {
    /// The weights of joints 2 and 3.
    fn diagonal(joints: [f64; 2]) -> SymmetricWeight<N>;
}

impl PaperWeights<2> for PaperArm {
    fn diagonal(joints: [f64; 2]) -> SymmetricWeight {
        SymmetricWeight::Diagonal(joints)
    }
}

/// Weights made for a model, for laws of every kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DerivedWeights<const N: usize> {
    /// γ.
    pub attenuation_level: f64,
    /// R.
    pub r: SymmetricWeight<N>,
    /// Q1ᵀQ1 and Q2ᵀQ2.
    pub state: StateWeights<N>,
    /// How a law adapts that learns inertial parameters.
    pub inertial: AdaptationSettings,
    /// How a law adapts that learns the output weights of networks.
    pub networks: AdaptationSettings,
    /// How a law adapts that learns the consequents of fuzzy rules.
    pub rules: AdaptationSettings,
}

/// What a law for N joints tells of itself. Its settings implement it; their [`Default`], where there is one, is the paper's.
pub trait LawDefinition<const N: usize> {
    /// The name in files and on command lines: that of the module, with hyphens.
    const NAME: &'static str;
    /// What the law is, in a line.
    const DESCRIPTION: &'static str;
    /// The law's row of Table 4; `None` for a law that is not in the paper.
    const PUBLISHED_INDICES: Option<PublishedIndices> = None;
    /// Forms that a comparison shows as rows of their own.
    const VARIANTS: &'static [LawVariant] = &[];

    /// The law itself.
    type Controller<T: Scalar, const B: usize, M: CatalogueModel<T, N, B>>: Controller<T, N, B>;

    /// Settings with `weights` that were made for a model.
    fn derived(weights: &DerivedWeights<N>) -> Self;

    /// The law for `context`, with the H∞ design made of its weights.
    ///
    /// # Errors
    /// [`BuildError`] if a setting is refused.
    fn build<T: Scalar, const B: usize, M: CatalogueModel<T, N, B>>(
        &self,
        synthesis: Synthesis<T, N>,
        context: &BuildContext<T, M>,
    ) -> Result<Self::Controller<T, B, M>, BuildError>;

    /// Q1 and Q2. `None` for a law without weights of its own: it is designed with those of controller 1.
    fn state_weights(&self) -> Option<StateWeights<N>> {
        None
    }

    /// How the law adapts; `None` for a law that does not.
    fn adaptation(&self) -> Option<AdaptationSettings> {
        None
    }

    /// How the fuzzy rules of the law fire; `None` for a law without.
    fn firing(&self) -> Option<Firing> {
        None
    }

    /// Chooses how the law has the base acceleration.
    ///
    /// # Errors
    /// [`UnsupportedBaseAcceleration`] if the law does not offer the mode.
    fn set_base_acceleration(&mut self, mode: BaseAcceleration) -> Result<(), UnsupportedBaseAcceleration> {
        Err(UnsupportedBaseAcceleration { found: mode, expected: "a law that models the base: this one does not" })
    }
}

/// Why a controller cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// The weights have no solution.
    #[error(transparent)]
    Synthesis(#[from] SynthesisError),
    /// z is refused.
    #[error(transparent)]
    Weight(#[from] WeightError),
    /// Φ(0) or its set is refused.
    #[error(transparent)]
    Bound(#[from] BoundError),
    /// The weights leave the baseline without gains.
    #[error(transparent)]
    Gain(#[from] GainError),
    /// A setting of the law is refused.
    #[error("{setting} is {found}, expected {expected}")]
    Setting {
        /// The setting's name in files.
        setting: &'static str,
        /// What was found.
        found: f64,
        /// What was expected.
        expected: &'static str,
    },
}
