//! Controller 2: adaptive nonlinear H∞ control with a linear parametrisation (paper section 3.1).
//!
//! For the paper's arm F = M_mm x1 + C_mm x2 is linear in Φ = [I2, I3, m2 lc2², m3 lc3², m3 W2², m3 W2 lc3] (eq. 13), with x1 = q̈ᵈ − Λq̃̇ and
//! x2 = q̇ᵈ − Λq̃:
//!
//! - Φ̇ = −Z⁻¹Ξᵀ T11ᵀBᵀT0x̃ (eq. 18),
//! - τ̄ = ΞΦ − T11⁻¹R⁻¹BᵀT0x̃ (eq. 19),
//! - Ξ = [x11, x11+x12, x11, x11+x12, x11, x13; 0, x11+x12, 0, x11+x12, 0, x23],
//!   x13 = (2x11 + x12) c3 − x21 q̇3 s3 − x22 (q̇2 + q̇3) s3, x23 = x11 c3 + x21 q̇2 s3.
//!
//! What τ̄ leaves out, E, is `measured` (τ_m = τ̄ + E, E by the nominal model, since the parametrisation covers F only), `eliminated` (τ_m = M̄ q̈_m + h̄ with q̈_m = M_mm⁻¹(τ̄ − C_mm q̇_m),
//! all with the estimate, eqs. 20 and 21) or `omitted` (τ_m = τ̄). A `reduced` form there is not: M̄ is rational in Φ.
//!
//! For N joints with any axes Φ are the ten inertial parameters of each link, and Ξ is the regressor of the arm on a locked
//! base ([`SerialManipulator::regressor`]). Where the estimated M_mm or M_bb is not positive definite, `eliminated` gives
//! τ̄ for the cycle and says so.
//!
//! Joints share parameters here, so that inequality 12 is proven for T11 = tI only: Φ's part of V̇ cancels if
//! c sᵀΞ = sᵀT11²Ξ. With the paper's R, T11 is diag(0.86, 2.07), and the argument has a gap.

use super::state::state_is_its_estimators;
use crate::adaptation::{Adaptation, AdaptationWeight, AdaptiveOutput, ParameterEstimator, ScalarWeight};
use crate::arm_model::LinearModel;
use crate::law_definition::{
    AdaptationSettings, BuildContext, BuildError, CatalogueModel, DerivedWeights, InertialScale, LawDefinition,
    PaperArm, PaperWeights, PublishedIndices, StateWeights,
};
use crate::{AdaptiveBaseAcceleration, BaseAcceleration, SymmetricWeight, UnsupportedBaseAcceleration};
use crate::{AuxiliaryMotion, BaseMeasurement};
use crate::{Command, Controller, Measurement, Reference, Synthesis, TrackingError};
use dem_model::{
    BaseFreedom, BaseMotion, LINK_PARAMETERS, REGRESSOR_PARAMETERS, Scalar, SerialManipulator, ThreeLinkDem,
};
use nalgebra::{SMatrix, SVector};

/// Settings of the law. The default is Table 3.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Settings<const N: usize = 2> {
    /// Weight of the velocity error.
    pub q1: SymmetricWeight<N>,
    /// Weight of the position error.
    pub q2: SymmetricWeight<N>,
    /// z of Z = zI, positive.
    pub z: f64,
    /// How far each parameter may go from its start under [`AdaptationGuard::Bounded`](crate::AdaptationGuard::Bounded).
    /// Chosen: several times as far as any goes in the paper's task.
    pub bound: f64,
    /// How the base acceleration is had.
    pub base_acceleration: AdaptiveBaseAcceleration,
}

impl<const N: usize> Default for Settings<N>
where
    PaperArm: PaperWeights<N>,
{
    fn default() -> Self {
        Self {
            q1: PaperArm::diagonal([0.64, 0.64]),
            q2: PaperArm::diagonal([9.0, 7.0]),
            z: 10.0,
            bound: 0.05,
            base_acceleration: AdaptiveBaseAcceleration::Eliminated,
        }
    }
}

impl<const N: usize> LawDefinition<N> for Settings<N> {
    const NAME: &'static str = "adaptive";
    const DESCRIPTION: &'static str = "adaptive nonlinear H-infinity control, linear parametrisation";
    const PUBLISHED_INDICES: Option<PublishedIndices> = Some(PublishedIndices { tracking: 0.0379, torque: 0.1244 });

    type Controller<T: Scalar, const B: usize, M: CatalogueModel<T, N, B>> = M::Adaptive;

    fn derived(weights: &DerivedWeights<N>) -> Self {
        let AdaptationSettings { z, bound } = weights.inertial;
        Self {
            q1: weights.state.q1,
            q2: weights.state.q2,
            z,
            bound,
            base_acceleration: AdaptiveBaseAcceleration::Eliminated,
        }
    }

    fn build<T: Scalar, const B: usize, M: CatalogueModel<T, N, B>>(
        &self,
        synthesis: Synthesis<T, N>,
        context: &BuildContext<T, M>,
    ) -> Result<M::Adaptive, BuildError> {
        let settings = AdaptationSettings { z: self.z, bound: self.bound };
        M::adaptive(synthesis, self.base_acceleration, context, settings)
    }

    fn state_weights(&self) -> Option<StateWeights<N>> {
        Some(StateWeights { q1: self.q1, q2: self.q2 })
    }

    fn adaptation(&self) -> Option<AdaptationSettings> {
        Some(AdaptationSettings { z: self.z, bound: self.bound })
    }

    fn set_base_acceleration(&mut self, mode: BaseAcceleration) -> Result<(), UnsupportedBaseAcceleration> {
        self.base_acceleration = mode.try_into()?;
        Ok(())
    }
}

/// Controller 2, for a model whose F is linear in G groups of K parameters.
///
/// Start it at the nominal Φ, [`LinearModel::parameters`]: at Φ = 0 the estimated M_mm is singular.
#[derive(Clone, Debug, PartialEq)]
pub struct Adaptive<
    T: Scalar,
    const N: usize = 2,
    const B: usize = 1,
    const K: usize = REGRESSOR_PARAMETERS,
    const G: usize = 1,
    M = ThreeLinkDem<T>,
    Z = ScalarWeight<T>,
> {
    model: M,
    synthesis: Synthesis<T, N>,
    base_acceleration: AdaptiveBaseAcceleration,
    estimator: ParameterEstimator<T, K, G, Z>,
}

impl<T, const N: usize, const B: usize, const K: usize, const G: usize, M, Z> Adaptive<T, N, B, K, G, M, Z>
where
    T: Scalar,
    M: LinearModel<T, N, B, K, G>,
    Z: AdaptationWeight<T, K, G>,
{
    /// The law for a nominal `model`. What Φ lacks stays as it is.
    pub fn new(
        model: M,
        synthesis: Synthesis<T, N>,
        base_acceleration: AdaptiveBaseAcceleration,
        adaptation: Adaptation<T, K, G, Z>,
    ) -> Self {
        Self { model, synthesis, base_acceleration, estimator: ParameterEstimator::new(adaptation) }
    }
}

impl<T, const N: usize, const B: usize, const K: usize, const G: usize, M, Z> Controller<T, N, B>
    for Adaptive<T, N, B, K, G, M, Z>
where
    T: Scalar,
    M: LinearModel<T, N, B, K, G>,
    Z: AdaptationWeight<T, K, G>,
{
    fn update(&mut self, measurement: &Measurement<T, N, B>, reference: &Reference<T, N>, period: T) -> Command<T, N> {
        let Self { model, synthesis, base_acceleration, estimator } = self;
        estimator.cycle(measurement, reference, period, |parameters| {
            let error = TrackingError::new(measurement, reference);
            let motion = synthesis.auxiliary_motion(reference, &error);
            let regressor = model.regressor(measurement, &motion);
            let learnt = product(&regressor, parameters);
            let arm_torque = learnt + synthesis.feedback_torque(&error);
            // None if an estimated matrix is not positive definite.
            let torque = match base_acceleration {
                AdaptiveBaseAcceleration::Measured => Some(arm_torque + model.base_reaction(measurement)),
                AdaptiveBaseAcceleration::Eliminated => {
                    model.estimated_compensation(parameters, measurement, &arm_torque)
                }
                AdaptiveBaseAcceleration::Omitted => Some(arm_torque),
            };
            AdaptiveOutput {
                torque: torque.unwrap_or(arm_torque),
                control_input: synthesis.control_input(&error),
                gradient: transposed_product(&regressor, &synthesis.adaptation_signal(&error)),
                fell_back: torque.is_none(),
            }
        })
    }

    state_is_its_estimators!(T, N);
}

/// ΞΦ.
fn product<T: Scalar, const N: usize, const K: usize, const G: usize>(
    regressor: &[SMatrix<T, N, K>; G],
    parameters: &SMatrix<T, K, G>,
) -> SVector<T, N> {
    let groups = regressor.iter().zip(parameters.column_iter());
    groups.fold(SVector::zeros(), |sum, (block, group)| sum + block * group)
}

/// Ξᵀv.
fn transposed_product<T: Scalar, const N: usize, const K: usize, const G: usize>(
    regressor: &[SMatrix<T, N, K>; G],
    signal: &SVector<T, N>,
) -> SMatrix<T, K, G> {
    let mut gradient = SMatrix::<T, K, G>::zeros();
    for (block, mut group) in regressor.iter().zip(gradient.column_iter_mut()) {
        group.copy_from(&block.tr_mul(signal));
    }
    gradient
}

/// Controller 2 for an arm whose Φ are the ten inertial parameters of each link.
pub type SerialAdaptive<T, const N: usize, const B: usize, Z = ScalarWeight<T>> =
    Adaptive<T, N, B, LINK_PARAMETERS, N, SerialManipulator<T, N, B>, Z>;

fn inertial_scale<T, const N: usize, const B: usize, const K: usize, const G: usize, M>(
    model: &M,
    position: &SVector<T, N>,
) -> InertialScale<T>
where
    T: Scalar,
    M: LinearModel<T, N, B, K, G>,
{
    let rest = Measurement { position: *position, velocity: SVector::zeros(), base: BaseMeasurement::at_rest() };
    let motion = AuxiliaryMotion { acceleration: SVector::repeat(T::one()), velocity: SVector::zeros() };
    let regressor = model.regressor(&rest, &motion);
    InertialScale {
        regressor_squared: regressor.iter().fold(T::zero(), |sum, block| sum + block.norm_squared()),
        largest_parameter: model.parameters().amax(),
    }
}

fn from_nominal<T, const N: usize, const B: usize, const K: usize, const G: usize, M>(
    synthesis: Synthesis<T, N>,
    mode: AdaptiveBaseAcceleration,
    context: &BuildContext<T, M>,
    settings: AdaptationSettings,
) -> Result<Adaptive<T, N, B, K, G, M>, BuildError>
where
    T: Scalar,
    M: LinearModel<T, N, B, K, G>,
{
    let adaptation = context.adaptation(context.model.parameters(), settings)?;
    Ok(Adaptive::new(context.model.clone(), synthesis, mode, adaptation))
}

impl<T: Scalar> CatalogueModel<T, 2, 1> for ThreeLinkDem<T> {
    type Adaptive = Adaptive<T>;

    fn inertial_scale(&self, position: &SVector<T, 2>) -> InertialScale<T> {
        inertial_scale(self, position)
    }

    fn adaptive(
        synthesis: Synthesis<T>,
        mode: AdaptiveBaseAcceleration,
        context: &BuildContext<T, Self>,
        settings: AdaptationSettings,
    ) -> Result<Adaptive<T>, BuildError> {
        from_nominal(synthesis, mode, context, settings)
    }
}

impl<T: Scalar, const N: usize, const B: usize> CatalogueModel<T, N, B> for SerialManipulator<T, N, B>
where
    BaseFreedom<B>: BaseMotion<T, B>,
{
    type Adaptive = SerialAdaptive<T, N, B>;

    fn inertial_scale(&self, position: &SVector<T, N>) -> InertialScale<T> {
        inertial_scale(self, position)
    }

    fn adaptive(
        synthesis: Synthesis<T, N>,
        mode: AdaptiveBaseAcceleration,
        context: &BuildContext<T, Self>,
        settings: AdaptationSettings,
    ) -> Result<SerialAdaptive<T, N, B>, BuildError> {
        from_nominal(synthesis, mode, context, settings)
    }
}
