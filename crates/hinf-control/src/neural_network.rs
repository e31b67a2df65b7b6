//! The neural networks of controllers 3 and 4 (paper eqs. 22–24).
//!
//! Per joint k one network with a hidden layer of tanh neurons, H_k = Σ_i φ_ki tanh(Σ_j w_ij x_ej + b_i) = ξ_kᵀΦ_k, over
//! xe = [q_m, q̇_m, q_mᵈ, q̇_mᵈ, q̈_mᵈ] (eq. 26). Only the output weights Φ = [Φ_1; Φ_2] adapt, so that H = ΞΦ with
//! Ξ = diag(ξ_1ᵀ, ξ_2ᵀ).

use crate::{Measurement, Reference};
use dem_model::Scalar;
use nalgebra::{SMatrix, SVector};

/// Neurons in each joint's hidden layer (paper section 4).
pub const NEURONS: usize = 7;
/// Inputs xe of each network: five quantities of two joints.
pub const NETWORK_INPUTS: usize = 10;
/// Adapted parameters of both networks.
pub const NETWORK_PARAMETERS: usize = 2 * NEURONS;

/// Input weights and biases of the two networks, constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TanhNetworks<T: Scalar> {
    weights: [SMatrix<T, NEURONS, NETWORK_INPUTS>; 2],
    biases: [SVector<T, NEURONS>; 2],
}

/// A weight or bias is NaN or infinite.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the weights and biases of a network must be finite numbers")]
pub struct NetworkError;

impl<T: Scalar> TanhNetworks<T> {
    /// Networks with these weights w and biases b, one per joint: rows of `weights` and elements of `biases` are neurons,
    /// columns are xe.
    ///
    /// # Errors
    /// [`NetworkError`] if one is not finite.
    pub fn new(
        weights: [SMatrix<T, NEURONS, NETWORK_INPUTS>; 2],
        biases: [SVector<T, NEURONS>; 2],
    ) -> Result<Self, NetworkError> {
        let finite = weights.iter().flat_map(|weights| weights.iter()).all(|weight| weight.is_finite())
            && biases.iter().flat_map(|biases| biases.iter()).all(|bias| bias.is_finite());
        if finite { Ok(Self { weights, biases }) } else { Err(NetworkError) }
    }

    /// The paper's: all weights 1, biases −3 … 3. The scan has lost the weights' signs, if there were any.
    pub fn paper() -> Self {
        let biases = SVector::from([-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0].map(T::constant));
        Self { weights: [SMatrix::repeat(T::one()); 2], biases: [biases; 2] }
    }

    /// xe of eq. 26.
    pub fn inputs(measurement: &Measurement<T>, reference: &Reference<T>) -> SVector<T, NETWORK_INPUTS> {
        let mut inputs = SVector::<T, NETWORK_INPUTS>::zeros();
        inputs.fixed_rows_mut::<2>(0).copy_from(&measurement.position);
        inputs.fixed_rows_mut::<2>(2).copy_from(&measurement.velocity);
        inputs.fixed_rows_mut::<2>(4).copy_from(&reference.position);
        inputs.fixed_rows_mut::<2>(6).copy_from(&reference.velocity);
        inputs.fixed_rows_mut::<2>(8).copy_from(&reference.acceleration);
        inputs
    }

    /// Ξ = diag(ξ_1ᵀ, ξ_2ᵀ) of eqs. 23 and 24. Its elements lie within ±1.
    pub fn regressor(
        &self,
        measurement: &Measurement<T>,
        reference: &Reference<T>,
    ) -> SMatrix<T, 2, NETWORK_PARAMETERS> {
        let inputs = Self::inputs(measurement, reference);
        let mut regressor = SMatrix::<T, 2, NETWORK_PARAMETERS>::zeros();
        for (joint, (weights, biases)) in self.weights.iter().zip(&self.biases).enumerate() {
            let activations = (weights * inputs + biases).map(|sum| sum.tanh());
            regressor.fixed_view_mut::<1, NEURONS>(joint, joint * NEURONS).copy_from(&activations.transpose());
        }
        regressor
    }
}
