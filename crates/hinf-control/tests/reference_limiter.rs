//! The reference meets its own boundary conditions; the limiter keeps its promises.

use approx::assert_relative_eq;
use hinf_control::{QuinticReference, ReferenceError, TorqueLimitError, TorqueLimiter, TorqueLimits, TorqueNotFinite};
use nalgebra::Vector2;
use proptest::prelude::*;

#[test]
fn the_paper_moves_from_20_20_to_80_60_degrees() {
    let reference = QuinticReference::<f64>::paper();
    let middle = reference.at(1.5);
    assert_relative_eq!(middle.position, Vector2::new(50.0_f64.to_radians(), 40.0_f64.to_radians()), epsilon = 1e-15);
    // The rate peaks in the middle at 15/8 of the mean.
    let peak = Vector2::new(60.0_f64.to_radians(), 40.0_f64.to_radians()) / 3.0 * 1.875;
    assert_relative_eq!(middle.velocity, peak, epsilon = 1e-15);
    assert_relative_eq!(middle.acceleration, Vector2::zeros(), epsilon = 1e-15);
}

#[test]
fn a_reference_that_cannot_be_is_refused() {
    let zero = Vector2::zeros();
    let error = |start, end, duration| QuinticReference::<f64>::new(start, end, duration).unwrap_err();
    assert_eq!(error(Vector2::new(f64::NAN, 0.0), zero, 1.0), ReferenceError::PostureNotFinite);
    assert_eq!(error(zero, zero, 0.0), ReferenceError::DurationNotPositive { found: 0.0 });
    assert!(matches!(error(zero, zero, f64::NAN), ReferenceError::DurationNotPositive { .. }));
    assert!(matches!(error(zero, Vector2::new(1.0, 1.0), 1e-200), ReferenceError::MotionNotFinite { .. }));
}

#[test]
fn limits_that_cannot_be_are_refused() {
    let good = TorqueLimits::new(Vector2::new(1.0_f64, 2.0)).unwrap();
    assert_eq!(TorqueLimits::new(Vector2::new(1.0_f64, 0.0)), Err(TorqueLimitError::Magnitude { found: 0.0 }));
    assert_eq!(good.with_rate(Vector2::new(-1.0, 1.0)), Err(TorqueLimitError::Rate { found: -1.0 }));
}

#[test]
fn an_open_limiter_changes_nothing_to_the_bit() {
    let limits = TorqueLimits::new(Vector2::new(1.0_f64, 1.0)).unwrap().with_rate(Vector2::new(1e6, 1e6)).unwrap();
    let mut limiter = TorqueLimiter::new(limits);
    for step in 0..100 {
        let requested = Vector2::new((f64::from(step) * 0.1).sin() / 3.0, -0.07);
        let limited = limiter.limit(requested, 0.003).unwrap();
        assert_eq!(limited.applied, requested);
        assert_eq!(limited.limited, [false, false]);
    }
}

/// 10 N·m/s for 10 ms are 0.1 N·m, up to 0.25 N·m and down to −0.05 N·m; the limit of joint 3 is 0.15 N·m.
#[test]
fn a_limited_rate_leads_to_what_was_asked_for_from_both_sides() {
    let limits = TorqueLimits::new(Vector2::new(1.0_f64, 0.15)).unwrap().with_rate(Vector2::new(10.0, 10.0)).unwrap();
    let mut limiter = TorqueLimiter::new(limits);
    let mut assert_applied = |requested: f64, expected: [f64; 2]| {
        let limited = limiter.limit(Vector2::new(requested, -requested), 0.01).unwrap();
        assert_relative_eq!(limited.applied, Vector2::from(expected), epsilon = 1e-15);
    };
    for expected in [[0.1, -0.1], [0.2, -0.15], [0.25, -0.15]] {
        assert_applied(0.25, expected);
    }
    for expected in [[0.15, -0.05], [0.05, 0.05], [-0.05, 0.05]] {
        assert_applied(-0.05, expected);
    }
}

/// Joint 3 was thawed beyond its limit of 0.5 N·m, and so begins at zero; a step is 0.1 N·m.
#[test]
fn a_thawed_limiter_goes_on_from_a_torque_that_can_have_been_applied() {
    let limits = TorqueLimits::new(Vector2::new(1.0_f64, 0.5)).unwrap().with_rate(Vector2::new(10.0, 10.0)).unwrap();
    let applied_after = |thawed| {
        let mut limiter = TorqueLimiter::new(limits);
        limiter.thaw(thawed);
        limiter.limit(Vector2::new(-1.0, 0.5), 0.01).unwrap().applied
    };
    assert_relative_eq!(applied_after(Vector2::new(-0.5, 0.75)), Vector2::new(-0.6, 0.1), epsilon = 1e-15);
    assert_relative_eq!(applied_after(Vector2::new(1.0, -0.5)), Vector2::new(0.9, -0.4), epsilon = 1e-15);
    assert_relative_eq!(applied_after(Vector2::new(f64::NAN, f64::NAN)), Vector2::new(-0.1, 0.1), epsilon = 1e-15);
}

/// What the torque was does not matter any more: 0.1 N·m from zero.
#[test]
fn a_reset_limiter_begins_at_zero_torque() {
    let limits = TorqueLimits::new(Vector2::new(1.0_f64, 1.0)).unwrap().with_rate(Vector2::new(10.0, 10.0)).unwrap();
    let mut limiter = TorqueLimiter::new(limits);
    limiter.limit(Vector2::new(1.0, -1.0), 0.05).unwrap();
    limiter.reset();
    assert_eq!(limiter.limit(Vector2::new(1.0, -1.0), 0.01).unwrap().applied, Vector2::new(0.1, -0.1));
}

fn any_torque() -> impl Strategy<Value = Vector2<f64>> {
    (prop::num::f64::ANY, -3.0..3.0).prop_map(|(x, y)| Vector2::new(x, y))
}

proptest! {
    #[test]
    fn derivatives_agree_with_differences(
        start in [-3.0..3.0, -3.0..3.0_f64], end in [-3.0..3.0, -3.0..3.0_f64], duration in 0.5..10.0_f64, s in 0.01..0.99_f64
    ) {
        let reference = QuinticReference::new(start.into(), end.into(), duration).unwrap();
        let (step, time) = (1e-5 * duration, s * duration);
        let (before, at, after) = (reference.at(time - step), reference.at(time), reference.at(time + step));
        // Second-order differences: the error is of the order of step² times the third derivative, plus rounding.
        let rate = (after.position - before.position) / (2.0 * step);
        let acceleration = (after.velocity - before.velocity) / (2.0 * step);
        prop_assert!((rate - at.velocity).amax() < 1e-6);
        prop_assert!((acceleration - at.acceleration).amax() < 1e-6);
    }

    #[test]
    fn it_rests_before_and_after(time in 0.0..100.0_f64) {
        let reference = QuinticReference::<f64>::paper();
        for (held, posture) in [(reference.at(-time), reference.start()), (reference.at(3.0 + time), reference.end())] {
            prop_assert_eq!(held.position, *posture);
            prop_assert_eq!(held.velocity, Vector2::zeros());
            prop_assert_eq!(held.acceleration, Vector2::zeros());
        }
    }

    #[test]
    fn applied_torque_is_within_both_limits(
        requests in prop::collection::vec(any_torque(), 1..50), period in prop::num::f64::ANY
    ) {
        let (magnitude, rate) = (Vector2::new(0.5, 1.5), Vector2::new(10.0, 30.0));
        let mut limiter = TorqueLimiter::new(TorqueLimits::new(magnitude).unwrap().with_rate(rate).unwrap());
        let time = if period.is_finite() { period.max(0.0) } else { 0.0 };
        let mut before = Vector2::<f64>::zeros();
        for request in requests {
            let frozen = limiter;
            let limited = match limiter.limit(request, period) {
                Ok(limited) => limited,
                Err(TorqueNotFinite { joint, .. }) => {
                    prop_assert!(!request[joint - 1].is_finite() && request.iter().take(joint - 1).all(|t| t.is_finite()));
                    prop_assert_eq!(limiter, frozen);
                    continue;
                }
            };
            prop_assert!(request.iter().all(|torque| torque.is_finite()));
            for joint in 0..2 {
                let applied = limited.applied[joint];
                prop_assert!(applied.abs() <= magnitude[joint]);
                // A sum of two torques rounds by up to an ulp of 1.5.
                prop_assert!((applied - before[joint]).abs() <= rate[joint] * time + 4e-16);
                prop_assert_eq!(limited.limited[joint], applied != request[joint]);
            }
            before = limited.applied;
        }
    }
}
