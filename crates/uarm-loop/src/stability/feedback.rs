//! The feedback that a law is around rest in one configuration.

use hinf_control::{BaseMeasurement, Controller, Measurement, Reference};
use nalgebra::{Matrix2, Vector2};

/// How far a measurement is moved to see what a law makes of it, rad, rad/s or rad/s²: around rest the torque is linear up to
/// terms of third order, which are below rounding here.
const STEP: f64 = 1e-4;

/// τ = K_p (q_m − q) + K_d q̇_m + k_v q̇_b + k_a q̈_b around rest in the configuration q: the torque's derivatives, which are
/// negative where the feedback is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Feedback {
    /// K_p, N·m/rad.
    pub position: Matrix2<f64>,
    /// K_d, N·m·s/rad.
    pub velocity: Matrix2<f64>,
    /// k_v, N·m·s/rad.
    pub base_velocity: Vector2<f64>,
    /// k_a, N·m·s²/rad.
    pub base_acceleration: Vector2<f64>,
}

/// What of a measurement at rest is moved, and how far.
#[derive(Clone, Copy, Default)]
struct Change {
    position: Vector2<f64>,
    velocity: Vector2<f64>,
    base_velocity: f64,
    base_acceleration: f64,
}

impl Feedback {
    /// The feedback of `law` at `configuration` [q2, q3], rad, by central differences of its torque. The law is reset: an
    /// adaptive law is asked with the parameters that it starts with.
    pub fn of(law: &mut dyn Controller<f64>, configuration: &Vector2<f64>) -> Self {
        law.reset();
        let mut derivative = |change: fn(f64) -> Change| {
            let ahead = torque(law, configuration, &change(STEP));
            (ahead - torque(law, configuration, &change(-STEP))) / (2.0 * STEP)
        };
        let position = Matrix2::from_columns(&[
            derivative(|step| Change { position: Vector2::new(step, 0.0), ..Change::default() }),
            derivative(|step| Change { position: Vector2::new(0.0, step), ..Change::default() }),
        ]);
        let velocity = Matrix2::from_columns(&[
            derivative(|step| Change { velocity: Vector2::new(step, 0.0), ..Change::default() }),
            derivative(|step| Change { velocity: Vector2::new(0.0, step), ..Change::default() }),
        ]);
        Self {
            position,
            velocity,
            base_velocity: derivative(|step| Change { base_velocity: step, ..Change::default() }),
            base_acceleration: derivative(|step| Change { base_acceleration: step, ..Change::default() }),
        }
    }
}

/// The law's torque at rest in `configuration` but for `change`, N·m. No time passes, so that an adaptive law does not adapt.
fn torque(law: &mut dyn Controller<f64>, configuration: &Vector2<f64>, change: &Change) -> Vector2<f64> {
    let measurement = Measurement {
        position: configuration + change.position,
        velocity: change.velocity,
        base: BaseMeasurement::planar(change.base_velocity, change.base_acceleration),
    };
    let at_rest = Reference { position: *configuration, velocity: Vector2::zeros(), acceleration: Vector2::zeros() };
    law.update(&measurement, &at_rest, 0.0).torque
}
