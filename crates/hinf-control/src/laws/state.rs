//! The parts of [`Controller`](crate::Controller) that laws with the same kind of state share.

/// For an adaptive law: its state is that of its field `estimator`.
macro_rules! state_is_its_estimators {
    ($scalar:ty, $joints:ident) => {
        fn limited(&mut self, joints: crate::LimitedJoints<$joints>) {
            self.estimator.limited(joints);
        }

        fn hold_adaptation(&mut self) {
            self.estimator.hold();
        }

        fn parameters(&self) -> &[$scalar] {
            self.estimator.parameters().as_slice()
        }

        fn reset(&mut self) {
            self.estimator.reset();
        }

        fn freeze(&self) -> crate::FrozenState<$scalar, $joints> {
            self.estimator.freeze()
        }

        fn thaw(&mut self, state: &crate::FrozenState<$scalar, $joints>) -> Result<(), crate::ThawError> {
            self.estimator.thaw(state)
        }
    };
}
pub(crate) use state_is_its_estimators;

/// For a law without inner state.
macro_rules! has_no_state {
    ($scalar:ty, $joints:ident) => {
        fn reset(&mut self) {}

        fn freeze(&self) -> crate::FrozenState<$scalar, $joints> {
            crate::FrozenState::empty()
        }

        fn thaw(&mut self, state: &crate::FrozenState<$scalar, $joints>) -> Result<(), crate::ThawError> {
            state.expect_empty()
        }
    };
}
pub(crate) use has_no_state;
