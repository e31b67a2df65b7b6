//! The whole inner state of the signal path between two cycles, frozen: a replay can start from it.

use hinf_control::{FrozenState, QuinticReference, ReferenceError, ThawError};
use nalgebra::Vector2;

use super::JOINTS;
use super::estimation::JointState;
use super::signal_path::SignalPath;
use super::task_clock::TaskClockState;

/// A frozen [`SignalPath`]. What is configuration (weights, limits, the task) is not in it; the performance indices are
/// not either: they are sums over a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Keyframe {
    /// Of the law: Φ and its rate.
    pub controller: FrozenState<f64>,
    /// Of encoders and estimators.
    pub joints: [JointState; JOINTS],
    /// Of the torque limiter: the torque applied last, N·m.
    pub torque_applied: Vector2<f64>,
    /// Of the task clock; its previous tick tells which cycle the keyframe follows.
    pub task_clock: TaskClockState,
    /// Where the approach began and how long it takes, rad and s; nothing in a run without one.
    pub approach: Option<Approach>,
}

/// The way to the start of the task, measured at the start of the run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// Angles of joints 2 and 3, rad.
    pub from: Vector2<f64>,
    /// Duration, s.
    pub duration: f64,
}

/// Why a keyframe cannot be put back.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum KeyframeError {
    /// It belongs to another law.
    #[error("controller state: {0}")]
    Controller(#[from] ThawError),
    /// Its approach is none.
    #[error("approach: {0}")]
    Approach(#[from] ReferenceError),
}

impl SignalPath<'_> {
    /// The whole inner state.
    pub fn freeze(&self) -> Keyframe {
        Keyframe {
            controller: self.controller.freeze(),
            joints: self.estimation.freeze(),
            torque_applied: *self.torque.limiter.applied(),
            task_clock: self.task_clock.freeze(),
            approach: self
                .motion
                .approach()
                .map(|approach| Approach { from: *approach.start(), duration: approach.duration() }),
        }
    }

    /// Goes on from a frozen state of a path of the same configuration.
    ///
    /// # Errors
    /// [`KeyframeError`] if it does not fit; the path may then be partly changed.
    pub fn thaw(&mut self, keyframe: &Keyframe) -> Result<(), KeyframeError> {
        self.controller.thaw(&keyframe.controller)?;
        self.thaw_measured(keyframe)
    }

    /// As [`thaw`](Self::thaw), but for the law, which stays as it is: for another law on the same measurements.
    ///
    /// # Errors
    /// [`KeyframeError::Approach`].
    pub fn thaw_measured(&mut self, keyframe: &Keyframe) -> Result<(), KeyframeError> {
        if let Some(Approach { from, duration }) = keyframe.approach {
            let approach = QuinticReference::new(from, *self.motion.task_reference().start(), duration)?;
            self.motion = self.motion.after(approach);
        }
        self.estimation.thaw(&keyframe.joints);
        self.torque.limiter.thaw(keyframe.torque_applied);
        self.task_clock.restart(self.motion.start());
        self.task_clock.thaw(keyframe.task_clock);
        Ok(())
    }
}
