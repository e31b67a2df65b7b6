//! Along the arm from the base outwards.

use nalgebra::SVector;

use super::frame::{Column, Frame};
use super::manipulator::{Link, SerialManipulator};
use crate::scalar::Scalar;

impl<T: Scalar, const N: usize, const B: usize> SerialManipulator<T, N, B> {
    /// Calls `visit` for each joint and its link from the base outwards, with the link's frame and the joint's column.
    pub(super) fn walk(
        &self,
        base: &Frame<T>,
        position: &SVector<T, N>,
        velocity: &SVector<T, N>,
        mut visit: impl FnMut(&Link<T>, &Frame<T>, Column<T>),
    ) -> Frame<T> {
        let mut next = base.moved(&self.base_length);
        let joints = self.joints.iter().zip(&self.links).zip(position.iter().zip(velocity.iter()));
        for ((joint, link), (position, velocity)) in joints {
            let (frame, column) = next.through(joint, link.stroke, *position, *velocity);
            visit(link, &frame, column);
            next = frame.moved(&link.length);
        }
        next
    }
}
