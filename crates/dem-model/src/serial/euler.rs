//! The base's attitude in Euler angles, as the paper writes it, and the dynamics in these coordinates.
//!
//! Angles have a singularity that the attitude has not: simulate with a quaternion, and use these to compare.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::matrices::SerialDynamics;
use crate::scalar::Scalar;

/// Which axes the angles turn about, each in the frame that the one before has turned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EulerSequence {
    /// z, then x, then z.
    Zxz,
    /// z, then y, then z.
    Zyz,
}

/// The attitude R = R_z(α) R_x(β) R_z(γ), or with R_y(β) in the middle, from base to inertial axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EulerAngles<T: Scalar> {
    /// Which axes.
    pub sequence: EulerSequence,
    /// α, β, γ in rad.
    pub angles: Vector3<T>,
}

impl<T: Scalar> EulerAngles<T> {
    fn middle_axis(&self) -> Vector3<T> {
        match self.sequence {
            EulerSequence::Zxz => Vector3::x(),
            EulerSequence::Zyz => Vector3::y(),
        }
    }

    fn about(axis: Vector3<T>, angle: T) -> Rotation3<T> {
        Rotation3::new(axis * angle)
    }

    /// The rotation from base to inertial axes.
    pub fn rotation(&self) -> Rotation3<T> {
        let [z, middle] = [Vector3::z(), self.middle_axis()];
        Self::about(z, self.angles.x) * Self::about(middle, self.angles.y) * Self::about(z, self.angles.z)
    }

    /// T with ω = T [α̇; β̇; γ̇], ω in base axes. Its determinant is ± [`sin_middle`](Self::sin_middle).
    pub fn velocity_map(&self) -> Matrix3<T> {
        self.map_and_rate(&Vector3::zeros()).0
    }

    /// Ṫ in 1/s at the rates [α̇; β̇; γ̇] in rad/s.
    pub fn velocity_map_rate(&self, rates: &Vector3<T>) -> Matrix3<T> {
        self.map_and_rate(rates).1
    }

    /// sin β: at zero the first and the last angle turn about the same axis, and no rates give some angular velocities.
    pub fn sin_middle(&self) -> T {
        self.angles.y.sin()
    }

    fn map_and_rate(&self, rates: &Vector3<T>) -> (Matrix3<T>, Matrix3<T>) {
        let (last, middle) = (Vector3::<T>::z(), self.middle_axis());
        let to_last = Self::about(last, self.angles.z).inverse();
        let to_middle = to_last * Self::about(middle, self.angles.y).inverse();
        let (first, second) = (to_middle * Vector3::z(), to_last * middle);
        // An axis that is fixed in a frame outboard of which the base turns at ω moves in base axes at −ω × axis.
        let turning = last * rates.z;
        let first_rate = first.cross(&(second * rates.y + turning));
        let second_rate = second.cross(&turning);
        (
            Matrix3::from_columns(&[first, second, last]),
            Matrix3::from_columns(&[first_rate, second_rate, Vector3::zeros()]),
        )
    }
}

impl<T: Scalar, const N: usize> SerialDynamics<T, N, 3> {
    /// M and C with the base's velocity as the rates of `attitude` in rad/s: M' = SᵀMS and C' = SᵀCS + SᵀMṠ with
    /// S = diag(T, I). For angles that have no singularity: see [`EulerAngles::sin_middle`].
    pub fn in_euler_angles(&self, attitude: &EulerAngles<T>, rates: &Vector3<T>) -> Self {
        let (map, map_rate) = (attitude.velocity_map(), attitude.velocity_map_rate(rates));
        let transposed = map.transpose();
        Self {
            mass_bb: transposed * self.mass_bb * map,
            mass_bm: transposed * self.mass_bm,
            mass_mm: self.mass_mm,
            coriolis_bb: transposed * (self.coriolis_bb * map + self.mass_bb * map_rate),
            coriolis_bm: transposed * self.coriolis_bm,
            coriolis_mb: self.coriolis_mb * map + self.mass_bm.tr_mul(&map_rate),
            coriolis_mm: self.coriolis_mm,
        }
    }
}
