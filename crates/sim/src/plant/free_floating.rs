//! The planar free-floating space manipulator, simulated without its dynamically equivalent manipulator.
//!
//! The derivation shares nothing with the DEM: the spacecraft's position is a coordinate, each body contributes the
//! inertia m JᵀJ + I w wᵀ of its own Jacobians, and the velocity forces come from the bodies' accelerations at q̈ = 0.
//! Coordinates: [x, y, θ, q2, q3] with (x, y) the spacecraft's centre of mass in an inertial frame whose origin is the
//! system's centre of mass, θ its attitude.

use super::integrator::MotionState;
use super::mechanical::{InertialTerms, MechanicalPlant, Mechanism};
use dem_model::PlanarSpaceManipulator;
use nalgebra::{ComplexField, Matrix2x5, Matrix5, RowVector5, Vector2, Vector3, Vector5};

/// A body of the chain; its centre of mass is at (x, y) + Σ_j lever_j e(φ_j).
#[derive(Clone, Copy, Debug, PartialEq)]
struct Body {
    mass: f64,
    inertia: f64,
    /// How far the centre of mass moves along the direction of each of the three bodies, m.
    levers: [f64; 3],
    /// ∂φ/∂q of this body's absolute angle φ.
    spin: RowVector5<f64>,
}

/// What one body does at a state.
struct BodyMotion {
    /// Centre of mass, m.
    centre: Vector2<f64>,
    /// ∂(centre)/∂q.
    jacobian: Matrix2x5<f64>,
    /// The centre's acceleration at q̈ = 0, m/s².
    velocity_acceleration: Vector2<f64>,
}

/// A spacecraft with two links in the plane, as a mechanism of five coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeFloatingManipulator {
    bodies: [Body; 3],
}

/// The free-floating space manipulator as a plant.
///
/// Joint 1 is the spacecraft's attitude; a torque on it is an external couple on the spacecraft (the paper has none).
/// It starts with the system's centre of mass at rest in the origin.
pub type FreeFloatingPlant = MechanicalPlant<FreeFloatingManipulator, 5>;

/// ∂φ_j/∂q of the three bodies' absolute angles.
const SPINS: [RowVector5<f64>; 3] = [
    RowVector5::new(0.0, 0.0, 1.0, 0.0, 0.0),
    RowVector5::new(0.0, 0.0, 1.0, 1.0, 0.0),
    RowVector5::new(0.0, 0.0, 1.0, 1.0, 1.0),
];

/// Where a body points, and how fast it turns.
struct Direction {
    /// e(φ).
    along: Vector2<f64>,
    /// φ̇, rad/s.
    angular_velocity: f64,
}

impl Body {
    fn motion(&self, state: &MotionState<5>, directions: &[Direction; 3]) -> BodyMotion {
        let mut centre = Vector2::new(state.position.x, state.position.y);
        let mut jacobian = Matrix2x5::identity();
        let mut velocity_acceleration = Vector2::zeros();
        for ((lever, spin), direction) in self.levers.iter().zip(&SPINS).zip(directions) {
            let along = direction.along * *lever;
            centre += along;
            jacobian += Vector2::new(-along.y, along.x) * spin;
            velocity_acceleration -= along * (direction.angular_velocity * direction.angular_velocity);
        }
        BodyMotion { centre, jacobian, velocity_acceleration }
    }
}

impl FreeFloatingManipulator {
    /// The mechanism of `manipulator`.
    pub fn new(manipulator: &PlanarSpaceManipulator<f64, 2>) -> Self {
        let spacecraft = manipulator.spacecraft();
        let [second, third] = *manipulator.links();
        let [spin_1, spin_2, spin_3] = SPINS;
        let to_joint_2 = spacecraft.centre_of_mass_to_joint;
        let second_length = second.joint_to_centre_of_mass + second.centre_of_mass_to_joint;
        let body = |mass, inertia, levers, spin| Body { mass, inertia, levers, spin };
        Self {
            bodies: [
                body(spacecraft.mass, spacecraft.inertia, [0.0, 0.0, 0.0], spin_1),
                body(second.mass, second.inertia, [to_joint_2, second.joint_to_centre_of_mass, 0.0], spin_2),
                body(third.mass, third.inertia, [to_joint_2, second_length, third.joint_to_centre_of_mass], spin_3),
            ],
        }
    }

    /// What each body does.
    fn motions(&self, state: &MotionState<5>) -> [BodyMotion; 3] {
        let directions = SPINS.map(|spin| {
            let (sine, cosine) = ComplexField::sin_cos((spin * state.position).x);
            Direction { along: Vector2::new(cosine, sine), angular_velocity: (spin * state.velocity).x }
        });
        self.bodies.each_ref().map(|body| body.motion(state, &directions))
    }

    /// Total mass, kg.
    fn total_mass(&self) -> f64 {
        self.bodies.iter().map(|body| body.mass).sum()
    }

    /// Linear momentum, kg·m/s.
    pub fn linear_momentum(&self, state: &MotionState<5>) -> Vector2<f64> {
        let bodies = self.bodies.iter().zip(self.motions(state));
        bodies.map(|(body, motion)| motion.jacobian * state.velocity * body.mass).sum()
    }

    /// Angular momentum about the inertial frame's origin, kg·m²/s.
    pub fn angular_momentum(&self, state: &MotionState<5>) -> f64 {
        let of_body = |(body, motion): (&Body, BodyMotion)| {
            let velocity = motion.jacobian * state.velocity;
            body.mass * motion.centre.perp(&velocity) + body.inertia * (body.spin * state.velocity).x
        };
        self.bodies.iter().zip(self.motions(state)).map(of_body).sum()
    }

    /// Centre of mass of the whole, m.
    pub fn centre_of_mass(&self, state: &MotionState<5>) -> Vector2<f64> {
        let bodies = self.bodies.iter().zip(self.motions(state));
        let moment: Vector2<f64> = bodies.map(|(body, motion)| motion.centre * body.mass).sum();
        moment / self.total_mass()
    }
}

impl Mechanism<5> for FreeFloatingManipulator {
    const JOINTS: [usize; 3] = [2, 3, 4];

    fn inertial_terms(&self, state: &MotionState<5>) -> InertialTerms<5> {
        let mut terms = InertialTerms { mass: Matrix5::zeros(), velocity_force: Vector5::zeros() };
        for (body, motion) in self.bodies.iter().zip(self.motions(state)) {
            let pull = motion.jacobian.transpose() * body.mass;
            terms.mass += pull * motion.jacobian + body.spin.transpose() * body.spin * body.inertia;
            terms.velocity_force += pull * motion.velocity_acceleration;
        }
        terms
    }

    fn applied_force(&self, _state: &MotionState<5>, motor: &Vector3<f64>, disturbance: &Vector3<f64>) -> Vector5<f64> {
        let torque = motor + disturbance;
        Vector5::new(0.0, 0.0, torque.x, torque.y, torque.z)
    }

    fn place(&self, position: &Vector3<f64>, velocity: &Vector3<f64>) -> MotionState<5> {
        let mut state = MotionState {
            position: Vector5::new(0.0, 0.0, position.x, position.y, position.z),
            velocity: Vector5::new(0.0, 0.0, velocity.x, velocity.y, velocity.z),
        };
        let centre = self.centre_of_mass(&state);
        let velocity = self.linear_momentum(&state) / self.total_mass();
        state.position -= Vector5::new(centre.x, centre.y, 0.0, 0.0, 0.0);
        state.velocity -= Vector5::new(velocity.x, velocity.y, 0.0, 0.0, 0.0);
        state
    }
}

impl FreeFloatingPlant {
    /// The space manipulator `manipulator` in the paper's initial state, undisturbed.
    pub fn new(manipulator: &PlanarSpaceManipulator<f64, 2>) -> Self {
        Self::from_mechanism(FreeFloatingManipulator::new(manipulator))
    }

    /// Linear momentum, kg·m/s; constant, since nothing pushes the system.
    pub fn linear_momentum(&self) -> Vector2<f64> {
        self.mechanism().linear_momentum(self.motion_state())
    }

    /// Angular momentum about the origin, kg·m²/s; constant unless the spacecraft is turned or held from outside.
    pub fn angular_momentum(&self) -> f64 {
        self.mechanism().angular_momentum(self.motion_state())
    }
}
