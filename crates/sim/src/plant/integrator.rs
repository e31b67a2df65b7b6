//! Fixed-step integration of a mechanism's motion.

use core::time::Duration;
use nalgebra::SVector;

/// Generalised coordinates and their velocities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionState<const DOF: usize> {
    /// Generalised coordinates, rad or m.
    pub position: SVector<f64, DOF>,
    /// Their velocities, rad/s or m/s.
    pub velocity: SVector<f64, DOF>,
}

/// One step of the classic fourth-order Runge-Kutta method for q̈ = f(s, q, q̇), s the seconds since the step's start.
pub fn runge_kutta_step<const DOF: usize>(
    start: &MotionState<DOF>,
    step: f64,
    acceleration: impl Fn(f64, &MotionState<DOF>) -> SVector<f64, DOF>,
) -> MotionState<DOF> {
    let half = 0.5 * step;
    let moved = |velocity: &SVector<f64, DOF>, acceleration: &SVector<f64, DOF>, by: f64| MotionState {
        position: start.position + velocity * by,
        velocity: start.velocity + acceleration * by,
    };
    let a1 = acceleration(0.0, start);
    let second = moved(&start.velocity, &a1, half);
    let a2 = acceleration(half, &second);
    let third = moved(&second.velocity, &a2, half);
    let a3 = acceleration(half, &third);
    let fourth = moved(&third.velocity, &a3, step);
    let a4 = acceleration(step, &fourth);
    let sixth = step / 6.0;
    MotionState {
        position: start.position
            + (start.velocity + (second.velocity + third.velocity) * 2.0 + fourth.velocity) * sixth,
        velocity: start.velocity + (a1 + (a2 + a3) * 2.0 + a4) * sixth,
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
                state = runge_kutta_step(&state, step, |_, state| -state.position);
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
        let end = runge_kutta_step(&start, 2.0, |s, _| SVector::<f64, 1>::new(3.0 * s * s));
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
}
