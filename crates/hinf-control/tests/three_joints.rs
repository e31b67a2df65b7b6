//! The contract for another number of active joints than the paper's two.

use hinf_control::adaptation::{Adaptation, AdaptiveOutput, ParameterEstimator, ScalarWeight};
use hinf_control::{
    BaseMeasurement, Command, Controller, FrozenState, LimitedJoints, Measurement, PerformanceIndices,
    QuinticReference, Reference, ThawError, TorqueLimiter, TorqueLimits, TrackingError,
};
use nalgebra::{SVector, Vector3};

/// Learns a constant torque for each joint: τ_m = Φ − q̃̇, Φ̇ = −q̃̇.
struct ConstantTorque(ParameterEstimator<f64, 3>);

impl Controller<f64, 3> for ConstantTorque {
    fn update(
        &mut self,
        measurement: &Measurement<f64, 3>,
        reference: &Reference<f64, 3>,
        period: f64,
    ) -> Command<f64, 3> {
        self.0.cycle(measurement, reference, period, |parameters| {
            let error = TrackingError::new(measurement, reference);
            let control_input = -error.velocity;
            let torque = parameters + control_input;
            AdaptiveOutput { torque, control_input, gradient: error.velocity, fell_back: false }
        })
    }

    fn limited(&mut self, joints: LimitedJoints<3>) {
        self.0.limited(joints);
    }

    fn reset(&mut self) {
        self.0.reset();
    }

    fn freeze(&self) -> FrozenState<f64, 3> {
        self.0.freeze()
    }

    fn thaw(&mut self, state: &FrozenState<f64, 3>) -> Result<(), ThawError> {
        self.0.thaw(state)
    }
}

#[test]
fn a_law_for_three_joints_runs_between_reference_and_limiter() {
    let adaptation = Adaptation::new(SVector::zeros(), ScalarWeight::new(1.0).unwrap()).unwrap();
    let mut law = ConstantTorque(ParameterEstimator::new(adaptation));
    let reference = QuinticReference::new(Vector3::zeros(), Vector3::new(1.0, 2.0, 3.0), 2.0).unwrap();
    let mut limiter = TorqueLimiter::new(TorqueLimits::new(Vector3::new(1.0, 1.0, 1.0)).unwrap());
    // The velocity peaks in the middle at 15/8 of the mean.
    let desired = reference.at(1.0);
    assert_eq!(desired.velocity, Vector3::new(1.0, 2.0, 3.0) / 2.0 * 1.875);
    let base = BaseMeasurement::at_rest();
    let measurement = Measurement { position: desired.position, velocity: Vector3::zeros(), base };
    let command = law.update(&measurement, &desired, 0.0);
    assert_eq!(command.torque, desired.velocity);
    let torque = limiter.limit(command.torque, 0.5).unwrap();
    assert_eq!(torque.applied, Vector3::new(0.9375, 1.0, 1.0));
    assert_eq!(torque.limited, [false, true, true]);
    // Φ = 0.5 s · q̇ᵈ after the first step.
    assert_eq!(law.update(&measurement, &desired, 0.5).torque, desired.velocity * 1.5);
    let mut indices = PerformanceIndices::new();
    indices.record(&TrackingError::new(&measurement, &desired), &torque.applied, 1.0);
    assert_eq!(indices.torque(), 2.9375);
    assert_eq!(indices.tracking(), desired.velocity.norm());
}
