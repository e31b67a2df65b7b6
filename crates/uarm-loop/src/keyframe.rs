//! The whole inner state of the signal path between two cycles, frozen: a replay can start from it.

use hinf_control::{FrozenState, QuinticReference, ReferenceError, ThawError};
use nalgebra::SVector;

use crate::estimation::JointState;
use crate::signal_path::SignalPath;
use crate::supervision::{Supervision, SupervisionState};
use crate::task_clock::TaskClockState;

/// A frozen [`SignalPath`]. What is configuration (weights, limits, the task) is not in it; the performance indices are
/// not either: they are sums over a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Keyframe<const J: usize, const N: usize> {
    /// The law: Φ and its derivative.
    pub controller: FrozenState<f64, N>,
    /// Encoders and estimators of the joints.
    pub joints: [JointState; J],
    /// The law's torque limiter: the torque applied last, N·m.
    pub torque_applied: SVector<f64, N>,
    /// The last limiter: the torque sent last, N·m.
    pub torque_output: SVector<f64, N>,
    /// For how long each torque has been cut without a break, s.
    pub saturation: [f64; N],
    /// What the supervision knows; nothing before the first cycle, or without it.
    pub supervision: Option<SupervisionState<J>>,
    /// The task clock; its previous tick tells which cycle the keyframe follows.
    pub task_clock: TaskClockState,
    /// Where the approach began and how long it takes, rad and s; nothing in a run without one.
    pub approach: Option<Approach<N>>,
}

/// The way to the start of the task, measured at the start of the run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach<const N: usize> {
    /// Angles of the active joints, rad.
    pub from: SVector<f64, N>,
    /// Duration, s.
    pub duration: f64,
}

/// Why a keyframe cannot be put back.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum KeyframeError {
    /// It belongs to another law.
    #[error("controller state: {0}")]
    Controller(#[from] ThawError),
    /// Its approach cannot be driven.
    #[error("approach: {0}")]
    Approach(#[from] ReferenceError),
}

impl<const J: usize, const N: usize> SignalPath<'_, J, N> {
    /// The whole inner state.
    pub fn freeze(&self) -> Keyframe<J, N> {
        Keyframe {
            controller: self.controller.freeze(),
            joints: self.estimation.freeze(),
            torque_applied: *self.torque.limiter.applied(),
            torque_output: *self.torque.output_limiter.applied(),
            saturation: self.saturation.lasting(),
            supervision: self.supervision.as_ref().and_then(Supervision::freeze),
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
    pub fn thaw(&mut self, keyframe: &Keyframe<J, N>) -> Result<(), KeyframeError> {
        self.controller.thaw(&keyframe.controller)?;
        self.thaw_measured(keyframe)
    }

    /// As [`thaw`](Self::thaw), but for the law, which stays as it is: for another law on the same measurements.
    ///
    /// # Errors
    /// [`KeyframeError::Approach`].
    pub fn thaw_measured(&mut self, keyframe: &Keyframe<J, N>) -> Result<(), KeyframeError> {
        if let Some(Approach { from, duration }) = keyframe.approach {
            let approach = QuinticReference::new(from, *self.motion.task_reference().start(), duration)?;
            self.motion = self.motion.clone().after(approach);
        }
        self.estimation.thaw(&keyframe.joints);
        self.torque.limiter.thaw(keyframe.torque_applied);
        self.torque.output_limiter.thaw(keyframe.torque_output);
        self.saturation.thaw(keyframe.saturation);
        if let Some(supervision) = &mut self.supervision {
            supervision.thaw(keyframe.supervision);
        }
        self.task_clock.restart(self.motion.start());
        self.task_clock.thaw(keyframe.task_clock);
        Ok(())
    }
}
