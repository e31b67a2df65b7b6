//! How Φ is stepped, held, projected and refused.

use approx::assert_relative_eq;
use hinf_control::adaptation::{
    Adaptation, AdaptationWeight, AdaptiveOutput, AntiWindup, Ball, BoundError, DiagonalWeight, FullWeight,
    ParameterBox, ParameterEstimator, ParameterSet, ScalarWeight, WeightError,
};
use hinf_control::{
    AdaptationStatus, BaseMeasurement, ControllerSettings, Law, Measurement, Reference, Synthesis, ThawError,
};
use nalgebra::{SMatrix, SVector, Vector2, Vector3};
use proptest::prelude::*;

type Estimator<Z> = ParameterEstimator<f64, 3, 1, Z>;

fn plain(initial: Vector3<f64>) -> Adaptation<f64, 3> {
    Adaptation::new(initial, ScalarWeight::new(2.0).unwrap()).unwrap()
}

/// One cycle whose output is nothing but this gradient.
fn cycle<const P: usize, Z: AdaptationWeight<f64, P>>(
    estimator: &mut ParameterEstimator<f64, P, 1, Z>,
    gradient: SVector<f64, P>,
    period: f64,
) -> AdaptationStatus {
    let rest = Vector2::zeros();
    let base = BaseMeasurement::<f64>::at_rest();
    let measurement = Measurement { position: rest, velocity: rest, base };
    let reference = Reference { position: rest, velocity: rest, acceleration: rest };
    let output = AdaptiveOutput { torque: rest, control_input: rest, gradient, fell_back: false };
    estimator.cycle(&measurement, &reference, period, |_| output).adaptation
}

/// Steps Φ once along −Z⁻¹·`gradient`.
fn push<const P: usize, Z: AdaptationWeight<f64, P>>(
    estimator: &mut ParameterEstimator<f64, P, 1, Z>,
    gradient: &SVector<f64, P>,
    period: f64,
) -> AdaptationStatus {
    cycle(estimator, *gradient, 0.0);
    cycle(estimator, SVector::zeros(), period)
}

#[test]
fn a_step_is_explicit_euler_with_the_rate_of_the_cycle_before() {
    let mut estimator = Estimator::new(plain(Vector3::new(1.0, 2.0, 3.0)));
    cycle(&mut estimator, Vector3::zeros(), 5.0);
    assert_eq!(*estimator.parameters(), Vector3::new(1.0, 2.0, 3.0));
    push(&mut estimator, &Vector3::new(4.0, 0.0, -4.0), 0.5);
    // −Z⁻¹·gradient·period
    assert_eq!(*estimator.parameters(), Vector3::new(0.0, 2.0, 4.0));
}

#[test]
fn anti_windup_skips_exactly_the_steps_after_limited_cycles() {
    let adaptation = plain(Vector3::zeros()).with_anti_windup(AntiWindup::FreezeWhileLimited);
    let mut estimator = Estimator::new(adaptation);
    let gradient = Vector3::new(-2.0, 0.0, 0.0);
    let mut expected = 0.0;
    for (number, limited) in [[false, false], [false, true], [true, true], [false, false]].into_iter().enumerate() {
        cycle(&mut estimator, gradient, 0.0);
        estimator.limited(limited);
        let status = cycle(&mut estimator, Vector3::zeros(), 1.0);
        assert_eq!(status.frozen, limited.contains(&true), "cycle {number}");
        expected += if limited.contains(&true) { 0.0 } else { 1.0 };
        assert_eq!(estimator.parameters().x, expected, "cycle {number}");
    }
}

#[test]
fn without_anti_windup_a_limited_cycle_is_like_any_other() {
    let mut estimator = Estimator::new(plain(Vector3::zeros()));
    cycle(&mut estimator, Vector3::new(-2.0, 0.0, 0.0), 0.0);
    estimator.limited([true, true]);
    assert!(!cycle(&mut estimator, Vector3::zeros(), 1.0).frozen);
    assert_eq!(estimator.parameters().x, 1.0);
}

#[test]
fn an_alarm_lets_parameters_go_and_a_projection_does_not() {
    let bounds = ParameterBox::new(Vector3::repeat(-1.0), Vector3::repeat(1.0)).unwrap();
    let alarmed = plain(Vector3::zeros()).with_alarm_at(ParameterSet::Box(bounds)).unwrap();
    let projected = plain(Vector3::zeros()).projected_onto_box(bounds).unwrap();
    let gradient = Vector3::new(-4.0, 0.5, 0.0);
    let mut estimator = Estimator::new(alarmed);
    let status = push(&mut estimator, &gradient, 1.0);
    assert!(status.at_bound && !status.projected);
    assert_eq!(*estimator.parameters(), Vector3::new(2.0, -0.25, 0.0));
    let mut estimator = Estimator::new(projected);
    let status = push(&mut estimator, &gradient, 1.0);
    assert!(status.at_bound && status.projected);
    assert_eq!(*estimator.parameters(), Vector3::new(1.0, -0.25, 0.0));
    // Coming back ends the alarm.
    let status = push(&mut estimator, &-gradient, 0.1);
    assert!(!status.at_bound && !status.projected);
}

#[test]
fn what_is_not_finite_leaves_the_parameters_where_they_were() {
    let mut estimator = Estimator::new(plain(Vector3::repeat(1.0)));
    assert!(!cycle(&mut estimator, Vector3::repeat(-2.0), 0.0).fell_back);
    // Neither the pending step nor the one after a gradient that is no number is made.
    assert!(cycle(&mut estimator, Vector3::new(f64::NAN, 0.0, 0.0), 1.0).fell_back);
    assert_eq!(*estimator.parameters(), Vector3::repeat(1.0));
    assert!(!cycle(&mut estimator, Vector3::new(1e300, 0.0, 0.0), 1.0).fell_back);
    assert_eq!(*estimator.parameters(), Vector3::repeat(1.0));
    // A step that overflows.
    assert!(cycle(&mut estimator, Vector3::zeros(), 1e300).fell_back);
    assert_eq!(*estimator.parameters(), Vector3::repeat(1.0));
}

#[test]
fn impossible_choices_are_refused() {
    assert_eq!(ScalarWeight::new(0.0_f64), Err(WeightError::NotPositive { found: 0.0 }));
    assert_eq!(DiagonalWeight::new(Vector2::new(1.0_f64, -1.0)), Err(WeightError::NotPositive { found: -1.0 }));
    let asymmetric = SMatrix::<f64, 2, 2>::new(1.0, 0.5, 0.0, 1.0);
    assert_eq!(FullWeight::new(&asymmetric), Err(WeightError::NotSymmetric { difference: 0.5 }));
    let indefinite = SMatrix::<f64, 2, 2>::new(1.0, 2.0, 2.0, 1.0);
    assert_eq!(FullWeight::new(&indefinite), Err(WeightError::NotPositiveDefinite));
    assert_eq!(Ball::new(Vector2::zeros(), -1.0), Err(BoundError::Radius { found: -1.0 }));
    let crossed = ParameterBox::new(Vector2::new(0.0, 1.0), Vector2::new(1.0, 0.0));
    assert_eq!(crossed, Err(BoundError::Empty { index: 1 }));
    let far = Ball::new(Vector3::repeat(5.0), 1.0).unwrap();
    assert_eq!(plain(Vector3::zeros()).projected_onto_ball(far), Err(BoundError::InitialOutside));
    let nan = Adaptation::new(Vector3::repeat(f64::NAN), ScalarWeight::new(1.0).unwrap());
    assert_eq!(nan, Err(BoundError::NotFinite));
}

/// ‖v‖_Z = 2‖v‖, so that a radius of 3 is 1.5 of Euclid's, around (1, −2, 0.5).
fn off_centre() -> (Ball<f64, 3>, impl Fn(f64) -> Adaptation<f64, 3>) {
    let centre = Vector3::new(1.0, -2.0, 0.5);
    let beside = move |offset| {
        Adaptation::new(centre + Vector3::new(0.0, 0.0, offset), ScalarWeight::new(4.0).unwrap()).unwrap()
    };
    (Ball::new(centre, 3.0).unwrap(), beside)
}

#[test]
fn a_ball_has_its_centre_its_radius_and_its_border() {
    let (ball, beside) = off_centre();
    assert!(beside(1.5).projected_onto_ball(ball).is_ok(), "the border is part of it");
    assert_eq!(beside(1.5625).projected_onto_ball(ball), Err(BoundError::InitialOutside));
    assert_eq!(beside(-1.5625).projected_onto_ball(ball), Err(BoundError::InitialOutside));
    // Φ̇ = −Z⁻¹·gradient leads four units away from the centre.
    let mut estimator = Estimator::new(beside(0.0).projected_onto_ball(ball).unwrap());
    let status = push(&mut estimator, &Vector3::new(0.0, 0.0, -16.0), 1.0);
    assert!(status.projected && status.at_bound);
    assert_relative_eq!(*estimator.parameters(), Vector3::new(1.0, -2.0, 2.0), epsilon = 1e-15);
}

#[test]
fn the_alarm_of_a_ball_sounds_from_its_border_on() {
    let (ball, beside) = off_centre();
    for (offset, at_bound) in [(1.0, false), (1.25, false), (1.5, true), (-1.5, true)] {
        let mut estimator = Estimator::new(beside(offset).with_alarm_at(ParameterSet::Ball(ball)).unwrap());
        assert_eq!(cycle(&mut estimator, Vector3::zeros(), 0.0).at_bound, at_bound, "{offset}");
    }
}

#[test]
fn the_alarm_of_a_box_sounds_from_its_border_on() {
    let bounds = ParameterBox::new(Vector3::new(-1.0, -2.0, -3.0), Vector3::new(1.0, 2.0, 3.0)).unwrap();
    for (start, at_bound) in [([0.5, -1.5, 2.5], false), ([1.0, 0.0, 0.0], true), ([0.0, 0.0, -3.0], true)] {
        let mut estimator = Estimator::new(plain(start.into()).with_alarm_at(ParameterSet::Box(bounds)).unwrap());
        assert_eq!(cycle(&mut estimator, Vector3::zeros(), 0.0).at_bound, at_bound, "{start:?}");
    }
}

/// Whatever the anti-windup: a predicted angle teaches nothing.
#[test]
fn parameters_that_are_held_stand_still_for_one_step() {
    let mut estimator = Estimator::new(plain(Vector3::zeros()));
    let gradient = Vector3::new(-2.0, 0.0, 0.0);
    cycle(&mut estimator, gradient, 0.0);
    estimator.hold();
    for (frozen, expected) in [(true, 0.0), (false, 1.0)] {
        assert_eq!(cycle(&mut estimator, gradient, 1.0).frozen, frozen);
        assert_eq!(estimator.parameters().x, expected);
    }
}

#[test]
fn a_weight_has_an_inverse_and_is_symmetric_to_rounding() {
    for z in [1e-310, f64::INFINITY, -0.5] {
        assert_eq!(ScalarWeight::new(z), Err(WeightError::NotPositive { found: z }));
    }
    for z in [1e-300, 0.5, 1e300] {
        assert_eq!(ScalarWeight::new(z).unwrap().value(), z);
    }
    // A thousand units in the last place of the largest element, here 4.
    let skewed = |units: f64| SMatrix::<f64, 2, 2>::new(4.0, 0.0, 4.0 * units * 2.0_f64.powi(-52), 4.0);
    assert!(FullWeight::new(&skewed(1000.0)).is_ok());
    assert!(matches!(FullWeight::new(&skewed(1001.0)), Err(WeightError::NotSymmetric { .. })));
}

#[test]
fn a_full_weight_of_many_parameters_is_inverted() {
    const PARAMETERS: usize = 54;
    let z = SMatrix::<f64, PARAMETERS, PARAMETERS>::from_fn(|row, column| {
        let distance = row.abs_diff(column);
        if distance == 0 { 3.0 } else { 1.0 / (1.0 + distance as f64 * distance as f64) }
    });
    let weight = FullWeight::new(&z).unwrap();
    let vector = SVector::<f64, PARAMETERS>::from_fn(|row, _| (row as f64).sin());
    assert_relative_eq!(z * weight.solve(&vector), vector, epsilon = 1e-13);
    assert_relative_eq!(weight.norm_squared(&vector), vector.dot(&(z * vector)), max_relative = 1e-13);
}

#[test]
fn a_box_in_the_metric_of_a_full_weight_would_break_the_proof() {
    // Why the types refuse it: clamping element by element moves away from Φ* = (1, 1) in this metric.
    let weight = FullWeight::new(&SMatrix::<f64, 2, 2>::new(1.0, -0.95, -0.95, 1.0)).unwrap();
    let (truth, outside) = (Vector2::new(1.0, 1.0), Vector2::new(3.0, 2.9));
    let clamped = Vector2::new(1.5, 2.9);
    assert!(weight.norm_squared(&(clamped - truth)) > weight.norm_squared(&(outside - truth)));
}

#[test]
fn one_ball_over_both_joints_can_raise_the_storage_of_table_3() {
    // Why the docs advise the box there. One parameter per joint, Z = I; V weighs the joints by 1/t_k².
    let design = Synthesis::<f64>::new(&ControllerSettings::default().weights(Law::Nonlinear)).unwrap();
    let storage = DiagonalWeight::new(design.t11().diagonal().map(|t| 1.0 / (t * t))).unwrap();
    let (truth, outside) = (Vector2::new(0.956, 0.292), Vector2::new(0.485, 0.875) * 1.3);
    let ball = Ball::new(Vector2::zeros(), 1.0).unwrap();
    let adaptation = Adaptation::new(Vector2::zeros(), ScalarWeight::new(1.0).unwrap()).unwrap();
    let mut estimator = ParameterEstimator::new(adaptation.projected_onto_ball(ball).unwrap());
    assert!(push(&mut estimator, &-outside, 1.0).projected);
    let distance = |point: &Vector2<f64>| storage.norm_squared(&(point - truth));
    assert!(distance(estimator.parameters()) > distance(&outside));
}

fn vector3(range: std::ops::Range<f64>) -> impl Strategy<Value = Vector3<f64>> {
    [range.clone(), range.clone(), range].prop_map(Vector3::from)
}

proptest! {
    /// Inequality 12 survives: the projected Φ is never farther from a Φ* in the set than the unprojected one.
    #[test]
    fn projection_onto_a_ball_never_raises_the_storage(
        root in prop::collection::vec(-1.0..1.0_f64, 9), gradient in vector3(-50.0..50.0),
        towards in vector3(-1.0..1.0), depth in 0.0..1.0_f64
    ) {
        let root = SMatrix::<f64, 3, 3>::from_column_slice(&root);
        let weight = FullWeight::new(&(root.transpose() * root + SMatrix::identity() * 0.1)).unwrap();
        let radius = 2.0;
        prop_assume!(towards.norm() > 0.1);
        let truth = towards * (depth * radius / weight.norm_squared(&towards).sqrt());
        let free = Adaptation::new(Vector3::zeros(), weight.clone()).unwrap();
        let kept = free.clone().projected_onto_ball(Ball::new(Vector3::zeros(), radius).unwrap()).unwrap();
        let (mut free, mut kept) = (Estimator::new(free), Estimator::new(kept));
        push(&mut free, &gradient, 1.0);
        let status = push(&mut kept, &gradient, 1.0);
        let distance = |point: &Vector3<f64>| weight.norm_squared(&(point - truth));
        prop_assert!(distance(kept.parameters()) <= distance(free.parameters()) * (1.0 + 1e-12));
        prop_assert!(weight.norm_squared(kept.parameters()).sqrt() <= radius * (1.0 + 1e-12));
        prop_assert_eq!(status.projected, free.parameters() != kept.parameters());
    }

    #[test]
    fn projection_onto_a_box_never_raises_the_storage(
        z in vector3(0.1..10.0), gradient in vector3(-50.0..50.0), truth in vector3(-1.0..1.0), metric in vector3(0.1..10.0)
    ) {
        let weight = DiagonalWeight::new(z).unwrap();
        let bounds = ParameterBox::new(Vector3::repeat(-1.0), Vector3::repeat(1.0)).unwrap();
        let free = Adaptation::new(Vector3::zeros(), weight).unwrap();
        let kept = free.clone().projected_onto_box(bounds).unwrap();
        let (mut free, mut kept) = (Estimator::new(free), Estimator::new(kept));
        push(&mut free, &gradient, 1.0);
        push(&mut kept, &gradient, 1.0);
        // In the metric of Z, and in any other diagonal one: that of V scales Z by c/t_k² where T11 is not tI.
        for metric in [weight, DiagonalWeight::new(metric).unwrap()] {
            let distance = |point: &Vector3<f64>| metric.norm_squared(&(point - truth));
            prop_assert!(distance(kept.parameters()) <= distance(free.parameters()));
        }
        prop_assert!(kept.parameters().amax() <= 1.0);
    }

    #[test]
    fn the_three_weights_agree_where_they_mean_the_same(z in 0.1..10.0_f64, vector in vector3(-1.0..1.0)) {
        let (scalar, diagonal) = (ScalarWeight::new(z).unwrap(), DiagonalWeight::new(Vector3::repeat(z)).unwrap());
        let full = FullWeight::new(&(SMatrix::<f64, 3, 3>::identity() * z)).unwrap();
        let solved = AdaptationWeight::<f64, 3>::solve(&scalar, &vector);
        prop_assert!((diagonal.solve(&vector) - solved).amax() < 1e-14);
        prop_assert!((full.solve(&vector) - solved).amax() < 1e-13);
        let norm = AdaptationWeight::<f64, 3>::norm_squared(&scalar, &vector);
        prop_assert!((diagonal.norm_squared(&vector) - norm).abs() < 1e-13);
        prop_assert!((full.norm_squared(&vector) - norm).abs() < 1e-13);
    }
}

#[test]
fn a_state_of_another_size_or_without_numbers_is_refused() {
    let mut estimator = Estimator::new(plain(Vector3::repeat(1.0)));
    let other = hinf_control::FrozenState::<f64>::new(&[1.0, 2.0]).unwrap();
    assert_eq!(estimator.thaw(&other), Err(ThawError::Size { expected: 7, found: 2 }));
    let nan = hinf_control::FrozenState::<f64>::new(&[f64::NAN; 7]).unwrap();
    assert_eq!(estimator.thaw(&nan), Err(ThawError::NotFinite));
    assert_eq!(*estimator.parameters(), Vector3::repeat(1.0));
}
