//! The designer's weights Q and R. Those of the paper's Table 3 are in
//! [`ControllerSettings`](crate::ControllerSettings).

use dem_model::Scalar;
use nalgebra::{SMatrix, SVector};

/// How the numbers given for Q1 and Q2 are read.
///
/// The paper's text says factors; its Table 4 fits blocks clearly better. Open, so both are supported.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum WeightReading {
    /// The numbers are Q1 and Q2, so that Q has the blocks Q1ᵀQ1 and Q2ᵀQ2. They need not be symmetric.
    Factors,
    /// The numbers are the blocks Q1ᵀQ1 and Q2ᵀQ2 of Q themselves, symmetric and positive definite. For Table 3 this
    /// means Q1 of 0.8 I and Q2 of diag(3, √7), for example.
    #[default]
    Blocks,
}

/// The weights of the performance criterion (paper eq. 8): Q = [Q1ᵀQ1 Q12; Q12ᵀ Q2ᵀQ2], R, and γ.
///
/// Checked by [`Synthesis::new`](crate::Synthesis::new), which is the only reader.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights<T: Scalar, const N: usize = 2> {
    /// Weight of the velocity error q̃̇: Q1 or Q1ᵀQ1, as [`Weights::reading`] says.
    pub velocity: SMatrix<T, N, N>,
    /// Weight of the position error q̃: Q2 or Q2ᵀQ2, as [`Weights::reading`] says.
    pub position: SMatrix<T, N, N>,
    /// Cross weight Q12. Never a factor.
    pub cross: SMatrix<T, N, N>,
    /// Weight R of the control input u, symmetric, 0 < R < γ²I.
    pub control: SMatrix<T, N, N>,
    /// Desired disturbance attenuation level γ > 0.
    pub attenuation_level: T,
    /// What [`Weights::velocity`] and [`Weights::position`] are.
    pub reading: WeightReading,
}

/// γ of the paper's experiments (section 4).
pub const PAPER_ATTENUATION_LEVEL: f64 = 2.0;

impl<T: Scalar, const N: usize> Weights<T, N> {
    /// Diagonal weights without cross weight.
    pub fn diagonal(
        velocity: SVector<T, N>,
        position: SVector<T, N>,
        control: SVector<T, N>,
        attenuation_level: T,
        reading: WeightReading,
    ) -> Self {
        Self {
            velocity: SMatrix::from_diagonal(&velocity),
            position: SMatrix::from_diagonal(&position),
            cross: SMatrix::zeros(),
            control: SMatrix::from_diagonal(&control),
            attenuation_level,
            reading,
        }
    }
}
