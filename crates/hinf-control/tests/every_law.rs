//! What every law keeps: finite outputs whatever comes in, exact freezing and thawing, the same answers in f32 and f64.

use dem_model::{Scalar, ThreeLinkDem};
use hinf_control::adaptation::AntiWindup;
use hinf_control::{
    AnyController, BaseAcceleration, BaseMeasurement, BuildError, Controller, ControllerOptions, Firing, FuzzySets,
    FuzzySystem, Law, LimitAction, Measurement, NominalForm, ParameterLimits, Reference, ThawError, TrackingError,
    WeightReading, Weights,
};
use nalgebra::Vector2;
use proptest::prelude::*;

/// Every law in every form, with what keeps Φ in its place on or off.
fn variants<T: Scalar>(safeguards: bool) -> Vec<(String, AnyController<T>)> {
    let mut variants = Vec::new();
    let modes = [
        BaseAcceleration::Measured,
        BaseAcceleration::Eliminated,
        BaseAcceleration::Omitted,
        BaseAcceleration::Reduced,
        BaseAcceleration::ReducedMomentum,
    ];
    let forms = [NominalForm::ActiveJoints, NominalForm::Reduced];
    let firings = [Firing::Minimum, Firing::Product];
    for law in Law::ALL {
        for base_acceleration in modes {
            for nominal_form in forms {
                for firing in firings {
                    let mut options = ControllerOptions::paper(law);
                    options.base_acceleration = base_acceleration;
                    options.nominal_form = nominal_form;
                    options.fuzzy_system = FuzzySystem::new(FuzzySets::untrained(), firing);
                    if safeguards {
                        options.parameter_limits = ParameterLimits::Ball { radius: T::constant(0.05) };
                        options.limit_action = LimitAction::Project;
                        options.anti_windup = AntiWindup::FreezeWhileLimited;
                    }
                    let weights = Weights::table_3(law, WeightReading::Blocks);
                    match AnyController::new(law, ThreeLinkDem::table_2(), &weights, &options) {
                        Ok(controller) => {
                            let name = format!("{law:?} {base_acceleration:?} {nominal_form:?} {firing:?}");
                            variants.push((name, controller));
                        }
                        Err(error) => assert_eq!(error, BuildError::AdaptiveReduced),
                    }
                }
            }
        }
    }
    variants
}

/// What comes in in one cycle, in f64.
#[derive(Clone, Debug)]
struct Cycle {
    numbers: [f64; 13],
    period: f64,
    limited: [bool; 2],
}

impl Cycle {
    fn inputs<T: Scalar>(&self) -> (Measurement<T>, Reference<T>, T) {
        let [q2, q3, r2, r3, b0, b1, b2, p2, p3, v2, v3, a2, a3] = self.numbers.map(T::constant);
        let measurement = Measurement {
            position: Vector2::new(q2, q3),
            velocity: Vector2::new(r2, r3),
            base: BaseMeasurement { position: b0, velocity: b1, acceleration: b2 },
        };
        let reference = Reference {
            position: Vector2::new(p2, p3),
            velocity: Vector2::new(v2, v3),
            acceleration: Vector2::new(a2, a3),
        };
        (measurement, reference, T::constant(self.period))
    }
}

fn wild() -> impl Strategy<Value = Cycle> {
    let number = prop_oneof![
        6 => -3.0..3.0_f64,
        1 => prop::num::f64::ANY,
        1 => prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN_POSITIVE, 0.0]),
    ];
    let period = prop_oneof![8 => 0.0..0.01_f64, 1 => prop::num::f64::ANY];
    (prop::collection::vec(number, 13), period, prop::bool::ANY, prop::bool::ANY).prop_map(
        |(numbers, period, first, second)| Cycle {
            numbers: numbers.try_into().unwrap(),
            period,
            limited: [first, second],
        },
    )
}

/// A robot on its way: errors of a few degrees.
fn ordinary() -> impl Strategy<Value = Cycle> {
    let motion = prop::collection::vec(-1.5..1.5_f64, 9);
    let errors = prop::collection::vec(-0.05..0.05_f64, 4);
    (motion, errors, 0.001..0.006_f64, prop::bool::ANY).prop_map(|(motion, errors, period, limited)| {
        let [p2, p3, v2, v3, a2, a3, b0, b1, b2] = motion.try_into().unwrap();
        let [e2, e3, f2, f3]: [f64; 4] = errors.try_into().unwrap();
        let numbers = [p2 + e2, p3 + e3, v2 + f2, v3 + f3, b0, b1, b2, p2, p3, v2, v3, a2, a3];
        Cycle { numbers, period, limited: [false, limited] }
    })
}

fn answer<T: Scalar>(law: &mut AnyController<T>, cycle: &Cycle) -> hinf_control::Command<T> {
    let (measurement, reference, period) = cycle.inputs();
    let command = law.update(&measurement, &reference, period);
    law.limited(cycle.limited);
    command
}

fn stays_finite<T: Scalar>(cycles: &[Cycle]) -> Result<(), TestCaseError> {
    for safeguards in [false, true] {
        for (name, mut law) in variants::<T>(safeguards) {
            for cycle in cycles {
                let command = answer(&mut law, cycle);
                let numbers = command.torque.iter().chain(command.control_input.iter()).chain(law.parameters());
                prop_assert!(numbers.copied().all(|number| number.is_finite()), "{}", name);
                let (measurement, reference, period) = cycle.inputs::<T>();
                if !hinf_control::is_usable(&measurement, &reference, period) {
                    prop_assert!(command.adaptation.fell_back, "{}", name);
                    prop_assert_eq!(command.torque, Vector2::zeros());
                }
            }
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn nothing_that_is_not_finite_leaves_a_law(cycles in prop::collection::vec(wild(), 1..12)) {
        stays_finite::<f64>(&cycles)?;
        stays_finite::<f32>(&cycles)?;
    }

    #[test]
    fn a_thawed_law_goes_on_to_the_bit(
        before in prop::collection::vec(ordinary(), 0..6), after in prop::collection::vec(ordinary(), 1..6)
    ) {
        for safeguards in [false, true] {
            for ((name, mut law), (_, mut other)) in variants::<f64>(safeguards).into_iter().zip(variants(safeguards)) {
                before.iter().for_each(|cycle| { answer(&mut law, cycle); });
                // The other has a past of its own, which thawing must wipe out.
                after.iter().for_each(|cycle| { answer(&mut other, cycle); });
                let frozen = law.freeze();
                other.thaw(&frozen).unwrap();
                prop_assert_eq!(other.freeze(), frozen);
                for cycle in &after {
                    prop_assert_eq!(answer(&mut other, cycle), answer(&mut law, cycle), "{}", name);
                }
                prop_assert_eq!(other.parameters(), law.parameters());
            }
        }
    }

    #[test]
    fn reset_brings_the_beginning_back(cycles in prop::collection::vec(ordinary(), 1..6)) {
        for ((name, mut law), (_, mut fresh)) in variants::<f64>(true).into_iter().zip(variants(true)) {
            cycles.iter().for_each(|cycle| { answer(&mut law, cycle); });
            law.reset();
            for cycle in &cycles {
                prop_assert_eq!(answer(&mut law, cycle), answer(&mut fresh, cycle), "{}", name);
            }
        }
    }

    #[test]
    fn single_and_double_precision_agree(cycles in prop::collection::vec(ordinary(), 1..6)) {
        for ((name, mut double), (_, mut single)) in variants::<f64>(false).into_iter().zip(variants::<f32>(false)) {
            for cycle in &cycles {
                let (double, single) = (answer(&mut double, cycle).torque, answer(&mut single, cycle).torque);
                let difference = (double - single.map(f64::from)).amax();
                // f32 holds angles of 3 rad to 2e-7; Λ/R of 15/s multiplies, the sums and solutions add their own.
                prop_assert!(difference < 1e-4 * (1.0 + double.amax()), "{}: {:e}", name, difference);
            }
        }
    }
}

#[test]
fn the_reduced_adaptive_law_does_not_exist() {
    let mut options = ControllerOptions::<f64>::paper(Law::Adaptive);
    options.base_acceleration = BaseAcceleration::Reduced;
    let weights = Weights::table_3(Law::Adaptive, WeightReading::Blocks);
    let refused = AnyController::new(Law::Adaptive, ThreeLinkDem::table_2(), &weights, &options);
    assert_eq!(refused, Err(BuildError::AdaptiveReduced));
}

#[test]
fn options_of_the_wrong_length_are_refused() {
    let mut options = ControllerOptions::<f64>::paper(Law::Neural);
    options.initial_parameters = Some(&[0.0; 13]);
    let weights = Weights::table_3(Law::Neural, WeightReading::Blocks);
    let refused = AnyController::new(Law::Neural, ThreeLinkDem::table_2(), &weights, &options);
    assert_eq!(refused, Err(BuildError::ParameterCount { expected: 14, found: 13 }));
}

#[test]
fn a_state_of_another_law_is_refused() {
    let mut laws = variants::<f64>(false);
    let (_, nonlinear) = laws.remove(0);
    let (_, mut fuzzy) = laws.into_iter().find(|(name, _)| name.starts_with("Fuzzy ")).unwrap();
    assert_eq!(fuzzy.thaw(&nonlinear.freeze()), Err(ThawError::Size { expected: 109, found: 0 }));
}

#[test]
fn names_find_their_laws() {
    for law in Law::ALL {
        assert_eq!(Law::from_name(law.name()), Some(law));
    }
    assert_eq!(Law::from_name("sliding-mode"), None);
}

#[test]
fn rules_share_the_firing_and_none_fires_far_away() {
    for firing in [Firing::Minimum, Firing::Product] {
        let system = FuzzySystem::<f64>::new(FuzzySets::untrained(), firing);
        let strengths = system.firing_strengths(0.1, -0.02).unwrap();
        assert!((strengths.sum() - 1.0).abs() < 1e-15);
        // 0.1 rad/s is nearest to 0 °/s, −0.02 rad to −0.75°: rule 3·1 + 1.
        assert_eq!(strengths.imax(), 4);
        assert_eq!(system.firing_strengths(1e60, 1e60), None);
        let error = TrackingError { velocity: Vector2::new(1e60, 0.0), position: Vector2::new(1e60, 0.0) };
        let regressor = system.regressor(&error);
        assert!(regressor.fell_back);
        assert_eq!(regressor.matrix[(0, 0)], 1.0 / 9.0);
    }
}
