//! Closed forms for matrices of two by two.

use dem_model::Scalar;
use nalgebra::{Matrix2, Matrix4};

/// The eigenvalues of a symmetric matrix, smaller first.
pub(crate) fn eigenvalues<T: Scalar>(matrix: &Matrix2<T>) -> (T, T) {
    let half = T::constant(0.5);
    let mean = (matrix.m11 + matrix.m22) * half;
    let deviation = ((matrix.m11 - matrix.m22) * half).hypot((matrix.m12 + matrix.m21) * half);
    (mean - deviation, mean + deviation)
}

/// The inverse, unless rounding alone could have made the matrix invertible.
pub(crate) fn invert_well_conditioned<T: Scalar>(matrix: &Matrix2<T>) -> Option<Matrix2<T>> {
    let scale = matrix.amax();
    let threshold = scale * scale * T::default_epsilon();
    if matrix.determinant().abs() > threshold { matrix.try_inverse() } else { None }
}

/// The positive definite square root of a positive definite matrix: (A + √det A·I)/√(tr A + 2√det A).
pub(crate) fn square_root<T: Scalar>(matrix: &Matrix2<T>) -> Matrix2<T> {
    if matrix.m12 == T::zero() && matrix.m21 == T::zero() {
        return Matrix2::from_diagonal(&matrix.diagonal().map(|element| element.sqrt()));
    }
    let root_of_determinant = matrix.determinant().sqrt();
    let trace = matrix.trace() + T::constant(2.0) * root_of_determinant;
    (matrix + Matrix2::identity() * root_of_determinant) / trace.sqrt()
}

/// The geometric mean A # B of positive definite matrices, the symmetric solution X of XA⁻¹X = B:
/// √(αβ)/√det(A/α + B/β)·(A/α + B/β) with α = √det A, β = √det B.
pub(crate) fn geometric_mean<T: Scalar>(a: &Matrix2<T>, b: &Matrix2<T>) -> Matrix2<T> {
    let diagonal = [a.m12, a.m21, b.m12, b.m21].iter().all(|element| *element == T::zero());
    if diagonal {
        return Matrix2::from_diagonal(&a.diagonal().zip_map(&b.diagonal(), |x, y| x.sqrt() * y.sqrt()));
    }
    let (alpha, beta) = (a.determinant().sqrt(), b.determinant().sqrt());
    let sum = a / alpha + b / beta;
    sum * ((alpha * beta).sqrt() / sum.determinant().sqrt())
}

/// [upper_left upper_right; lower_left lower_right].
pub(crate) fn block_matrix<T: Scalar>(
    upper_left: &Matrix2<T>,
    upper_right: &Matrix2<T>,
    lower_left: &Matrix2<T>,
    lower_right: &Matrix2<T>,
) -> Matrix4<T> {
    let mut matrix = Matrix4::zeros();
    matrix.fixed_view_mut::<2, 2>(0, 0).copy_from(upper_left);
    matrix.fixed_view_mut::<2, 2>(0, 2).copy_from(upper_right);
    matrix.fixed_view_mut::<2, 2>(2, 0).copy_from(lower_left);
    matrix.fixed_view_mut::<2, 2>(2, 2).copy_from(lower_right);
    matrix
}
