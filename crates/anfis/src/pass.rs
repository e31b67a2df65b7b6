//! One hybrid pass: consequents by least squares, then the error and its gradient.

use nalgebra::{DMatrix, DVector};

use crate::data::DataSet;
use crate::error::AnfisError;
use crate::gradient::BellGradient;
use crate::gradient::premise_gradient;
use crate::inference::Anfis;
use crate::inference::{check_width, parameters, root_mean_square};
use crate::least_squares::{Estimate, minimum_norm, recursive};
use crate::network::{Fired, Network, weighted_output};
use crate::premises::PremiseSets;

/// The covariance from which the recursive estimate starts, a multiple of the identity: a positive number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialCovariance(f64);

impl InitialCovariance {
    /// The factor of Jang's published runs.
    pub const JANG: Self = Self(1e6);
    /// The range allowed; Jang advises "a large positive number".
    const RANGE: std::ops::RangeInclusive<f64> = 1e-12..=1e12;

    /// The covariance `factor`·I.
    ///
    /// # Errors
    /// [`AnfisError::Training`] outside [1e-12, 1e12].
    pub fn new(factor: f64) -> Result<Self, AnfisError> {
        if Self::RANGE.contains(&factor) {
            Ok(Self(factor))
        } else {
            Err(AnfisError::Training { option: "initial covariance", found: factor, expected: "within [1e-12, 1e12]" })
        }
    }
}

/// How the forward pass finds the consequents.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum ConsequentEstimator {
    /// Exact least squares; of several solutions the shortest. Reports the rank.
    #[default]
    LeastSquares,
    /// Jang's sequential formula, started anew in each epoch. Slower, and biased towards 0 by its finite start; the
    /// published error curves come from it.
    Recursive(InitialCovariance),
}

/// What one pass over the training data finds for given premises.
#[derive(Clone, Debug, PartialEq)]
pub struct Pass {
    consequents: Vec<f64>,
    rank: Option<usize>,
    rmse: f64,
    gradient: Vec<BellGradient>,
}

impl Pass {
    /// Estimates the consequents of `premises` on `data`, then takes the error's gradient with the consequents held.
    ///
    /// # Errors
    /// [`AnfisError::Length`] when the data have another number of inputs than the premises.
    pub fn new(premises: &PremiseSets, data: &DataSet, estimator: ConsequentEstimator) -> Result<Self, AnfisError> {
        check_width(premises, data)?;
        let network = Network::new(premises);
        let fired = network.fire_all(data);
        let Estimate { parameters: found, rank } = estimate(&network, &fired, premises, data, estimator);
        let consequents = found.as_slice().to_vec();
        let rows = fired.strengths.chunks_exact(network.rules());
        let errors: Vec<f64> =
            data.samples().zip(rows).map(|((x, target), row)| weighted_output(row, &consequents, x) - target).collect();
        let gradient = premise_gradient(&network, &fired, &consequents, data);
        Ok(Self { rmse: root_mean_square(errors.into_iter()), consequents, rank, gradient })
    }

    /// The consequents, rule by rule, each rule's constant first.
    #[must_use]
    pub fn consequents(&self) -> &[f64] {
        &self.consequents
    }

    /// Numerical rank of the least squares problem, where the estimator reveals it. Below the number of consequents the
    /// data do not determine them all.
    #[must_use]
    pub const fn rank(&self) -> Option<usize> {
        self.rank
    }

    /// Root mean square error on the training data with these consequents, in the target's unit.
    #[must_use]
    pub const fn rmse(&self) -> f64 {
        self.rmse
    }

    /// The gradient, for the bells of the first input, then of the second, and so on.
    #[must_use]
    pub fn gradient(&self) -> &[BellGradient] {
        &self.gradient
    }

    /// The system that this pass found.
    pub(crate) fn system(&self, premises: PremiseSets) -> Result<Anfis, AnfisError> {
        Anfis::new(premises, self.consequents.clone())
    }
}

/// Solves for the consequents. The row of a sample holds per rule w̄·[1, x1, …, xn].
fn estimate(
    network: &Network,
    fired: &Fired,
    premises: &PremiseSets,
    data: &DataSet,
    estimator: ConsequentEstimator,
) -> Estimate {
    let (rules, block) = (network.rules(), data.width() + 1);
    let mut design = DMatrix::zeros(data.len(), parameters(premises));
    for (sample, ((x, _), strengths)) in data.samples().zip(fired.strengths.chunks_exact(rules)).enumerate() {
        for (rule, strength) in strengths.iter().enumerate() {
            design[(sample, rule * block)] = *strength;
            for (input, x) in x.iter().enumerate() {
                design[(sample, rule * block + 1 + input)] = strength * x;
            }
        }
    }
    let target = DVector::from_column_slice(data.targets());
    match estimator {
        ConsequentEstimator::LeastSquares => minimum_norm(design, &target),
        ConsequentEstimator::Recursive(InitialCovariance(factor)) => recursive(&design, &target, factor),
    }
}
