//! How an arm and its base stand and move.

use super::pose::{BasePose, PosedBase};
use crate::plant::integrator::Integrable;
use core::ops::{Add, Mul};
use dem_model::{BaseFreedom, SerialAcceleration, SerialState};
use nalgebra::SVector;

/// The pose of a base of `B` degrees of freedom.
pub(super) type PoseOf<const B: usize> = <BaseFreedom<B> as PosedBase<B>>::Pose;
type PoseRateOf<const B: usize> = <PoseOf<B> as Integrable>::Rate;

/// The whole state of an arm of `N` joints on a base of `B` degrees of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SerialMotion<const N: usize, const B: usize>
where
    BaseFreedom<B>: PosedBase<B>,
{
    /// Where the base is and how it is turned: see [`PosedBase`].
    pub pose: PoseOf<B>,
    /// Joints, and all velocities.
    pub state: SerialState<f64, N, B>,
}

/// The rate of a [`SerialMotion`].
#[derive(Clone, Copy)]
pub struct SerialRate<const N: usize, const B: usize>
where
    BaseFreedom<B>: PosedBase<B>,
{
    pose: PoseRateOf<B>,
    position: SVector<f64, N>,
    acceleration: SerialAcceleration<f64, N, B>,
}

impl<const N: usize, const B: usize> SerialMotion<N, B>
where
    BaseFreedom<B>: PosedBase<B>,
{
    /// At rest with the joints at `position`, in rad or m, and base axes along inertial axes.
    pub fn at_rest(position: SVector<f64, N>) -> Self {
        let state = SerialState { position, velocity: SVector::zeros(), base_velocity: SVector::zeros() };
        Self { pose: BasePose::upright(), state }
    }

    /// Its rate under an acceleration.
    pub(super) fn rate(&self, acceleration: SerialAcceleration<f64, N, B>) -> SerialRate<N, B> {
        let SerialState { velocity, base_velocity, .. } = self.state;
        SerialRate { pose: self.pose.rate(&base_velocity), position: velocity, acceleration }
    }

    /// See [`BasePose::normalised`].
    pub(super) fn normalised(self) -> Self {
        Self { pose: self.pose.normalised(), ..self }
    }
}

impl<const N: usize, const B: usize> Integrable for SerialMotion<N, B>
where
    BaseFreedom<B>: PosedBase<B>,
{
    type Rate = SerialRate<N, B>;

    fn moved(&self, rate: &Self::Rate, seconds: f64) -> Self {
        let SerialState { position, velocity, base_velocity } = self.state;
        Self {
            pose: self.pose.moved(&rate.pose, seconds),
            state: SerialState {
                position: position + rate.position * seconds,
                velocity: velocity + rate.acceleration.joints * seconds,
                base_velocity: base_velocity + rate.acceleration.base * seconds,
            },
        }
    }
}

impl<const N: usize, const B: usize> Add for SerialRate<N, B>
where
    BaseFreedom<B>: PosedBase<B>,
{
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            pose: self.pose + other.pose,
            position: self.position + other.position,
            acceleration: SerialAcceleration {
                base: self.acceleration.base + other.acceleration.base,
                joints: self.acceleration.joints + other.acceleration.joints,
            },
        }
    }
}

impl<const N: usize, const B: usize> Mul<f64> for SerialRate<N, B>
where
    BaseFreedom<B>: PosedBase<B>,
{
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self {
            pose: self.pose * factor,
            position: self.position * factor,
            acceleration: SerialAcceleration {
                base: self.acceleration.base * factor,
                joints: self.acceleration.joints * factor,
            },
        }
    }
}
