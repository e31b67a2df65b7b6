//! Inverse dynamics in O(N): the torques of a motion, link by link, without a matrix.

use nalgebra::SVector;

use super::base::{BaseFreedom, BaseMotion, Columns, base_twist};
use super::composite::Composite;
use super::frame::{Column, Frame};
use super::manipulator::SerialManipulator;
use super::matrices::SerialState;
use super::twist::{Twist, Wrench};
use crate::scalar::Scalar;

/// The rate of a [`SerialState`]'s velocities.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SerialAcceleration<T: Scalar, const N: usize, const B: usize> {
    /// v̇_b: the rates of the components in base axes, in rad/s² and m/s².
    pub base: SVector<T, B>,
    /// q̈_m in rad/s² or m/s².
    pub joints: SVector<T, N>,
}

impl<T: Scalar, const N: usize, const B: usize> SerialManipulator<T, N, B>
where
    BaseFreedom<B>: BaseMotion<T, B>,
{
    /// The torques τ_b on the base and τ_m on the joints that give the `acceleration`, in N·m (N where they slide):
    /// τ = M v̇ + C v by the recursion of Newton and Euler.
    pub fn inverse_dynamics(
        &self,
        state: &SerialState<T, N, B>,
        acceleration: &SerialAcceleration<T, N, B>,
    ) -> (SVector<T, B>, SVector<T, N>) {
        let mut motion = base_twist(&state.base_velocity);
        let base = Frame::of_base(&motion);
        let base_columns = <BaseFreedom<B> as Columns<T, B>>::twists();
        let mut rate = base_twist(&acceleration.base);
        for (column, velocity) in base_columns.iter().zip(state.base_velocity.iter()) {
            rate = rate + Column::of_base(*column, &motion).rate * *velocity;
        }
        let body = Composite::body(&self.base, &base);
        let on_base = body.momentum_of(&rate) + body.rate_of(&motion);

        let mut wrenches = [(Twist::zero(), on_base); N];
        let mut places = wrenches.iter_mut().zip(state.velocity.iter().zip(acceleration.joints.iter()));
        self.walk(&base, &state.position, &state.velocity, |link, frame, column| {
            if let Some((place, (velocity, acceleration))) = places.next() {
                motion = motion + column.twist * *velocity;
                rate = rate + column.twist * *acceleration + column.rate * *velocity;
                let body = Composite::body(&link.moments, frame);
                *place = (column.twist, body.momentum_of(&rate) + body.rate_of(&motion));
            }
        });

        let mut torque = SVector::<T, N>::zeros();
        let mut outboard: Option<Wrench<T>> = None;
        for ((twist, wrench), torque) in wrenches.iter().zip(torque.iter_mut()).rev() {
            let carried = outboard.map_or(*wrench, |beyond| beyond + *wrench);
            *torque = twist.power(&carried);
            outboard = Some(carried);
        }
        let whole = outboard.map_or(on_base, |arm| arm + on_base);
        let mut base_torque = SVector::<T, B>::zeros();
        for (column, torque) in base_columns.iter().zip(base_torque.iter_mut()) {
            *torque = column.power(&whole);
        }
        (base_torque, torque)
    }
}
