//! What the drives are sent, in numbers.

use approx::assert_abs_diff_eq;
use uarm_loop::hinf_control::{Disturbance, TorqueLimiter, TorqueLimits};
use uarm_loop::nalgebra::Vector2;
use uarm_loop::torque::{DisturbanceSite, PreparedTorque, TorqueStage};

use crate::fake_path::scale;

/// The sine of eq. 48 is 1 at 1/12 s after its onset; e^(−5/12) = 0.659241 is left of its amplitudes 0.075 and 0.05 N·m.
const PEAK: f64 = 1.0 + 1.0 / 12.0;

fn prepare(disturbance: Disturbance, site: DisturbanceSite, time: f64) -> PreparedTorque<3, 2> {
    let limits = TorqueLimits::new(Vector2::new(0.06, 0.1)).unwrap();
    let scales = [scale(200), scale(200), scale(400)];
    let mut stage = TorqueStage { limiter: TorqueLimiter::new(limits), scales, disturbance, site };
    stage.prepare(Vector2::new(0.07, -0.04), time, 0.003).unwrap()
}

/// 0.06 N·m of 200 mN·m are 300 per mille, −0.04 N·m of 400 mN·m are −100. The passive joint is sent nothing.
#[test]
fn limited_torques_are_sent_and_the_plant_adds_the_disturbance_by_itself() {
    let torque = prepare(Disturbance::Paper, DisturbanceSite::Plant, PEAK);
    assert_eq!(torque.sent, [0, 300, -100]);
    assert_eq!(torque.limited.requested, Vector2::new(0.07, -0.04));
    assert_eq!(torque.limited.applied, Vector2::new(0.06, -0.04));
    assert_eq!(torque.limited.limited, [true, false]);
    // It is told wherever it acts.
    assert_abs_diff_eq!(torque.disturbance.x, 0.049_443_0, epsilon = 1e-7);
    assert_abs_diff_eq!(torque.disturbance.y, 0.032_962_0, epsilon = 1e-7);
}

/// 0.06 + 0.049443 = 0.109443 N·m are 547 per mille of 200 mN·m; −0.04 + 0.032962 = −0.007038 N·m are −18 of 400 mN·m.
#[test]
fn a_disturbance_of_the_command_is_added_after_the_limiter() {
    let torque = prepare(Disturbance::Paper, DisturbanceSite::Command, PEAK);
    assert_eq!(torque.sent, [0, 547, -18]);
    assert_eq!(torque.limited.applied, Vector2::new(0.06, -0.04), "E is made of the law's torque alone");
}

#[test]
fn nothing_disturbs_before_the_onset_or_on_the_way_to_the_start() {
    for time in [-2.0, 0.0, 0.999] {
        let torque = prepare(Disturbance::Paper, DisturbanceSite::Command, time);
        assert_eq!((torque.sent, torque.disturbance), ([0, 300, -100], Vector2::zeros()));
    }
    assert_eq!(prepare(Disturbance::None, DisturbanceSite::Command, PEAK).sent, [0, 300, -100]);
}

#[test]
fn the_sine_swings_below_zero_half_a_period_later() {
    // At 1 + 1/4 s: e^(−5/4) = 0.286505, sine −1: −0.0214879 and −0.0143252 N·m.
    let torque = prepare(Disturbance::Paper, DisturbanceSite::Command, 1.25);
    // 0.0385121 N·m of 200 mN·m, −0.0543252 of 400 mN·m.
    assert_eq!(torque.sent, [0, 193, -136]);
}
