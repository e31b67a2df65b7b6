//! The balance that decides whether a law keeps its attenuation level, in any situation that a robot may meet.
#![allow(dead_code)] // Each test binary uses a part of it.

use super::State;
use dem_model::ThreeLinkDem;
use hinf_control::{Command, Measurement, ProvenAttenuation, Reference, Synthesis, TrackingError};
use nalgebra::{Matrix2, SMatrix, SVector, Vector2, Vector3};
use proptest::prelude::*;

/// What a sample of a closed loop has to show.
pub struct Sample<const N: usize = 2> {
    pub error: TrackingError<f64, N>,
    /// q̃̈.
    pub error_acceleration: SVector<f64, N>,
    pub control_input: SVector<f64, N>,
    pub disturbance: SVector<f64, N>,
    pub mass: SMatrix<f64, N, N>,
    pub mass_rate: SMatrix<f64, N, N>,
    /// Σ_k κ_k Φ̃_kᵀZ_kΦ̇_k.
    pub parameter_storage_rate: f64,
}

/// V̇ + ½x̃ᵀQx̃ + ½uᵀRu − ½γ²ωᵀω, and the sum of the magnitudes of its terms.
pub fn excess<const N: usize>(
    design: &Synthesis<f64, N>,
    proven: &ProvenAttenuation<f64>,
    sample: &Sample<N>,
) -> (f64, f64) {
    let Sample { error, error_acceleration, control_input, disturbance, .. } = sample;
    let s = design.filtered_error(error);
    let s_rate = error_acceleration + design.error_rate() * error.velocity;
    let kinetic = proven.storage_gain * (s.dot(&(sample.mass * s_rate)) + 0.5 * s.dot(&(sample.mass_rate * s)));
    let potential = error.velocity.dot(&(design.storage() * error.position));
    let state = 0.5 * design.state_weight().penalty(error);
    let control = 0.5 * control_input.dot(&(design.control_weight() * control_input));
    let supply = 0.5 * proven.level_squared * (design.t11() * disturbance).norm_squared();
    let terms = [kinetic, potential, sample.parameter_storage_rate, state, control, -supply];
    (terms.iter().sum(), terms.iter().map(|term| term.abs()).sum())
}

/// The relative error of Ṁ by central differences is some 1e-9; the rest is rounding.
pub const RELATIVE_TOLERANCE: f64 = 1e-7;

pub fn dissipates<const N: usize>(
    design: &Synthesis<f64, N>,
    proven: &ProvenAttenuation<f64>,
    sample: &Sample<N>,
) -> bool {
    let (excess, scale) = excess(design, proven, sample);
    excess <= RELATIVE_TOLERANCE * scale
}

pub fn rate_along(q: &Vector3<f64>, rate: &Vector3<f64>, mass: impl Fn(&Vector3<f64>) -> Matrix2<f64>) -> Matrix2<f64> {
    let step = 1e-5;
    (mass(&(q + rate * step)) - mass(&(q - rate * step))) / (2.0 * step)
}

/// Any state, motion and disturbance that a robot may meet.
#[derive(Clone, Debug)]
pub struct Situation {
    pub state: State,
    pub reference: Reference<f64>,
    pub disturbance: Vector2<f64>,
}

pub fn pair(range: std::ops::Range<f64>) -> impl Strategy<Value = Vector2<f64>> {
    [range.clone(), range].prop_map(Vector2::from)
}

pub fn situation() -> impl Strategy<Value = Situation> {
    let small = 10.0_f64.to_radians();
    let motion = (pair(-3.0..3.0), pair(-2.0..2.0), pair(-5.0..5.0));
    let error = (pair(-small..small), pair(-1.0..1.0), -2.0..2.0_f64);
    // Magnitudes over four decades: what fails at the scale of the errors may hold far above it.
    let disturbance = (pair(-1.0..1.0), -3.0..1.0_f64).prop_map(|(direction, decade)| direction * 10f64.powf(decade));
    (motion, error, disturbance).prop_map(|((position, velocity, acceleration), (dq, dr, base), disturbance)| {
        let (q, r) = (position + dq, velocity + dr);
        Situation {
            state: State { q: Vector3::new(0.3, q.x, q.y), velocity: Vector3::new(base, r.x, r.y) },
            reference: Reference { position, velocity, acceleration },
            disturbance,
        }
    })
}

impl Situation {
    pub fn joint_velocity(&self) -> Vector2<f64> {
        Vector2::new(self.state.velocity.y, self.state.velocity.z)
    }

    /// Turns the base such that the angular momentum is zero.
    pub fn without_momentum(mut self, model: &ThreeLinkDem<f64>) -> Self {
        let reduced = model.reduced(&self.state.q, &self.joint_velocity());
        self.state.velocity.x = reduced.base_velocity(&self.joint_velocity(), 0.0);
        self
    }

    /// The same, and the same under the disturbance that is worst for V: ω = c(γ²T11)⁻¹s leaves least to spare.
    pub fn with_worst(self, design: &Synthesis<f64>, level: &ProvenAttenuation<f64>) -> [Self; 2] {
        let s = design.filtered_error(&TrackingError::new(&self.state.measurement(f64::NAN), &self.reference));
        let input = design.t11_inverse() * s * (level.storage_gain / level.level_squared);
        [self.clone(), Self { disturbance: design.t11_inverse() * input, ..self }]
    }

    /// The joints' acceleration on the ideal plant under `torque` and the disturbance, and the base's.
    pub fn accelerations(&self, model: &ThreeLinkDem<f64>, torque: &Vector2<f64>) -> Vector3<f64> {
        let joint = torque + self.disturbance;
        model.forward_dynamics(&self.state.q, &self.state.velocity, &Vector3::new(0.0, joint.x, joint.y))
    }

    /// The measurement with the true base acceleration for a law that adds E to what it asks for without E. q̈_b depends
    /// on the torque and the torque on q̈_b; with E cancelled, M_mm q̈_m + C_mm q̇_m = τ̄ + d gives both.
    pub fn with_true_base(&self, model: &ThreeLinkDem<f64>, arm_torque: &Vector2<f64>) -> Measurement<f64> {
        let parts = model.partition(&self.state.q, &self.state.velocity);
        let joint_velocity = self.joint_velocity();
        let force = arm_torque + self.disturbance - parts.coriolis_mm * joint_velocity;
        let joints = parts.mass_mm.try_inverse().unwrap() * force;
        let base_force = (parts.mass_bm * joints).x
            + parts.coriolis_bb * self.state.velocity.x
            + (parts.coriolis_bm * joint_velocity).x;
        self.state.measurement(-base_force / parts.mass_bb)
    }

    pub fn sample(&self, command: &Command<f64>, acceleration: Vector2<f64>, mass: Masses, adaptation: f64) -> Sample {
        Sample {
            error: TrackingError::new(&self.state.measurement(f64::NAN), &self.reference),
            error_acceleration: acceleration - self.reference.acceleration,
            control_input: command.control_input,
            disturbance: self.disturbance,
            mass: mass.value,
            mass_rate: mass.rate,
            parameter_storage_rate: adaptation,
        }
    }
}

pub struct Masses {
    pub value: Matrix2<f64>,
    pub rate: Matrix2<f64>,
}

/// M_mm and its rate.
pub fn arm_mass(model: &ThreeLinkDem<f64>, state: &State) -> Masses {
    let mass = |q: &Vector3<f64>| model.partition(q, &Vector3::zeros()).mass_mm;
    Masses { value: mass(&state.q), rate: rate_along(&state.q, &state.velocity, mass) }
}

/// M̄ and its rate.
pub fn reduced_mass(model: &ThreeLinkDem<f64>, state: &State) -> Masses {
    let mass = |q: &Vector3<f64>| model.reduced(q, &Vector2::zeros()).mass;
    Masses { value: mass(&state.q), rate: rate_along(&state.q, &state.velocity, mass) }
}

/// What is proven for a design of Table 3.
pub fn proven(design: &Synthesis<f64>) -> ProvenAttenuation<f64> {
    design.proven_attenuation_level().unwrap()
}
