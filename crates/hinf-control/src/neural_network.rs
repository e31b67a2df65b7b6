//! The neural networks of controllers 3 and 4 (paper eqs. 22–24).
//!
//! Per joint k one network with a hidden layer of tanh neurons, H_k = Σ_i φ_ki tanh(Σ_j w_ij x_ej + b_i) = ξ_kᵀΦ_k, over
//! xe = [q_m, q̇_m, q_mᵈ, q̇_mᵈ, q̈_mᵈ] (eq. 26), 5N inputs for N joints. Only the output weights Φ = [Φ_1; …; Φ_N] adapt, so that
//! H = ΞΦ with Ξ = diag(ξ_1ᵀ, …, ξ_Nᵀ).

use crate::{JointRegressor, Measurement, Reference};
use dem_model::Scalar;
use nalgebra::{SMatrix, SVector};

/// Neurons in each joint's hidden layer (paper section 4): adapted parameters of each joint.
pub const NEURONS: usize = 7;
/// Quantities in xe, each of all joints.
pub const NETWORK_QUANTITIES: usize = 5;

/// The hidden layer of one joint's network, constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HiddenLayer<T: Scalar, const N: usize = 2> {
    /// Weights w of q_m, q̇_m, q_mᵈ, q̇_mᵈ and q̈_mᵈ: rows are neurons, columns joints.
    pub weights: [SMatrix<T, NEURONS, N>; NETWORK_QUANTITIES],
    /// Biases b.
    pub biases: SVector<T, NEURONS>,
}

/// The networks of the joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TanhNetworks<T: Scalar, const N: usize = 2> {
    /// `None` where it is that of the joint before, which is then not computed again.
    layers: [Option<HiddenLayer<T, N>>; N],
}

/// A weight or bias is NaN or infinite.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the weights and biases of a network must be finite numbers")]
pub struct NetworkError;

impl<T: Scalar, const N: usize> HiddenLayer<T, N> {
    fn is_finite(&self) -> bool {
        let weights = self.weights.iter().flat_map(|weights| weights.iter());
        weights.chain(self.biases.iter()).all(|number| number.is_finite())
    }

    /// tanh(W xe + b), summed from the first input to the last.
    fn activations(&self, inputs: &[SVector<T, N>; NETWORK_QUANTITIES]) -> SVector<T, NEURONS> {
        let mut sums = SVector::<T, NEURONS>::zeros();
        for (weights, inputs) in self.weights.iter().zip(inputs) {
            for (column, input) in weights.column_iter().zip(inputs.iter()) {
                sums.zip_apply(&column, |sum, weight| *sum += weight * *input);
            }
        }
        (sums + self.biases).map(|sum| sum.tanh())
    }
}

impl<T: Scalar, const N: usize> TanhNetworks<T, N> {
    /// Networks with these hidden layers, one for each joint.
    ///
    /// # Errors
    /// [`NetworkError`] if a number is not finite.
    pub fn new(layers: [HiddenLayer<T, N>; N]) -> Result<Self, NetworkError> {
        if layers.iter().all(HiddenLayer::is_finite) { Ok(Self::finite(layers)) } else { Err(NetworkError) }
    }

    fn finite(layers: [HiddenLayer<T, N>; N]) -> Self {
        let mut before = None;
        Self { layers: layers.map(|layer| (before.replace(layer) != Some(layer)).then_some(layer)) }
    }

    /// The paper's: all weights 1, biases −3 … 3. The scan has lost the weights' signs, if there were any.
    pub fn paper() -> Self {
        let biases = SVector::from([-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0].map(T::constant));
        Self::finite([HiddenLayer { weights: [SMatrix::repeat(T::one()); NETWORK_QUANTITIES], biases }; N])
    }

    /// Ξ = diag(ξ_1ᵀ, …, ξ_Nᵀ) of eqs. 23 and 24. Its elements lie within ±1.
    pub fn regressor<const B: usize>(
        &self,
        measurement: &Measurement<T, N, B>,
        reference: &Reference<T, N>,
    ) -> JointRegressor<T, NEURONS, N> {
        let inputs = [
            measurement.position,
            measurement.velocity,
            reference.position,
            reference.velocity,
            reference.acceleration,
        ];
        let mut columns = SMatrix::<T, NEURONS, N>::zeros();
        let mut activations = SVector::zeros();
        for (mut column, layer) in columns.column_iter_mut().zip(&self.layers) {
            if let Some(layer) = layer {
                activations = layer.activations(&inputs);
            }
            column.copy_from(&activations);
        }
        JointRegressor::new(columns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BaseMeasurement;

    /// Without weights, ξ_k = tanh(b_k).
    #[test]
    fn each_joint_has_the_neurons_of_its_own_network() {
        let layer = |bias: f64| HiddenLayer::<f64, 3> {
            weights: [SMatrix::zeros(); NETWORK_QUANTITIES],
            biases: SVector::repeat(bias),
        };
        let zeros = SVector::zeros();
        let measurement = Measurement { position: zeros, velocity: zeros, base: BaseMeasurement::<_, 1>::at_rest() };
        let reference = Reference { position: zeros, velocity: zeros, acceleration: zeros };
        for biases in [[0.5, 0.5, 1.5], [0.5, 1.5, 0.5], [1.5, 0.5, 0.5], [0.5, 0.5, 0.5]] {
            let networks = TanhNetworks::new(biases.map(layer)).unwrap();
            let regressor = networks.regressor(&measurement, &reference);
            for (column, bias) in regressor.columns().column_iter().zip(biases) {
                for element in column.iter() {
                    approx::assert_relative_eq!(*element, f64::tanh(bias), max_relative = 1e-15);
                }
            }
        }
    }
}
