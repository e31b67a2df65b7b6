//! The adaptation weight Z: how slowly each parameter is learnt, and the metric in which Φ is measured.

use dem_model::Scalar;
use nalgebra::{Cholesky, SMatrix};

/// A symmetric positive definite Z (paper eq. 12) for G groups of K parameters.
pub trait AdaptationWeight<T: Scalar, const K: usize, const G: usize = 1>: Clone {
    /// Z⁻¹v.
    fn solve(&self, vector: &SMatrix<T, K, G>) -> SMatrix<T, K, G>;

    /// ‖v‖²_Z = vᵀZv.
    fn norm_squared(&self, vector: &SMatrix<T, K, G>) -> T;
}

/// A Z without off-diagonal elements: in its metric, the nearest point of a box is found element by element.
pub trait SeparableWeight<T: Scalar, const K: usize, const G: usize = 1>: AdaptationWeight<T, K, G> {}

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
    // The inverse must be a number too: a denormal z has none. That of infinity is zero.
    let inverse = T::one() / value;
    if inverse > T::zero() && inverse.is_finite() {
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

impl<T: Scalar, const K: usize, const G: usize> AdaptationWeight<T, K, G> for ScalarWeight<T> {
    fn solve(&self, vector: &SMatrix<T, K, G>) -> SMatrix<T, K, G> {
        let mut solution = *vector;
        for element in solution.as_mut_slice() {
            *element /= self.0;
        }
        solution
    }

    fn norm_squared(&self, vector: &SMatrix<T, K, G>) -> T {
        vector.norm_squared() * self.0
    }
}

impl<T: Scalar, const K: usize, const G: usize> SeparableWeight<T, K, G> for ScalarWeight<T> {}

/// Z = diag(z).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiagonalWeight<T: Scalar, const K: usize, const G: usize = 1>(SMatrix<T, K, G>);

impl<T: Scalar, const K: usize, const G: usize> DiagonalWeight<T, K, G> {
    /// Z = diag(`z`).
    ///
    /// # Errors
    /// [`WeightError::NotPositive`] unless all of `z` are positive finite numbers.
    pub fn new(z: SMatrix<T, K, G>) -> Result<Self, WeightError> {
        z.iter().try_for_each(|value| check_positive(*value).map(|_| ()))?;
        Ok(Self(z))
    }

    /// z.
    pub fn diagonal(&self) -> &SMatrix<T, K, G> {
        &self.0
    }
}

impl<T: Scalar, const K: usize, const G: usize> AdaptationWeight<T, K, G> for DiagonalWeight<T, K, G> {
    fn solve(&self, vector: &SMatrix<T, K, G>) -> SMatrix<T, K, G> {
        vector.component_div(&self.0)
    }

    fn norm_squared(&self, vector: &SMatrix<T, K, G>) -> T {
        vector.zip_fold(&self.0, T::zero(), |sum, value, weight| sum + value * value * weight)
    }
}

impl<T: Scalar, const K: usize, const G: usize> SeparableWeight<T, K, G> for DiagonalWeight<T, K, G> {}

/// A Z with full blocks of K × K, one for each of the G groups of parameters, kept as their Cholesky factors. With G = 1 it
/// is any symmetric positive definite Z.
#[derive(Clone, Debug, PartialEq)]
pub struct FullWeight<T: Scalar, const K: usize, const G: usize = 1> {
    /// L of each block Z = LLᵀ.
    factors: [SMatrix<T, K, K>; G],
}

/// Symmetry is checked to this many units of rounding of the largest element.
const SYMMETRY_ALLOWANCE: f64 = 1e3;

fn factor<T: Scalar, const K: usize>(z: &SMatrix<T, K, K>) -> Result<SMatrix<T, K, K>, WeightError> {
    let mut difference = T::zero();
    for row in 0..K {
        for column in 0..row {
            difference = difference.max((z[(row, column)] - z[(column, row)]).abs());
        }
    }
    if difference > z.amax() * T::default_epsilon() * T::constant(SYMMETRY_ALLOWANCE) {
        return Err(WeightError::NotSymmetric { difference: difference.to_f64() });
    }
    let factor = Cholesky::new(*z).ok_or(WeightError::NotPositiveDefinite)?.unpack();
    if factor.iter().all(|element| element.is_finite()) { Ok(factor) } else { Err(WeightError::NotPositiveDefinite) }
}

impl<T: Scalar, const K: usize> FullWeight<T, K> {
    /// Z as it is, factorised here and now.
    ///
    /// # Errors
    /// [`WeightError`] unless `z` is finite, symmetric and positive definite.
    pub fn new(z: &SMatrix<T, K, K>) -> Result<Self, WeightError> {
        Self::blocks(&[*z])
    }
}

impl<T: Scalar, const K: usize, const G: usize> FullWeight<T, K, G> {
    /// Z = diag(`blocks`), factorised here and now.
    ///
    /// # Errors
    /// [`WeightError`] unless each block is finite, symmetric and positive definite.
    pub fn blocks(blocks: &[SMatrix<T, K, K>; G]) -> Result<Self, WeightError> {
        let mut factors = *blocks;
        for block in &mut factors {
            *block = factor(block)?;
        }
        Ok(Self { factors })
    }
}

impl<T: Scalar, const K: usize, const G: usize> AdaptationWeight<T, K, G> for FullWeight<T, K, G> {
    fn solve(&self, vector: &SMatrix<T, K, G>) -> SMatrix<T, K, G> {
        let mut solution = *vector;
        for (factor, mut group) in self.factors.iter().zip(solution.column_iter_mut()) {
            // The diagonal of a Cholesky factor is positive, so both substitutions succeed.
            factor.solve_lower_triangular_unchecked_mut(&mut group);
            factor.tr_solve_lower_triangular_unchecked_mut(&mut group);
        }
        solution
    }

    fn norm_squared(&self, vector: &SMatrix<T, K, G>) -> T {
        let groups = self.factors.iter().zip(vector.column_iter());
        groups.fold(T::zero(), |sum, (factor, group)| sum + factor.tr_mul(&group).norm_squared())
    }
}
