//! Why a design is refused.

/// Why a design is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SynthesisError {
    /// A weight or γ is NaN or infinite, or the design made from them is.
    #[error("{quantity} holds a number that is not finite")]
    NotFinite {
        /// Which quantity.
        quantity: &'static str,
    },
    /// γ is zero or negative.
    #[error("the attenuation level γ is {found}, expected a positive number")]
    AttenuationLevelNotPositive {
        /// The γ found.
        found: f64,
    },
    /// A weight that must be symmetric is not.
    #[error("{quantity} is not symmetric: its off-diagonal elements differ by {difference:e}")]
    NotSymmetric {
        /// Which weight.
        quantity: &'static str,
        /// Magnitude of the difference.
        difference: f64,
    },
    /// A weight that must be positive definite is not.
    #[error("{quantity} is not positive definite: its smallest eigenvalue is {smallest_eigenvalue}")]
    NotPositiveDefinite {
        /// Which weight.
        quantity: &'static str,
        /// What was found, expected positive.
        smallest_eigenvalue: f64,
    },
    /// R ≥ γ²I: the control is too expensive for the attenuation asked for.
    #[error(
        "R must be less than γ²I: its largest eigenvalue is {largest_eigenvalue}, γ² is {attenuation_level_squared}"
    )]
    ControlWeightTooLarge {
        /// The largest eigenvalue of R.
        largest_eigenvalue: f64,
        /// γ².
        attenuation_level_squared: f64,
    },
    /// Q1, and with it T11 and T0, has no inverse.
    #[error("T0 is singular: the determinant of T11 is {determinant:e}")]
    SingularTransformation {
        /// det T11.
        determinant: f64,
    },
    /// Q1ᵀQ2 − Q12 is not symmetric, so that no K solves eq. 9.
    #[error(
        "equation 9 has no solution for these weights: its residual is {residual:e}, Q1ᵀQ2 − Q12 must be symmetric"
    )]
    Unsolvable {
        /// Largest magnitude in the residual of eq. 9.
        residual: f64,
    },
    /// K is not positive definite.
    #[error("K is not positive definite: its smallest eigenvalue is {smallest_eigenvalue}")]
    StorageNotPositive {
        /// What was found, expected positive.
        smallest_eigenvalue: f64,
    },
    /// Q as a whole is not positive definite: Q12 is too large.
    #[error("Q is not positive definite: the cross weight Q12 is too large for Q1 and Q2")]
    StateWeightNotPositive,
}
