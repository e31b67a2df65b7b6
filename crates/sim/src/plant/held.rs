//! Coordinates that brakes hold.

use super::interface::Brake;
use nalgebra::{SMatrix, SVector};

/// Which coordinates a brake holds.
pub(super) type Held<const DOF: usize> = [Brake; DOF];

/// True if a coordinate that is held moves at its entry of `velocity`.
pub(super) fn engages_on_motion<const DOF: usize>(held: &Held<DOF>, velocity: &SVector<f64, DOF>) -> bool {
    held.iter().zip(velocity.iter()).any(|(brake, velocity)| *brake == Brake::Engaged && *velocity != 0.0)
}

/// Solves M x = b for the free coordinates with the held entries of x at zero.
///
/// Rows and columns of held coordinates become those of the unit matrix: what is left is a principal block of M, hence
/// positive definite. If M is not (a non-finite state), the answer is not a number, which does not go unseen.
pub(super) fn solve_free<const DOF: usize>(
    mut mass: SMatrix<f64, DOF, DOF>,
    mut right: SVector<f64, DOF>,
    held: &Held<DOF>,
) -> SVector<f64, DOF> {
    let is_held = |index: usize| held.get(index) == Some(&Brake::Engaged);
    for (column_index, mut column) in mass.column_iter_mut().enumerate() {
        for (row_index, entry) in column.iter_mut().enumerate() {
            if is_held(row_index) || is_held(column_index) {
                *entry = if row_index == column_index { 1.0 } else { 0.0 };
            }
        }
    }
    for (index, entry) in right.iter_mut().enumerate() {
        if is_held(index) {
            *entry = 0.0;
        }
    }
    match mass.cholesky() {
        Some(factors) => factors.solve(&right),
        None => SVector::repeat(f64::NAN),
    }
}
