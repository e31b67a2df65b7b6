//! The spectral radius of a matrix.

use nalgebra::{ComplexField, DMatrix};

/// After this many squarings the power is 2^30: what the norm has too much, at most the condition of the eigenvectors, is a
/// factor of its 2^30th root. Below 1e-7 up to a condition of 1e40.
const SQUARINGS: u32 = 30;

/// The largest magnitude of an eigenvalue, by Gelfand's formula ρ = lim ‖Aⁿ‖^(1/n) for n = 2^30, by squaring. Unlike an
/// iteration for the eigenvalues themselves it always ends. A matrix with an entry that is no number gives NaN.
pub fn spectral_radius(matrix: &DMatrix<f64>) -> f64 {
    let mut power = matrix.clone();
    let mut logarithm = 0.0;
    // 2^−k after k squarings.
    let mut share = 1.0;
    for _ in 0..SQUARINGS {
        let norm = power.norm();
        if norm == 0.0 {
            return 0.0;
        }
        logarithm += share * ComplexField::ln(norm);
        power /= norm;
        power = &power * &power;
        share *= 0.5;
    }
    ComplexField::exp(logarithm + share * ComplexField::ln(power.norm()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{ComplexField, Matrix3, Schur};

    fn radius(matrix: &Matrix3<f64>) -> f64 {
        spectral_radius(&DMatrix::from_column_slice(3, 3, matrix.as_slice()))
    }

    #[test]
    fn of_matrices_whose_eigenvalues_are_known() {
        let rotation = Matrix3::new(0.0, -0.9, 0.0, 0.9, 0.0, 0.0, 0.0, 0.0, 0.5);
        assert!((radius(&rotation) - 0.9).abs() < 1e-9);
        // A Jordan block has the worst growth: n ρ^(n−1).
        let block = Matrix3::new(0.99, 1.0, 0.0, 0.0, 0.99, 1.0, 0.0, 0.0, 0.99);
        assert!((radius(&block) - 0.99).abs() < 1e-7);
        let nilpotent = Matrix3::new(0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0);
        assert_eq!(radius(&nilpotent), 0.0);
        assert!(radius(&Matrix3::repeat(f64::NAN)).is_nan());
    }

    /// Against the Schur form of nalgebra.
    #[test]
    fn of_random_matrices() {
        let mut state = 12_345_u64;
        let mut random = || {
            state = state * 48_271 % 2_147_483_647;
            state as f64 / 2_147_483_647.0 - 0.5
        };
        for _ in 0..20 {
            let matrix = DMatrix::from_fn(8, 8, |_, _| random());
            let eigenvalues = Schur::new(matrix.clone()).complex_eigenvalues();
            let expected = eigenvalues.iter().map(|value| value.modulus()).fold(0.0, f64::max);
            assert!((spectral_radius(&matrix) - expected).abs() < 1e-7, "{matrix}");
        }
    }
}
