//! Random arms: any axes, revolute and prismatic.

use dem_model::{Body, Joint, JointMotion, SerialState, SpaceLink, SpacecraftBody, SpatialSpaceManipulator};
use nalgebra::{Matrix3, SVector, Vector3};
use proptest::prelude::*;

/// Numbers of a random arm and state, each in [−1, 1].
pub const NUMBERS: usize = 400;

/// A source of numbers that are drawn one after another.
pub struct Draws(std::vec::IntoIter<f64>);

pub fn draws() -> impl Strategy<Value = Vec<f64>> {
    proptest::collection::vec(-1.0..1.0_f64, NUMBERS).no_shrink()
}

impl Draws {
    pub fn new(numbers: Vec<f64>) -> Self {
        Self(numbers.into_iter())
    }

    pub fn next(&mut self) -> f64 {
        self.0.next().expect("enough numbers")
    }

    pub fn vector<const ROWS: usize>(&mut self) -> SVector<f64, ROWS> {
        SVector::from_fn(|_, _| self.next())
    }

    fn mass(&mut self) -> f64 {
        2.0 + self.next()
    }

    /// An inertia that a body can have: that of eight point masses.
    fn inertia(&mut self) -> Matrix3<f64> {
        (0..8)
            .map(|_| self.vector::<3>() * 0.2)
            .map(|r| Matrix3::identity() * r.norm_squared() - r * r.transpose())
            .sum()
    }

    pub fn space_manipulator<const N: usize>(&mut self) -> SpatialSpaceManipulator<f64, N> {
        let spacecraft = SpacecraftBody {
            mass: 3.0 * self.mass(),
            inertia: self.inertia() * 3.0,
            centre_of_mass_to_joint: self.vector::<3>() * 0.3,
        };
        let links = core::array::from_fn(|_| SpaceLink {
            mass: self.mass(),
            inertia: self.inertia(),
            joint_to_centre_of_mass: self.vector::<3>() * 0.3,
            centre_of_mass_to_joint: self.vector::<3>() * 0.3,
        });
        SpatialSpaceManipulator::new(spacecraft, links).unwrap()
    }

    /// About one in four slides.
    pub fn joints<const N: usize>(&mut self) -> [Joint<f64>; N] {
        core::array::from_fn(|index| {
            let motion = if self.next() > 0.5 { JointMotion::Prismatic } else { JointMotion::Revolute };
            let axis = self.vector::<3>() + Vector3::new(0.0, 0.0, 2.0);
            Joint::new(motion, axis, Body::Link(index + 2)).unwrap()
        })
    }

    pub fn state<const N: usize, const B: usize>(&mut self) -> SerialState<f64, N, B> {
        SerialState {
            position: self.vector::<N>() * 2.0,
            velocity: self.vector::<N>(),
            base_velocity: self.vector::<B>(),
        }
    }
}
