//! What the drives are sent, in numbers.

use approx::assert_abs_diff_eq;
use proptest::prelude::*;
use uarm_loop::fade::{Fade, StopRamp};
use uarm_loop::hinf_control::{Disturbance, TorqueLimiter, TorqueLimits};
use uarm_loop::nalgebra::Vector2;
use uarm_loop::supervisor::Authority;
use uarm_loop::torque::{DisturbanceSite, PreparedTorque, TorqueStage};

use crate::fake_path::scale;

/// The sine of eq. 48 is 1 at 1/12 s after its onset; e^(−5/12) = 0.659241 is left of its amplitudes 0.075 and 0.05 N·m.
const PEAK: f64 = 1.0 + 1.0 / 12.0;

fn prepare(disturbance: Disturbance, site: DisturbanceSite, time: f64) -> PreparedTorque<3, 2> {
    let limits = TorqueLimits::new(Vector2::new(0.06, 0.1)).unwrap();
    let scales = [scale(200), scale(200), scale(400)];
    let fade = Fade::new(StopRamp::default());
    let mut stage = TorqueStage {
        limiter: TorqueLimiter::new(limits),
        output_limiter: TorqueLimiter::new(limits),
        fade,
        scales,
        disturbance,
        site,
    };
    stage.prepare(Vector2::new(0.07, -0.04), time, 0.003, Authority::Full).unwrap()
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

/// 0.06 + 0.049443 = 0.109443 N·m are more than joint 2 may have: 0.06 N·m are 300 per mille of 200 mN·m. −0.04 + 0.032962 =
/// −0.007038 N·m are −18 of 400 mN·m.
#[test]
fn a_disturbance_of_the_command_is_added_to_the_laws_torque_and_limited_with_it() {
    let torque = prepare(Disturbance::Paper, DisturbanceSite::Command, PEAK);
    assert_eq!(torque.sent, [0, 300, -18]);
    assert_eq!(torque.limited.applied, Vector2::new(0.06, -0.04), "E is made of the law's torque alone");
    assert_eq!(torque.output.x, 0.06);
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

/// Magnitudes and rates of the limits, N·m and N·m/s.
const MAGNITUDE: [f64; 2] = [0.06, 0.1];
const RATE: [f64; 2] = [2.0, 5.0];

fn any_torque() -> impl Strategy<Value = f64> {
    prop_oneof![4 => -0.3..0.3_f64, 1 => any::<f64>()]
}

proptest! {
    /// Whatever laws ask for, however long the cycles are, with the disturbance added or not, running or stopping.
    #[test]
    fn torque_that_leaves_the_stage_is_finite_and_within_limit_and_rate(
        requests in prop::collection::vec((any_torque(), any_torque(), 0.9..1.5_f64, 0.001..0.02_f64), 1..40),
        stops_at in 0..60_usize,
        injected in any::<bool>(),
    ) {
        let limits = TorqueLimits::new(Vector2::from(MAGNITUDE)).unwrap().with_rate(Vector2::from(RATE)).unwrap();
        let site = if injected { DisturbanceSite::Command } else { DisturbanceSite::Plant };
        let mut stage = TorqueStage {
            limiter: TorqueLimiter::new(limits),
            output_limiter: TorqueLimiter::new(limits),
            fade: Fade::new(StopRamp::default()),
            scales: [scale(200), scale(200), scale(200)],
            disturbance: Disturbance::Paper,
            site,
        };
        let mut before = [0.0; 2];
        for (cycle, (joint_2, joint_3, time, rise_time)) in requests.into_iter().enumerate() {
            let authority = if cycle < stops_at { Authority::Full } else { Authority::Fading };
            let Ok(torque) = stage.prepare(Vector2::new(joint_2, joint_3), time, rise_time, authority) else {
                prop_assert!(!(joint_2.is_finite() && joint_3.is_finite()), "only what is no number is refused");
                continue;
            };
            prop_assert!(joint_2.is_finite() && joint_3.is_finite());
            for joint in 0..2 {
                let output = torque.output[joint];
                prop_assert!(output.is_finite() && output.abs() <= MAGNITUDE[joint]);
                prop_assert!((output - before[joint]).abs() <= RATE[joint] * rise_time + 1e-15);
                // Half a per mille of 200 mN·m is what rounding to whole per mille costs.
                prop_assert!((f64::from(torque.sent[joint + 1]) * 2e-4 - output).abs() <= 1e-4 + 1e-12);
                if authority == Authority::Fading {
                    prop_assert!(output.abs() <= before[joint].abs().max(0.0) + 1e-15 || RATE[joint] * rise_time < MAGNITUDE[joint]);
                }
                before[joint] = output;
            }
            prop_assert_eq!(torque.sent[0], 0, "the passive joint");
        }
    }
}

/// Every sign and exponent of a double, NaN, infinity, zero and subnormal numbers among them, with the first, the last and a middle
/// fraction: whatever is asked for, what leaves the stage is finite and within its limit, or it is refused.
#[test]
fn no_bit_pattern_of_a_request_leaves_the_stage_beyond_its_limit() {
    const EXPONENTS: u64 = 1 << 11;
    const FRACTION: u64 = (1 << 52) - 1;
    let mut refused = 0;
    for (sign, exponent) in
        [0, 1 << 63].into_iter().flat_map(|sign| (0..EXPONENTS).map(move |exponent| (sign, exponent)))
    {
        for fraction in [0, 1, FRACTION / 3, FRACTION] {
            let request = f64::from_bits(sign | exponent << 52 | fraction);
            let limits = TorqueLimits::new(Vector2::from(MAGNITUDE)).unwrap();
            let mut stage = TorqueStage {
                limiter: TorqueLimiter::new(limits),
                output_limiter: TorqueLimiter::new(limits),
                fade: Fade::new(StopRamp::default()),
                scales: [scale(200), scale(200), scale(200)],
                disturbance: Disturbance::None,
                site: DisturbanceSite::Plant,
            };
            match stage.prepare(Vector2::new(request, -request), 1.0, 0.003, Authority::Full) {
                Ok(torque) => {
                    for (joint, limit) in MAGNITUDE.into_iter().enumerate() {
                        let (output, sent) = (torque.output[joint], f64::from(torque.sent[joint + 1]) * 2e-4);
                        assert!(output.is_finite() && output.abs() <= limit, "{request:e}: {output}");
                        assert!(sent.abs() <= limit + 1e-12, "{request:e}: {sent}");
                    }
                }
                Err(_) => {
                    assert!(!request.is_finite(), "{request:e}");
                    refused += 1;
                }
            }
        }
    }
    assert_eq!(refused, 2 * 4, "infinity and three kinds of NaN, of either sign");
}
