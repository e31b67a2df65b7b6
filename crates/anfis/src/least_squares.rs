//! The forward pass: the consequents that fit the targets best, the premises held.

use nalgebra::{ColPivQR, DMatrix, DMatrixView, DVector, DVectorView};

/// Solution of a linear least squares problem.
pub(crate) struct Estimate {
    pub parameters: DVector<f64>,
    /// Numerical rank, where the method reveals it.
    pub rank: Option<usize>,
}

/// The shortest x that minimises ‖A x − b‖, by a complete orthogonal decomposition: QR with column pivoting, cut at the
/// first diagonal entry that is no more than rounding, and a second QR of what is left when the rank has dropped.
///
/// The threshold is max(rows, columns) · ε relative to the largest diagonal entry, as other solvers have it for singular
/// values. Pivoting by the largest element bounds what is cut off by √(rows · columns) times the threshold.
pub(crate) fn minimum_norm(matrix: DMatrix<f64>, target: &DVector<f64>) -> Estimate {
    let (rows, columns) = matrix.shape();
    let factors = ColPivQR::new(matrix);
    let mut rotated = target.clone();
    factors.q_tr_mul(&mut rotated);
    let triangle = factors.r();
    let diagonal = || (0..rows.min(columns)).map(|i| triangle[(i, i)]);
    let threshold = f64::EPSILON * rows.max(columns) as f64 * diagonal().fold(0.0, f64::max);
    // A threshold of 0 belongs to a matrix of zeros: rank 0, x = 0.
    let rank = diagonal().position(|entry| entry <= threshold).unwrap_or(rows.min(columns));
    let mut parameters = DVector::zeros(columns);
    solve_leading(triangle.view((0, 0), (rank, columns)), rotated.rows(0, rank), &mut parameters);
    factors.p().inv_permute_rows(&mut parameters);
    Estimate { parameters, rank: Some(rank) }
}

/// The shortest x with T x = b for an upper trapezoidal T of full row rank.
fn solve_leading(trapezium: DMatrixView<'_, f64>, target: DVectorView<'_, f64>, parameters: &mut DVector<f64>) {
    let (rank, columns) = trapezium.shape();
    if rank == columns {
        parameters.copy_from(&target);
        // The diagonal lies above the threshold, so that the substitution cannot divide by zero.
        trapezium.solve_upper_triangular_mut(parameters);
    } else if rank > 0 {
        let factors = trapezium.transpose().qr();
        let mut reduced = target.clone_owned();
        factors.r().tr_solve_upper_triangular_mut(&mut reduced);
        *parameters = factors.q() * reduced;
    }
}

/// Jang's sequential estimate (1993, eq. 14): starts at x = 0 with the covariance `initial_covariance`·I and takes in one
/// row after the other. Equal to least squares with the penalty ‖x‖²/`initial_covariance`.
///
/// In Potter's form, which carries a square root W of the covariance, S = W Wᵀ: S stays semidefinite whatever the
/// rounding, where the printed formula may lose that and then diverge.
pub(crate) fn recursive(matrix: &DMatrix<f64>, target: &DVector<f64>, initial_covariance: f64) -> Estimate {
    let columns = matrix.ncols();
    let mut root = DMatrix::from_diagonal_element(columns, columns, initial_covariance.sqrt());
    let mut parameters = DVector::zeros(columns);
    let [mut row, mut image, mut gain] = [(); 3].map(|()| DVector::zeros(columns));
    for (sample, &target) in target.iter().enumerate() {
        row.tr_copy_from(&matrix.row(sample));
        // φ = Wᵀa, β = 1/(1 + aᵀSa), gain β W φ.
        image.gemv_tr(1.0, &root, &row, 0.0);
        let beta = 1.0 / (1.0 + image.norm_squared());
        gain.gemv(beta, &root, &image, 0.0);
        let innovation = target - row.dot(&parameters);
        parameters.axpy(innovation, &gain, 1.0);
        root.ger(-1.0 / (1.0 + beta.sqrt()), &gain, &image, 1.0);
    }
    Estimate { parameters, rank: None }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    use super::*;

    fn matrix(rows: usize, columns: usize, values: &[f64]) -> DMatrix<f64> {
        DMatrix::from_fn(rows, columns, |i, j| values[(i * columns + j) % values.len()])
    }

    #[test]
    fn zeros_give_zeros() {
        let found = minimum_norm(DMatrix::zeros(3, 2), &DVector::from_element(3, 1.0));
        assert_eq!((found.rank, found.parameters), (Some(0), DVector::zeros(2)));
    }

    proptest! {
        #[test]
        fn the_minimum_norm_solution_is_the_pseudo_inverse(
            rows in 1..12_usize, columns in 1..8_usize, kept in 1..8_usize,
            values in prop::collection::vec(-1.0..1.0_f64, 150..200),
        ) {
            // A = L R with thin factors of full rank: A⁺ = Rᵀ(R Rᵀ)⁻¹(LᵀL)⁻¹Lᵀ.
            let kept = kept.min(rows).min(columns);
            let (left, right) = (matrix(rows, kept, &values), matrix(kept, columns, &values[60..]));
            let target = DVector::from_fn(rows, |i, _| values[i + 7]);
            let gram = |product: DMatrix<f64>| product.cholesky().filter(|factor| factor.l_dirty().diagonal().min() > 0.1);
            let (left_gram, right_gram) = (gram(left.transpose() * &left), gram(&right * right.transpose()));
            // Only problems whose rank is beyond doubt.
            prop_assume!(left_gram.is_some() && right_gram.is_some());
            let inner = left_gram.unwrap().solve(&(left.transpose() * &target));
            let expected = right.transpose() * right_gram.unwrap().solve(&inner);
            let found = minimum_norm(&left * &right, &target);
            prop_assert_eq!(found.rank, Some(kept));
            // Gram matrices of condition up to 1e4 or so.
            prop_assert!((&found.parameters - &expected).norm() <= 1e-9 * (1.0 + expected.norm()));
        }

        #[test]
        fn the_recursion_is_least_squares_with_a_penalty(
            rows in 1..12_usize, columns in 1..6_usize, values in prop::collection::vec(-1.0..1.0_f64, 100..120),
        ) {
            let (a, b) = (matrix(rows, columns, &values), DVector::from_fn(rows, |i, _| values[i + 3]));
            let penalty = DMatrix::identity(columns, columns) * 0.01;
            let normal = (a.transpose() * &a + penalty).cholesky().unwrap();
            let expected = normal.solve(&(a.transpose() * &b));
            let found = recursive(&a, &b, 100.0);
            assert_relative_eq!(found.parameters, expected, epsilon = 1e-9, max_relative = 1e-9);
        }
    }
}
