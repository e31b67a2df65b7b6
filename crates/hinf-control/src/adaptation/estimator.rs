//! The running state of an adaptive law.

use super::{Adaptation, AdaptationWeight, AntiWindup, Bound, ScalarWeight, bound::is_finite};
use crate::{AdaptationStatus, Command, FrozenState, LimitedJoints, ThawError};
use dem_model::Scalar;
use nalgebra::SVector;

/// Φ, its rate, and how both go on from cycle to cycle.
///
/// A law calls [`step`](Self::step), computes its torque with [`parameters`](Self::parameters), and ends with
/// [`learn`](Self::learn). After the limiter has spoken, [`limited`](Self::limited).
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterEstimator<T: Scalar, const P: usize, Z = ScalarWeight<T>> {
    adaptation: Adaptation<T, P, Z>,
    parameters: SVector<T, P>,
    /// Φ̇ of the last cycle.
    rate: SVector<T, P>,
    /// Anti-windup holds Φ over the coming step.
    held: bool,
}

impl<T: Scalar, const P: usize, Z: AdaptationWeight<T, P>> ParameterEstimator<T, P, Z> {
    /// At Φ(0), at rest.
    pub fn new(adaptation: Adaptation<T, P, Z>) -> Self {
        const { assert!(2 * P < crate::STATE_CAPACITY, "the state must fit into FrozenState") };
        let parameters = adaptation.initial;
        Self { adaptation, parameters, rate: SVector::zeros(), held: false }
    }

    /// The choices it was built with.
    pub fn adaptation(&self) -> &Adaptation<T, P, Z> {
        &self.adaptation
    }

    /// Φ.
    pub fn parameters(&self) -> &SVector<T, P> {
        &self.parameters
    }

    /// Φ_k = Φ_{k−1} + `period`·Φ̇_{k−1} (explicit Euler), projected if so chosen. Where the sum overflows, Φ stands still.
    pub fn step(&mut self, period: T) -> AdaptationStatus {
        let mut status = AdaptationStatus { frozen: self.held, ..AdaptationStatus::default() };
        if !self.held {
            let stepped = self.parameters + self.rate * period;
            let next = self.bounded(stepped);
            status.projected = next != stepped;
            status.fell_back = !is_finite(&next);
            if is_finite(&next) {
                self.parameters = next;
            }
        }
        self.held = false;
        status.at_bound = status.projected || self.is_at_bound();
        status
    }

    /// Takes Φ̇ = −Z⁻¹`gradient` for the coming step, with `gradient` = ΞᵀT11ᵀBᵀT0x̃. If that is not finite, Φ stands still
    /// and `status` says so.
    pub fn learn(&mut self, gradient: &SVector<T, P>, status: &mut AdaptationStatus) {
        let rate = -self.adaptation.weight.solve(gradient);
        let usable = is_finite(&rate);
        self.rate = if usable { rate } else { SVector::zeros() };
        status.fell_back |= !usable;
    }

    /// The answer to inputs that cannot be worked with: no torque, and Φ stands still over this and the coming step.
    pub fn fall_back<const N: usize>(&mut self) -> Command<T, N> {
        self.rate.fill(T::zero());
        self.held = false;
        Command::fallback(AdaptationStatus::default())
    }

    /// What the limiter did with the torque of this cycle.
    pub fn limited<const N: usize>(&mut self, joints: LimitedJoints<N>) {
        let freezes = self.adaptation.anti_windup == AntiWindup::FreezeWhileLimited;
        self.held = freezes && joints.contains(&true);
    }

    /// Back to Φ(0), at rest.
    pub fn reset(&mut self) {
        self.parameters = self.adaptation.initial;
        self.rate.fill(T::zero());
        self.held = false;
    }

    /// Φ, then Φ̇, then 1 if anti-windup holds the coming step and 0 if not.
    pub fn freeze(&self) -> FrozenState<T> {
        let held = if self.held { T::one() } else { T::zero() };
        FrozenState::gather(self.parameters.iter().chain(self.rate.iter()).copied().chain([held]))
    }

    /// Goes on from what [`freeze`](Self::freeze) gave.
    ///
    /// # Errors
    /// [`ThawError`] if the state has another size, or holds a number that is not finite.
    pub fn thaw(&mut self, state: &FrozenState<T>) -> Result<(), ThawError> {
        let values = state.values();
        let (expected, found) = (2 * P + 1, values.len());
        if found != expected {
            return Err(ThawError::Size { expected, found });
        }
        if !values.iter().all(|value| value.is_finite()) {
            return Err(ThawError::NotFinite);
        }
        let (vectors, held) = values.split_at(2 * P);
        let (parameters, rate) = vectors.split_at(P);
        self.parameters.copy_from_slice(parameters);
        self.rate.copy_from_slice(rate);
        self.held = held.contains(&T::one());
        Ok(())
    }

    fn bounded(&self, parameters: SVector<T, P>) -> SVector<T, P> {
        match &self.adaptation.bound {
            Bound::Project(set) => set.nearest(&parameters, &self.adaptation.weight),
            Bound::None | Bound::Alarm(_) => parameters,
        }
    }

    fn is_at_bound(&self) -> bool {
        match &self.adaptation.bound {
            Bound::None => false,
            Bound::Project(set) | Bound::Alarm(set) => !set.contains_inside(&self.parameters, &self.adaptation.weight),
        }
    }
}
