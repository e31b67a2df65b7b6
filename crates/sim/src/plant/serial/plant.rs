//! An arm of N joints on its base, moved by the fixed-step integrator.

use super::imperfections::SerialImperfections;
use super::motion::{PoseOf, SerialMotion};
use super::pose::{BasePose, FloatingPose, PosedBase, halves};
use crate::plant::held::{engages_on_motion, solve_free};
use crate::plant::integrator::{IntegrationStep, runge_kutta_step};
use crate::plant::interface::Brake;
use core::time::Duration;
use dem_model::{BaseFreedom, SerialAcceleration, SerialDynamics, SerialManipulator};
use hinf_control::Disturbance;
use nalgebra::{SVector, Vector3};

/// An arm of `N` joints on a base of `B` degrees of freedom as a plant: M v̇ + C v = τ, with friction, gains, disturbance and
/// brakes, and the pose that v_b moves.
///
/// The attitude in space is a quaternion that the classic Runge-Kutta method integrates as four numbers and that is divided by
/// its norm after each step: the norm does not drift, and the method keeps its order.
///
/// Brakes are ideal, as in [`MechanicalPlant`](crate::MechanicalPlant): an engaged one holds its joint, and stops one that
/// moves as a plastic impact does. A torque that is not finite makes the state so: callers check what they command.
#[derive(Clone, Debug)]
pub struct SerialPlant<const N: usize, const B: usize>
where
    BaseFreedom<B>: PosedBase<B>,
{
    arm: SerialManipulator<f64, N, B>,
    imperfections: SerialImperfections<N>,
    disturbance: Disturbance,
    step: IntegrationStep,
    time: Duration,
    motion: SerialMotion<N, B>,
}

/// The DEM in the plane, whose base turns about a passive joint.
pub type PlanarBasePlant<const N: usize> = SerialPlant<N, 1>;
/// The DEM in space, whose base turns about a passive spherical joint.
pub type SphericalBasePlant<const N: usize> = SerialPlant<N, 3>;
/// The space manipulator as it is: its spacecraft floats.
pub type SerialSpacePlant<const N: usize> = SerialPlant<N, 6>;

/// What holds the joints, and the base.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SerialBrakes<const N: usize> {
    /// Engaged, it holds the base in inertial space.
    pub base: Brake,
    /// The joints', from the base outwards.
    pub joints: [Brake; N],
}

impl<const N: usize> SerialBrakes<N> {
    /// Nothing is held.
    pub const RELEASED: Self = Self { base: Brake::Released, joints: [Brake::Released; N] };
}

impl<const N: usize, const B: usize> SerialPlant<N, B>
where
    BaseFreedom<B>: PosedBase<B>,
{
    /// The arm at plant time zero, at rest with all coordinates at zero, undisturbed.
    pub fn new(arm: SerialManipulator<f64, N, B>, imperfections: SerialImperfections<N>) -> Self {
        Self {
            arm,
            imperfections,
            disturbance: Disturbance::None,
            step: IntegrationStep::DEFAULT,
            time: Duration::ZERO,
            motion: SerialMotion::at_rest(SVector::zeros()),
        }
    }

    /// The same plant with another start.
    #[must_use]
    pub fn with_motion(mut self, motion: SerialMotion<N, B>) -> Self {
        self.motion = motion;
        self
    }

    /// The same plant, disturbed: the first joints of the arm are those that the disturbance acts on.
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

    /// The arm.
    pub fn arm(&self) -> &SerialManipulator<f64, N, B> {
        &self.arm
    }

    /// Pose, coordinates and velocities.
    pub fn motion(&self) -> &SerialMotion<N, B> {
        &self.motion
    }

    /// Plant time.
    pub fn time(&self) -> Duration {
        self.time
    }

    /// From base axes to inertial axes.
    pub fn attitude(&self) -> nalgebra::UnitQuaternion<f64> {
        self.motion.pose.attitude()
    }

    /// Kinetic energy ½ vᵀ M v, J.
    pub fn kinetic_energy(&self) -> f64 {
        let state = &self.motion.state;
        self.arm.dynamics(state).kinetic_energy(&state.base_velocity, &state.velocity)
    }

    /// Angular momentum about the inertial origin in inertial axes, N·m·s: constant unless something acts on the base.
    pub fn angular_momentum(&self) -> Vector3<f64> {
        self.motion.pose.angular_momentum(&self.base_momentum())
    }

    /// M_bb v_b + M_bm q̇_m.
    fn base_momentum(&self) -> SVector<f64, B> {
        let state = &self.motion.state;
        self.arm.dynamics(state).momentum(&state.base_velocity, &state.velocity).0
    }

    /// Moves on to `until` with `base_torque` on the base (N·m, and N where it floats, base axes; nothing of the arm's own
    /// can act there) and a motor `torque` (N·m or N) that varies with plant time (s), smooth between the grid's points.
    pub fn advance_under(
        &mut self,
        until: Duration,
        base_torque: &SVector<f64, B>,
        torque: impl Fn(f64) -> SVector<f64, N>,
        brakes: SerialBrakes<N>,
    ) {
        self.stop_held(&brakes);
        if self.is_at_rest(base_torque, &brakes) {
            self.time = self.time.max(until);
            return;
        }
        for step in self.step.steps(self.disturbance, self.time, until) {
            let start = step.start.as_secs_f64();
            let next = runge_kutta_step(&self.motion, step.seconds(), |offset, motion| {
                let disturbance = self.disturbance.torque::<N>(step.start, offset);
                motion.rate(self.acceleration(motion, base_torque, &torque(start + offset), &disturbance, &brakes))
            });
            self.motion = next.normalised();
            self.time = step.end;
        }
    }

    /// True if nothing moves and nothing will: all joints are held, and nothing turns the base.
    fn is_at_rest(&self, base_torque: &SVector<f64, B>, brakes: &SerialBrakes<N>) -> bool {
        let state = &self.motion.state;
        let held = brakes.joints.iter().all(|brake| *brake == Brake::Engaged);
        let still = state.velocity.iter().chain(state.base_velocity.iter()).all(|entry| *entry == 0.0);
        let left_alone = brakes.base == Brake::Engaged || base_torque.iter().all(|entry| *entry == 0.0);
        held && still && left_alone
    }

    fn stop_held(&mut self, brakes: &SerialBrakes<N>) {
        let state = &self.motion.state;
        let base = brakes.base == Brake::Engaged && state.base_velocity.iter().any(|entry| *entry != 0.0);
        if base || engages_on_motion(&brakes.joints, &state.velocity) {
            let dynamics = self.arm.dynamics(state);
            let (base, joints) = dynamics.momentum(&state.base_velocity, &state.velocity);
            let velocity = solve(&dynamics, &base, &joints, brakes);
            self.motion.state.base_velocity = velocity.base;
            self.motion.state.velocity = velocity.joints;
        }
    }

    fn acceleration(
        &self,
        motion: &SerialMotion<N, B>,
        base_torque: &SVector<f64, B>,
        torque: &SVector<f64, N>,
        disturbance: &SVector<f64, N>,
        brakes: &SerialBrakes<N>,
    ) -> SerialAcceleration<f64, N, B> {
        let state = &motion.state;
        let dynamics = self.arm.dynamics(state);
        let (base, joints) = dynamics.coriolis_torque(&state.base_velocity, &state.velocity);
        let base = base_torque + self.imperfections.base_torque(&state.base_velocity) - base;
        let joints = self.imperfections.joint_torque(torque, &state.velocity) + disturbance - joints;
        solve(&dynamics, &base, &joints, brakes)
    }
}

impl<const N: usize> SerialSpacePlant<N> {
    /// Linear momentum in inertial axes, kg·m/s: constant unless something acts on the spacecraft.
    pub fn linear_momentum(&self) -> Vector3<f64> {
        self.motion.pose.attitude * halves(&self.base_momentum()).1
    }

    /// Centre of mass of the whole in inertial axes, m.
    pub fn centre_of_mass(&self) -> Vector3<f64> {
        let FloatingPose { attitude, place } = self.motion.pose;
        place + attitude * self.centre_in_base_axes()
    }

    /// The same plant, put where the centre of mass of the whole is at rest in the inertial origin: what its DEM moves like.
    #[must_use]
    pub fn about_centre_of_mass(mut self) -> Self {
        let centre = self.centre_in_base_axes();
        let pose: &mut PoseOf<6> = &mut self.motion.pose;
        pose.place = -(pose.attitude * centre);
        let drift = halves(&self.base_momentum()).1 / self.total_mass();
        for (entry, drift) in self.motion.state.base_velocity.iter_mut().skip(3).zip(drift.iter()) {
            *entry -= drift;
        }
        self
    }

    /// kg.
    fn total_mass(&self) -> f64 {
        self.arm.dynamics(&self.motion.state).mass_bb.m44
    }

    /// From the spacecraft's centre of mass, m. The momentum of a base that turns is m ω × c.
    fn centre_in_base_axes(&self) -> Vector3<f64> {
        let mass = self.arm.dynamics(&self.motion.state).mass_bb;
        Vector3::new(mass.m53, mass.m61, mass.m42) / mass.m44
    }
}

/// Solves M x = b for x = (x_b, x_m) with the entries that brakes hold at zero. Not a number if M is not positive definite (a
/// state that is not finite), which does not go unseen.
fn solve<const N: usize, const B: usize>(
    dynamics: &SerialDynamics<f64, N, B>,
    base: &SVector<f64, B>,
    joints: &SVector<f64, N>,
    brakes: &SerialBrakes<N>,
) -> SerialAcceleration<f64, N, B> {
    if brakes.base == Brake::Engaged {
        let joints = solve_free(dynamics.mass_mm, *joints, &brakes.joints);
        return SerialAcceleration { base: SVector::zeros(), joints };
    }
    let Some(base_inertia) = dynamics.mass_bb.cholesky() else {
        return SerialAcceleration { base: SVector::repeat(f64::NAN), joints: SVector::repeat(f64::NAN) };
    };
    let coupling = base_inertia.solve(&dynamics.mass_bm);
    let reduced = dynamics.generalised_inertia(&coupling);
    let joints = solve_free(reduced, joints - coupling.tr_mul(base), &brakes.joints);
    SerialAcceleration { base: base_inertia.solve(base) - coupling * joints, joints }
}
