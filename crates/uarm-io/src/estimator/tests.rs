use super::*;
use approx::{assert_abs_diff_eq, assert_relative_eq};
use proptest::prelude::*;

const PERIOD: f64 = 0.003;

fn all() -> [AnyEstimator<f64>; 4] {
    [
        EstimatorConfiguration::LowPass { cutoff: 27.81882 },
        EstimatorConfiguration::Tracking { bandwidth: 60.0 },
        EstimatorConfiguration::Kalman(KalmanSettings {
            jerk_density: 50.0,
            measurement_deviation: 1e-4,
            nominal_period: PERIOD,
        }),
        EstimatorConfiguration::Levant { jerk_bound: 20.0 },
    ]
    .map(|configuration| configuration.build().unwrap())
}

/// Runs an estimator over `motion` for `duration`, stepping by what `period` gives, and returns its last estimate and
/// the time of it.
fn follow(
    estimator: &mut AnyEstimator<f64>,
    motion: impl Fn(f64) -> f64,
    duration: f64,
    mut period: impl FnMut() -> f64,
) -> (Estimate<f64>, f64) {
    let mut time = 0.0;
    let mut estimate = estimator.update(motion(time), 0.0);
    while time < duration {
        let step = period();
        time += step;
        estimate = estimator.update(motion(time), step);
    }
    (estimate, time)
}

/// A repeatable sequence in 0 … 1 (a Lehmer generator).
fn sequence() -> impl FnMut() -> f64 {
    let mut state = 12_345_u64;
    move || {
        state = state * 48_271 % 2_147_483_647;
        state as f64 / 2_147_483_647.0
    }
}

#[test]
fn settings_are_checked() {
    for cutoff in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(LowPassDerivative::<f64>::new(cutoff).is_err());
        assert!(TrackingLoop::<f64>::new(cutoff).is_err());
        assert!(LevantDifferentiator::<f64>::new(cutoff).is_err());
        let settings = KalmanSettings { jerk_density: cutoff, measurement_deviation: 1e-4, nominal_period: PERIOD };
        assert!(KalmanFilter::<f64>::new(&settings).is_err());
    }
    let error = LowPassDerivative::<f64>::new(-1.0).unwrap_err();
    assert_eq!(std::format!("{error}"), "low-pass cutoff (rad/s) of -1, expected a finite number above zero");
}

/// The low-pass as a sum over its impulse response instead of a recursion: v_n = Σ α (1−α)^(n−k) d_k.
#[test]
fn the_low_pass_is_the_convolution_with_its_impulse_response() {
    let cutoff = 27.81882;
    let motion = |k: i32| 0.3 * (2.0 * PERIOD * f64::from(k)).sin() + 1e-3 * f64::from(k * 7919 % 13);
    let mut estimator = VelocityEstimator::new(LowPassDerivative::new(cutoff).unwrap());
    estimator.update(motion(0), 0.0);
    let smoothing = 1.0 - (-cutoff * PERIOD).exp();
    for n in 1..400 {
        let velocity = estimator.update(motion(n), PERIOD).velocity;
        let sum: f64 =
            (1..=n).map(|k| smoothing * (1.0 - smoothing).powi(n - k) * (motion(k) - motion(k - 1)) / PERIOD).sum();
        // 400 terms of size 1 in another order.
        assert_abs_diff_eq!(velocity, sum, epsilon = 1e-12);
    }
}

/// Two half steps and one whole step over a steady slope leave the low-pass in the same state: the weight of a
/// difference is that of its time.
#[test]
fn the_low_pass_weighs_time_not_steps() {
    let mut whole = VelocityEstimator::new(LowPassDerivative::new(30.0).unwrap());
    let mut halves = whole;
    whole.update(0.0, 0.0);
    halves.update(0.0, 0.0);
    whole.update(0.01, 0.004);
    halves.update(0.005, 0.002);
    halves.update(0.01, 0.002);
    assert_relative_eq!(whole.freeze().unwrap().velocity, halves.freeze().unwrap().velocity, max_relative = 1e-14);
}

/// With the measurement at zero the loop's state dies out along its triple pole: (1 − θ z⁻¹)³ x = 0.
#[test]
fn the_tracking_loop_has_a_triple_pole() {
    let mut estimator = VelocityEstimator::new(TrackingLoop::new(60.0).unwrap());
    estimator.thaw(Some(Estimate { position: 1.0, velocity: -20.0, acceleration: 300.0 }));
    let pole = (-60.0 * PERIOD).exp();
    let mut states = std::vec![estimator.freeze().unwrap()];
    for _ in 0..10 {
        states.push(estimator.update(0.0, PERIOD));
    }
    for window in states.windows(4) {
        for part in [|x: &Estimate<f64>| x.position, |x: &Estimate<f64>| x.velocity, |x: &Estimate<f64>| x.acceleration]
        {
            let terms = [part(&window[3]), -3.0 * pole * part(&window[2]), 3.0 * pole * pole * part(&window[1])];
            let sum = terms.iter().sum::<f64>();
            assert_relative_eq!(sum, pole * pole * pole * part(&window[0]), epsilon = 1e-9, max_relative = 1e-9);
        }
    }
}

#[test]
fn standing_still_is_seen_exactly() {
    for mut estimator in all() {
        let (estimate, _) = follow(&mut estimator, |_| 0.7, 1.0, || PERIOD);
        assert_eq!(estimate, Estimate::at_rest(0.7), "{estimator:?}");
    }
}

#[test]
fn a_ramp_is_followed_without_error_however_the_period_varies() {
    for mut estimator in all() {
        let mut random = sequence();
        let (estimate, time) = follow(&mut estimator, |t| 0.1 + 0.5 * t, 4.0, || PERIOD * (0.5 + random()));
        // The linear ones converge exponentially. Levant's keeps a limit cycle of the order L T².
        let tolerance =
            if matches!(estimator.method(), AnyMethod::Levant(_)) { 20.0 * 20.0 * PERIOD * PERIOD } else { 1e-9 };
        assert_abs_diff_eq!(estimate.velocity, 0.5, epsilon = tolerance);
        assert_abs_diff_eq!(estimate.position, 0.1 + 0.5 * time, epsilon = tolerance);
    }
}

#[test]
fn a_constant_acceleration_is_followed_by_those_that_track_it() {
    for mut estimator in all() {
        let mut random = sequence();
        let (estimate, time) = follow(&mut estimator, |t| 0.5 * t * t, 3.0, || PERIOD * (0.5 + random()));
        match estimator.method() {
            // A first-order low-pass lags by 1/ω_c, the backward difference by about half a period.
            AnyMethod::LowPass(_) => {
                assert_abs_diff_eq!(time - estimate.velocity, 1.0 / 27.81882, epsilon = PERIOD);
            }
            AnyMethod::Levant(_) => {
                assert_abs_diff_eq!(estimate.velocity, time, epsilon = 20.0 * 20.0 * PERIOD * PERIOD)
            }
            _ => assert_abs_diff_eq!(estimate.velocity, time, epsilon = 1e-7),
        }
    }
}

/// Levant's accuracy without noise scales as T² for the velocity: a quarter of the period, a sixteenth of the error.
#[test]
fn levants_differentiator_keeps_the_order_of_its_accuracy() {
    let worst = |period: f64| {
        let mut estimator = VelocityEstimator::new(LevantDifferentiator::new(3.0).unwrap());
        let steps = (6.0 / period) as i32;
        (0..steps)
            .map(|k| {
                let time = f64::from(k) * period;
                let error = estimator.update(time.sin(), period).velocity - time.cos();
                if time > 4.0 { error.abs() } else { 0.0 }
            })
            .fold(0.0, f64::max)
    };
    let (coarse, fine) = (worst(0.004), worst(0.001));
    assert!(coarse < 60.0 * 0.004 * 0.004, "{coarse}");
    assert!((8.0..32.0).contains(&(coarse / fine)), "{coarse} {fine}");
}

/// One step from rest, worked out by hand: L = 8, so L^(1/3) = 2; the angle jumps by 0.001, so |e|^(1/3) = 0.1.
#[test]
fn levants_gains_are_2_and_1_5_sqrt_2_and_1_1() {
    let mut estimator = VelocityEstimator::new(LevantDifferentiator::new(8.0).unwrap());
    estimator.reset(0.0);
    let Estimate { position, velocity, acceleration } = estimator.update(1e-3, 0.01);
    // 2 · 2 · 0.01 · 0.01, 1.5 · √2 · 4 · 0.1 · 0.01, 1.1 · 8 · 0.01.
    assert_relative_eq!(position, 4e-4, max_relative = 1e-14);
    assert_relative_eq!(velocity, 0.008_485_281_374_238_57, max_relative = 1e-14);
    assert_relative_eq!(acceleration, 0.088, max_relative = 1e-14);
    // Over a long step the correction of the angle stops at the measurement.
    estimator.reset(0.0);
    assert_eq!(estimator.update(1e-3, 1.0).position, 1e-3);
}

#[test]
fn a_reset_is_at_rest() {
    for mut estimator in all() {
        follow(&mut estimator, |t| t.sin(), 0.5, || PERIOD);
        estimator.reset(0.25);
        assert_eq!(estimator.freeze(), Some(Estimate { position: 0.25, velocity: 0.0, acceleration: 0.0 }));
        estimator.reset_unknown();
        assert_eq!(estimator.freeze(), None);
        assert_eq!(estimator.update(-3.0, PERIOD), Estimate { position: -3.0, velocity: 0.0, acceleration: 0.0 });
    }
}

#[test]
fn a_frozen_state_goes_on_to_the_bit() {
    for (mut estimator, mut thawed) in all().into_iter().zip(all()) {
        follow(&mut estimator, |t| t.sin(), 0.5, || PERIOD);
        thawed.thaw(estimator.freeze());
        for k in 0..100 {
            let position = f64::from(k) * 1e-3;
            assert_eq!(estimator.update(position, PERIOD), thawed.update(position, PERIOD));
        }
    }
}

#[test]
fn single_precision_follows_double() {
    let mut wide = VelocityEstimator::new(TrackingLoop::<f64>::new(60.0).unwrap());
    let mut narrow = VelocityEstimator::new(TrackingLoop::<f32>::new(60.0).unwrap());
    for k in 0..1000 {
        let position = (f64::from(k) * PERIOD).sin();
        let velocity = wide.update(position, PERIOD).velocity;
        // β/T magnifies the rounding of an angle of 1 rad to 24 bits some thirty times.
        assert_abs_diff_eq!(
            f64::from(narrow.update(position as f32, PERIOD as f32).velocity),
            velocity,
            epsilon = 1e-4
        );
    }
}

proptest! {
    /// Every estimate is finite, whatever the period, as long as the angle is finite.
    #[test]
    fn estimates_stay_finite(
        steps in proptest::collection::vec((-100.0_f64..100.0, prop_oneof![0.0_f64..0.1, Just(0.0), Just(-1.0), Just(f64::NAN)]), 1..100),
    ) {
        for mut estimator in all() {
            for (position, period) in &steps {
                let estimate = estimator.update(*position, *period);
                prop_assert!(estimate.position.is_finite() && estimate.velocity.is_finite() && estimate.acceleration.is_finite());
            }
        }
    }

    /// A step without time changes nothing.
    #[test]
    fn no_time_no_change(position in -3.0_f64..3.0, other in -3.0_f64..3.0) {
        for mut estimator in all() {
            estimator.update(position, 0.0);
            let before = estimator.update(position + 1e-3, PERIOD);
            prop_assert_eq!(estimator.update(other, 0.0), before);
        }
    }

    /// Lags and gains do not depend on where the joint is.
    #[test]
    fn the_linear_ones_are_linear(offset in -3.0_f64..3.0, scale in -5.0_f64..5.0) {
        for estimator in &all()[..3] {
            let (mut plain, mut moved) = (*estimator, *estimator);
            for k in 0..200 {
                let position = (f64::from(k) * 0.01).sin();
                let (a, b) = (plain.update(position, PERIOD), moved.update(offset + scale * position, PERIOD));
                prop_assert!((b.velocity - scale * a.velocity).abs() < 1e-10);
            }
        }
    }
}

/// What an estimator at rest at 0 rad that turns with 1 rad/s makes of an angle.
fn step(method: &impl EstimationMethod<f64>, position: f64, period: f64) -> Estimate<f64> {
    method.step(&Estimate { position: 0.0, velocity: 1.0, acceleration: 0.0 }, position, period)
}

/// Half of each difference, for α = 1 − exp(−ω T) = 1/2: 3 rad/s now, so 2 rad/s, 1 rad/s more than 10 ms ago.
#[test]
fn a_step_of_the_low_pass_is_the_share_alpha_of_the_difference() {
    let method = LowPassDerivative::new(100.0 * std::f64::consts::LN_2).unwrap();
    let estimate = step(&method, 0.03, 0.01);
    assert_abs_diff_eq!(estimate.velocity, 2.0, epsilon = 1e-12);
    assert_abs_diff_eq!(estimate.acceleration, 100.0, epsilon = 1e-9);
}

/// L = 27 rad/s³, e = 1 mrad: |e|^(1/3) = 0.1, L^(1/3) = 3. In 1 ms: 2 · 3 · 0.01, 1.5 √2 · 9 · 0.1 and 1.1 · 27 times that.
#[test]
fn a_step_of_levants_differentiator_has_its_gains() {
    let method = LevantDifferentiator::new(27.0).unwrap();
    let estimate = step(&method, 0.0, 0.001);
    assert_abs_diff_eq!(estimate.position, 0.001 - 0.000_06, epsilon = 1e-15);
    assert_abs_diff_eq!(estimate.velocity, 1.0 - 0.001_909_188_309_203_678, epsilon = 1e-15);
    assert_abs_diff_eq!(estimate.acceleration, -0.0297, epsilon = 1e-15);
}
