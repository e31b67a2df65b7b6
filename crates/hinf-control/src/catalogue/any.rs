//! One type for all laws, without allocation.

use super::{BuildError, ControllerOptions, Law};
use crate::adaptation::DiagonalWeight;
use crate::{
    Adaptive, AdaptiveBaseAcceleration, BaseAcceleration, Command, Controller, FUZZY_PARAMETERS, FrozenState, Fuzzy,
    FuzzyModel, LimitedJoints, Measurement, NETWORK_PARAMETERS, Neural, NeuralModel, NominalModel, NonlinearHInfinity,
    PdComputedTorque, PdGains, Reference, Synthesis, ThawError, Weights,
};
use dem_model::{REGRESSOR_PARAMETERS, Scalar, ThreeLinkDem};
use nalgebra::SVector;

/// Any law of [`Law`], chosen at run time.
///
/// ```
/// use dem_model::ThreeLinkDem;
/// use hinf_control::{AnyController, ControllerOptions, Law, WeightReading, Weights};
/// for law in Law::ALL {
///     let weights = Weights::table_3(law, WeightReading::Blocks);
///     AnyController::<f64>::new(law, ThreeLinkDem::table_2(), &weights, &ControllerOptions::paper(law))?;
/// }
/// # Ok::<(), hinf_control::BuildError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant)] // Boxing would allocate; the largest is about 3 KiB.
pub enum AnyController<T: Scalar> {
    /// Controller 1.
    Nonlinear(NonlinearHInfinity<T>),
    /// Controller 2.
    Adaptive(Adaptive<T, DiagonalWeight<T, REGRESSOR_PARAMETERS>>),
    /// Controller 3.
    Neural(Neural<T, DiagonalWeight<T, NETWORK_PARAMETERS>>),
    /// Controller 4.
    NeuralModel(NeuralModel<T, DiagonalWeight<T, NETWORK_PARAMETERS>>),
    /// Controller 5.
    Fuzzy(Fuzzy<T, DiagonalWeight<T, FUZZY_PARAMETERS>>),
    /// Controller 6.
    FuzzyModel(FuzzyModel<T, DiagonalWeight<T, FUZZY_PARAMETERS>>),
    /// The baseline.
    ComputedTorque(PdComputedTorque<T>),
}

impl<T: Scalar> AnyController<T> {
    /// `law` for a nominal `model`, designed with `weights`.
    ///
    /// # Errors
    /// [`BuildError`].
    pub fn new(
        law: Law,
        model: ThreeLinkDem<T>,
        weights: &Weights<T>,
        options: &ControllerOptions<'_, T>,
    ) -> Result<Self, BuildError> {
        let design = Synthesis::new(weights)?;
        let nominal = NominalModel::new(model, options.nominal_form);
        let (networks, system) = (options.networks, options.fuzzy_system);
        Ok(match law {
            Law::Nonlinear => Self::Nonlinear(NonlinearHInfinity::new(model, design, options.base_acceleration)),
            Law::Adaptive => {
                let adaptation = options.adaptation(model.regressor_parameters())?;
                Self::Adaptive(Adaptive::new(model, design, adaptive_mode(options.base_acceleration)?, adaptation))
            }
            Law::Neural => Self::Neural(Neural::new(design, networks, options.adaptation(SVector::zeros())?)),
            Law::NeuralModel => {
                let adaptation = options.adaptation(SVector::zeros())?;
                Self::NeuralModel(NeuralModel::new(nominal, design, networks, adaptation))
            }
            Law::Fuzzy => Self::Fuzzy(Fuzzy::new(design, system, options.adaptation(SVector::zeros())?)),
            Law::FuzzyModel => {
                let adaptation = options.adaptation(SVector::zeros())?;
                Self::FuzzyModel(FuzzyModel::new(nominal, design, system, adaptation))
            }
            Law::ComputedTorque => Self::ComputedTorque(PdComputedTorque::new(nominal, PdGains::matching(&design)?)),
        })
    }

    fn law(&self) -> &dyn Controller<T> {
        match self {
            Self::Nonlinear(law) => law,
            Self::Adaptive(law) => law,
            Self::Neural(law) => law,
            Self::NeuralModel(law) => law,
            Self::Fuzzy(law) => law,
            Self::FuzzyModel(law) => law,
            Self::ComputedTorque(law) => law,
        }
    }

    fn law_mut(&mut self) -> &mut dyn Controller<T> {
        match self {
            Self::Nonlinear(law) => law,
            Self::Adaptive(law) => law,
            Self::Neural(law) => law,
            Self::NeuralModel(law) => law,
            Self::Fuzzy(law) => law,
            Self::FuzzyModel(law) => law,
            Self::ComputedTorque(law) => law,
        }
    }
}

fn adaptive_mode(mode: BaseAcceleration) -> Result<AdaptiveBaseAcceleration, BuildError> {
    match mode {
        BaseAcceleration::Measured => Ok(AdaptiveBaseAcceleration::Measured),
        BaseAcceleration::Eliminated => Ok(AdaptiveBaseAcceleration::Eliminated),
        BaseAcceleration::Omitted => Ok(AdaptiveBaseAcceleration::Omitted),
        BaseAcceleration::Reduced | BaseAcceleration::ReducedMomentum => Err(BuildError::AdaptiveReduced),
    }
}

impl<T: Scalar> Controller<T> for AnyController<T> {
    fn update(&mut self, measurement: &Measurement<T>, reference: &Reference<T>, period: T) -> Command<T> {
        self.law_mut().update(measurement, reference, period)
    }

    fn limited(&mut self, joints: LimitedJoints) {
        self.law_mut().limited(joints);
    }

    fn parameters(&self) -> &[T] {
        self.law().parameters()
    }

    fn reset(&mut self) {
        self.law_mut().reset();
    }

    fn freeze(&self) -> FrozenState<T> {
        self.law().freeze()
    }

    fn thaw(&mut self, state: &FrozenState<T>) -> Result<(), ThawError> {
        self.law_mut().thaw(state)
    }
}
