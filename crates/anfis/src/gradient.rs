//! The backward pass: the gradient of the error with respect to the premises, the consequents held.

use crate::data::DataSet;
use crate::network::{Fired, Network, consequent, weighted_output};
use crate::premises::Firing;

/// Derivatives of the error with respect to one bell's half width, steepness and centre.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct BellGradient {
    /// ∂E/∂a, in the square of the target's unit over the input's.
    pub half_width: f64,
    /// ∂E/∂b, in the square of the target's unit.
    pub steepness: f64,
    /// ∂E/∂c, in the square of the target's unit over the input's.
    pub centre: f64,
}

/// The gradient of E = Σ (y − target)² over all samples, per bell over all inputs.
///
/// With y = Σ w̄_r f_r and w̄ normalised, ∂y/∂θ = Σ_r w̄_r (f_r − y) ∂ln w_r/∂θ, and ln w_r is the sum of the ln μ of the
/// rule's premises (product) or the least of them (minimum).
pub(crate) fn premise_gradient(
    network: &Network,
    fired: &Fired,
    consequents: &[f64],
    data: &DataSet,
) -> Vec<BellGradient> {
    let bells = network.bells.len();
    let mut gradient = vec![BellGradient::default(); bells];
    let mut shares = vec![0.0; bells];
    let rows = fired.grades.chunks_exact(bells).zip(fired.strengths.chunks_exact(network.rules()));
    for ((x, target), (grades, strengths)) in data.samples().zip(rows) {
        let output = weighted_output(strengths, consequents, x);
        let weight = 2.0 * (output - target);
        shares.fill(0.0);
        let outputs = consequents.chunks_exact(x.len() + 1).map(|coefficients| consequent(coefficients, x));
        for ((premises, strength), rule_output) in network.premises().zip(strengths).zip(outputs) {
            let share = weight * strength * (rule_output - output);
            match network.firing {
                Firing::Product => premises.iter().for_each(|&bell| shares[bell] += share),
                Firing::Minimum => shares[least(premises, grades)] += share,
            }
        }
        for ((total, share), (bell, x)) in gradient.iter_mut().zip(&shares).zip(network.bells_at(x)) {
            let derivatives = bell.log_derivatives(x);
            total.half_width += share * derivatives.half_width;
            total.steepness += share * derivatives.steepness;
            total.centre += share * derivatives.centre;
        }
    }
    gradient
}

/// The bell of the least grade, the first of equals.
fn least(premises: &[usize], grades: &[f64]) -> usize {
    premises.iter().copied().reduce(|least, bell| if grades[bell] < grades[least] { bell } else { least }).unwrap_or(0)
}
