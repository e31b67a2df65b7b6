//! The estimator: a method and the last estimate that it made.

use super::estimate::{Estimate, EstimationMethod, Real};

/// An estimator's whole state: its last estimate, none before the first measurement.
pub type EstimatorState<T> = Option<Estimate<T>>;

/// Makes velocities and accelerations of measured angles by the method `M`; plain data, a copy of it is a snapshot.
///
/// The first measurement, after construction or [`VelocityEstimator::reset_unknown`], is taken as a joint at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocityEstimator<T, M> {
    method: M,
    state: EstimatorState<T>,
}

impl<T: Real, M: EstimationMethod<T>> VelocityEstimator<T, M> {
    /// An estimator that has measured nothing yet.
    pub const fn new(method: M) -> Self {
        Self { method, state: None }
    }

    /// The method.
    pub const fn method(&self) -> &M {
        &self.method
    }

    /// The estimate after measuring `position` rad, `period` s after the previous measurement; the period of the first
    /// call does not matter.
    ///
    /// A period that is not finite or not above zero leaves the estimate as it is: without time there is no difference, and
    /// the next step gets the whole of it.
    pub fn update(&mut self, position: T, period: T) -> Estimate<T> {
        let estimate = match &self.state {
            None => Estimate::at_rest(position),
            Some(last) if period.is_positive_finite() => self.method.step(last, position, period),
            Some(last) => *last,
        };
        self.state = Some(estimate);
        estimate
    }

    /// The whole state, to be put back with [`VelocityEstimator::thaw`].
    pub const fn freeze(&self) -> EstimatorState<T> {
        self.state
    }

    /// Goes on from a frozen state.
    pub const fn thaw(&mut self, state: EstimatorState<T>) {
        self.state = state;
    }

    /// Starts again, at rest at `position` rad.
    pub fn reset(&mut self, position: T) {
        self.state = Some(Estimate::at_rest(position));
    }

    /// Starts again, at rest where the next measurement will be.
    pub const fn reset_unknown(&mut self) {
        self.state = None;
    }
}
