//! What the links beyond a joint weigh together.

use core::ops::AddAssign;

use nalgebra::{Matrix3, Matrix6, Vector3};

use super::frame::Frame;
use super::twist::{Twist, Wrench};
use crate::scalar::Scalar;

/// What a body weighs, about its inboard joint in its own frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Moments<T: Scalar> {
    /// m in kg.
    pub mass: T,
    /// m c in kg·m.
    pub first: Vector3<T>,
    /// The inertia about the joint in kg·m².
    pub inertia: Matrix3<T>,
}

impl<T: Scalar> Moments<T> {
    /// Of a body of the `mass` in kg with its centre of mass at `centre` in m and an `inertia` about it in kg·m².
    pub(super) fn new(mass: T, centre: &Vector3<T>, inertia: &Matrix3<T>) -> Self {
        let about_joint = Matrix3::identity() * centre.norm_squared() - centre * centre.transpose();
        Self { mass, first: centre * mass, inertia: inertia + about_joint * mass }
    }
}

/// Sums over bodies, with c and ċ place and velocity of a centre of mass, ω a body's angular velocity, I its inertia about
/// the centre of mass, and Ē = ½ tr(I) 1 − I.
///
/// The Coriolis matrix C = Σ m J_vᵀ J̇_v + J_ωᵀ (I J̇_ω − [ω]× Ē J_ω) is Levi-Civita's for these quasi-velocities: the
/// second term is what Σ m J_vᵀ J̇_v gives for the points of a rigid body, Ē being their second moment Σ m r rᵀ.
#[derive(Debug, Clone, Copy)]
pub(super) struct Composite<T: Scalar> {
    /// Σ m in kg.
    mass: T,
    /// Σ m c in kg·m.
    first_moment: Vector3<T>,
    /// Σ m ċ in kg·m/s.
    momentum: Vector3<T>,
    /// Σ I + m (cᵀc 1 − c cᵀ) in kg·m²: the inertia about the base's origin.
    inertia: Matrix3<T>,
    /// Σ m (cᵀċ 1 − ċ cᵀ) − [ω]× Ē in kg·m²/s.
    rate: Matrix3<T>,
}

impl<T: Scalar> Composite<T> {
    /// One body whose joint is at the frame's origin; linear in the body's `moments`.
    pub(super) fn body(moments: &Moments<T>, frame: &Frame<T>) -> Self {
        let Frame { rotation, place, velocity, angular } = frame;
        let identity = Matrix3::<T>::identity();
        let mass = moments.mass;
        let from_joint = rotation * moments.first;
        let turning = angular.cross(&from_joint);
        let inertia = rotation * moments.inertia * rotation.transpose();
        let second_moment = identity * (inertia.trace() * T::constant(0.5)) - inertia;
        let first_moment = place * mass + from_joint;
        Self {
            mass,
            first_moment,
            momentum: velocity * mass + turning,
            inertia: inertia + identity * (place.dot(&first_moment) + place.dot(&from_joint))
                - place * first_moment.transpose()
                - from_joint * place.transpose(),
            rate: identity * (velocity.dot(&first_moment) + place.dot(&turning))
                - velocity * first_moment.transpose()
                - turning * place.transpose()
                - angular.cross_matrix() * second_moment,
        }
    }

    /// The momentum of bodies that move with the `twist`.
    pub(super) fn momentum_of(&self, twist: &Twist<T>) -> Wrench<T> {
        let Twist { angular, linear } = twist;
        Wrench {
            moment: self.inertia * angular + self.first_moment.cross(linear),
            force: linear * self.mass + angular.cross(&self.first_moment),
        }
    }

    /// The matrix of [`Composite::momentum_of`]: angular above linear, moment above force.
    pub(super) fn inertia_matrix(&self) -> Matrix6<T> {
        let first = self.first_moment.cross_matrix();
        let mut matrix = Matrix6::zeros();
        matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(&self.inertia);
        matrix.fixed_view_mut::<3, 3>(0, 3).copy_from(&first);
        matrix.fixed_view_mut::<3, 3>(3, 0).copy_from(&first.transpose());
        matrix.fixed_view_mut::<3, 3>(3, 3).copy_from(&Matrix3::from_diagonal_element(self.mass));
        matrix
    }

    /// What C takes a `twist` of these bodies to, but for the rate of the twist itself.
    pub(super) fn rate_of(&self, twist: &Twist<T>) -> Wrench<T> {
        Wrench { moment: self.rate * twist.angular, force: twist.angular.cross(&self.momentum) }
    }

    /// The transpose of [`Composite::rate_of`]: its product with any twist has an angular part only.
    pub(super) fn rate_transposed(&self, twist: &Twist<T>) -> Vector3<T> {
        self.rate.tr_mul(&twist.angular) + self.momentum.cross(&twist.linear)
    }
}

impl<T: Scalar> AddAssign for Composite<T> {
    fn add_assign(&mut self, other: Self) {
        self.mass += other.mass;
        self.first_moment += other.first_moment;
        self.momentum += other.momentum;
        self.inertia += other.inertia;
        self.rate += other.rate;
    }
}
