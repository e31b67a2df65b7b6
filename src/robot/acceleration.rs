//! How fast the joints can change their velocities at most, by the nominal model.

use dem_model::ThreeLinkDem;
use nalgebra::Vector3;
use uarm_loop::plausibility::AccelerationBound;

/// Angles of joints 2 and 3 at which the model is looked at, over a whole turn.
const STEPS: u32 = 24;

/// q̈ = M⁻¹ (τ − C q̇), over a grid of configurations, with all torques at their limits and all velocities of size one, whatever
/// their signs.
pub(super) fn bounds(model: &ThreeLinkDem<f64>, largest_torque: &[f64; 3]) -> Option<[AccelerationBound; 3]> {
    let torque = Vector3::from(*largest_torque);
    let mut bounds = [AccelerationBound { by_torque: 0.0, by_velocity: 0.0 }; 3];
    let angle = |step: u32| std::f64::consts::TAU * f64::from(step) / f64::from(STEPS);
    for (second, third) in (0..STEPS).flat_map(|second| (0..STEPS).map(move |third| (second, third))) {
        let q = Vector3::new(0.0, angle(second), angle(third));
        let inverse = model.mass_matrix(&q).try_inverse()?;
        let by_torque = inverse.abs() * torque;
        for signs in 0..27_i32 {
            let sign = |divisor: i32| f64::from(signs / divisor % 3 - 1);
            let velocity = Vector3::new(sign(1), sign(3), sign(9));
            let by_velocity = inverse * (model.coriolis_matrix(&q, &velocity) * velocity);
            for (joint, bound) in bounds.iter_mut().enumerate() {
                bound.by_torque = bound.by_torque.max(by_torque[joint]);
                bound.by_velocity = bound.by_velocity.max(by_velocity[joint].abs());
            }
        }
    }
    Some(bounds)
}
