//! The contract of every control law: state and reference in, torque out, period passed in.
//!
//! Generic over N, the number of active joints, and B, the degrees of freedom of the base: 1 in the plane, 3 in space. The
//! defaults are the paper's arm.

use dem_model::Scalar;
use nalgebra::SVector;

/// What the laws know of the robot at a sampling instant.
///
/// Joint vectors hold the N active joints in the order of the arm, for two `[q2, q3]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement<T: Scalar, const N: usize = 2, const B: usize = 1> {
    /// Joint angles q_m, rad.
    pub position: SVector<T, N>,
    /// Joint velocities q̇_m, rad/s.
    pub velocity: SVector<T, N>,
    /// The free-floating base (DEM: passive joint 1).
    pub base: BaseMeasurement<T, B>,
}

/// What is known of the base. Controllers 3–6 and the `omitted` and `reduced` forms read none of it. Its attitude has no
/// effect on the arm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaseMeasurement<T: Scalar, const B: usize = 1> {
    /// Base velocity v_b in base axes, rad/s: q̇_1 in the plane, ω_b in space.
    pub velocity: SVector<T, B>,
    /// Base acceleration v̇_b in base axes, rad/s²: the differentiated velocity, or the plant's truth in a simulation.
    pub acceleration: SVector<T, B>,
}

impl<T: Scalar, const B: usize> BaseMeasurement<T, B> {
    /// What a law that reads nothing of the base may be given: a base at rest.
    pub fn at_rest() -> Self {
        Self { velocity: SVector::zeros(), acceleration: SVector::zeros() }
    }
}

impl<T: Scalar> BaseMeasurement<T> {
    /// A base in the plane that turns at `velocity`, rad/s, with `acceleration`, rad/s².
    pub fn planar(velocity: T, acceleration: T) -> Self {
        Self { velocity: SVector::from([velocity]), acceleration: SVector::from([acceleration]) }
    }
}

/// The desired motion of the active joints at a sampling instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reference<T: Scalar, const N: usize = 2> {
    /// q_mᵈ, rad.
    pub position: SVector<T, N>,
    /// q̇_mᵈ, rad/s.
    pub velocity: SVector<T, N>,
    /// q̈_mᵈ, rad/s².
    pub acceleration: SVector<T, N>,
}

/// What a law asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Command<T: Scalar, const N: usize = 2> {
    /// Joint torques τ_m, N·m, before any limit.
    pub torque: SVector<T, N>,
    /// The H∞ control input u of eq. 10.
    pub control_input: SVector<T, N>,
    /// What adaptation met in this cycle.
    pub adaptation: AdaptationStatus,
}

/// What a law met in one cycle. Only `fell_back` and `not_finite` can be `true` for a law that does not adapt.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AdaptationStatus {
    /// The projection moved Φ back to the border of its set.
    pub projected: bool,
    /// The alarm: Φ is on or beyond the border of the set it should stay in, projected or not.
    pub at_bound: bool,
    /// Φ stood still over the step to this cycle, because the torque was limited (anti-windup) or the law was told to hold it
    /// ([`Controller::hold_adaptation`]).
    pub frozen: bool,
    /// A value was met that cannot be worked with; the defined fallback was used: for a non-finite input or result the
    /// torque is zero, and Φ stands still over this step and the next, see [`Command::fallback`]. Other substitutes are
    /// documented with each law.
    pub fell_back: bool,
    /// The reason was a number that is not finite, in an input, Φ or the result: [`Command::fallback`]. Whoever sends the torques
    /// should stop then.
    pub not_finite: bool,
}

impl<T: Scalar, const N: usize> Command<T, N> {
    /// What leaves a law when its inputs or its result are not finite: no torque.
    ///
    /// Zero is the one torque that is safe without knowledge: whoever sends the torques stops upon
    /// [`AdaptationStatus::not_finite`]. An adaptive law keeps Φ as it was before the cycle and sets Φ̇ to zero, so that Φ
    /// stands still over the coming step too: a cycle that cannot be trusted teaches nothing.
    pub fn fallback(status: AdaptationStatus) -> Self {
        Self {
            torque: SVector::zeros(),
            control_input: SVector::zeros(),
            adaptation: AdaptationStatus { fell_back: true, not_finite: true, ..status },
        }
    }

    /// This command if its numbers are finite, otherwise the fallback.
    #[must_use]
    pub fn or_fallback(self) -> Self {
        let finite = self.torque.iter().chain(self.control_input.iter()).all(|value| value.is_finite());
        if finite { self } else { Self::fallback(self.adaptation) }
    }
}

/// Whether a law can work with what it got: finite numbers, and a period that is not negative. What is known of the base is
/// left out, since not every law reads it.
pub fn is_usable<T: Scalar, const N: usize, const B: usize>(
    measurement: &Measurement<T, N, B>,
    reference: &Reference<T, N>,
    period: T,
) -> bool {
    let vectors =
        [measurement.position, measurement.velocity, reference.position, reference.velocity, reference.acceleration];
    vectors.iter().all(|vector| vector.iter().all(|value| value.is_finite()))
        && period.is_finite()
        && period >= T::zero()
}

/// Which joints' torques left the limiter other than they came.
pub type LimitedJoints<const N: usize = 2> = [bool; N];

/// The most numbers that the state of any law holds for each joint.
pub(crate) const STATE_OF_A_JOINT: usize = 64;

/// The whole inner state of a law, copied out: a replay can start from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrozenState<T: Scalar, const N: usize = 2> {
    values: [[T; N]; STATE_OF_A_JOINT],
    len: usize,
}

impl<T: Scalar, const N: usize> FrozenState<T, N> {
    /// The most numbers that the state of any law for N joints holds.
    pub const CAPACITY: usize = N * STATE_OF_A_JOINT;

    /// A copy of `values`; `None` if there are more than [`CAPACITY`](Self::CAPACITY).
    pub fn new(values: &[T]) -> Option<Self> {
        let mut state = Self { len: values.len(), ..Self::empty() };
        state.values.as_flattened_mut().get_mut(..values.len())?.copy_from_slice(values);
        Some(state)
    }

    /// The state of a law that has none.
    pub fn empty() -> Self {
        Self { values: [[T::zero(); N]; STATE_OF_A_JOINT], len: 0 }
    }

    /// The first [`CAPACITY`](Self::CAPACITY) of `values`; a law checks at compile time that it has no more.
    pub(crate) fn gather(values: impl Iterator<Item = T>) -> Self {
        let mut state = Self::empty();
        for (slot, value) in state.values.as_flattened_mut().iter_mut().zip(values) {
            *slot = value;
            state.len += 1;
        }
        state
    }

    /// Checks that this is the state of a law that has none.
    pub(crate) fn expect_empty(&self) -> Result<(), ThawError> {
        if self.len == 0 { Ok(()) } else { Err(ThawError::Size { expected: 0, found: self.len }) }
    }

    /// The numbers that make up the state, in the order that the law documents.
    pub fn values(&self) -> &[T] {
        self.values.as_flattened().get(..self.len).unwrap_or(&[])
    }
}

/// Why a frozen state is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ThawError {
    /// It belongs to another law, or to another shape of the same law.
    #[error("the frozen state holds {found} numbers, this law has {expected}")]
    Size {
        /// Numbers that this law's state has.
        expected: usize,
        /// Numbers that were handed in.
        found: usize,
    },
    /// It holds a number that no law can have left in it.
    #[error("the frozen state holds a number that is not finite")]
    NotFinite,
}

/// A control law for N active joints on a base of B degrees of freedom.
///
/// The caller samples the robot, calls [`Controller::update`] once a cycle, limits the torque, and reports with
/// [`Controller::limited`] what the limiter did. A law never reads a clock, allocates or fails: bad configurations are
/// refused when it is built. Nothing non-finite leaves it, whatever comes in: see [`Command::fallback`].
pub trait Controller<T: Scalar, const N: usize = 2, const B: usize = 1> {
    /// One cycle. `period` is the time since the previous call in seconds, zero on the first: adaptive laws first step
    /// Φ over it with the Φ̇ of the previous call (explicit Euler), then compute the torque from the stepped Φ.
    fn update(&mut self, measurement: &Measurement<T, N, B>, reference: &Reference<T, N>, period: T) -> Command<T, N>;

    /// Tells the law which of its torques the limiter cut, after each [`Controller::update`].
    fn limited(&mut self, _joints: LimitedJoints<N>) {}

    /// Tells the law that the measurement of this cycle was no measurement of every joint, after [`Controller::limited`]: Φ
    /// stands still over the coming step.
    fn hold_adaptation(&mut self) {}

    /// The adapted parameters Φ; empty for a law that does not adapt.
    fn parameters(&self) -> &[T] {
        &[]
    }

    /// Back to the state in which it was built.
    fn reset(&mut self);

    /// The whole inner state.
    fn freeze(&self) -> FrozenState<T, N>;

    /// Goes on from a frozen state.
    ///
    /// # Errors
    /// [`ThawError`] if the state has another size than this law's, or is not finite; the law is then unchanged.
    fn thaw(&mut self, state: &FrozenState<T, N>) -> Result<(), ThawError>;
}
