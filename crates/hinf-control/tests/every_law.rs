//! What every law keeps: finite outputs whatever comes in, exact freezing and thawing, the same commands in f32 and f64.

use dem_model::{Scalar, ThreeLinkDem};
use hinf_control::{
    AdaptationGuard, AnyController, BaseAcceleration, BaseMeasurement, BuildContext, Controller, ControllerSettings,
    Firing, FuzzySets, FuzzySystem, Law, Measurement, PublishedIndices, Reference, StateWeights, SymmetricWeight,
    ThawError, TrackingError,
};
use nalgebra::Vector2;
use proptest::prelude::*;

/// Every law in every form, with what keeps Φ in its place on or off.
fn variants<T: Scalar>(safeguards: bool) -> Vec<(String, AnyController<T>)> {
    let mut variants = Vec::new();
    let mut context = BuildContext::new(ThreeLinkDem::table_2());
    if safeguards {
        context.adaptation_guard = AdaptationGuard::Bounded;
    }
    for law in Law::ALL {
        let mut forms = vec![("default".to_owned(), ControllerSettings::default())];
        for mode in BaseAcceleration::ALL {
            let mut settings = ControllerSettings::default();
            if settings.set_base_acceleration(law, mode).is_ok() {
                forms.push((mode.name().to_owned(), settings));
            }
        }
        let mut settings = ControllerSettings::default();
        settings.fuzzy.firing = Firing::Product;
        settings.fuzzy_model.firing = Firing::Product;
        if settings.firing(law).is_some() {
            forms.push(("product".to_owned(), settings));
        }
        for (form, settings) in forms {
            variants.push((format!("{law:?} {form}"), settings.build(law, &context).unwrap()));
        }
    }
    variants
}

/// What comes in in one cycle, in f64.
#[derive(Clone, Debug)]
struct Cycle {
    numbers: [f64; 12],
    period: f64,
    limited: [bool; 2],
}

impl Cycle {
    fn inputs<T: Scalar>(&self) -> (Measurement<T>, Reference<T>, T) {
        let [q2, q3, r2, r3, b1, b2, p2, p3, v2, v3, a2, a3] = self.numbers.map(T::constant);
        let measurement = Measurement {
            position: Vector2::new(q2, q3),
            velocity: Vector2::new(r2, r3),
            base: BaseMeasurement::planar(b1, b2),
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
    (prop::collection::vec(number, 12), period, prop::bool::ANY, prop::bool::ANY).prop_map(
        |(numbers, period, first, second)| Cycle {
            numbers: numbers.try_into().unwrap(),
            period,
            limited: [first, second],
        },
    )
}

/// A robot on its way: errors of a few degrees.
fn ordinary() -> impl Strategy<Value = Cycle> {
    let motion = prop::collection::vec(-1.5..1.5_f64, 8);
    let errors = prop::collection::vec(-0.05..0.05_f64, 4);
    (motion, errors, 0.001..0.006_f64, prop::bool::ANY).prop_map(|(motion, errors, period, limited)| {
        let [p2, p3, v2, v3, a2, a3, b1, b2] = motion.try_into().unwrap();
        let [e2, e3, f2, f3]: [f64; 4] = errors.try_into().unwrap();
        let numbers = [p2 + e2, p3 + e3, v2 + f2, v3 + f3, b1, b2, p2, p3, v2, v3, a2, a3];
        Cycle { numbers, period, limited: [false, limited] }
    })
}

fn run_cycle<T: Scalar>(law: &mut AnyController<T>, cycle: &Cycle) -> hinf_control::Command<T> {
    let (measurement, reference, period) = cycle.inputs();
    let command = law.update(&measurement, &reference, period);
    law.limited(cycle.limited);
    command
}

fn stays_finite<T: Scalar>(cycles: &[Cycle]) -> Result<(), TestCaseError> {
    for safeguards in [false, true] {
        for (name, mut law) in variants::<T>(safeguards) {
            for cycle in cycles {
                let command = run_cycle(&mut law, cycle);
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

    /// A cycle without a finite result is void: no torque, and Φ stands still over this step and the next.
    #[test]
    fn a_void_cycle_leaves_the_state_and_teaches_nothing(
        before in prop::collection::vec(ordinary(), 1..4), bad in wild(), after in ordinary()
    ) {
        for safeguards in [false, true] {
            for (name, mut law) in variants::<f64>(safeguards) {
                before.iter().for_each(|cycle| { run_cycle(&mut law, cycle); });
                let parameters = law.parameters().to_vec();
                let (measurement, reference, period) = bad.inputs();
                let command = law.update(&measurement, &reference, period);
                let void = command.adaptation.fell_back
                    && command.torque == Vector2::zeros()
                    && command.control_input == Vector2::zeros();
                if void {
                    prop_assert_eq!(law.parameters(), &parameters[..], "{}", &name);
                    let frozen = law.freeze();
                    let pending = frozen.values().get(parameters.len()..).unwrap();
                    prop_assert!(pending.iter().all(|value| *value == 0.0), "{}", &name);
                    run_cycle(&mut law, &after);
                    prop_assert_eq!(law.parameters(), &parameters[..], "{}", &name);
                }
            }
        }
    }

    #[test]
    fn a_thawed_law_goes_on_to_the_bit(
        before in prop::collection::vec(ordinary(), 0..6), after in prop::collection::vec(ordinary(), 1..6)
    ) {
        for safeguards in [false, true] {
            for ((name, mut law), (_, mut other)) in variants::<f64>(safeguards).into_iter().zip(variants(safeguards)) {
                before.iter().for_each(|cycle| { run_cycle(&mut law, cycle); });
                // The other has a past of its own, which thawing must wipe out.
                after.iter().for_each(|cycle| { run_cycle(&mut other, cycle); });
                let frozen = law.freeze();
                other.thaw(&frozen).unwrap();
                prop_assert_eq!(other.freeze(), frozen);
                for cycle in &after {
                    prop_assert_eq!(run_cycle(&mut other, cycle), run_cycle(&mut law, cycle), "{}", name);
                }
                prop_assert_eq!(other.parameters(), law.parameters());
            }
        }
    }

    #[test]
    fn reset_brings_the_beginning_back(cycles in prop::collection::vec(ordinary(), 1..6)) {
        for ((name, mut law), (_, mut fresh)) in variants::<f64>(true).into_iter().zip(variants(true)) {
            cycles.iter().for_each(|cycle| { run_cycle(&mut law, cycle); });
            law.reset();
            for cycle in &cycles {
                prop_assert_eq!(run_cycle(&mut law, cycle), run_cycle(&mut fresh, cycle), "{}", name);
            }
        }
    }

    #[test]
    fn single_and_double_precision_agree(cycles in prop::collection::vec(ordinary(), 1..6)) {
        for ((name, mut double), (_, mut single)) in variants::<f64>(false).into_iter().zip(variants::<f32>(false)) {
            for cycle in &cycles {
                let (double, single) = (run_cycle(&mut double, cycle).torque, run_cycle(&mut single, cycle).torque);
                let difference = (double - single.map(f64::from)).amax();
                // f32 holds angles of 3 rad to 2e-7; Λ/R of 15/s multiplies, the sums and solutions add their own.
                prop_assert!(difference < 1e-4 * (1.0 + double.amax()), "{}: {:e}", name, difference);
            }
        }
    }
}

#[test]
fn a_law_refuses_modes_of_the_base_acceleration_that_it_does_not_offer() {
    use BaseAcceleration::{Eliminated, Measured, Omitted, Reduced, ReducedMomentum};
    let offered: [(Law, &[BaseAcceleration]); 7] = [
        (Law::Nonlinear, &[Measured, Eliminated, Omitted, Reduced, ReducedMomentum]),
        (Law::Adaptive, &[Measured, Eliminated, Omitted]),
        (Law::Neural, &[]),
        (Law::NeuralModel, &[Omitted, Reduced, ReducedMomentum]),
        (Law::Fuzzy, &[]),
        (Law::FuzzyModel, &[Omitted, Reduced, ReducedMomentum]),
        (Law::ComputedTorque, &[Omitted, Reduced, ReducedMomentum]),
    ];
    for (law, offered) in offered {
        for mode in BaseAcceleration::ALL {
            let mut settings = ControllerSettings::default();
            let set = settings.set_base_acceleration(law, mode);
            assert_eq!(set.is_ok(), offered.contains(&mode), "{law:?} {mode:?}");
            if let Err(refusal) = set {
                assert_eq!(refusal.found, mode);
                assert_eq!(settings, ControllerSettings::default());
            }
        }
        for variant in law.variants() {
            assert!(offered.contains(&variant.base_acceleration), "{}", variant.name);
        }
    }
}

#[test]
fn the_guard_keeps_the_parameters_in_a_box_around_their_start() {
    for law in Law::ALL {
        let settings = ControllerSettings::default();
        let Some(adaptation) = settings.adaptation(law) else { continue };
        let model = ThreeLinkDem::<f64>::table_2();
        let free = BuildContext::new(model);
        let bounded = BuildContext { adaptation_guard: AdaptationGuard::Bounded, ..free };
        let start = settings.build(law, &free).unwrap().parameters().to_vec();
        let farthest = |context: &BuildContext<f64>| {
            let mut controller = settings.build(law, context).unwrap();
            let cycle = Cycle {
                numbers: [1.0, -1.0, 3.0, -3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 2.0],
                period: 1.0,
                limited: [false, false],
            };
            (0..20).for_each(|_| {
                run_cycle(&mut controller, &cycle);
            });
            let distances = controller.parameters().iter().zip(&start).map(|(now, start)| f64::abs(now - start));
            distances.fold(0.0, f64::max)
        };
        assert!(farthest(&free) > adaptation.bound, "{law:?}");
        assert!((farthest(&bounded) - adaptation.bound).abs() < 1e-12, "{law:?}");
    }
}

#[test]
fn the_guard_holds_the_parameters_while_a_torque_is_limited() {
    let cycle = |limited| Cycle {
        numbers: [0.3, 0.4, 0.1, -0.1, 0.2, 0.1, 0.32, 0.37, 0.0, 0.0, 0.0, 0.0],
        period: 0.003,
        limited: [false, limited],
    };
    for law in Law::ALL {
        let settings = ControllerSettings::default();
        for (adaptation_guard, holds) in [(AdaptationGuard::None, false), (AdaptationGuard::Bounded, true)] {
            let context = BuildContext { adaptation_guard, ..BuildContext::new(ThreeLinkDem::<f64>::table_2()) };
            let mut controller = settings.build(law, &context).unwrap();
            let start = controller.parameters().to_vec();
            run_cycle(&mut controller, &cycle(true));
            let command = run_cycle(&mut controller, &cycle(true));
            let adapts = settings.adaptation(law).is_some();
            assert_eq!(controller.parameters() == start, holds || !adapts, "{law:?}");
            assert_eq!(command.adaptation.frozen, holds && adapts, "{law:?}");
        }
    }
}

#[test]
fn table_3_and_table_4() {
    let settings = ControllerSettings::default();
    // Q1, Q2, z, L2, E
    let expected = [
        (Law::Nonlinear, 0.64, [9.0, 7.0], None, 0.0778, 0.1419),
        (Law::Adaptive, 0.64, [9.0, 7.0], Some(10.0), 0.0379, 0.1244),
        (Law::Neural, 0.64, [9.0, 7.0], Some(10.0), 0.0317, 0.1322),
        (Law::NeuralModel, 4.0, [9.0, 7.0], Some(100.0), 0.0292, 0.1406),
        (Law::Fuzzy, 1.0, [9.0, 7.0], Some(0.8), 0.0340, 0.1563),
        (Law::FuzzyModel, 4.0, [25.0, 7.0], Some(20.0), 0.0318, 0.1788),
    ];
    assert_eq!(expected.map(|(law, ..)| law), Law::PAPER);
    for (law, velocity, position, z, tracking, torque) in expected {
        let weights =
            StateWeights { q1: SymmetricWeight::Diagonal([velocity; 2]), q2: SymmetricWeight::Diagonal(position) };
        assert_eq!(settings.state_weights(law), Some(weights), "{law:?}");
        assert_eq!(settings.adaptation(law).map(|adaptation| adaptation.z), z);
        assert_eq!(law.published_indices(), Some(PublishedIndices { tracking, torque }));
    }
    assert!(!Law::ComputedTorque.is_in_paper());
    // The baseline has no weights of its own.
    assert_eq!(settings.state_weights(Law::ComputedTorque), None);
    assert_eq!(settings.weights::<f64>(Law::ComputedTorque), settings.weights(Law::Nonlinear));
}

#[test]
fn rules_fire_as_the_section_of_their_law_says() {
    let mut settings = ControllerSettings::default();
    settings.fuzzy_model.firing = Firing::Product;
    for law in Law::ALL {
        let expected = match law {
            Law::Fuzzy => Some(Firing::Minimum),
            Law::FuzzyModel => Some(Firing::Product),
            _ => None,
        };
        assert_eq!(settings.firing(law), expected, "{law:?}");
    }
    settings.fuzzy.firing = Firing::Product;
    assert_eq!(settings.firing(Law::Fuzzy), Some(Firing::Product));
    settings.fuzzy_model.firing = Firing::Minimum;
    assert_eq!(settings.firing(Law::FuzzyModel), Some(Firing::Minimum));
}

#[test]
fn a_state_of_another_law_is_refused() {
    let mut laws = variants::<f64>(false);
    let (_, nonlinear) = laws.remove(0);
    let (_, mut fuzzy) = laws.into_iter().find(|(name, _)| name == "Fuzzy default").unwrap();
    assert_eq!(fuzzy.thaw(&nonlinear.freeze()), Err(ThawError::Size { expected: 109, found: 0 }));
}

/// The base acceleration is no part of what `is_usable` checks: each law must find out itself.
#[test]
fn a_base_acceleration_that_is_no_number_voids_the_cycle() {
    let start = Cycle {
        numbers: [0.3, 0.4, 0.1, -0.1, 0.2, 0.1, 0.32, 0.37, 0.0, 0.0, 0.0, 0.0],
        period: 0.003,
        limited: [false, false],
    };
    let mut bad = start.clone();
    bad.numbers[5] = f64::NAN;
    let mut found = 0;
    for (name, mut law) in variants::<f64>(false) {
        run_cycle(&mut law, &start);
        run_cycle(&mut law, &start);
        let parameters = law.parameters().to_vec();
        let command = run_cycle(&mut law, &bad);
        if name.ends_with(" measured") {
            found += 1;
            assert!(command.adaptation.fell_back && command.torque == Vector2::zeros(), "{name}");
            assert_eq!(law.parameters(), parameters, "{name}");
            run_cycle(&mut law, &start);
            assert_eq!(law.parameters(), parameters, "{name}");
        } else {
            assert!(!command.adaptation.fell_back, "{name}");
        }
    }
    assert_eq!(found, 2);
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
        assert_eq!(regressor.regressor.columns()[(0, 0)], 1.0 / 9.0);
    }
}
