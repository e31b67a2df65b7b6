//! Keyframes as messages of `/keyframes`, and back.

use uarm_loop::estimation::JointState;
use uarm_loop::hinf_control::FrozenState;
use uarm_loop::keyframe::{Approach, Keyframe};
use uarm_loop::plausibility::Trend;
use uarm_loop::supervision::decision::Suspicion;
use uarm_loop::supervision::observer::JointMotion;
use uarm_loop::supervision::stop::{Change, Course};
use uarm_loop::supervision::{REMEMBERED_TORQUES, SupervisionState};
use uarm_loop::task_clock::TaskClockState;
use uarm_loop::uarm_io::encoder::EncoderReading;
use uarm_loop::uarm_io::estimator::Estimate;
use uarm_loop::uarm_io::time::Duration;

use crate::proto::{self, keyframe};
use crate::shape::{ShapeError, array, array_ref};
use crate::time_axis::TimeAxis;

/// The message of a keyframe.
pub fn message<const J: usize, const N: usize>(state: &Keyframe<J, N>, axis: TimeAxis) -> proto::Keyframe {
    let TaskClockState { time, previous_sync, previous_tick } = state.task_clock;
    proto::Keyframe {
        after_tick: previous_sync.map(|_| previous_tick),
        time,
        sync_sent_ns: previous_sync.map(|sync| axis.at(sync)),
        joints: state.joints.iter().map(joint).collect(),
        controller: state.controller.values().to_vec(),
        torque_applied: state.torque_applied.as_slice().to_vec(),
        torque_output: state.torque_output.as_slice().to_vec(),
        saturation: state.saturation.to_vec(),
        supervision: state.supervision.as_ref().map(supervised).unwrap_or_default(),
        supervision_settling: state.supervision.map_or(0.0, |state| state.settling),
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
            velocity,
            acceleration,
        }),
        predicted: state.predicted,
        refused: state.refused,
        trend: Some(trend(state.trend)),
        time_error: state.time_error,
    }
}

fn supervised<const J: usize>(state: &SupervisionState<J>) -> Vec<keyframe::Supervised> {
    let joints = state.motion.iter().zip(&state.suspicions).enumerate();
    let message = |(index, (motion, suspicion)): (usize, (&JointMotion, &Suspicion))| {
        let JointMotion { angle, velocity, momentum, torque, filtered_torque, residual } = *motion;
        let Suspicion { count, standing_velocity, standing_distance, reversed, beyond, course } = *suspicion;
        keyframe::Supervised {
            angle,
            velocity,
            momentum,
            torque,
            filtered_torque,
            residual,
            count,
            standing_velocity,
            standing_distance,
            reversed,
            beyond,
            sent: state.sent.iter().map(|torques| torques[index]).collect(),
            changes: course.changes.map(|change| change.counts).to_vec(),
            change_times: course.changes.map(|change| change.time).to_vec(),
            stood: course.stood,
        }
    };
    joints.map(message).collect()
}

/// Nothing in a log of an earlier version, or of a run without supervision.
fn supervision<const J: usize>(keyframe: &proto::Keyframe) -> Result<Option<SupervisionState<J>>, ShapeError> {
    if keyframe.supervision.is_empty() {
        return Ok(None);
    }
    let messages: &[keyframe::Supervised; J] = array_ref("Keyframe.supervision", &keyframe.supervision)?;
    let mut state = SupervisionState {
        motion: messages.each_ref().map(|message| JointMotion {
            angle: message.angle,
            velocity: message.velocity,
            momentum: message.momentum,
            torque: message.torque,
            filtered_torque: message.filtered_torque,
            residual: message.residual,
        }),
        suspicions: messages.each_ref().map(|message| Suspicion {
            count: message.count,
            standing_velocity: message.standing_velocity,
            standing_distance: message.standing_distance,
            reversed: message.reversed,
            beyond: message.beyond,
            course: course(message),
        }),
        sent: [[0.0; J]; REMEMBERED_TORQUES],
        settling: keyframe.supervision_settling,
    };
    for (index, message) in messages.iter().enumerate() {
        let sent: [f64; REMEMBERED_TORQUES] = array("Keyframe.supervision.sent", &message.sent)?;
        for (torques, torque) in state.sent.iter_mut().zip(sent) {
            torques[index] = torque;
        }
    }
    Ok(Some(state))
}

/// Nothing in a log of an earlier version: it is not known then how the joint went.
fn course(message: &keyframe::Supervised) -> Course {
    let mut course = Course { stood: message.stood, ..Course::default() };
    for ((change, counts), time) in course.changes.iter_mut().zip(&message.changes).zip(&message.change_times) {
        *change = Change { counts: *counts, time: *time };
    }
    course
}

const fn trend(Trend { velocity, span, time_error }: Trend) -> keyframe::Trend {
    keyframe::Trend { velocity, span, time_error }
}

/// The keyframe of a message.
///
/// # Errors
/// [`ShapeError`] if a field has another number of values than any robot's.
pub fn state<const J: usize, const N: usize>(
    message: &proto::Keyframe,
    axis: TimeAxis,
) -> Result<Keyframe<J, N>, ShapeError> {
    let joints: &[keyframe::JointState; J] = array_ref("Keyframe.joints", &message.joints)?;
    let controller = FrozenState::new(&message.controller).ok_or(ShapeError {
        field: "Keyframe.controller",
        found: message.controller.len(),
        expected: FrozenState::<f64, N>::CAPACITY,
    })?;
    Ok(Keyframe {
        controller,
        joints: joints.each_ref().map(joint_state),
        torque_applied: array("Keyframe.torque_applied", &message.torque_applied)?.into(),
        torque_output: later("Keyframe.torque_output", &message.torque_output, &message.torque_applied)?.into(),
        saturation: later("Keyframe.saturation", &message.saturation, &[0.0; N])?,
        supervision: supervision(message)?,
        task_clock: TaskClockState {
            time: message.time,
            previous_sync: message.sync_sent_ns.map(|at| axis.instant(at)),
            previous_tick: message.after_tick.unwrap_or(0),
        },
        approach: message
            .approach
            .as_ref()
            .map(|approach| {
                let from = array("Keyframe.approach.from", &approach.from)?.into();
                Ok(Approach { from, duration: approach.duration })
            })
            .transpose()?,
    })
}

/// A field that logs of earlier versions lack.
fn later<const N: usize>(field: &'static str, values: &[f64], otherwise: &[f64]) -> Result<[f64; N], ShapeError> {
    array(field, if values.is_empty() { otherwise } else { values })
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
            velocity: estimate.velocity,
            acceleration: estimate.acceleration,
        }),
        predicted: state.predicted,
        refused: state.refused,
        trend: state.trend.map_or_else(Trend::default, |trend| {
            let keyframe::Trend { velocity, span, time_error } = trend;
            Trend { velocity, span, time_error }
        }),
        time_error: state.time_error,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use uarm_loop::uarm_io::time::Instant;

    prop_compose! {
        fn any_joint()(
            encoder in prop::option::of((any::<i32>(), any::<i64>(), any::<u64>())),
            estimate in prop::option::of(any::<[f64; 3]>()),
            [predicted, refused] in any::<[u32; 2]>(),
            [velocity, span, trend_error, time_error] in any::<[f64; 4]>(),
        ) -> JointState {
            JointState {
                encoder: encoder.map(|(raw, count, age)| EncoderReading { raw, count, age: Duration::from_nanos(age) }),
                estimator: estimate.map(|[position, velocity, acceleration]| Estimate { position, velocity, acceleration }),
                predicted,
                refused,
                trend: Trend { velocity, span, time_error: trend_error },
                time_error,
            }
        }
    }

    prop_compose! {
        fn any_supervision()(
            motion in any::<[[f64; 6]; 3]>(),
            suspicions in any::<[(i32, [f64; 4], [[f64; 2]; 3], f64); 3]>(),
            sent in any::<[[f64; 3]; 3]>(),
            settling in any::<f64>(),
        ) -> SupervisionState<3> {
            SupervisionState {
                motion: motion.map(|[angle, velocity, momentum, torque, filtered_torque, residual]| JointMotion {
                    angle, velocity, momentum, torque, filtered_torque, residual,
                }),
                suspicions: suspicions.map(|(count, [standing_velocity, standing_distance, reversed, beyond], changes, stood)| Suspicion {
                    count, standing_velocity, standing_distance, reversed, beyond,
                    course: Course { changes: changes.map(|[counts, time]| Change { counts, time }), stood },
                }),
                sent,
                settling,
            }
        }
    }

    prop_compose! {
        fn any_keyframe()(
            controller in prop::collection::vec(any::<f64>(), 0..=FrozenState::<f64>::CAPACITY),
            joints in prop::array::uniform3(any_joint()),
            [torque, output, saturation] in any::<[[f64; 2]; 3]>(),
            supervision in prop::option::of(any_supervision()),
            time in any::<f64>(),
            previous in prop::option::of((0..1_u64 << 60, any::<u64>())),
            approach in prop::option::of(any::<[f64; 3]>()),
        ) -> Keyframe<3, 2> {
            Keyframe {
                controller: FrozenState::new(&controller).unwrap(),
                joints,
                torque_applied: torque.into(),
                torque_output: output.into(),
                saturation,
                supervision,
                task_clock: TaskClockState {
                    time,
                    previous_sync: previous.map(|(sync, _)| Instant::from_nanoseconds(sync)),
                    previous_tick: previous.map_or(0, |(_, tick)| tick),
                },
                approach: approach.map(|[second, third, duration]| Approach { from: [second, third].into(), duration }),
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
