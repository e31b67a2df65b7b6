//! Fixed-step integration of a mechanism's motion.

use core::ops::{Add, Mul};
use core::time::Duration;
use hinf_control::Disturbance;
use nalgebra::SVector;

/// A state that a rate moves: what [`runge_kutta_step`] integrates.
pub trait Integrable: Copy {
    /// What the state's entries change by in a second.
    type Rate: Copy + Add<Output = Self::Rate> + Mul<f64, Output = Self::Rate>;

    /// The state after `seconds` at a constant `rate`.
    fn moved(&self, rate: &Self::Rate, seconds: f64) -> Self;
}

/// Generalised coordinates and their velocities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionState<const DOF: usize> {
    /// Generalised coordinates, rad or m.
    pub position: SVector<f64, DOF>,
    /// Their velocities, rad/s or m/s.
    pub velocity: SVector<f64, DOF>,
}

impl<const DOF: usize> Add for MotionState<DOF> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { position: self.position + other.position, velocity: self.velocity + other.velocity }
    }
}

impl<const DOF: usize> Mul<f64> for MotionState<DOF> {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self { position: self.position * factor, velocity: self.velocity * factor }
    }
}

/// Its rate has the velocity in place of the position, and the acceleration in place of the velocity.
impl<const DOF: usize> Integrable for MotionState<DOF> {
    type Rate = Self;

    fn moved(&self, rate: &Self, seconds: f64) -> Self {
        *self + *rate * seconds
    }
}

/// One step of the classic fourth-order Runge-Kutta method for ẋ = f(s, x), s the seconds since the step's start.
pub fn runge_kutta_step<S: Integrable>(start: &S, step: f64, rate: impl Fn(f64, &S) -> S::Rate) -> S {
    let half = 0.5 * step;
    let first = rate(0.0, start);
    let second = rate(half, &start.moved(&first, half));
    let third = rate(half, &start.moved(&second, half));
    let fourth = rate(step, &start.moved(&third, step));
    start.moved(&(first + (second + third) * 2.0 + fourth), step / 6.0)
}

/// A step of the grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct GridStep {
    /// Plant time at its start.
    pub start: Duration,
    /// Plant time at its end.
    pub end: Duration,
}

impl GridStep {
    /// Its length in s.
    pub fn seconds(&self) -> f64 {
        (self.end - self.start).as_secs_f64()
    }
}

/// The grid on which a plant integrates: whole multiples of one step from plant time zero.
///
/// The grid is absolute, so that the result does not depend on how the caller cuts time into calls, as long as it cuts
/// on the grid. A cut elsewhere, and an event of the disturbance, only adds a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IntegrationStep(Duration);

impl IntegrationStep {
    /// 100 µs: 30 steps in the paper's period of 3 ms, and t = 1 s, where the disturbance starts, lies on the grid.
    pub const DEFAULT: Self = Self(Duration::from_micros(100));
    /// 1 ms: for studies of thousands of experiments. The UARM's fastest part, Coulomb friction around standstill, has a time
    /// constant of about 5 ms, so that RK4's error stays far below a count of the encoders.
    pub const COARSE: Self = Self(Duration::from_millis(1));
    /// The shortest step: below it a real-time thread would do nothing but integrate.
    pub const SHORTEST: Duration = Duration::from_micros(1);
    /// The longest step: RK4 is still stable with the UARM's friction, the fastest part of any plant here.
    pub const LONGEST: Duration = Duration::from_millis(10);

    /// A step; `None` outside [`SHORTEST`](Self::SHORTEST)..=[`LONGEST`](Self::LONGEST).
    pub fn new(step: Duration) -> Option<Self> {
        (Self::SHORTEST..=Self::LONGEST).contains(&step).then_some(Self(step))
    }

    /// The step.
    pub const fn duration(self) -> Duration {
        self.0
    }

    /// The first grid point after `time`.
    pub fn next_grid_point(self, time: Duration) -> Duration {
        let into_step = time.as_nanos() % self.0.as_nanos();
        // The remainder is below the step, which is at most LONGEST: it fits.
        let into_step = Duration::from_nanos(u64::try_from(into_step).unwrap_or(0));
        time + (self.0 - into_step)
    }

    /// The steps from `time` to `until`, which end on the grid, on `until` and where the `disturbance` is not smooth.
    pub(super) fn steps(
        self,
        disturbance: Disturbance,
        time: Duration,
        until: Duration,
    ) -> impl Iterator<Item = GridStep> {
        let step_from = move |start: Duration| {
            let grid = self.next_grid_point(start).min(until);
            let end = disturbance.next_event_after(start).map_or(grid, |event| event.min(grid));
            (start < until).then_some(GridStep { start, end })
        };
        core::iter::successors(step_from(time), move |last| step_from(last.end))
    }
}

impl Default for IntegrationStep {
    fn default() -> Self {
        Self::DEFAULT
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::SVector;

    /// q̈ = −q: the error after one second must fall by 2⁴ when the step is halved.
    #[test]
    fn order_is_four() {
        let error = |steps: u32| {
            let mut state =
                MotionState { position: SVector::<f64, 1>::new(1.0), velocity: SVector::<f64, 1>::new(0.0) };
            let step = 1.0 / f64::from(steps);
            for _ in 0..steps {
                state = runge_kutta_step(&state, step, |_, state| MotionState {
                    position: state.velocity,
                    velocity: -state.position,
                });
            }
            (state.position.x - 1.0_f64.cos()).abs() + (state.velocity.x + 1.0_f64.sin()).abs()
        };
        let order = (error(50) / error(100)).log2();
        assert!((3.9..4.1).contains(&order), "order {order}");
    }

    /// A force that is a polynomial of time of degree two is integrated without error in the velocity (Simpson).
    #[test]
    fn time_within_the_step_reaches_the_force() {
        let start = MotionState { position: SVector::<f64, 1>::new(0.0), velocity: SVector::<f64, 1>::new(0.0) };
        let end = runge_kutta_step(&start, 2.0, |s, state| MotionState {
            position: state.velocity,
            velocity: SVector::<f64, 1>::new(3.0 * s * s),
        });
        approx::assert_relative_eq!(end.velocity.x, 8.0, max_relative = 1e-15);
    }

    #[test]
    fn grid_points_are_multiples_of_the_step() {
        let step = IntegrationStep::DEFAULT;
        assert_eq!(step.next_grid_point(Duration::ZERO), Duration::from_micros(100));
        assert_eq!(step.next_grid_point(Duration::from_nanos(1)), Duration::from_micros(100));
        assert_eq!(step.next_grid_point(Duration::from_micros(100)), Duration::from_micros(200));
        assert_eq!(IntegrationStep::new(Duration::ZERO), None);
    }

    #[test]
    fn steps_end_on_the_grid_at_the_event_and_at_the_end() {
        let step = IntegrationStep::new(Duration::from_millis(3)).unwrap();
        let milliseconds = Duration::from_millis;
        let steps = step.steps(Disturbance::Paper, milliseconds(997), milliseconds(1_004));
        let ends: std::vec::Vec<_> = steps.map(|step| step.end).collect();
        assert_eq!(ends, [999, 1_000, 1_002, 1_004].map(milliseconds));
        assert_eq!(step.steps(Disturbance::None, milliseconds(1), milliseconds(1)).count(), 0);
    }
}
