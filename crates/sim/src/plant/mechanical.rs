//! A mechanism, its state and its brakes, moved by the fixed-step integrator.

use super::held::{Held, engages_on_motion, solve_free};
use super::integrator::{IntegrationStep, MotionState, runge_kutta_step};
use super::interface::{Brake, Plant};
use core::time::Duration;
use hinf_control::Disturbance;
use nalgebra::{SMatrix, SVector, Vector3};

/// The equations of motion M(q) q̈ + h(q, q̇) = f(q, q̇, τ) of a mechanism with `DOF` coordinates, among them three joints.
pub trait Mechanism<const DOF: usize> {
    /// Which coordinate is joint 1 (the base's attitude), 2 and 3.
    const JOINTS: [usize; 3];

    /// M(q) and h(q, q̇): what inertia does.
    fn inertial_terms(&self, state: &MotionState<DOF>) -> InertialTerms<DOF>;

    /// f(q, q̇, τ): everything else, from `motor` (commanded joint torques, N·m) and `disturbance` (N·m at the joints).
    fn applied_force(
        &self,
        state: &MotionState<DOF>,
        motor: &Vector3<f64>,
        disturbance: &Vector3<f64>,
    ) -> SVector<f64, DOF>;

    /// The whole state that belongs to joint angles (rad) and velocities (rad/s).
    fn place(&self, position: &Vector3<f64>, velocity: &Vector3<f64>) -> MotionState<DOF>;
}

/// The inertial side of the equations of motion at one state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InertialTerms<const DOF: usize> {
    /// M(q), symmetric positive definite.
    pub mass: SMatrix<f64, DOF, DOF>,
    /// h(q, q̇), the Coriolis and centrifugal forces.
    pub velocity_force: SVector<f64, DOF>,
}

/// Joint angles and velocities at plant time zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialState {
    /// Joint angles, rad.
    pub position: Vector3<f64>,
    /// Joint velocities, rad/s.
    pub velocity: Vector3<f64>,
}

impl InitialState {
    /// The paper's start: the base at 0, joints 2 and 3 at 20°, at rest.
    pub fn paper() -> Self {
        let start = 20.0_f64.to_radians();
        Self { position: Vector3::new(0.0, start, start), velocity: Vector3::zeros() }
    }
}

impl Default for InitialState {
    fn default() -> Self {
        Self::paper()
    }
}

/// A [`Plant`] made of a [`Mechanism`]: state, plant time, disturbance and brakes.
///
/// Brakes are ideal: an engaged brake holds its joint's acceleration at zero. When it engages on a moving joint, it stops
/// that joint at once as a plastic impact does: the momenta conjugate to the free coordinates do not change, and the kinetic
/// energy does not grow.
///
/// A non-finite torque makes the state non-finite: callers check what they command.
#[derive(Clone, Debug)]
pub struct MechanicalPlant<M, const DOF: usize> {
    mechanism: M,
    disturbance: Disturbance,
    step: IntegrationStep,
    time: Duration,
    state: MotionState<DOF>,
}

impl<M: Mechanism<DOF>, const DOF: usize> MechanicalPlant<M, DOF> {
    /// The mechanism at plant time zero in the paper's initial state, undisturbed.
    pub fn from_mechanism(mechanism: M) -> Self {
        let InitialState { position, velocity } = InitialState::paper();
        let state = mechanism.place(&position, &velocity);
        Self { mechanism, disturbance: Disturbance::None, step: IntegrationStep::DEFAULT, time: Duration::ZERO, state }
    }

    /// The same plant with another start.
    #[must_use]
    pub fn with_initial_state(mut self, initial: InitialState) -> Self {
        self.state = self.mechanism.place(&initial.position, &initial.velocity);
        self
    }

    /// The same plant, disturbed.
    #[must_use]
    pub fn with_disturbance(mut self, disturbance: Disturbance) -> Self {
        self.disturbance = disturbance;
        self
    }

    /// The same plant on another grid.
    #[must_use]
    pub fn with_integration_step(mut self, step: IntegrationStep) -> Self {
        self.step = step;
        self
    }

    /// The mechanism.
    pub fn mechanism(&self) -> &M {
        &self.mechanism
    }

    /// All coordinates and their velocities.
    pub fn motion_state(&self) -> &MotionState<DOF> {
        &self.state
    }

    /// Kinetic energy ½ q̇ᵀ M q̇, J.
    pub fn kinetic_energy(&self) -> f64 {
        let velocity = &self.state.velocity;
        0.5 * velocity.dot(&(self.mechanism.inertial_terms(&self.state).mass * velocity))
    }

    /// Joint accelerations, rad/s², now under `torque` (N·m) and the disturbance, with the joints in `brakes` held.
    pub fn acceleration(&self, torque: &Vector3<f64>, brakes: [Brake; 3]) -> Vector3<f64> {
        let disturbance = joint_torque(self.disturbance, self.time, 0.0);
        let held = held_coordinates::<M, DOF>(brakes);
        joints::<M, DOF>(&coordinate_acceleration(&self.mechanism, &self.state, torque, &disturbance, &held))
    }

    /// Like [`Plant::advance`] with a torque (N·m) that varies with plant time (s), smooth between the grid's points.
    pub fn advance_under(&mut self, until: Duration, torque: impl Fn(f64) -> Vector3<f64>, brakes: [Brake; 3]) {
        let held = held_coordinates::<M, DOF>(brakes);
        self.stop_held_joints(&held);
        if brakes == [Brake::Engaged; 3] && self.is_at_rest(&held) {
            // What integrating would give as well, step by step; a robot may stand for hours.
            self.time = self.time.max(until);
            return;
        }
        for step in self.step.steps(self.disturbance, self.time, until) {
            let start = step.start.as_secs_f64();
            self.state = runge_kutta_step(&self.state, step.seconds(), |offset, state| {
                let disturbance = joint_torque(self.disturbance, step.start, offset);
                let torque = torque(start + offset);
                MotionState {
                    position: state.velocity,
                    velocity: coordinate_acceleration(&self.mechanism, state, &torque, &disturbance, &held),
                }
            });
            self.time = step.end;
        }
    }

    /// True if nothing moves and nothing will: with all joints held, neither motors nor the disturbance move anything.
    fn is_at_rest(&self, held: &Held<DOF>) -> bool {
        let nothing = Vector3::zeros();
        let still = |vector: &SVector<f64, DOF>| vector.iter().all(|entry| *entry == 0.0);
        still(&self.state.velocity)
            && still(&coordinate_acceleration(&self.mechanism, &self.state, &nothing, &nothing, held))
    }

    fn stop_held_joints(&mut self, held: &Held<DOF>) {
        if !engages_on_motion(held, &self.state.velocity) {
            return;
        }
        let mass = self.mechanism.inertial_terms(&self.state).mass;
        self.state.velocity = solve_free(mass, mass * self.state.velocity, held);
    }
}

impl<M: Mechanism<DOF>, const DOF: usize> Plant for MechanicalPlant<M, DOF> {
    fn time(&self) -> Duration {
        self.time
    }

    fn position(&self) -> Vector3<f64> {
        joints::<M, DOF>(&self.state.position)
    }

    fn velocity(&self) -> Vector3<f64> {
        joints::<M, DOF>(&self.state.velocity)
    }

    fn advance(&mut self, until: Duration, torque: &Vector3<f64>, brakes: [Brake; 3]) {
        self.advance_under(until, |_| *torque, brakes);
    }
}

/// The entries of `vector` that belong to the joints.
fn joints<M: Mechanism<DOF>, const DOF: usize>(vector: &SVector<f64, DOF>) -> Vector3<f64> {
    Vector3::from(M::JOINTS.map(|index| vector.get(index).copied().unwrap_or(f64::NAN)))
}

fn held_coordinates<M: Mechanism<DOF>, const DOF: usize>(brakes: [Brake; 3]) -> Held<DOF> {
    core::array::from_fn(|coordinate| {
        let joint = M::JOINTS.iter().position(|index| *index == coordinate);
        joint.and_then(|joint| brakes.get(joint)).copied().unwrap_or(Brake::Released)
    })
}

fn coordinate_acceleration<M: Mechanism<DOF>, const DOF: usize>(
    mechanism: &M,
    state: &MotionState<DOF>,
    torque: &Vector3<f64>,
    disturbance: &Vector3<f64>,
    held: &Held<DOF>,
) -> SVector<f64, DOF> {
    let terms = mechanism.inertial_terms(state);
    solve_free(terms.mass, mechanism.applied_force(state, torque, disturbance) - terms.velocity_force, held)
}

/// The disturbance at the three joints, N·m: none acts on the base.
fn joint_torque(disturbance: Disturbance, time: Duration, offset: f64) -> Vector3<f64> {
    let [joint_2, joint_3] = disturbance.torque::<2>(time, offset).into();
    Vector3::new(0.0, joint_2, joint_3)
}
