//! Ξ of laws whose joints have parameters of their own.

use dem_model::Scalar;
use nalgebra::{SMatrix, SVector};

/// Ξ = diag(ξ_1ᵀ, …, ξ_Nᵀ), N × KN, kept as the columns ξ_k. Φ has the same shape, a column for each joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointRegressor<T: Scalar, const K: usize, const N: usize>(SMatrix<T, K, N>);

impl<T: Scalar, const K: usize, const N: usize> JointRegressor<T, K, N> {
    /// From ξ_k as columns.
    pub fn new(columns: SMatrix<T, K, N>) -> Self {
        Self(columns)
    }

    /// ξ_k as columns.
    pub fn columns(&self) -> &SMatrix<T, K, N> {
        &self.0
    }

    /// ΞΦ, summed from the first parameter of each joint to its last.
    pub fn torque(&self, parameters: &SMatrix<T, K, N>) -> SVector<T, N> {
        let mut torque = SVector::<T, N>::zeros();
        let columns = self.0.data.0.iter().zip(&parameters.data.0);
        for (torque, (regressor, parameters)) in torque.as_mut_slice().iter_mut().zip(columns) {
            let terms = regressor.iter().zip(parameters);
            *torque = terms.fold(T::zero(), |sum, (element, parameter)| sum + *element * *parameter);
        }
        torque
    }

    /// Ξᵀv.
    pub fn gradient(&self, signal: &SVector<T, N>) -> SMatrix<T, K, N> {
        let mut gradient = self.0;
        for (column, signal) in gradient.data.0.iter_mut().zip(signal.as_slice()) {
            for element in column {
                *element *= *signal;
            }
        }
        gradient
    }
}
