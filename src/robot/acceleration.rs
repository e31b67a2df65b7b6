//! The most that the joints of the nominal model accelerate, for the braking barrier.

use std::f64::consts::TAU;

use dem_model::ThreeLinkDem;
use nalgebra::Vector3;
use uarm_loop::barrier::LargestAcceleration;

use crate::dimensions::JOINTS;

/// How finely the postures are looked at: every 15 degrees of joints 2 and 3; joint 1 turns the robot as a whole. Between two of them
/// accelerations change by a few per cent.
const POSTURES: u16 = 24;
/// What the postures in between may have more.
const MARGIN: f64 = 1.05;

/// For each joint, with torques up to `limits`, N·m.
pub(super) fn largest(model: &ThreeLinkDem<f64>, limits: [f64; JOINTS]) -> [LargestAcceleration; JOINTS] {
    let angle = |step: u16| TAU * f64::from(step) / f64::from(POSTURES);
    let mut most = [LargestAcceleration::default(); JOINTS];
    for second in 0..POSTURES {
        for third in 0..POSTURES {
            let q = Vector3::new(0.0, angle(second), angle(third));
            let by_torque = by_torque(model, &q, limits);
            let by_motion = by_motion(model, &q);
            for (joint, most) in most.iter_mut().enumerate() {
                most.by_torque = most.by_torque.max(by_torque[joint] * MARGIN);
                most.by_motion = most.by_motion.max(by_motion[joint] * MARGIN);
            }
        }
    }
    most
}

/// Σ_j |M⁻¹_ij| τ_j, rad/s²: the torques of all joints at their limits, each with the worst sign.
fn by_torque(model: &ThreeLinkDem<f64>, q: &Vector3<f64>, limits: [f64; JOINTS]) -> Vector3<f64> {
    let rest = Vector3::zeros();
    let mut sum = Vector3::zeros();
    for (joint, limit) in limits.into_iter().enumerate() {
        let mut torque = Vector3::zeros();
        torque[joint] = limit;
        sum += model.forward_dynamics(q, &rest, &torque).abs();
    }
    sum
}

/// Σ_jk |h_ijk| where −M⁻¹C(q, q̇)q̇ = Σ_jk h_ijk q̇_j q̇_k: no more than that with velocities of one, rad/s² per (rad/s)².
fn by_motion(model: &ThreeLinkDem<f64>, q: &Vector3<f64>) -> Vector3<f64> {
    let none = Vector3::zeros();
    let with = |velocity: Vector3<f64>| model.forward_dynamics(q, &velocity, &none);
    let unit = |joint: usize| Vector3::ith(joint, 1.0);
    let mut sum = Vector3::zeros();
    for first in 0..JOINTS {
        let alone = with(unit(first));
        sum += alone.abs();
        for second in first + 1..JOINTS {
            sum += (with(unit(first) + unit(second)) - alone - with(unit(second))).abs();
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against accelerations at random states: none is larger.
    #[test]
    fn no_state_within_the_limits_accelerates_more() {
        let model = ThreeLinkDem::<f64>::table_2();
        let limits = [0.0, 0.2, 0.2];
        let most = largest(&model, limits);
        let mut seed = 1_u64;
        let mut random = |scale: f64| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (f64::from(u32::try_from(seed >> 33).unwrap()) / f64::from(1_u32 << 31) * 2.0 - 1.0) * scale
        };
        let mut closest = [0.0_f64; JOINTS];
        for _ in 0..20_000 {
            let q = Vector3::from_fn(|_, _| random(TAU));
            let velocity = Vector3::from_fn(|_, _| random(1.0));
            let torque = Vector3::new(0.0, random(0.2), random(0.2));
            let acceleration = model.forward_dynamics(&q, &velocity, &torque);
            for joint in 0..JOINTS {
                let bound = most[joint].by_torque + most[joint].by_motion * velocity.amax().powi(2);
                assert!(acceleration[joint].abs() <= bound, "joint {}: {acceleration} {bound}", joint + 1);
                closest[joint] = closest[joint].max(acceleration[joint].abs() / bound);
            }
        }
        assert!(closest.iter().all(|share| *share > 0.5), "the bound is of use: {closest:?}");
    }

    #[test]
    fn twice_the_torque_is_twice_the_acceleration() {
        let model = ThreeLinkDem::<f64>::table_2();
        let [one, two] = [0.1, 0.2].map(|limit| largest(&model, [0.0, limit, limit]));
        for joint in 0..JOINTS {
            assert!((two[joint].by_torque / one[joint].by_torque - 2.0).abs() < 1e-12);
            assert_eq!(two[joint].by_motion, one[joint].by_motion);
        }
    }
}
