//! The performance indices of the paper's section 4: L2 of the tracking error and E, the summed torque.

use crate::TrackingError;
use dem_model::Scalar;
use nalgebra::SVector;

/// Accumulates L2 = √(1/(t_r − t_0) ∫‖x̃‖² dt) and E = Σ_i ∫|τ_i| dt as left sums at the control rate.
///
/// t_r is the time at which the caller stops recording: when all joints have arrived.
///
/// ```
/// use hinf_control::{PerformanceIndices, TrackingError};
/// use nalgebra::Vector2;
/// let mut indices = PerformanceIndices::<f64>::new();
/// let error = TrackingError { velocity: Vector2::new(3.0, 0.0), position: Vector2::new(0.0, 4.0) };
/// indices.record(&error, &Vector2::new(1.0, -2.0), 0.5);
/// assert_eq!(indices.tracking(), 5.0);
/// assert_eq!(indices.torque(), 1.5);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerformanceIndices<T: Scalar> {
    squared_error: T,
    torque: T,
    elapsed: T,
}

impl<T: Scalar> PerformanceIndices<T> {
    /// Nothing recorded yet.
    pub fn new() -> Self {
        Self { squared_error: T::zero(), torque: T::zero(), elapsed: T::zero() }
    }

    /// One sample that stands for the `duration` (s) until the next: the error when it was taken, and the torque of the
    /// controller (N·m, the disturbance is not part of it) held from then on.
    pub fn record<const N: usize>(&mut self, error: &TrackingError<T, N>, torque: &SVector<T, N>, duration: T) {
        self.squared_error += error.norm_squared() * duration;
        self.torque += torque.fold(T::zero(), |sum, torque| sum + torque.abs()) * duration;
        self.elapsed += duration;
    }

    /// L2 of the state tracking error so far; zero before anything was recorded.
    pub fn tracking(&self) -> T {
        if self.elapsed > T::zero() { (self.squared_error / self.elapsed).sqrt() } else { T::zero() }
    }

    /// E so far, N·m·s. The paper relates it to energy, which has another unit.
    pub fn torque(&self) -> T {
        self.torque
    }

    /// The time recorded, t_r − t_0, s.
    pub fn elapsed(&self) -> T {
        self.elapsed
    }
}

impl<T: Scalar> Default for PerformanceIndices<T> {
    fn default() -> Self {
        Self::new()
    }
}
