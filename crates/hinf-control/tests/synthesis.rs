//! The synthesis solves eq. 9, and refuses each design that cannot be for its own reason.

use approx::assert_relative_eq;
use hinf_control::{
    ControllerSettings, Law, StateWeight, Synthesis, SynthesisError, TrackingError, WeightReading, Weights,
};
use nalgebra::{Matrix2, Matrix4, Vector2};
use proptest::prelude::*;

/// Table 3 in one of its readings.
fn weights(law: Law, reading: WeightReading) -> Weights<f64> {
    ControllerSettings { reading, ..ControllerSettings::default() }.weights(law)
}

fn table_3() -> Weights<f64> {
    weights(Law::Nonlinear, WeightReading::Factors)
}

fn refusal(change: impl FnOnce(&mut Weights<f64>)) -> SynthesisError {
    let mut weights = table_3();
    change(&mut weights);
    Synthesis::new(&weights).expect_err("must be refused")
}

fn elements(range: std::ops::Range<f64>) -> impl Strategy<Value = Matrix2<f64>> {
    [range.clone(), range.clone(), range.clone(), range].prop_map(|[a, b, c, d]| Matrix2::new(a, b, c, d))
}

/// Well-conditioned and positive definite.
fn positive_definite() -> impl Strategy<Value = Matrix2<f64>> {
    elements(-1.0..1.0).prop_map(|root| root.transpose() * root + Matrix2::identity() * 0.1)
}

/// Q from its blocks.
fn state_weight(design: &Synthesis<f64>) -> Matrix4<f64> {
    let StateWeight { velocity, cross, position } = design.state_weight();
    let mut weight = Matrix4::zeros();
    weight.fixed_view_mut::<2, 2>(0, 0).copy_from(velocity);
    weight.fixed_view_mut::<2, 2>(0, 2).copy_from(cross);
    weight.fixed_view_mut::<2, 2>(2, 0).copy_from(&cross.transpose());
    weight.fixed_view_mut::<2, 2>(2, 2).copy_from(position);
    weight
}

/// Eq. 9 from its own text, with R⁻¹ − I/γ² rather than what the synthesis kept of it.
fn residual_of_equation_9(design: &Synthesis<f64>) -> f64 {
    let mut input = nalgebra::Matrix4x2::zeros();
    input.fixed_view_mut::<2, 2>(0, 0).fill_with_identity();
    let level = design.attenuation_level();
    let term = design.control_weight().try_inverse().unwrap() - Matrix2::identity() / (level * level);
    let mut transformation = Matrix4::identity();
    transformation.fixed_view_mut::<2, 2>(0, 0).copy_from(design.t11());
    transformation.fixed_view_mut::<2, 2>(0, 2).copy_from(design.t12());
    let transformed = transformation.transpose() * input;
    let mut storage_rate = Matrix4::zeros();
    storage_rate.fixed_view_mut::<2, 2>(0, 2).copy_from(design.storage());
    storage_rate.fixed_view_mut::<2, 2>(2, 0).copy_from(design.storage());
    (storage_rate - transformed * term * transformed.transpose() + state_weight(design)).amax()
}

#[test]
fn table_3_is_solved_for_every_law_and_reading() {
    for law in Law::ALL {
        for reading in [WeightReading::Factors, WeightReading::Blocks] {
            let design = Synthesis::<f64>::new(&weights(law, reading)).unwrap();
            // Numbers up to 625 met a few roundings of 2.2e-16.
            assert!(design.riccati_residual() < 1e-12, "{law:?} {reading:?}");
            assert!(residual_of_equation_9(&design) < 1e-12, "{law:?} {reading:?}");
        }
    }
}

#[test]
fn diagonal_blocks_are_the_squares_of_diagonal_factors() {
    let blocks = Synthesis::<f64>::new(&weights(Law::Fuzzy, WeightReading::Blocks)).unwrap();
    let root = |x: f64, y: f64| Vector2::new(x.sqrt(), y.sqrt());
    let factors =
        Weights::diagonal(root(1.0, 1.0), root(9.0, 7.0), Vector2::new(0.9, 2.5), 2.0, WeightReading::Factors);
    let factors = Synthesis::new(&factors).unwrap();
    assert_relative_eq!(blocks.t11(), factors.t11(), max_relative = 1e-14);
    assert_relative_eq!(blocks.t12(), factors.t12(), max_relative = 1e-14);
}

#[test]
fn the_level_cancels_from_diagonal_feedback() {
    let mut weights = table_3();
    let error = TrackingError { velocity: Vector2::new(0.3, -0.2), position: Vector2::new(-0.1, 0.05) };
    let torque = |weights: &Weights<f64>| {
        let design = Synthesis::new(weights).unwrap();
        design.t11_inverse() * design.control_input(&error)
    };
    let before = torque(&weights);
    weights.attenuation_level = 7.0;
    assert_relative_eq!(before, torque(&weights), max_relative = 1e-13);
    // −R⁻¹(q̃̇ + Q1⁻¹Q2 q̃)
    let by_hand = Vector2::new(-(0.3 - 9.0 / 0.64 * 0.1) / 0.9, -(-0.2 + 7.0 / 0.64 * 0.05) / 2.5);
    assert_relative_eq!(before, by_hand, max_relative = 1e-13);
}

#[test]
fn each_reason_has_its_own_refusal() {
    assert!(matches!(refusal(|w| w.velocity.m11 = f64::NAN), SynthesisError::NotFinite { quantity: "Q1" }));
    assert!(matches!(refusal(|w| w.control.m22 = f64::INFINITY), SynthesisError::NotFinite { quantity: "R" }));
    assert!(matches!(refusal(|w| w.attenuation_level = 0.0), SynthesisError::AttenuationLevelNotPositive { .. }));
    assert!(matches!(refusal(|w| w.control.m12 = 0.1), SynthesisError::NotSymmetric { quantity: "R", .. }));
    assert!(matches!(refusal(|w| w.control.m11 = -0.9), SynthesisError::NotPositiveDefinite { quantity: "R", .. }));
    assert!(matches!(refusal(|w| w.control.m22 = 4.0), SynthesisError::ControlWeightTooLarge { .. }));
    assert!(matches!(refusal(|w| w.velocity.m22 = 0.0), SynthesisError::SingularTransformation { .. }));
    assert!(matches!(refusal(|w| w.cross.m12 = 0.5), SynthesisError::Unsolvable { .. }));
    assert!(matches!(refusal(|w| w.position.m11 = -9.0), SynthesisError::StorageNotPositive { .. }));
    assert!(matches!(refusal(|w| w.cross.m11 = -9.0), SynthesisError::StateWeightNotPositive));
    let asymmetric_block = refusal(|w| {
        w.reading = WeightReading::Blocks;
        w.position.m21 = 0.5;
    });
    assert!(matches!(asymmetric_block, SynthesisError::NotSymmetric { quantity: "Q2ᵀQ2", .. }));
}

#[test]
fn what_table_3_proves() {
    for law in Law::PAPER {
        let design = Synthesis::<f64>::new(&weights(law, WeightReading::Blocks)).unwrap();
        let proven = design.proven_attenuation_level().unwrap();
        assert_relative_eq!(proven.level_squared, 3.526, epsilon = 1e-3);
    }
}

#[test]
fn a_design_outside_the_theorem_proves_less_than_it_was_designed_for() {
    let weights = |ratio: f64| {
        let rate = Vector2::new(1.0, ratio);
        Weights::diagonal(rate, Vector2::new(9.0, 7.0), Vector2::new(0.9, 2.5), 2.0, WeightReading::Factors)
    };
    let design = Synthesis::new(&weights(4.0)).unwrap();
    let t = design.t11().diagonal().map(|t| t * t);
    assert!(t.max() > (t.x * (8.0 / 0.9 - 1.0)).min(t.y * (8.0 / 2.5 - 1.0)), "the condition of the theorem fails");
    assert!(design.proven_attenuation_level().unwrap().level_squared > 4.0);
    assert!(Synthesis::new(&weights(1.0)).unwrap().proven_attenuation_level().unwrap().level_squared < 4.0);
}

proptest! {
    #[test]
    fn any_positive_definite_blocks_are_solved(
        rate in positive_definite(), position in positive_definite(), control in positive_definite()
    ) {
        let mut weights = table_3();
        (weights.velocity, weights.position, weights.control) = (rate, position, control);
        weights.attenuation_level = 3.0;
        weights.reading = WeightReading::Blocks;
        let design = Synthesis::new(&weights).unwrap();
        let scale = state_weight(&design).amax() * control.try_inverse().unwrap().amax();
        prop_assert!(residual_of_equation_9(&design) < 1e-11 * scale);
        let q = state_weight(&design);
        prop_assert!((q.fixed_view::<2, 2>(0, 0) - rate).amax() < 1e-12);
        prop_assert!((q.fixed_view::<2, 2>(2, 2) - position).amax() < 1e-11 * scale);
    }

    #[test]
    fn full_factors_are_solved_with_the_cross_weight_that_makes_them_solvable(
        rate in elements(-1.0..1.0), position in elements(-1.0..1.0), control in positive_definite()
    ) {
        let q1 = rate + Matrix2::identity() * 3.0;
        let q2 = position + Matrix2::identity() * 3.0;
        let product = q1.transpose() * q2;
        let mut weights = table_3();
        (weights.velocity, weights.position, weights.control) = (q1, q2, control);
        weights.cross = (product - product.transpose()) * 0.5;
        weights.attenuation_level = 3.0;
        let design = Synthesis::new(&weights).unwrap();
        prop_assert!(residual_of_equation_9(&design) < 1e-10);
        // Λ = T11⁻¹T12 = Q1⁻¹Q2.
        prop_assert!((design.error_rate() - q1.try_inverse().unwrap() * q2).amax() < 1e-11);
    }
}
