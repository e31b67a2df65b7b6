//! Functions of symmetric matrices of N by N: extreme eigenvalues, square root, geometric mean, inverse.
//!
//! Two by two has closed forms, which the paper's results are computed with. Every other size goes through nalgebra's
//! factorisation of one fixed size, into which the matrix is embedded: its eigenvalues need sizes that are known when the
//! crate is compiled.

use dem_model::Scalar;
use nalgebra::SMatrix;

/// The most active joints that a design can have.
pub const MOST_JOINTS: usize = 8;

type Largest<T> = SMatrix<T, MOST_JOINTS, MOST_JOINTS>;

/// `matrix` in the upper left corner, `filling` on the rest of the diagonal: a block of its own.
fn embed<T: Scalar, const N: usize>(matrix: &SMatrix<T, N, N>, filling: T) -> Largest<T> {
    const { assert!(N <= MOST_JOINTS, "a design has at most eight active joints") };
    Largest::from_fn(|row, column| {
        let rest = if row == column { filling } else { T::zero() };
        matrix.get((row, column)).copied().unwrap_or(rest)
    })
}

fn corner<T: Scalar, const N: usize>(matrix: &Largest<T>) -> SMatrix<T, N, N> {
    SMatrix::from_fn(|row, column| matrix.get((row, column)).copied().unwrap_or(T::zero()))
}

/// The elements of a matrix of two by two: [m11, m12, m21, m22].
fn two_by_two<T: Scalar, const N: usize>(matrix: &SMatrix<T, N, N>) -> Option<[T; 4]> {
    match *matrix.as_slice() {
        [m11, m21, m12, m22] if N == 2 => Some([m11, m12, m21, m22]),
        _ => None,
    }
}

/// det A.
pub(crate) fn determinant<T: Scalar, const N: usize>(matrix: &SMatrix<T, N, N>) -> T {
    match two_by_two(matrix) {
        Some([m11, m12, m21, m22]) => m11 * m22 - m21 * m12,
        None => embed(matrix, T::one()).determinant(),
    }
}

/// The smallest and the largest eigenvalue of a symmetric matrix; not finite if the matrix is not.
pub(crate) fn extreme_eigenvalues<T: Scalar, const N: usize>(matrix: &SMatrix<T, N, N>) -> (T, T) {
    if let Some([m11, m12, m21, m22]) = two_by_two(matrix) {
        let half = T::constant(0.5);
        let mean = (m11 + m22) * half;
        let deviation = ((m11 - m22) * half).hypot((m12 + m21) * half);
        return (mean - deviation, mean + deviation);
    }
    // An element of the diagonal lies between the extremes, so that the filling adds none.
    let filling = matrix.iter().next().copied().unwrap_or(T::zero());
    match embed(matrix, filling).try_symmetric_eigen(T::default_epsilon(), MOST_ITERATIONS) {
        Some(eigen) => (eigen.eigenvalues.min(), eigen.eigenvalues.max()),
        None => (T::constant(f64::NAN), T::constant(f64::NAN)),
    }
}

/// Far above what the symmetric QR iteration needs for eight rows.
const MOST_ITERATIONS: usize = 1000;

/// The inverse, unless rounding alone could have made the matrix invertible.
pub(crate) fn invert_well_conditioned<T: Scalar, const N: usize>(
    matrix: &SMatrix<T, N, N>,
) -> Option<SMatrix<T, N, N>> {
    if N == 2 {
        let scale = matrix.amax();
        let threshold = scale * scale * T::default_epsilon();
        return if determinant(matrix).abs() > threshold { matrix.try_inverse() } else { None };
    }
    matrix.try_inverse().filter(|inverse| inverse.amax() * matrix.amax() * T::default_epsilon() < T::one())
}

/// The positive definite square root of a positive definite matrix.
pub(crate) fn square_root<T: Scalar, const N: usize>(matrix: &SMatrix<T, N, N>) -> SMatrix<T, N, N> {
    if is_diagonal(matrix) {
        return SMatrix::from_diagonal(&matrix.diagonal().map(|element| element.sqrt()));
    }
    if two_by_two(matrix).is_some() {
        // (A + √det A·I)/√(tr A + 2√det A)
        let root_of_determinant = determinant(matrix).sqrt();
        let trace = matrix.trace() + T::constant(2.0) * root_of_determinant;
        return (matrix + SMatrix::identity() * root_of_determinant) / trace.sqrt();
    }
    match embed(matrix, T::one()).try_symmetric_eigen(T::default_epsilon(), MOST_ITERATIONS) {
        Some(mut eigen) => {
            eigen.eigenvalues.apply(|value| *value = value.sqrt());
            corner(&eigen.recompose())
        }
        None => SMatrix::repeat(T::constant(f64::NAN)),
    }
}

/// The geometric mean A # B of positive definite matrices, the symmetric solution X of XA⁻¹X = B:
/// A^½(A^−½ B A^−½)^½A^½. For two by two √(αβ)/√det(A/α + B/β)·(A/α + B/β) with α = √det A, β = √det B. None if A has no
/// inverse.
pub(crate) fn geometric_mean<T: Scalar, const N: usize>(
    a: &SMatrix<T, N, N>,
    b: &SMatrix<T, N, N>,
) -> Option<SMatrix<T, N, N>> {
    if is_diagonal(a) && is_diagonal(b) {
        return Some(SMatrix::from_diagonal(&a.diagonal().zip_map(&b.diagonal(), |x, y| x.sqrt() * y.sqrt())));
    }
    if N == 2 {
        let (alpha, beta) = (determinant(a).sqrt(), determinant(b).sqrt());
        let sum = a / alpha + b / beta;
        return Some(sum * ((alpha * beta).sqrt() / determinant(&sum).sqrt()));
    }
    let root = square_root(a);
    let inverse = root.try_inverse()?;
    Some(root * square_root(&symmetric_part(&(inverse * b * inverse))) * root)
}

/// ½(A + Aᵀ).
pub(crate) fn symmetric_part<T: Scalar, const N: usize>(matrix: &SMatrix<T, N, N>) -> SMatrix<T, N, N> {
    (matrix + matrix.transpose()) * T::constant(0.5)
}

/// Whether all elements off the diagonal are zero.
pub(crate) fn is_diagonal<T: Scalar, const N: usize>(matrix: &SMatrix<T, N, N>) -> bool {
    *matrix == SMatrix::from_diagonal(&matrix.diagonal())
}
