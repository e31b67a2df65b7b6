//! The robot UARM with its imperfections: friction, a tilted table, heavier links, a motor gain.

use super::integrator::MotionState;
use super::mechanical::{InertialTerms, MechanicalPlant, Mechanism};
use super::uarm_parameters::UarmPlantParameters;
use dem_model::{DemBase, DemLink, ParameterError, ThreeLinkDem};
use nalgebra::{ComplexField, RowVector3, Vector2, Vector3};

/// The DEM with scaled inertias, friction, tilt and gain.
///
/// Equations of motion: M q̈ + C q̇ = gain · τ + d − b q̇ − c tanh(q̇/0.02 rad/s) + Σ_i m_i (∂c_i/∂q)ᵀ g,
/// with M, C of the scaled inertias, c_i the centres of mass of links 2 and 3 and g the acceleration of the tilted table.
/// The base's mass is in none of it: its centre of mass lies in joint 1, so it neither swings nor weighs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uarm {
    dem: ThreeLinkDem<f64>,
    parameters: UarmPlantParameters,
}

/// The UARM as a plant.
pub type UarmPlant = MechanicalPlant<Uarm, 3>;

impl UarmPlant {
    /// The robot whose nominal model is `nominal`, with the given imperfections, in the paper's initial state, undisturbed.
    ///
    /// # Errors
    /// [`ParameterError`] if the scaled inertias leave the range in which M can be computed.
    pub fn new(nominal: &ThreeLinkDem<f64>, parameters: UarmPlantParameters) -> Result<Self, ParameterError> {
        let base = nominal.base();
        let base = DemBase { inertia: base.inertia * parameters.base_inertia_scale(), length: base.length };
        let scale = parameters.link_inertia_scale();
        let links =
            nominal.links().map(|link| DemLink { mass: link.mass * scale, inertia: link.inertia * scale, ..link });
        Ok(Self::from_mechanism(Uarm { dem: ThreeLinkDem::new(base, links)?, parameters }))
    }
}

impl Uarm {
    /// Viscous and smoothed Coulomb friction at the joints, N·m.
    fn friction(&self, velocity: &Vector3<f64>) -> Vector3<f64> {
        let smoothed_sign =
            velocity.map(|velocity| ComplexField::tanh(velocity / UarmPlantParameters::FRICTION_TRANSITION_VELOCITY));
        let parameters = &self.parameters;
        -(parameters.viscous_friction().component_mul(velocity)
            + parameters.coulomb_friction().component_mul(&smoothed_sign))
    }

    /// Σ_i m_i (∂c_i/∂q)ᵀ g, N·m. The centre of mass c_i = Σ_j a_ij e(φ_j), φ_j the absolute angle of link j, gives
    /// ∂c_i/∂q = Σ_j a_ij n(φ_j) ∂φ_j/∂q; for each link j the masses that it carries are gathered first.
    fn tilt_force(&self, position: &Vector3<f64>) -> Vector3<f64> {
        let [second, third] = self.dem.links();
        let base_length = self.dem.base().length;
        let first_moments = [
            (second.mass + third.mass) * base_length,
            second.mass * second.centre_of_mass + third.mass * second.length,
            third.mass * third.centre_of_mass,
        ];
        let spins = [RowVector3::new(1.0, 0.0, 0.0), RowVector3::new(1.0, 1.0, 0.0), RowVector3::new(1.0, 1.0, 1.0)];
        let mut force = Vector3::zeros();
        for (first_moment, spin) in first_moments.into_iter().zip(spins) {
            let (sine, cosine) = ComplexField::sin_cos((spin * position).x);
            let across = Vector2::new(-sine, cosine);
            force += spin.transpose() * (first_moment * across.dot(self.parameters.tilt()));
        }
        force
    }
}

impl Mechanism<3> for Uarm {
    const JOINTS: [usize; 3] = [0, 1, 2];

    fn inertial_terms(&self, state: &MotionState<3>) -> InertialTerms<3> {
        let (mass, coriolis) = self.dem.mass_and_coriolis(&state.position, &state.velocity);
        InertialTerms { mass, velocity_force: coriolis * state.velocity }
    }

    fn applied_force(&self, state: &MotionState<3>, motor: &Vector3<f64>, disturbance: &Vector3<f64>) -> Vector3<f64> {
        motor * self.parameters.gain() + disturbance + self.friction(&state.velocity) + self.tilt_force(&state.position)
    }

    fn place(&self, position: &Vector3<f64>, velocity: &Vector3<f64>) -> MotionState<3> {
        MotionState { position: *position, velocity: *velocity }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::{Brake, InitialState, Plant};
    use core::time::Duration;
    use hinf_control::Disturbance;
    use proptest::prelude::*;

    const FREE: [Brake; 3] = [Brake::Released; 3];

    fn uarm() -> Uarm {
        *UarmPlant::new(&ThreeLinkDem::table_2(), UarmPlantParameters::fitted()).unwrap().mechanism()
    }

    /// U = −Σ m_i g·c_i, from the centres of mass written out.
    fn tilt_potential(uarm: &Uarm, q: &Vector3<f64>) -> f64 {
        let along = |angle: f64| Vector2::new(angle.cos(), angle.sin());
        let [second, third] = uarm.dem.links();
        let joint_2 = along(q.x) * uarm.dem.base().length;
        let joint_3 = joint_2 + along(q.x + q.y) * second.length;
        let centre_2 = joint_2 + along(q.x + q.y) * second.centre_of_mass;
        let centre_3 = joint_3 + along(q.x + q.y + q.z) * third.centre_of_mass;
        -(centre_2 * second.mass + centre_3 * third.mass).dot(uarm.parameters.tilt())
    }

    proptest! {
        /// The force of the tilt is minus the gradient of its potential, by central differences.
        #[test]
        fn tilt_force_is_minus_the_gradient(q in prop::array::uniform3(-3.0..3.0_f64)) {
            let (uarm, q, step) = (uarm(), Vector3::from(q), 1e-5);
            let force = uarm.tilt_force(&q);
            for joint in 0..3 {
                let mut offset = Vector3::zeros();
                offset[joint] = step;
                let slope = (tilt_potential(&uarm, &(q + offset)) - tilt_potential(&uarm, &(q - offset))) / (2.0 * step);
                // Third derivative times step²/6 and rounding over 2·step are both below 1e-10 N·m here.
                prop_assert!((force[joint] + slope).abs() < 1e-10);
            }
        }

        /// Friction takes energy out at any velocity, and vanishes at rest.
        #[test]
        fn friction_dissipates(velocity in prop::array::uniform3(-3.0..3.0_f64)) {
            let velocity = Vector3::from(velocity);
            prop_assert!(uarm().friction(&velocity).dot(&velocity) <= 0.0);
            prop_assert_eq!(uarm().friction(&Vector3::zeros()), Vector3::zeros());
        }
    }

    #[test]
    fn without_imperfections_it_is_the_ideal_dem() {
        let nominal = ThreeLinkDem::table_2();
        let mut ideal = crate::plant::DemPlant::new(nominal).with_disturbance(Disturbance::Paper);
        let parameters = UarmPlantParameters::ideal();
        let mut uarm = UarmPlant::new(&nominal, parameters).unwrap().with_disturbance(Disturbance::Paper);
        let torque = Vector3::new(0.0, 0.01, -0.005);
        ideal.advance(Duration::from_millis(1500), &torque, FREE);
        uarm.advance(Duration::from_millis(1500), &torque, FREE);
        assert_eq!(ideal.motion_state(), uarm.motion_state());
    }

    /// Power balance: the energy gained is what motors, disturbance and friction did, less what the tilt's potential took.
    #[test]
    fn energy_balance() {
        let initial = InitialState { position: Vector3::new(0.1, 0.3, 0.4), velocity: Vector3::new(-0.2, 0.5, 0.3) };
        let mut plant = UarmPlant::new(&ThreeLinkDem::table_2(), UarmPlantParameters::fitted())
            .unwrap()
            .with_initial_state(initial)
            .with_disturbance(Disturbance::Paper);
        let torque = Vector3::new(0.0, 0.03, -0.02);
        let uarm = *plant.mechanism();
        let energy = |plant: &UarmPlant| plant.kinetic_energy() + tilt_potential(&uarm, &plant.position());
        let power = |plant: &UarmPlant| {
            let (velocity, time) = (plant.velocity(), plant.time());
            let [joint_2, joint_3] = Disturbance::Paper.torque::<2>(time, 0.0).into();
            let disturbance = Vector3::new(0.0, joint_2, joint_3);
            let joint_torque = torque * uarm.parameters.gain() + disturbance + uarm.friction(&velocity);
            velocity.dot(&joint_torque)
        };
        let start = energy(&plant);
        let mut work = 0.0;
        // Simpson's rule over pairs of grid steps.
        for pair in 0..7_500_u64 {
            let at = |step: u64| Duration::from_micros(100) * u32::try_from(2 * pair + step).unwrap();
            let before = power(&plant);
            plant.advance(at(1), &torque, FREE);
            let middle = power(&plant);
            plant.advance(at(2), &torque, FREE);
            work += (before + 4.0 * middle + power(&plant)) * 2e-4 / 6.0;
        }
        // Both sides are fourth order in 100 µs; friction's tanh is the steepest part.
        approx::assert_abs_diff_eq!(energy(&plant) - start, work, epsilon = 1e-10);
    }
}
