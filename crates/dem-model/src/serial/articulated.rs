//! Forward dynamics in O(N) by articulated bodies (Featherstone, *The calculation of robot dynamics using articulated-body
//! inertias*, International Journal of Robotics Research 2 (1983) 13–30), for an arm on a base that moves freely.
//!
//! All bodies are written in base axes about the base's origin, where a wrench on a body is I A + p: A the rate of its twist
//! in an inertial frame, p what its motion asks for. From the tip inwards, with S a joint's column, S' q̇ its own rate c,
//! U = I_A S, D = SᵀU and u = τ − Sᵀp_A: the body beyond the joint weighs I_A − UUᵀ/D and asks for
//! p_A + (I_A − UUᵀ/D) c + U u/D. Outwards q̈ = (u − Uᵀ(A + c))/D.

use core::ops::AddAssign;

use nalgebra::{Matrix6, SMatrix, SVector, Vector6};

use super::base::{BaseFreedom, BaseMotion, Columns, base_twist};
use super::composite::Composite;
use super::frame::{Column, Frame};
use super::manipulator::SerialManipulator;
use super::matrices::SerialState;
use super::recursive::SerialAcceleration;
use super::twist::{Twist, Wrench};
use crate::scalar::Scalar;

/// Moment above force, or angular above linear.
fn of_twist<T: Scalar>(twist: &Twist<T>) -> Vector6<T> {
    let Twist { angular, linear } = twist;
    Vector6::new(angular.x, angular.y, angular.z, linear.x, linear.y, linear.z)
}

fn of_wrench<T: Scalar>(wrench: &Wrench<T>) -> Vector6<T> {
    let Wrench { moment, force } = wrench;
    Vector6::new(moment.x, moment.y, moment.z, force.x, force.y, force.z)
}

/// Bodies whose joints beyond are free: a wrench of `inertia` times the rate of their twist, and `bias`.
#[derive(Clone, Copy)]
struct Articulated<T: Scalar> {
    inertia: Matrix6<T>,
    bias: Vector6<T>,
}

impl<T: Scalar> Articulated<T> {
    /// One body that moves with the twist.
    fn body(body: &Composite<T>, motion: &Twist<T>) -> Self {
        Self { inertia: body.inertia_matrix(), bias: of_wrench(&body.rate_of(motion)) }
    }
}

impl<T: Scalar> AddAssign for Articulated<T> {
    fn add_assign(&mut self, other: Self) {
        self.inertia += other.inertia;
        self.bias += other.bias;
    }
}

/// A joint on its way from the tip inwards.
#[derive(Clone, Copy)]
struct Pass<T: Scalar> {
    /// S.
    column: Vector6<T>,
    /// c.
    rate: Vector6<T>,
    body: Articulated<T>,
    /// U.
    reaction: Vector6<T>,
    /// D.
    inertia: T,
    /// u.
    torque: T,
}

impl<T: Scalar> Pass<T> {
    /// Frees the joint under `torque`: what the link before feels of it.
    fn free(&mut self, torque: T) -> Articulated<T> {
        self.reaction = self.body.inertia * self.column;
        self.inertia = self.column.dot(&self.reaction);
        self.torque = torque - self.column.dot(&self.body.bias);
        let inertia = self.body.inertia - self.reaction * (self.reaction / self.inertia).transpose();
        let bias = self.body.bias + inertia * self.rate + self.reaction * (self.torque / self.inertia);
        Articulated { inertia, bias }
    }
}

impl<T: Scalar, const N: usize, const B: usize> SerialManipulator<T, N, B>
where
    BaseFreedom<B>: BaseMotion<T, B>,
{
    /// [`forward_dynamics`](Self::forward_dynamics) in O(N), without M: the acceleration [v̇_b; q̈_m] under the torques τ_b on
    /// the base and τ_m on the joints. None if a value is not finite.
    pub fn recursive_forward_dynamics(
        &self,
        state: &SerialState<T, N, B>,
        base_torque: &SVector<T, B>,
        torque: &SVector<T, N>,
    ) -> Option<SerialAcceleration<T, N, B>> {
        let mut motion = base_twist(&state.base_velocity);
        let base = Frame::of_base(&motion);
        let mut whole = Articulated::body(&Composite::body(&self.base, &base), &motion);
        let columns = <BaseFreedom<B> as Columns<T, B>>::twists().map(|column| Column::of_base(column, &motion));
        let (none, zero) = (Vector6::zeros(), T::zero());
        let mut passes =
            [Pass { column: none, rate: none, body: whole, reaction: none, inertia: zero, torque: zero }; N];
        let mut places = passes.iter_mut().zip(state.velocity.iter());
        self.walk(&base, &state.position, &state.velocity, |link, frame, column| {
            let Some((pass, velocity)) = places.next() else { return };
            motion = motion + column.twist * *velocity;
            pass.column = of_twist(&column.twist);
            pass.rate = of_twist(&column.rate) * *velocity;
            pass.body = Articulated::body(&Composite::body(&link.moments, frame), &motion);
        });

        let mut beyond: Option<Articulated<T>> = None;
        for (pass, torque) in passes.iter_mut().zip(torque.iter()).rev() {
            if let Some(beyond) = beyond {
                pass.body += beyond;
            }
            beyond = Some(pass.free(*torque));
        }
        if let Some(arm) = beyond {
            whole += arm;
        }

        let mut directions = SMatrix::<T, 6, B>::zeros();
        let mut rate = Vector6::zeros();
        let base_columns = columns.iter().zip(state.base_velocity.iter());
        for (mut direction, (column, velocity)) in directions.column_iter_mut().zip(base_columns) {
            direction.copy_from(&of_twist(&column.twist));
            rate += of_twist(&column.rate) * *velocity;
        }
        let asked = directions.tr_mul(&(whole.bias + whole.inertia * rate));
        let inertia = directions.tr_mul(&(whole.inertia * directions)).cholesky()?;
        let base_acceleration = inertia.solve(&(base_torque - asked));
        rate += directions * base_acceleration;

        let mut joints = SVector::<T, N>::zeros();
        for (pass, joint) in passes.iter().zip(joints.iter_mut()) {
            rate += pass.rate;
            *joint = (pass.torque - pass.reaction.dot(&rate)) / pass.inertia;
            rate += pass.column * *joint;
        }
        let finite = joints.iter().chain(base_acceleration.iter()).all(|value| value.is_finite());
        finite.then_some(SerialAcceleration { base: base_acceleration, joints })
    }
}
