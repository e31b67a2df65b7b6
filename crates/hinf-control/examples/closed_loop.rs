//! The paper's task in a simulation: every law on the ideal free-floating arm, with the paper's disturbance.
//!
//! `cargo run --example closed_loop` prints L2 of the tracking error and the summed torque E of each law.

use core::time::Duration;
use dem_model::ThreeLinkDem;
use hinf_control::{
    BaseAcceleration, BaseMeasurement, BuildContext, BuildError, Controller, ControllerSettings, Disturbance, Law,
    Measurement, PerformanceIndices, QuinticReference, TorqueLimiter, TorqueLimits, TrackingError,
};
use nalgebra::{Vector2, Vector3};

/// The control period, ms.
const PERIOD_MS: u64 = 3;
/// Semi-implicit Euler steps per period.
const SUBSTEPS: u32 = 100;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut settings = ControllerSettings::default();
    // The adaptive law with an eliminated base acceleration would need the base velocity.
    settings.set_base_acceleration(Law::Adaptive, BaseAcceleration::Omitted)?;
    println!("{:<16} {:>8} {:>8}", "law", "L2", "E");
    for law in Law::ALL {
        let indices = run(law, &settings)?;
        println!("{:<16} {:>8.4} {:>8.4}", law.name(), indices.tracking(), indices.torque());
    }
    Ok(())
}

fn run(law: Law, settings: &ControllerSettings) -> Result<PerformanceIndices<f64>, Box<dyn std::error::Error>> {
    let model = ThreeLinkDem::table_2();
    let mut controller = build(law, settings, model)?;
    let mut limiter = TorqueLimiter::new(TorqueLimits::new(Vector2::new(0.3, 0.3))?);
    let reference = QuinticReference::paper();
    let mut indices = PerformanceIndices::new();
    // Base, joint 2, joint 3: rad and rad/s.
    let mut position = Vector3::new(0.0, reference.start().x, reference.start().y);
    let mut velocity = Vector3::zeros();
    let mut time = Duration::ZERO;
    let period = Duration::from_millis(PERIOD_MS);
    while time.as_secs_f64() < reference.duration() {
        let measurement = Measurement {
            position: position.yz(),
            velocity: velocity.yz(),
            base: BaseMeasurement::planar(velocity.x, 0.0),
        };
        let desired = reference.at(time.as_secs_f64());
        let elapsed = if time.is_zero() { 0.0 } else { period.as_secs_f64() };
        let command = controller.update(&measurement, &desired, elapsed);
        let torque = limiter.limit(command.torque, period.as_secs_f64())?;
        controller.limited(torque.limited);
        indices.record(&TrackingError::new(&measurement, &desired), &torque.applied, period.as_secs_f64());
        let step = period.as_secs_f64() / f64::from(SUBSTEPS);
        for substep in 0..SUBSTEPS {
            let motors = Vector3::new(0.0, torque.applied.x, torque.applied.y);
            let force = motors + Disturbance::Paper.torque(time, f64::from(substep) * step);
            velocity += model.forward_dynamics(&position, &velocity, &force) * step;
            position += velocity * step;
        }
        time += period;
    }
    Ok(indices)
}

fn build(
    law: Law,
    settings: &ControllerSettings,
    model: ThreeLinkDem<f64>,
) -> Result<impl Controller<f64> + use<>, BuildError> {
    settings.build(law, &BuildContext::new(model))
}
