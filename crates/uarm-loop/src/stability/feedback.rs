//! The feedback that a law is around rest in one configuration.

use hinf_control::{BaseMeasurement, Controller, Measurement, Reference};
use nalgebra::{SMatrix, SVector};

/// How far a measurement is moved to see what a law makes of it, rad, rad/s or rad/s²: around rest the torque is linear up to
/// terms of third order, which are below rounding here.
const STEP: f64 = 1e-4;

/// τ = K_p (q_m − q) + K_d q̇_m + k_v q̇_b + k_a q̈_b around rest in the configuration q: the torque's derivatives, which are
/// negative where the feedback is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Feedback<const N: usize = 2> {
    /// K_p, N·m/rad.
    pub position: SMatrix<f64, N, N>,
    /// K_d, N·m·s/rad.
    pub velocity: SMatrix<f64, N, N>,
    /// k_v, N·m·s/rad.
    pub base_velocity: SVector<f64, N>,
    /// k_a, N·m·s²/rad.
    pub base_acceleration: SVector<f64, N>,
}

impl<const N: usize> Feedback<N> {
    /// The feedback of `law` at `configuration` q_m, rad, by central differences of its torque. The law is reset: an
    /// adaptive law is asked with the parameters that it starts with.
    pub fn of(law: &mut dyn Controller<f64, N>, configuration: &SVector<f64, N>) -> Self {
        law.reset();
        let at_rest = Measurement {
            position: *configuration,
            velocity: SVector::zeros(),
            base: BaseMeasurement::planar(0.0, 0.0),
        };
        let reference =
            Reference { position: *configuration, velocity: SVector::zeros(), acceleration: SVector::zeros() };
        // No time passes, so that an adaptive law does not adapt.
        let mut derivative = |moved: &dyn Fn(&mut Measurement<f64, N>, f64)| {
            let mut torque = |step| {
                let mut measurement = at_rest;
                moved(&mut measurement, step);
                law.update(&measurement, &reference, 0.0).torque
            };
            let ahead = torque(STEP);
            (ahead - torque(-STEP)) / (2.0 * STEP)
        };
        let mut feedback = Self {
            position: SMatrix::zeros(),
            velocity: SMatrix::zeros(),
            base_velocity: derivative(&|measurement, step| measurement.base.velocity.x = step),
            base_acceleration: derivative(&|measurement, step| measurement.base.acceleration.x = step),
        };
        let columns = feedback.position.column_iter_mut().zip(feedback.velocity.column_iter_mut());
        for (joint, (mut position, mut velocity)) in columns.enumerate() {
            let unit = SVector::<f64, N>::from_fn(|row, _| if row == joint { 1.0 } else { 0.0 });
            position.copy_from(&derivative(&|measurement, step| measurement.position += unit * step));
            velocity.copy_from(&derivative(&|measurement, step| measurement.velocity += unit * step));
        }
        feedback
    }
}
