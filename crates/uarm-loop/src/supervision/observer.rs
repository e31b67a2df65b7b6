//! The generalised-momentum observer: which torques act on the joints that the model does not know?
//!
//! De Luca and Mattone, *Actuator failure detection and isolation using generalized momenta*, IEEE ICRA 2003: with p = M q̇ and
//! ṗ = τ + Cᵀ q̇ + f, f being what is not modelled, the residual r = K (p − ∫(τ + Cᵀ q̇ + r) dt − p₀) is f behind a low-pass of first order,
//! and needs no acceleration. Here the velocity comes from counts, so it has a low-pass of its own, and the torque has the same one:
//! r is f behind two low-passes of the same bandwidth. Both are discretised implicitly, so that no step is too long for them.

use super::model::MomentumModel;
use super::settings::Bandwidth;

/// What the observer knows of one joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointMotion {
    /// Its angle at the last SYNC, rad.
    pub angle: f64,
    /// Its filtered velocity, rad/s.
    pub velocity: f64,
    /// The generalised momentum of that, kg·m²/s.
    pub momentum: f64,
    /// The motor's torque between the last two SYNCs, N·m.
    pub torque: f64,
    /// The same, filtered as the velocity is, N·m.
    pub filtered_torque: f64,
    /// r: torque that the model does not explain, N·m.
    pub residual: f64,
}

/// Takes the joints on from one SYNC to the next, `elapsed` seconds later, at `angles`, rad, under `torques`, N·m, the means of that time.
/// Gives M(q), kg·m², by rows.
pub fn advance<const J: usize>(
    joints: &mut [JointMotion; J],
    model: &dyn MomentumModel<J>,
    bandwidth: Bandwidth,
    angles: &[f64; J],
    torques: &[f64; J],
    elapsed: f64,
) -> [[f64; J]; J] {
    let step = bandwidth.get() * elapsed;
    let blend = step / (1.0 + step);
    for ((joint, angle), torque) in joints.iter_mut().zip(angles).zip(torques) {
        joint.velocity += blend * ((angle - joint.angle) / elapsed - joint.velocity);
        // From the middle of one interval to that of the next, as the difference of the two mean velocities is.
        joint.filtered_torque += blend * ((torque + joint.torque) / 2.0 - joint.filtered_torque);
        joint.angle = *angle;
        joint.torque = *torque;
    }
    let velocity = joints.each_ref().map(|joint| joint.velocity);
    let inertia = model.inertia(angles);
    let velocity_torque = model.velocity_torque(angles, &velocity);
    for ((joint, row), velocity_torque) in joints.iter_mut().zip(&inertia).zip(velocity_torque) {
        let momentum = momentum(row, &velocity);
        let unexplained = (momentum - joint.momentum) / elapsed - joint.filtered_torque - velocity_torque;
        joint.residual += blend * (unexplained - joint.residual);
        joint.momentum = momentum;
    }
    inertia
}

/// Begins anew with joints that went to `angles`, rad, in `elapsed` seconds, with nothing unexplained.
pub fn resume<const J: usize>(
    joints: &mut [JointMotion; J],
    model: &dyn MomentumModel<J>,
    angles: &[f64; J],
    torques: &[f64; J],
    elapsed: f64,
) {
    for ((joint, angle), torque) in joints.iter_mut().zip(angles).zip(torques) {
        let velocity = (angle - joint.angle) / elapsed;
        *joint =
            JointMotion { angle: *angle, velocity, torque: *torque, filtered_torque: *torque, ..Default::default() };
    }
    let velocity = joints.each_ref().map(|joint| joint.velocity);
    for (joint, row) in joints.iter_mut().zip(&model.inertia(angles)) {
        joint.momentum = momentum(row, &velocity);
    }
}

fn momentum<const J: usize>(row: &[f64; J], velocity: &[f64; J]) -> f64 {
    row.iter().zip(velocity).map(|(inertia, velocity)| inertia * velocity).sum()
}

/// How far rounding of the angles and the instants of sampling may put the residual of the joint with this `row` of M(q) off, N·m: of angles
/// with these errors, rad, which are taken to be independent.
pub fn noise<const J: usize>(row: &[f64; J], errors: &[f64; J], bandwidth: Bandwidth) -> f64 {
    let sum = row.iter().zip(errors).map(|(inertia, error)| (inertia * error) * (inertia * error)).sum::<f64>();
    bandwidth.get() * bandwidth.get() * sum.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two wheels on one axle, the second relative to the first: inertias 0.3 and 0.1 kg·m² about it.
    #[derive(Debug)]
    struct Wheels;

    impl MomentumModel<2> for Wheels {
        fn inertia(&self, _: &[f64; 2]) -> [[f64; 2]; 2] {
            [[0.4, 0.1], [0.1, 0.1]]
        }
        fn velocity_torque(&self, _: &[f64; 2], _: &[f64; 2]) -> [f64; 2] {
            [0.0; 2]
        }
    }

    const BANDWIDTH: f64 = 50.0;

    /// Residuals after `time` s in steps of 1 ms, of wheels that accelerate by `acceleration`, rad/s², from rest under a motor torque on the second.
    fn residuals(acceleration: [f64; 2], torque: f64, time: f64) -> [f64; 2] {
        let mut joints = [JointMotion::default(); 2];
        for step in 1..=(time / 1e-3).round() as u32 {
            let at = f64::from(step) * 1e-3;
            let angles = acceleration.map(|acceleration| acceleration * at * at / 2.0);
            advance(&mut joints, &Wheels, Bandwidth::new(BANDWIDTH).unwrap(), &angles, &[0.0, torque], 1e-3);
        }
        joints.map(|joint| joint.residual)
    }

    /// 0.03 N·m between the wheels: 0.3 rad/s² forward for the second, 0.1 rad/s² backward for the first.
    #[test]
    fn motion_that_the_torque_explains_leaves_no_residual() {
        let [base, wheel] = residuals([-0.1, 0.4], 0.03, 0.2);
        assert!(base.abs() < 1e-12 && wheel.abs() < 2e-4, "{base} {wheel}");
    }

    /// The step response of two equal low-passes: 1 − (1 + ωt) e^(−ωt).
    #[test]
    fn what_the_torque_does_not_explain_is_the_residual_behind_two_low_passes() {
        for time in [0.02, 0.04, 0.1, 0.3] {
            let passed = BANDWIDTH * time;
            let expected = -0.05 * (1.0 - (1.0 + passed) * (-passed).exp());
            let [base, wheel] = residuals([0.1, -0.4], -0.03 + 0.05, time);
            assert!(base.abs() < 1e-12, "{base}");
            assert!((wheel - expected).abs() < 2.5e-3, "{time}: {wheel} for {expected}");
        }
    }
}
