//! The torque limiter: saturation and rate limit, both torques reported.

use crate::LimitedJoints;
use dem_model::Scalar;
use nalgebra::SVector;

/// What a robot's joints can be asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueLimits<T: Scalar, const N: usize = 2> {
    magnitude: SVector<T, N>,
    rate: Option<SVector<T, N>>,
}

/// Why limits are refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TorqueLimitError {
    /// A magnitude is not a positive finite number.
    #[error("a torque limit is {found} N·m, expected a positive finite number")]
    Magnitude {
        /// What was found, N·m.
        found: f64,
    },
    /// A rate is not a positive finite number.
    #[error("a torque rate limit is {found} N·m/s, expected a positive finite number")]
    Rate {
        /// What was found, N·m/s.
        found: f64,
    },
}

impl<T: Scalar, const N: usize> TorqueLimits<T, N> {
    /// Largest magnitude of each joint's torque, N·m.
    ///
    /// # Errors
    /// [`TorqueLimitError::Magnitude`] if one is not positive and finite.
    pub fn new(magnitude: SVector<T, N>) -> Result<Self, TorqueLimitError> {
        match first_not_positive(&magnitude) {
            Some(found) => Err(TorqueLimitError::Magnitude { found }),
            None => Ok(Self { magnitude, rate: None }),
        }
    }

    /// The same, with the largest rate of each joint's torque, N·m/s.
    ///
    /// # Errors
    /// [`TorqueLimitError::Rate`] if one is not positive and finite.
    pub fn with_rate(self, rate: SVector<T, N>) -> Result<Self, TorqueLimitError> {
        match first_not_positive(&rate) {
            Some(found) => Err(TorqueLimitError::Rate { found }),
            None => Ok(Self { rate: Some(rate), ..self }),
        }
    }

    /// Largest magnitude of each joint's torque, N·m.
    pub fn magnitude(&self) -> &SVector<T, N> {
        &self.magnitude
    }

    /// Largest rate of each joint's torque, N·m/s; `None` if the rate is not limited.
    pub fn rate(&self) -> Option<&SVector<T, N>> {
        self.rate.as_ref()
    }
}

fn first_not_positive<T: Scalar, const N: usize>(values: &SVector<T, N>) -> Option<f64> {
    values.iter().find(|value| !(value.is_finite() && **value > T::zero())).map(|value| value.to_f64())
}

/// A torque that is no finite number was asked for: there is nothing to limit.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the torque asked of active joint {joint} is {found}, expected a finite number")]
pub struct TorqueNotFinite {
    /// The active joint, counted from 1.
    pub joint: usize,
    /// What was asked for, N·m.
    pub found: f64,
}

/// What came in and what goes out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitedTorque<T: Scalar, const N: usize = 2> {
    /// What was asked for, N·m.
    pub requested: SVector<T, N>,
    /// What the drives get, N·m: always finite and within the limits.
    pub applied: SVector<T, N>,
    /// Which joints got something else than requested, for [`Controller::limited`](crate::Controller::limited).
    pub limited: LimitedJoints<N>,
}

/// Keeps torques within [`TorqueLimits`]. Remembers the torque applied last, zero at first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueLimiter<T: Scalar, const N: usize = 2> {
    limits: TorqueLimits<T, N>,
    applied: SVector<T, N>,
}

impl<T: Scalar, const N: usize> TorqueLimiter<T, N> {
    /// A limiter whose torque stands at zero.
    pub fn new(limits: TorqueLimits<T, N>) -> Self {
        Self { limits, applied: SVector::zeros() }
    }

    /// The torque applied last, N·m: the whole inner state.
    pub fn applied(&self) -> &SVector<T, N> {
        &self.applied
    }

    /// Goes on as if `applied`, N·m, had been applied last. What lies beyond the limits, or is no number, counts as zero.
    pub fn thaw(&mut self, applied: SVector<T, N>) {
        let within = |value: T, limit: T| if value.abs() <= limit { value } else { T::zero() };
        self.applied = applied.zip_map(&self.limits.magnitude, within);
    }

    /// The limits.
    pub fn limits(&self) -> &TorqueLimits<T, N> {
        &self.limits
    }

    /// Limits `requested` (N·m). `period` (s) is the time over which the torque may change: the scheduled period, on the
    /// first call too. If it is not positive and finite, a limited rate leaves the torque where it was.
    ///
    /// # Errors
    /// [`TorqueNotFinite`] for the first such request; the limiter is as it was before.
    pub fn limit(&mut self, requested: SVector<T, N>, period: T) -> Result<LimitedTorque<T, N>, TorqueNotFinite> {
        if let Some((index, torque)) = requested.iter().enumerate().find(|(_, torque)| !torque.is_finite()) {
            return Err(TorqueNotFinite { joint: index + 1, found: torque.to_f64() });
        }
        let saturated =
            requested.zip_map(&self.limits.magnitude, |torque, magnitude| torque.clamp(-magnitude, magnitude));
        let applied = match self.limits.rate {
            None => saturated,
            Some(rate) => {
                let time = if period.is_finite() { period.max(T::zero()) } else { T::zero() };
                let step = self.applied.zip_zip_map(&saturated, &(rate * time), towards);
                // The sum in `towards` may round to just outside.
                step.zip_map(&self.limits.magnitude, |torque, magnitude| torque.clamp(-magnitude, magnitude))
            }
        };
        self.applied = applied;
        Ok(LimitedTorque { requested, applied, limited: applied.zip_map(&requested, |a, r| a != r).into() })
    }

    /// Back to zero torque.
    pub fn reset(&mut self) {
        self.applied = SVector::zeros();
    }
}

/// `goal`, or as far towards it from `before` as `bound` allows.
fn towards<T: Scalar>(before: T, goal: T, bound: T) -> T {
    let change = goal - before;
    if change.abs() <= bound { goal } else { before + bound.copysign(change) }
}
