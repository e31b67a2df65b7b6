//! The number type of the estimators.

use nalgebra::RealField;

/// `f32` or `f64`; transcendentals come from `libm` on every target.
pub trait Real: RealField + Copy {
    /// The number nearest to `value`, for constants and settings written in `f64`.
    fn constant(value: f64) -> Self {
        nalgebra::convert(value)
    }

    /// True for finite numbers above zero.
    fn is_positive_finite(self) -> bool {
        self.is_finite() && self > Self::zero()
    }
}

impl<T: RealField + Copy> Real for T {}
