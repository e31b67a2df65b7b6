//! What must hold for any finite data.

use anfis::{
    Bell, BellParameters, ConsequentEstimator, DataSet, Firing, InitialCovariance, InputSets, Keep, Pass, PremiseSets,
    SteepnessRange, StepMetric, StepSizeRule, Training, Universe,
};
use proptest::prelude::*;

fn to_the_end(_: &anfis::Epoch) -> std::ops::ControlFlow<()> {
    std::ops::ControlFlow::Continue(())
}

/// Data of two inputs that no system of few rules fits exactly.
fn wavy(samples: u32) -> DataSet {
    let sample = |i: u32| {
        let (x, y) =
            (f64::from(i * 37 % samples) / f64::from(samples), f64::from(i * 11 % samples) / f64::from(samples));
        ([4.0 * x - 2.0, y], (7.0 * x * y).sin() + x * x - y)
    };
    DataSet::new((0..samples).map(sample)).unwrap()
}

fn grid(data: &DataSet, firing: Firing, sets: usize) -> PremiseSets {
    let inputs =
        (0..data.width()).map(|i| InputSets::grid(format!("x{i}"), "1", data.universe(i).unwrap(), sets).unwrap());
    PremiseSets::new(firing, inputs.collect()).unwrap()
}

/// The sets with one parameter of one bell changed; parameter 0, 1, 2 is a, b, c.
fn perturbed(sets: &PremiseSets, bell: usize, parameter: usize, by: f64) -> PremiseSets {
    let mut index = 0;
    let inputs = sets.inputs().iter().map(|input| {
        let bells = input.sets().iter().map(|old| {
            let mut abc = [old.half_width(), old.steepness(), old.centre()];
            if index == bell {
                abc[parameter] += by;
            }
            index += 1;
            let [half_width, steepness, centre] = abc;
            Bell::new(BellParameters { half_width, steepness, centre }).unwrap()
        });
        InputSets::new(input.name(), input.unit(), input.universe(), bells.collect()).unwrap()
    });
    PremiseSets::new(sets.firing(), inputs.collect()).unwrap()
}

#[test]
fn the_gradient_is_that_of_the_error_for_either_firing() {
    let data = wavy(101);
    for firing in [Firing::Product, Firing::Minimum] {
        let sets = grid(&data, firing, 3);
        // Off the grid, so that no two memberships are equal: there the minimum has a kink.
        let sets = (0..6).fold(sets, |sets, bell| perturbed(&sets, bell, 2, 0.013 * (bell as f64 + 1.0)));
        let pass = Pass::new(&sets, &data, ConsequentEstimator::LeastSquares).unwrap();
        // The consequents are optimal, so that to first order it does not matter that they are solved anew.
        let error = |sets: &PremiseSets| {
            let rmse = Pass::new(sets, &data, ConsequentEstimator::LeastSquares).unwrap().rmse();
            rmse * rmse * data.len() as f64
        };
        for (bell, found) in pass.gradient().iter().enumerate() {
            for (parameter, found) in [found.half_width, found.steepness, found.centre].into_iter().enumerate() {
                let step = 1e-5;
                let difference = (error(&perturbed(&sets, bell, parameter, step))
                    - error(&perturbed(&sets, bell, parameter, -step)))
                    / (2.0 * step);
                // Truncation step², rounding ε·E/step ~ 1e-11; a kink of the minimum within the step costs more.
                let tolerance = 1e-5 * difference.abs() + 1e-7;
                assert!((found - difference).abs() < tolerance, "{firing:?} {bell} {parameter}: {found} {difference}");
            }
        }
    }
}

#[test]
fn training_lowers_the_error_with_minimum_firing() {
    let data = wavy(101);
    let training = Training { premise_updates: 60, ..Training::default() };
    let trained = training.run(&grid(&data, Firing::Minimum, 3), &data, None, to_the_end).unwrap();
    let (first, kept) = (trained.history[0].rmse, trained.kept_epoch().rmse);
    assert!(kept < 0.9 * first, "{first} {kept}");
    assert_eq!(trained.anfis.rmse(&data).unwrap(), trained.kept_epoch().rmse);
}

#[test]
fn in_the_universe_metric_units_do_not_matter() {
    let data = wavy(101);
    let scaled = DataSet::new(data.samples().map(|(x, y)| ([x[0] * 1024.0, x[1] / 64.0], y))).unwrap();
    let training = Training { premise_updates: 30, metric: StepMetric::Universe, ..Training::default() };
    let run = |data: &DataSet| training.run(&grid(data, Firing::Product, 2), data, None, to_the_end).unwrap();
    for (one, other) in run(&data).history.iter().zip(&run(&scaled).history) {
        approx::assert_relative_eq!(one.rmse, other.rmse, max_relative = 1e-6);
    }
}

#[test]
fn early_stopping_hands_back_the_lowest_checking_error() {
    let data = DataSet::new(wavy(40).samples().enumerate().map(|(i, (x, y))| {
        // A repeatable disturbance that a flexible system will fit and should not.
        ([x[0], x[1]], y + 0.3 * (i as f64 * 12.9898).sin())
    }))
    .unwrap();
    let (training_set, checking_set) = data.split(3).unwrap();
    let patience = std::num::NonZeroUsize::new(15);
    let options = Training {
        premise_updates: 2000,
        keep: Keep::LowestCheckingError { patience },
        step: StepSizeRule::new(0.05, 1.1, 0.9).unwrap(),
        ..Training::default()
    };
    let start = grid(&training_set, Firing::Product, 2);
    let trained = options.run(&start, &training_set, Some(&checking_set), to_the_end).unwrap();
    let errors: Vec<f64> = trained.history.iter().map(|epoch| epoch.checking_rmse.unwrap()).collect();
    assert_eq!(trained.stopped, anfis::StopReason::OutOfPatience);
    assert_eq!(trained.history.len(), trained.kept + 16);
    assert!(errors.iter().all(|&error| error >= errors[trained.kept]));
    assert!(options.run(&start, &training_set, None, to_the_end).is_err());
}

#[test]
fn too_few_samples_are_reported_as_a_rank_drop() {
    let data = wavy(20);
    let trained = Training::default().run(&grid(&data, Firing::Product, 3), &data, None, to_the_end).unwrap();
    assert_eq!((trained.parameters, trained.history[0].rank), (27, Some(20)));
    assert_eq!(trained.rank_drops().count(), 1);
}

#[test]
fn the_progress_callback_ends_the_training() {
    let data = wavy(30);
    let options = Training { premise_updates: 100, keep: Keep::Last, ..Training::default() };
    let after_three = |epoch: &anfis::Epoch| match epoch.premise_updates {
        3 => std::ops::ControlFlow::Break(()),
        _ => std::ops::ControlFlow::Continue(()),
    };
    let trained = options.run(&grid(&data, Firing::Product, 2), &data, None, after_three).unwrap();
    assert_eq!((trained.stopped, trained.kept), (anfis::StopReason::Interrupted, 3));
}

/// Any finite value of the range that data sets admit, many of them extreme.
fn any_value() -> impl Strategy<Value = f64> {
    prop_oneof![-2.0..2.0_f64, -1e12..1e12_f64, Just(0.0), Just(1e-12), (-12..12_i32).prop_map(|e| 10.0_f64.powi(e))]
}

fn any_training() -> impl Strategy<Value = Training> {
    let metric = prop_oneof![Just(StepMetric::Raw), Just(StepMetric::Universe)];
    let range = prop_oneof![Just(SteepnessRange::Positive), Just(SteepnessRange::Unrestricted)];
    let recursive = Just(ConsequentEstimator::Recursive(InitialCovariance::JANG));
    let estimator = prop_oneof![Just(ConsequentEstimator::LeastSquares), recursive];
    let step = prop_oneof![Just(0.01), Just(1.0), Just(1e6)];
    (metric, range, estimator, step).prop_map(|(metric, steepness_range, estimator, initial)| Training {
        premise_updates: 12,
        step: StepSizeRule::new(initial, 1.1, 0.9).unwrap(),
        metric,
        steepness_range,
        estimator,
        keep: Keep::Last,
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn nothing_is_ever_not_finite_and_the_same_data_give_the_same_bits(
        values in prop::collection::vec((any_value(), any_value(), any_value()), 1..25),
        ends in (any_value(), any_value()), firing in prop_oneof![Just(Firing::Product), Just(Firing::Minimum)],
        training in any_training(), far in (any_value(), any_value()),
    ) {
        let universe = Universe::new(ends.0.min(ends.1), ends.0.max(ends.1));
        prop_assume!(universe.is_ok());
        let data = DataSet::new(values.into_iter().map(|(x, y, target)| ([x, y], target))).unwrap();
        let inputs = ["x", "y"].map(|name| InputSets::grid(name, "1", universe.clone().unwrap(), 3).unwrap());
        let start = PremiseSets::new(firing, inputs.to_vec()).unwrap();
        let trained = training.run(&start, &data, Some(&data), to_the_end).unwrap();
        for epoch in &trained.history {
            prop_assert!(epoch.rmse.is_finite() && epoch.checking_rmse.unwrap().is_finite() && epoch.step.is_finite());
        }
        prop_assert!(trained.anfis.output(&[far.0, far.1]).unwrap().is_finite());
        for input in trained.anfis.premises().inputs() {
            prop_assert!(input.sets().windows(2).all(|pair| pair[0].centre() <= pair[1].centre()));
            prop_assert!(input.sets().iter().all(|bell| bell.half_width() > 0.0));
        }
        prop_assert_eq!(&trained, &training.run(&start, &data, Some(&data), to_the_end).unwrap());
    }
}
