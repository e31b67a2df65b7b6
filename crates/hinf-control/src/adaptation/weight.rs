//! The adaptation weight Z: how slowly each parameter is learnt, and the metric in which Φ is measured.

use dem_model::Scalar;
use nalgebra::{Cholesky, SMatrix, SVector};

/// A symmetric positive definite Z of P × P (paper eq. 12).
pub trait AdaptationWeight<T: Scalar, const P: usize>: Clone {
    /// Z⁻¹v.
    fn solve(&self, vector: &SVector<T, P>) -> SVector<T, P>;

    /// ‖v‖²_Z = vᵀZv.
    fn norm_squared(&self, vector: &SVector<T, P>) -> T;
}

/// A Z without off-diagonal elements: in its metric, the nearest point of a box is found element by element.
pub trait SeparableWeight<T: Scalar, const P: usize>: AdaptationWeight<T, P> {}

/// Why an adaptation weight is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WeightError {
    /// A diagonal element is not a positive finite number.
    #[error("an adaptation weight is {found}, expected a positive finite number")]
    NotPositive {
        /// What was found.
        found: f64,
    },
    /// The matrix is not symmetric.
    #[error("the adaptation weight Z is not symmetric: two elements differ by {difference:e}")]
    NotSymmetric {
        /// Magnitude of the largest difference.
        difference: f64,
    },
    /// The matrix is not positive definite, or not finite.
    #[error("the adaptation weight Z is not positive definite")]
    NotPositiveDefinite,
}

fn check_positive<T: Scalar>(value: T) -> Result<T, WeightError> {
    // The inverse must be a number too: a denormal z has none.
    if value > T::zero() && value.is_finite() && (T::one() / value).is_finite() {
        Ok(value)
    } else {
        Err(WeightError::NotPositive { found: value.to_f64() })
    }
}

/// Z = zI, as in the paper's Table 3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScalarWeight<T: Scalar>(T);

impl<T: Scalar> ScalarWeight<T> {
    /// Z = `z`·I.
    ///
    /// # Errors
    /// [`WeightError::NotPositive`] unless `z` is a positive finite number.
    pub fn new(z: T) -> Result<Self, WeightError> {
        check_positive(z).map(Self)
    }

    /// z.
    pub fn value(&self) -> T {
        self.0
    }
}

impl<T: Scalar, const P: usize> AdaptationWeight<T, P> for ScalarWeight<T> {
    fn solve(&self, vector: &SVector<T, P>) -> SVector<T, P> {
        vector / self.0
    }

    fn norm_squared(&self, vector: &SVector<T, P>) -> T {
        vector.norm_squared() * self.0
    }
}

impl<T: Scalar, const P: usize> SeparableWeight<T, P> for ScalarWeight<T> {}

/// Z = diag(z).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiagonalWeight<T: Scalar, const P: usize>(SVector<T, P>);

impl<T: Scalar, const P: usize> DiagonalWeight<T, P> {
    /// Z = diag(`z`).
    ///
    /// # Errors
    /// [`WeightError::NotPositive`] unless all of `z` are positive finite numbers.
    pub fn new(z: SVector<T, P>) -> Result<Self, WeightError> {
        z.iter().try_for_each(|value| check_positive(*value).map(|_| ()))?;
        Ok(Self(z))
    }

    /// z.
    pub fn diagonal(&self) -> &SVector<T, P> {
        &self.0
    }
}

impl<T: Scalar, const P: usize> AdaptationWeight<T, P> for DiagonalWeight<T, P> {
    fn solve(&self, vector: &SVector<T, P>) -> SVector<T, P> {
        vector.component_div(&self.0)
    }

    fn norm_squared(&self, vector: &SVector<T, P>) -> T {
        vector.zip_fold(&self.0, T::zero(), |sum, value, weight| sum + value * value * weight)
    }
}

impl<T: Scalar, const P: usize> SeparableWeight<T, P> for DiagonalWeight<T, P> {}

/// A full Z, kept as its Cholesky factor.
///
/// It holds P² numbers (23 KiB for the 54 parameters of a fuzzy law in f64) and building it takes twice that from the
/// stack, once.
#[derive(Clone, Debug, PartialEq)]
pub struct FullWeight<T: Scalar, const P: usize> {
    /// L of Z = LLᵀ.
    factor: SMatrix<T, P, P>,
}

/// Symmetry is checked to this many units of rounding of the largest element.
const SYMMETRY_ALLOWANCE: f64 = 1e3;

impl<T: Scalar, const P: usize> FullWeight<T, P> {
    /// Z as it is, factorised here and now.
    ///
    /// # Errors
    /// [`WeightError`] unless `z` is finite, symmetric and positive definite.
    pub fn new(z: &SMatrix<T, P, P>) -> Result<Self, WeightError> {
        let mut difference = T::zero();
        for row in 0..P {
            for column in 0..row {
                difference = difference.max((z[(row, column)] - z[(column, row)]).abs());
            }
        }
        if difference > z.amax() * T::default_epsilon() * T::constant(SYMMETRY_ALLOWANCE) {
            return Err(WeightError::NotSymmetric { difference: difference.to_f64() });
        }
        let factor = Cholesky::new(*z).ok_or(WeightError::NotPositiveDefinite)?.unpack();
        if factor.iter().all(|element| element.is_finite()) {
            Ok(Self { factor })
        } else {
            Err(WeightError::NotPositiveDefinite)
        }
    }
}

impl<T: Scalar, const P: usize> AdaptationWeight<T, P> for FullWeight<T, P> {
    fn solve(&self, vector: &SVector<T, P>) -> SVector<T, P> {
        let mut solution = *vector;
        // The diagonal of a Cholesky factor is positive, so both substitutions succeed.
        self.factor.solve_lower_triangular_unchecked_mut(&mut solution);
        self.factor.tr_solve_lower_triangular_unchecked_mut(&mut solution);
        solution
    }

    fn norm_squared(&self, vector: &SVector<T, P>) -> T {
        self.factor.tr_mul(vector).norm_squared()
    }
}
