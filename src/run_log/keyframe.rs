//! Keyframes as messages of `/keyframes`, and back.

use hinf_control::FrozenState;
use nalgebra::Vector2;
use uarm_io::encoder::EncoderReading;
use uarm_io::estimator::Estimate;
use uarm_io::time::Duration;

use super::proto::{self, keyframe};
use super::time_axis::TimeAxis;
use crate::control_loop::estimation::JointState;
use crate::control_loop::keyframe::{Approach, Keyframe};
use crate::control_loop::task_clock::TaskClockState;

/// Why a message is no keyframe.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("keyframe: {field} has {found} values, expected {expected}")]
pub struct ShapeError {
    /// The field.
    pub field: &'static str,
    /// Values in it.
    pub found: usize,
    /// Values wanted.
    pub expected: &'static str,
}

/// The message of a keyframe.
pub fn message(state: &Keyframe, axis: TimeAxis) -> proto::Keyframe {
    let TaskClockState { time, previous_sync, previous_tick } = state.task_clock;
    proto::Keyframe {
        after_tick: previous_sync.map(|_| previous_tick),
        time,
        sync_sent_ns: previous_sync.map(|sync| axis.at(sync)),
        joints: state.joints.iter().map(joint).collect(),
        controller: state.controller.values().to_vec(),
        torque_applied: state.torque_applied.as_slice().to_vec(),
        approach: state.approach.map(|approach| keyframe::Approach {
            from: approach.from.as_slice().to_vec(),
            duration: approach.duration,
        }),
    }
}

fn joint(state: &JointState) -> keyframe::JointState {
    keyframe::JointState {
        encoder: state.encoder.map(|EncoderReading { raw, count, age }| keyframe::EncoderReading {
            raw,
            count,
            age_ns: u64::try_from(age.as_nanos()).unwrap_or(u64::MAX),
        }),
        estimate: state.estimator.map(|Estimate { position, velocity, acceleration }| keyframe::Estimate {
            position,
            rate: velocity,
            acceleration,
        }),
    }
}

/// The keyframe of a message.
///
/// # Errors
/// [`ShapeError`] if a field has another number of values than any robot's.
pub fn state(message: &proto::Keyframe, axis: TimeAxis) -> Result<Keyframe, ShapeError> {
    let joints = message.joints.as_slice();
    let joints: &[keyframe::JointState; 3] =
        joints.try_into().map_err(|_| ShapeError { field: "joints", found: joints.len(), expected: "3" })?;
    let controller = FrozenState::new(&message.controller).ok_or(ShapeError {
        field: "controller",
        found: message.controller.len(),
        expected: "at most hinf_control::STATE_CAPACITY",
    })?;
    Ok(Keyframe {
        controller,
        joints: joints.each_ref().map(joint_state),
        torque_applied: pair("torque_applied", &message.torque_applied)?,
        task_clock: TaskClockState {
            time: message.time,
            previous_sync: message.sync_sent_ns.map(|at| axis.instant(at)),
            previous_tick: message.after_tick.unwrap_or(0),
        },
        approach: message
            .approach
            .as_ref()
            .map(|approach| Ok(Approach { from: pair("approach.from", &approach.from)?, duration: approach.duration }))
            .transpose()?,
    })
}

fn joint_state(state: &keyframe::JointState) -> JointState {
    JointState {
        encoder: state.encoder.as_ref().map(|reading| EncoderReading {
            raw: reading.raw,
            count: reading.count,
            age: Duration::from_nanos(reading.age_ns),
        }),
        estimator: state.estimate.as_ref().map(|estimate| Estimate {
            position: estimate.position,
            velocity: estimate.rate,
            acceleration: estimate.acceleration,
        }),
    }
}

fn pair(field: &'static str, values: &[f64]) -> Result<Vector2<f64>, ShapeError> {
    match values {
        [second, third] => Ok(Vector2::new(*second, *third)),
        _ => Err(ShapeError { field, found: values.len(), expected: "2" }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use uarm_io::time::Instant;

    prop_compose! {
        fn any_joint()(
            encoder in prop::option::of((any::<i32>(), any::<i64>(), any::<u64>())),
            estimate in prop::option::of(any::<[f64; 3]>()),
        ) -> JointState {
            JointState {
                encoder: encoder.map(|(raw, count, age)| EncoderReading { raw, count, age: Duration::from_nanos(age) }),
                estimator: estimate.map(|[position, velocity, acceleration]| Estimate { position, velocity, acceleration }),
            }
        }
    }

    prop_compose! {
        fn any_keyframe()(
            controller in prop::collection::vec(any::<f64>(), 0..=128),
            joints in prop::array::uniform3(any_joint()),
            torque in any::<[f64; 2]>(),
            time in any::<f64>(),
            previous in prop::option::of((0..1_u64 << 60, any::<u64>())),
            approach in prop::option::of(any::<[f64; 3]>()),
        ) -> Keyframe {
            Keyframe {
                controller: FrozenState::new(&controller).unwrap(),
                joints,
                torque_applied: torque.into(),
                task_clock: TaskClockState {
                    time,
                    previous_sync: previous.map(|(sync, _)| Instant::from_nanoseconds(sync)),
                    previous_tick: previous.map_or(0, |(_, tick)| tick),
                },
                approach: approach.map(|[second, third, duration]| Approach { from: Vector2::new(second, third), duration }),
            }
        }
    }

    proptest! {
        #[test]
        fn a_keyframe_comes_back_bit_for_bit(keyframe in any_keyframe()) {
            use prost::Message;
            let axis = TimeAxis::simulated();
            let bytes = message(&keyframe, axis).encode_to_vec();
            let read = state(&proto::Keyframe::decode(bytes.as_slice()).unwrap(), axis).unwrap();
            prop_assert_eq!(read, keyframe);
        }
    }
}
