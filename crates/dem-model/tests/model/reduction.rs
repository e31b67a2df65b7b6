//! The reduced dynamics against the full ones.

use crate::common::random::{angles, signals, three_link_dem};
use nalgebra::{Matrix2, Vector2, Vector3};
use proptest::prelude::*;

/// Sums of some tens of products, relative to their greatest term.
const ROUNDING: f64 = 1e-13;
/// A fourth-order difference at a step of 1e-3, as in `properties.rs`, of a quotient of such functions.
const DIFFERENCE: f64 = 1e-6;

proptest! {
    #[test]
    fn reduced_matrices_have_their_symmetries(dem in three_link_dem(), q in angles::<3>(), joint_velocity in signals::<2>()) {
        let reduced = dem.reduced(&q, &joint_velocity);
        prop_assert_eq!(reduced.mass, reduced.mass.transpose());
        prop_assert!(reduced.mass.symmetric_eigenvalues().min() > 0.0);
        prop_assert_eq!(reduced.gyroscopic, -reduced.gyroscopic.transpose());

        let mass_at = |time: f64| dem.reduced(&(q + Vector3::new(0.0, joint_velocity.x, joint_velocity.y) * time), &joint_velocity).mass;
        let central = |step: f64| (mass_at(step) - mass_at(-step)) / (2.0 * step);
        let mass_derivative: Matrix2<f64> = (central(1e-3) * 4.0 - central(2e-3)) / 3.0;
        let skew = mass_derivative - reduced.coriolis * 2.0;
        let scale = 10.0 * dem.mass_matrix(&Vector3::zeros()).m11;
        prop_assert!((skew + skew.transpose()).amax() <= DIFFERENCE * scale, "not skew:{}", skew);
    }

    /// The angular momentum belongs to the base velocity and the other way round.
    #[test]
    fn momentum_and_base_velocity_belong_together(
        dem in three_link_dem(), q in angles::<3>(), joint_velocity in signals::<2>(), momentum in -1.0..1.0,
    ) {
        let base_velocity = dem.reduced(&q, &joint_velocity).base_velocity(&joint_velocity, momentum);
        let back = dem.angular_momentum(&q, &Vector3::new(base_velocity, joint_velocity.x, joint_velocity.y));
        let scale = 10.0 * dem.mass_matrix(&q).amax() * base_velocity.abs().max(3.0);
        prop_assert!((back - momentum).abs() <= ROUNDING * scale, "{back} is not {momentum}");
    }

    #[test]
    fn coriolis_at_once_is_the_sum(
        dem in three_link_dem(), q in angles::<3>(), joint_velocity in signals::<2>(), momentum in -1.0..1.0,
    ) {
        let sum = dem.reduced(&q, &joint_velocity).coriolis_with_momentum(momentum);
        let at_once = dem.reduced_coriolis(&q, &joint_velocity, momentum);
        let momentum_velocity = momentum / dem.mass_matrix(&q).m11;
        let scale = 10.0 * dem.mass_matrix(&Vector3::zeros()).m11 * (10.0 + momentum_velocity.abs());
        prop_assert!((sum - at_once).amax() <= ROUNDING * scale, "{}{}", sum, at_once);
    }

    /// M̄q̈_m + C̄q̇_m + pGq̇_m + p²g = τ_m − Aᵀτ_b for the motion that the full equations give, torque on the base included.
    #[test]
    fn reduced_equation_holds_for_the_full_motion(
        dem in three_link_dem(), q in angles::<3>(), velocity in signals::<3>(), acceleration in signals::<3>(),
    ) {
        let force = dem.inverse_dynamics(&q, &velocity, &acceleration);
        let joint_velocity = Vector2::new(velocity.y, velocity.z);
        let reduced = dem.reduced(&q, &joint_velocity);
        let momentum = dem.angular_momentum(&q, &velocity);
        let found = reduced.arm_torque(&Vector2::new(acceleration.y, acceleration.z), &joint_velocity, momentum);
        let expected = Vector2::new(force.y, force.z) - reduced.base_coupling.transpose() * force.x;
        let scale = 100.0 * dem.mass_matrix(&Vector3::zeros()).m11 * 9.0 * (1.0 + reduced.base_coupling.amax()).powi(2);
        prop_assert!((found - expected).amax() <= ROUNDING * scale, "{found} is not {expected}");
    }

    /// The reduced inertia is the one that the elimination of eq. 21 leaves.
    #[test]
    fn reduced_mass_is_that_of_the_elimination(dem in three_link_dem(), q in angles::<3>(), velocity in signals::<3>()) {
        let joint_velocity = Vector2::new(velocity.y, velocity.z);
        let eliminated = dem.partition(&q, &velocity).eliminate_base(velocity.x, &joint_velocity);
        let reduced = dem.reduced(&q, &joint_velocity);
        let scale = dem.mass_matrix(&q).amax();
        prop_assert!((eliminated.mass - reduced.mass).amax() <= ROUNDING * scale);
        // Without torque on the base both biases are the same force.
        let momentum = dem.angular_momentum(&q, &velocity);
        let bias = reduced.arm_torque(&Vector2::zeros(), &joint_velocity, momentum);
        let scale = 100.0 * dem.mass_matrix(&Vector3::zeros()).m11 * 9.0 * (1.0 + reduced.base_coupling.amax()).powi(2);
        prop_assert!((bias - eliminated.bias).amax() <= ROUNDING * scale, "{}{}", bias, eliminated.bias);
    }
}
