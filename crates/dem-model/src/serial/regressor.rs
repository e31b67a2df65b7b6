//! The arm's torques as a linear function of its inertial parameters, for N joints.
//!
//! With the base locked, the arm of a DEM is a manipulator on a fixed base: F = M_mm x_1 + C_mm x_2, C_mm at v_b = 0, is
//! linear in the ten inertial parameters of each link (Khosla and Kanade 1985; Atkeson, An and Hollerbach 1986). Not all of
//! the ten are identifiable. In the plane with revolute joints, four of them have an effect: m, m c_x, m c_y and I_zz.

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use super::composite::{Composite, Moments};
use super::frame::{Column, Frame};
use super::manipulator::SerialManipulator;
use super::matrices::set;
use super::twist::Twist;
use crate::scalar::Scalar;

/// The inertial parameters of a link: m in kg, m c_x, m c_y, m c_z in kg·m, and I_xx, I_xy, I_xz, I_yy, I_yz, I_zz in kg·m²,
/// about the link's inboard joint in the frame of the link.
pub const LINK_PARAMETERS: usize = 10;

/// For each link, the columns of Ξ that belong to its [`LINK_PARAMETERS`]: F = Σ Ξ_i Φ_i.
pub type SerialRegressor<T, const N: usize> = [SMatrix<T, N, LINK_PARAMETERS>; N];

impl<T: Scalar> Moments<T> {
    fn parameters(&self) -> SVector<T, LINK_PARAMETERS> {
        let (first, inertia) = (&self.first, &self.inertia);
        SVector::from([
            self.mass,
            first.x,
            first.y,
            first.z,
            inertia.m11,
            inertia.m12,
            inertia.m13,
            inertia.m22,
            inertia.m23,
            inertia.m33,
        ])
    }

    /// The inverse of [`Moments::parameters`].
    fn from_parameters(parameters: &SVector<T, LINK_PARAMETERS>) -> Self {
        let &[[mass, x, y, z, xx, xy, xz, yy, yz, zz]] = &parameters.data.0;
        Self { mass, first: Vector3::new(x, y, z), inertia: Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) }
    }
}

impl<T: Scalar, const N: usize, const B: usize> SerialManipulator<T, N, B> {
    /// Φ: the inertial parameters of the arm's links.
    pub fn inertial_parameters(&self) -> [SVector<T, LINK_PARAMETERS>; N] {
        self.links.map(|link| link.moments.parameters())
    }

    /// The same arm with other inertial parameters of its links, as a law estimates them. Nothing is checked: they need not
    /// belong to any manipulator.
    #[must_use]
    pub fn with_inertial_parameters(&self, parameters: &[SVector<T, LINK_PARAMETERS>; N]) -> Self {
        let mut estimate = *self;
        for (link, parameters) in estimate.links.iter_mut().zip(parameters) {
            link.moments = Moments::from_parameters(parameters);
        }
        estimate
    }

    /// Ξ with F = M_mm `x1` + C_mm `x2` = Σ Ξ_i Φ_i, the base locked, for joints at `position` and `velocity` (rad and rad/s;
    /// m and m/s where they slide). The rows are N·m for `x1` in rad/s² and `x2` in rad/s.
    pub fn regressor(
        &self,
        position: &SVector<T, N>,
        velocity: &SVector<T, N>,
        x1: &SVector<T, N>,
        x2: &SVector<T, N>,
    ) -> SerialRegressor<T, N> {
        let mut regressor = [SMatrix::zeros(); N];
        let mut columns = [Twist::<T>::zero(); N];
        let (mut acceleration, mut motion) = (Twist::<T>::zero(), Twist::<T>::zero());
        let mut signals = x1.iter().zip(x2.iter());
        let mut links = regressor.iter_mut().enumerate();
        self.walk(&Frame::of_base(&Twist::zero()), position, velocity, |_, frame, Column { twist, rate }| {
            let (Some((index, block)), Some((x1, x2))) = (links.next(), signals.next()) else { return };
            acceleration = acceleration + twist * *x1 + rate * *x2;
            motion = motion + twist * *x2;
            if let Some(place) = columns.get_mut(index) {
                *place = twist;
            }
            for parameter in 0..LINK_PARAMETERS {
                let unit = SVector::from_fn(|row, _| if row == parameter { T::one() } else { T::zero() });
                let body = Composite::body(&Moments::from_parameters(&unit), frame);
                let wrench = body.momentum_of(&acceleration) + body.rate_of(&motion);
                for (row, twist) in columns.iter().enumerate().take(index + 1) {
                    set(block, row, parameter, twist.power(&wrench));
                }
            }
        });
        regressor
    }
}
