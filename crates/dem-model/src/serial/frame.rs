//! Where a link is, how it moves, and the column of its joint.

use nalgebra::{Rotation3, Vector3};

use super::joint::{Joint, JointMotion};
use super::twist::Twist;
use crate::scalar::Scalar;

/// A joint's column: the twist that its unit velocity gives what is outboard, and the rate of that twist in an inertial
/// frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Column<T: Scalar> {
    pub twist: Twist<T>,
    pub rate: Twist<T>,
}

/// What a link is carried by: its frame at its inboard joint, in base axes about the base's origin.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame<T: Scalar> {
    /// From the link's frame to base axes.
    pub rotation: Rotation3<T>,
    /// The joint's place in m.
    pub place: Vector3<T>,
    /// The velocity of the point there in m/s.
    pub velocity: Vector3<T>,
    /// The link's angular velocity in rad/s.
    pub angular: Vector3<T>,
}

impl<T: Scalar> Frame<T> {
    /// That of a base whose origin moves with the twist.
    pub(super) fn of_base(twist: &Twist<T>) -> Self {
        Self {
            rotation: Rotation3::identity(),
            place: Vector3::zeros(),
            velocity: twist.linear,
            angular: twist.angular,
        }
    }

    /// The frame at `distance` of this one's origin, in this link.
    pub(super) fn moved(&self, distance: &Vector3<T>) -> Self {
        let arm = self.rotation * distance;
        Self { place: self.place + arm, velocity: self.velocity + self.angular.cross(&arm), ..*self }
    }

    /// Goes through a joint that is at this frame's origin: the next link's frame, and the joint's column.
    pub(super) fn through(&self, joint: &Joint<T>, stroke: T, coordinate: T, velocity: T) -> (Self, Column<T>) {
        let axis = self.rotation * joint.axis();
        match joint.motion() {
            JointMotion::Revolute => {
                let angular = self.angular + axis.into_inner() * velocity;
                let rotation = self.rotation * Rotation3::from_axis_angle(&joint.axis(), coordinate);
                let frame = Self { rotation, angular, ..*self };
                (frame, Column::about(&axis, &frame))
            }
            JointMotion::Prismatic => {
                let slide = axis.into_inner() * stroke;
                let moved = self.moved(&(joint.axis().into_inner() * (stroke * coordinate)));
                let frame = Self { velocity: moved.velocity + slide * velocity, ..moved };
                let column = Column { twist: Twist::sliding(slide), rate: Twist::sliding(self.angular.cross(&slide)) };
                (frame, column)
            }
        }
    }
}

impl<T: Scalar> Column<T> {
    /// Nothing.
    pub(super) fn zero() -> Self {
        Self { twist: Twist::zero(), rate: Twist::zero() }
    }

    /// Of a base's degree of freedom, along or about an axis that is fixed in the base, whose origin moves with `motion`.
    pub(super) fn of_base(twist: Twist<T>, motion: &Twist<T>) -> Self {
        let Twist { angular, linear } = twist;
        let rate = Twist {
            angular: motion.angular.cross(&angular),
            linear: motion.angular.cross(&linear) + motion.linear.cross(&angular),
        };
        Self { twist, rate }
    }

    /// Of an axis that is fixed in the frame and goes through its origin.
    pub(super) fn about(axis: &Vector3<T>, frame: &Frame<T>) -> Self {
        let turning = frame.angular.cross(axis);
        Self {
            twist: Twist { angular: *axis, linear: frame.place.cross(axis) },
            rate: Twist { angular: turning, linear: frame.velocity.cross(axis) + frame.place.cross(&turning) },
        }
    }
}
