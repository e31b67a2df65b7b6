//! Hyper-dual numbers: exact second derivatives of a scalar function, without differences.

use core::ops::{Add, Mul};

/// x + x_1 ε_1 + x_2 ε_2 + x_12 ε_1 ε_2 with ε_1² = ε_2² = 0.
#[derive(Debug, Clone, Copy)]
pub struct HyperDual {
    /// The value.
    pub value: f64,
    /// The derivative along the first direction.
    pub first: f64,
    /// The derivative along the second direction.
    pub second: f64,
    /// The mixed second derivative.
    pub mixed: f64,
}

impl HyperDual {
    /// A number that moves by `first` and `second` along the two directions.
    pub fn new(value: f64, first: f64, second: f64) -> Self {
        Self { value, first, second, mixed: 0.0 }
    }

    /// A number that does not move.
    pub fn fixed(value: f64) -> Self {
        Self::new(value, 0.0, 0.0)
    }

    fn chain(self, value: f64, slope: f64, curvature: f64) -> Self {
        Self {
            value,
            first: slope * self.first,
            second: slope * self.second,
            mixed: slope * self.mixed + curvature * self.first * self.second,
        }
    }

    /// The sine.
    pub fn sin(self) -> Self {
        let (sin, cos) = self.value.sin_cos();
        self.chain(sin, cos, -sin)
    }

    /// The cosine.
    pub fn cos(self) -> Self {
        let (sin, cos) = self.value.sin_cos();
        self.chain(cos, -sin, -cos)
    }
}

impl Add for HyperDual {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            first: self.first + other.first,
            second: self.second + other.second,
            mixed: self.mixed + other.mixed,
        }
    }
}

impl Mul for HyperDual {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self {
            value: self.value * other.value,
            first: self.first * other.value + self.value * other.first,
            second: self.second * other.value + self.value * other.second,
            mixed: self.mixed * other.value
                + self.first * other.second
                + self.second * other.first
                + self.value * other.mixed,
        }
    }
}
