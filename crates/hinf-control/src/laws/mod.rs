//! One file per control law, each opening with its equations.

mod adaptive;
mod computed_torque;
mod fuzzy;
mod fuzzy_model;
mod neural;
mod neural_model;
mod nominal;
mod nonlinear;

pub use adaptive::{Adaptive, AdaptiveBaseAcceleration};
pub use computed_torque::{GainError, PdComputedTorque, PdGains};
pub use fuzzy::Fuzzy;
pub use fuzzy_model::FuzzyModel;
pub use neural::Neural;
pub use neural_model::NeuralModel;
pub use nominal::{NominalForm, NominalModel};
pub use nonlinear::{BaseAcceleration, NonlinearHInfinity};

/// The part of [`Controller`](crate::Controller) that every adaptive law answers with its estimator's state.
macro_rules! state_is_its_estimators {
    ($scalar:ty) => {
        fn limited(&mut self, joints: crate::LimitedJoints) {
            self.estimator.limited(joints);
        }

        fn parameters(&self) -> &[$scalar] {
            self.estimator.parameters().as_slice()
        }

        fn reset(&mut self) {
            self.estimator.reset();
        }

        fn freeze(&self) -> crate::FrozenState<$scalar> {
            self.estimator.freeze()
        }

        fn thaw(&mut self, state: &crate::FrozenState<$scalar>) -> Result<(), crate::ThawError> {
            self.estimator.thaw(state)
        }
    };
}
pub(crate) use state_is_its_estimators;

/// The part of [`Controller`](crate::Controller) that a law without inner state answers.
macro_rules! has_no_state {
    ($scalar:ty) => {
        fn reset(&mut self) {}

        fn freeze(&self) -> crate::FrozenState<$scalar> {
            crate::FrozenState::empty()
        }

        fn thaw(&mut self, state: &crate::FrozenState<$scalar>) -> Result<(), crate::ThawError> {
            state.expect_empty()
        }
    };
}
pub(crate) use has_no_state;

use crate::Measurement;
use dem_model::Scalar;
use nalgebra::Vector3;

/// q for the model. The base's own angle has no effect on M or C and is left zero.
fn configuration<T: Scalar>(measurement: &Measurement<T>) -> Vector3<T> {
    Vector3::new(T::zero(), measurement.position.x, measurement.position.y)
}

/// q̇ for the model, with the base velocity as measured.
fn velocities<T: Scalar>(measurement: &Measurement<T>) -> Vector3<T> {
    Vector3::new(measurement.base.velocity, measurement.velocity.x, measurement.velocity.y)
}

/// q̇ for the model by a law that knows nothing of the base. M_mm and C_mm do not depend on the base velocity.
fn arm_velocities<T: Scalar>(measurement: &Measurement<T>) -> Vector3<T> {
    Vector3::new(T::zero(), measurement.velocity.x, measurement.velocity.y)
}
