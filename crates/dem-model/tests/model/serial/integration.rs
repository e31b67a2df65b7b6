//! The classical Runge-Kutta method for an arm whose base has an attitude.

use dem_model::{SerialAcceleration, SerialState};
use nalgebra::{Quaternion, SVector, UnitQuaternion, Vector3};

/// A state with the base's attitude; also a rate of one.
#[derive(Debug, Clone, Copy)]
pub struct Moving<const N: usize, const B: usize> {
    pub attitude: UnitQuaternion<f64>,
    pub joints: SerialState<f64, N, B>,
}

impl<const N: usize, const B: usize> Moving<N, B> {
    /// The rate of a `state` that accelerates so; the attitude turns at the first three components of the base's velocity.
    pub fn rate(state: &Self, acceleration: &SerialAcceleration<f64, N, B>) -> Self {
        let velocity = &state.joints.base_velocity;
        let turning = Quaternion::from_imag(Vector3::new(velocity[0], velocity[1], velocity[2]));
        Self {
            attitude: UnitQuaternion::new_unchecked(state.attitude.into_inner() * turning * 0.5),
            joints: SerialState {
                position: state.joints.velocity,
                velocity: acceleration.joints,
                base_velocity: acceleration.base,
            },
        }
    }

    fn moved(&self, rate: &Self, step: f64) -> Self {
        let add = |value: SVector<f64, N>, rate: SVector<f64, N>| value + rate * step;
        Self {
            attitude: UnitQuaternion::new_unchecked(*self.attitude + *rate.attitude * step),
            joints: SerialState {
                position: add(self.joints.position, rate.joints.position),
                velocity: add(self.joints.velocity, rate.joints.velocity),
                base_velocity: self.joints.base_velocity + rate.joints.base_velocity * step,
            },
        }
    }
}

/// From `begin` to `end` in steps of about `step` seconds.
pub fn run<const N: usize, const B: usize>(
    mut state: Moving<N, B>,
    begin: f64,
    end: f64,
    step: f64,
    rate: impl Fn(f64, &Moving<N, B>) -> Moving<N, B>,
) -> Moving<N, B> {
    let steps = ((end - begin) / step).round();
    let step = (end - begin) / steps;
    for index in 0..steps as usize {
        let time = begin + step * index as f64;
        let first = rate(time, &state);
        let second = rate(time + step / 2.0, &state.moved(&first, step / 2.0));
        let third = rate(time + step / 2.0, &state.moved(&second, step / 2.0));
        let fourth = rate(time + step, &state.moved(&third, step));
        for (slope, weight) in [(first, 1.0), (second, 2.0), (third, 2.0), (fourth, 1.0)] {
            state = state.moved(&slope, step * weight / 6.0);
        }
        state.attitude.renormalize();
    }
    state
}
