//! What the loop, its checks and its logs ask of an arm, whatever its joints are.

use std::any::Any;
use std::fmt;
use std::sync::Arc;

use dem_model::{PlanarBaseManipulator, SphericalBaseManipulator, ThreeLinkDem};
use hinf_control::{
    AdaptationGuard, AuxiliaryMotion, BaseMeasurement, BuildContext, BuildError, CatalogueModel, Command, Controller,
    ControllerSettings, FrozenState, FuzzySets, Law, LimitedJoints, Measurement, Momentum, NoDerivedWeights, Reference,
    ThawError,
};
use nalgebra::SVector;
use uarm_loop::plausibility::AccelerationBound;
use uarm_loop::stability::RestModel;
use uarm_loop::supervision::model::MomentumModel;

use super::acceleration;

/// What is chosen of a law besides its settings.
#[derive(Clone, Copy, Debug)]
pub struct LawChoice {
    /// The law.
    pub law: Law,
    /// What keeps its parameters from drifting.
    pub guard: AdaptationGuard,
    /// The premises of the fuzzy laws.
    pub fuzzy_sets: FuzzySets<f64>,
}

/// The nominal model of an arm of `N` active joints on a robot of `J` joints.
pub trait Arm<const J: usize, const N: usize>: fmt::Debug + Send + Sync {
    /// A law for the arm, in its initial state.
    ///
    /// # Errors
    /// [`BuildError`] if the settings allow no design.
    fn controller(
        &self,
        settings: &ControllerSettings<N>,
        choice: &LawChoice,
    ) -> Result<Box<dyn Controller<f64, N>>, BuildError>;

    /// Whether the law's torque depends on how the base moves.
    ///
    /// # Errors
    /// As [`controller`](Self::controller).
    fn reads_base(&self, settings: &ControllerSettings<N>, choice: &LawChoice) -> Result<bool, BuildError>;

    /// Settings of every law with weights made for the arm in the posture `start`, rad.
    ///
    /// # Errors
    /// [`NoDerivedWeights`] if the arm has no inertia there.
    fn derived_settings(&self, start: &SVector<f64, N>) -> Result<ControllerSettings<N>, NoDerivedWeights>;

    /// F̄ in N·m: what a `motion` from rest needs, without friction and disturbance. NaN where a number is not finite.
    fn torque_from_rest(&self, motion: &Reference<f64, N>) -> SVector<f64, N>;

    /// How fast the joints can change their velocities with torques up to `largest`, N·m; `None` where it is not known.
    fn acceleration_bounds(&self, largest: &[f64; J]) -> Option<[AccelerationBound; J]>;

    /// What the supervision compares torques with.
    fn momentum_model(&self) -> Arc<dyn MomentumModel<J>>;

    /// What the stability of the sampled loop is judged by.
    fn rest_model(&self) -> Arc<dyn RestModel<N>>;
}

impl Arm<3, 2> for ThreeLinkDem<f64> {
    fn controller(
        &self,
        settings: &ControllerSettings,
        choice: &LawChoice,
    ) -> Result<Box<dyn Controller<f64>>, BuildError> {
        Ok(Box::new(build::<2, 1, _>(self, settings, choice)?))
    }

    fn reads_base(&self, settings: &ControllerSettings, choice: &LawChoice) -> Result<bool, BuildError> {
        Ok(reads_base(&mut build::<2, 1, _>(self, settings, choice)?))
    }

    fn derived_settings(&self, start: &SVector<f64, 2>) -> Result<ControllerSettings, NoDerivedWeights> {
        ControllerSettings::derived::<1, _>(self, start)
    }

    fn torque_from_rest(&self, motion: &Reference<f64>) -> SVector<f64, 2> {
        torque_from_rest::<2, 1>(self, motion)
    }

    fn acceleration_bounds(&self, largest: &[f64; 3]) -> Option<[AccelerationBound; 3]> {
        acceleration::bounds(self, largest)
    }

    fn momentum_model(&self) -> Arc<dyn MomentumModel<3>> {
        Arc::new(*self)
    }

    fn rest_model(&self) -> Arc<dyn RestModel<2>> {
        Arc::new(*self)
    }
}

/// What arms with any axes share.
macro_rules! serial_arm {
    ($base:literal, $controller:expr) => {
        fn controller(
            &self,
            settings: &ControllerSettings<N>,
            choice: &LawChoice,
        ) -> Result<Box<dyn Controller<f64, N>>, BuildError> {
            Ok(Box::new($controller(build::<N, $base, _>(self, settings, choice)?)))
        }

        fn reads_base(&self, settings: &ControllerSettings<N>, choice: &LawChoice) -> Result<bool, BuildError> {
            Ok(reads_base(&mut build::<N, $base, _>(self, settings, choice)?))
        }

        fn derived_settings(&self, start: &SVector<f64, N>) -> Result<ControllerSettings<N>, NoDerivedWeights> {
            ControllerSettings::derived::<$base, _>(self, start)
        }

        fn torque_from_rest(&self, motion: &Reference<f64, N>) -> SVector<f64, N> {
            torque_from_rest::<N, $base>(self, motion)
        }

        fn acceleration_bounds(&self, _largest: &[f64; J]) -> Option<[AccelerationBound; J]> {
            None
        }

        fn momentum_model(&self) -> Arc<dyn MomentumModel<J>> {
            Arc::new(*self)
        }

        fn rest_model(&self) -> Arc<dyn RestModel<N>> {
            Arc::new(*self)
        }
    };
}

impl<const J: usize, const N: usize> Arm<J, N> for PlanarBaseManipulator<f64, N> {
    serial_arm!(1, std::convert::identity);
}

impl<const J: usize, const N: usize> Arm<J, N> for SphericalBaseManipulator<f64, N> {
    serial_arm!(3, WithoutBase);
}

fn build<const N: usize, const B: usize, M: CatalogueModel<f64, N, B>>(
    model: &M,
    settings: &ControllerSettings<N>,
    choice: &LawChoice,
) -> Result<hinf_control::AnyController<f64, N, B, M>, BuildError> {
    let context = BuildContext {
        fuzzy_sets: choice.fuzzy_sets,
        adaptation_guard: choice.guard,
        ..BuildContext::new(model.clone())
    };
    settings.build(choice.law, &context)
}

fn torque_from_rest<const N: usize, const B: usize>(
    model: &impl CatalogueModel<f64, N, B>,
    motion: &Reference<f64, N>,
) -> SVector<f64, N> {
    let Reference { position, velocity, acceleration } = *motion;
    let measurement = Measurement { position, velocity, base: BaseMeasurement::at_rest() };
    let auxiliary = AuxiliaryMotion { acceleration, velocity };
    model.reduced_torque(&measurement, &auxiliary, Momentum::Zero).unwrap_or(SVector::repeat(f64::NAN))
}

/// By what the torque is with the base at rest, turning and accelerated, in a state in which nothing else is zero.
fn reads_base<const N: usize, const B: usize>(law: &mut impl Controller<f64, N, B>) -> bool {
    let around = SVector::<f64, N>::from_fn(|row, _| 0.3 + 0.2 * row as f64);
    let reference = Reference { position: around * 0.9, velocity: around * 0.5, acceleration: around };
    let (none, some) = (SVector::zeros(), SVector::repeat(1.0));
    let mut torque = |velocity, acceleration| {
        law.reset();
        let base = BaseMeasurement { velocity, acceleration };
        law.update(&Measurement { position: around, velocity: around, base }, &reference, 0.0).torque
    };
    let at_rest = torque(none, none);
    [torque(some, none), torque(none, some)].iter().any(|moving| *moving != at_rest)
}

/// A law in space on a robot whose base has no sensor: it is told that the base rests. Only for laws that read nothing of it.
#[derive(Debug)]
struct WithoutBase<C>(C);

impl<const N: usize, C: Controller<f64, N, 3>> Controller<f64, N> for WithoutBase<C> {
    fn update(
        &mut self,
        measurement: &Measurement<f64, N>,
        reference: &Reference<f64, N>,
        period: f64,
    ) -> Command<f64, N> {
        let Measurement { position, velocity, .. } = *measurement;
        self.0.update(&Measurement { position, velocity, base: BaseMeasurement::at_rest() }, reference, period)
    }

    fn limited(&mut self, joints: LimitedJoints<N>) {
        self.0.limited(joints);
    }

    fn hold_adaptation(&mut self) {
        self.0.hold_adaptation();
    }

    fn parameters(&self) -> &[f64] {
        self.0.parameters()
    }

    fn reset(&mut self) {
        self.0.reset();
    }

    fn freeze(&self) -> FrozenState<f64, N> {
        self.0.freeze()
    }

    fn thaw(&mut self, state: &FrozenState<f64, N>) -> Result<(), ThawError> {
        self.0.thaw(state)
    }
}

/// `value` as another type, if it is that type: what is known of a robot's numbers of joints only where it runs.
pub(super) fn same<A: Any, B: Any>(value: A) -> Option<B> {
    let mut value = Some(value);
    let value: &mut dyn Any = &mut value;
    value.downcast_mut::<Option<B>>()?.take()
}

/// The paper's arm, if that is the robot with `J` joints of which `N` are active.
pub(super) fn of_three_links<const J: usize, const N: usize>(model: ThreeLinkDem<f64>) -> Option<Arc<dyn Arm<J, N>>> {
    let arm: Arc<dyn Arm<3, 2>> = Arc::new(model);
    same(arm)
}
