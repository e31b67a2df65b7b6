//! The number type of the model and the laws.

use nalgebra::RealField;

/// `f32` or `f64`: real numbers with transcendentals from `libm`, so that every target computes the same bits.
pub trait Scalar: RealField + Copy {
    /// The number nearest to `value`, for constants written in `f64`.
    fn constant(value: f64) -> Self {
        nalgebra::convert(value)
    }

    /// The value as `f64`: exact for `f32` and `f64`.
    fn to_f64(self) -> f64 {
        nalgebra::try_convert(self).unwrap_or(f64::NAN)
    }
}

impl Scalar for f32 {}
impl Scalar for f64 {}
