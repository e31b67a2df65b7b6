//! Arms of N joints as plants that drives sit on.

use super::plant::{PlanarBasePlant, SerialBrakes, SerialSpacePlant, SphericalBasePlant};
use crate::plant::interface::{Brake, Plant};
use core::time::Duration;
use nalgebra::SVector;

/// Drives sit on the arm's joints, none on the base.
macro_rules! drives_on_the_arm {
    ($($plant:ident),+) => {$(
        impl<const N: usize> Plant<N> for $plant<N> {
            fn time(&self) -> Duration {
                Self::time(self)
            }

            fn position(&self) -> SVector<f64, N> {
                self.motion().state.position
            }

            fn velocity(&self) -> SVector<f64, N> {
                self.motion().state.velocity
            }

            fn advance(&mut self, until: Duration, torque: &SVector<f64, N>, joints: [Brake; N]) {
                let brakes = SerialBrakes { joints, ..SerialBrakes::RELEASED };
                self.advance_under(until, &SVector::zeros(), |_| *torque, brakes);
            }
        }
    )+};
}

drives_on_the_arm!(SphericalBasePlant, SerialSpacePlant);

/// In the plane a drive sits on the base's joint too: joint 1, as on the paper's robot. Stable Rust has no N + 1 in an array's
/// length, so that each N is written out.
macro_rules! drive_on_planar_base {
    ($($arm:literal => $all:literal),+ $(,)?) => {$(
        impl Plant<$all> for PlanarBasePlant<$arm> {
            fn time(&self) -> Duration {
                Self::time(self)
            }

            fn position(&self) -> SVector<f64, $all> {
                let motion = self.motion();
                SVector::from_iterator(core::iter::once(motion.pose).chain(motion.state.position.iter().copied()))
            }

            fn velocity(&self) -> SVector<f64, $all> {
                let state = &self.motion().state;
                let entries = state.base_velocity.iter().chain(state.velocity.iter());
                SVector::from_iterator(entries.copied())
            }

            fn advance(&mut self, until: Duration, torque: &SVector<f64, $all>, brakes: [Brake; $all]) {
                let [base, joints @ ..] = brakes;
                let (on_base, arm) = (torque.fixed_rows::<1>(0).into_owned(), torque.fixed_rows::<$arm>(1).into_owned());
                self.advance_under(until, &on_base, |_| arm, SerialBrakes { base, joints });
            }
        }
    )+};
}

drive_on_planar_base!(1 => 2, 2 => 3, 3 => 4, 4 => 5, 5 => 6, 6 => 7, 7 => 8, 8 => 9);
