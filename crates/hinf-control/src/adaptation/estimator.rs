//! The running state of an adaptive law.

use super::bound::is_finite;
use super::choices::{Adaptation, AntiWindup, Bound};
use super::weight::{AdaptationWeight, ScalarWeight};
use crate::{AdaptationStatus, Command, FrozenState, LimitedJoints, Measurement, Reference, ThawError, is_usable};
use dem_model::Scalar;
use nalgebra::{SMatrix, SVector};

/// What an adaptive law with G groups of K parameters computes in one cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptiveOutput<T: Scalar, const N: usize, const K: usize, const G: usize = 1> {
    /// Joint torques τ_m, N·m, before any limit.
    pub torque: SVector<T, N>,
    /// The H∞ control input u of eq. 10.
    pub control_input: SVector<T, N>,
    /// ΞᵀT11ᵀBᵀT0x̃, of which Φ̇ = −Z⁻¹·gradient (eqs. 18, 30, 36, 42, 45).
    pub gradient: SMatrix<T, K, G>,
    /// A part of the law was replaced by the substitute that the law documents; reported in
    /// [`AdaptationStatus::fell_back`].
    pub fell_back: bool,
}

/// Φ, Φ̇, and how both go on from cycle to cycle.
///
/// A law does all of its work in [`cycle`](Self::cycle), and passes on what the limiter did to [`limited`](Self::limited).
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterEstimator<T: Scalar, const K: usize, const G: usize = 1, Z = ScalarWeight<T>> {
    adaptation: Adaptation<T, K, G, Z>,
    parameters: SMatrix<T, K, G>,
    /// Φ̇ of the last cycle.
    rate: SMatrix<T, K, G>,
    /// Φ stands still over the coming step: by anti-windup, or because the law was told so.
    held: bool,
}

impl<T: Scalar, const K: usize, const G: usize, Z: AdaptationWeight<T, K, G>> ParameterEstimator<T, K, G, Z> {
    /// At Φ(0), at rest.
    pub fn new(adaptation: Adaptation<T, K, G, Z>) -> Self {
        let parameters = adaptation.initial;
        Self { adaptation, parameters, rate: SMatrix::zeros(), held: false }
    }

    /// The choices it was built with.
    pub fn adaptation(&self) -> &Adaptation<T, K, G, Z> {
        &self.adaptation
    }

    /// Φ.
    pub fn parameters(&self) -> &SMatrix<T, K, G> {
        &self.parameters
    }

    /// One cycle of an adaptive law: steps Φ, has `law` compute its output with the stepped Φ, and takes
    /// Φ̇ = −Z⁻¹·gradient for the coming step.
    ///
    /// Without usable inputs ([`is_usable`]), and wherever the stepped Φ, the output or Φ̇ is not
    /// finite, the cycle is void: [`Command::fallback`] is returned, Φ is what it was before the cycle, and Φ̇ is zero, so
    /// that Φ stands still over the coming step too.
    pub fn cycle<const N: usize, const B: usize>(
        &mut self,
        measurement: &Measurement<T, N, B>,
        reference: &Reference<T, N>,
        period: T,
        law: impl FnOnce(&SMatrix<T, K, G>) -> AdaptiveOutput<T, N, K, G>,
    ) -> Command<T, N> {
        if !is_usable(measurement, reference, period) {
            return self.fall_back();
        }
        let before = self.parameters;
        let mut status = self.step(period);
        let output = law(&self.parameters);
        self.rate = self.adaptation.weight.solve(&output.gradient);
        for rate in self.rate.as_mut_slice() {
            *rate = -*rate;
        }
        let finite = [&self.parameters, &self.rate].iter().all(|vector| is_finite(vector))
            && is_finite(&output.torque)
            && is_finite(&output.control_input);
        if !finite {
            self.parameters = before;
            return self.fall_back();
        }
        status.fell_back = output.fell_back;
        Command { torque: output.torque, control_input: output.control_input, adaptation: status }
    }

    /// Φ_k = Φ_{k−1} + `period`·Φ̇_{k−1} (explicit Euler), projected if so chosen.
    fn step(&mut self, period: T) -> AdaptationStatus {
        let mut status = AdaptationStatus { frozen: self.held, ..AdaptationStatus::default() };
        if !self.held {
            for (parameter, rate) in self.parameters.as_mut_slice().iter_mut().zip(self.rate.as_slice()) {
                *parameter += *rate * period;
            }
            status.projected = self.project();
        }
        self.held = false;
        status.at_bound = status.projected || self.is_at_bound();
        status
    }

    /// No torque; Φ stands still over the coming step.
    fn fall_back<const N: usize>(&mut self) -> Command<T, N> {
        self.rate.fill(T::zero());
        self.held = false;
        Command::fallback(AdaptationStatus::default())
    }

    /// What the limiter did with the torque of this cycle.
    pub fn limited<const N: usize>(&mut self, joints: LimitedJoints<N>) {
        let freezes = self.adaptation.anti_windup == AntiWindup::FreezeWhileLimited;
        self.held = freezes && joints.contains(&true);
    }

    /// Holds Φ over the coming step.
    pub const fn hold(&mut self) {
        self.held = true;
    }

    /// Back to Φ(0), at rest.
    pub fn reset(&mut self) {
        self.parameters = self.adaptation.initial;
        self.rate.fill(T::zero());
        self.held = false;
    }

    /// Φ, then Φ̇, then 1 if Φ is held over the coming step and 0 if not.
    pub fn freeze<const N: usize>(&self) -> FrozenState<T, N> {
        const { assert!(2 * K * G < FrozenState::<T, N>::CAPACITY, "the state must fit into FrozenState") };
        let held = if self.held { T::one() } else { T::zero() };
        FrozenState::gather(self.parameters.iter().chain(self.rate.iter()).copied().chain([held]))
    }

    /// Goes on from what [`freeze`](Self::freeze) gave.
    ///
    /// # Errors
    /// [`ThawError`] if the state has another size, or holds a number that is not finite.
    pub fn thaw<const N: usize>(&mut self, state: &FrozenState<T, N>) -> Result<(), ThawError> {
        let values = state.values();
        let (expected, found) = (2 * K * G + 1, values.len());
        if found != expected {
            return Err(ThawError::Size { expected, found });
        }
        if !values.iter().all(|value| value.is_finite()) {
            return Err(ThawError::NotFinite);
        }
        let (vectors, held) = values.split_at(2 * K * G);
        let (parameters, rate) = vectors.split_at(K * G);
        self.parameters.copy_from_slice(parameters);
        self.rate.copy_from_slice(rate);
        self.held = held.contains(&T::one());
        Ok(())
    }

    /// Projects Φ if so chosen; tells whether that moved it.
    fn project(&mut self) -> bool {
        match &self.adaptation.bound {
            Bound::Project(set) => set.project(&mut self.parameters, &self.adaptation.weight),
            Bound::None | Bound::Alarm(_) => false,
        }
    }

    fn is_at_bound(&self) -> bool {
        match &self.adaptation.bound {
            Bound::None => false,
            Bound::Project(set) | Bound::Alarm(set) => !set.contains_inside(&self.parameters, &self.adaptation.weight),
        }
    }
}
