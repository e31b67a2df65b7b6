//! Jang's first example, the two-input sinc: 16 rules, 121 pairs. The start's centres are off the grid's, since from a
//! symmetric start rounding decides which way the symmetry breaks.

mod common;

use anfis::{ConsequentEstimator, Keep, Pass, SteepnessRange, Training};
use approx::assert_relative_eq;
use common::{Vectors, rmse_tolerance, step_tolerance, to_the_end};

fn vectors() -> Vectors {
    Vectors::load("anfis_sinc.json")
}

#[test]
fn the_data_are_the_sinc_on_a_grid() {
    let sinc = |x: f64| if x == 0.0 { 1.0 } else { x.sin() / x };
    for (x, y) in vectors().data().samples() {
        assert_relative_eq!(sinc(x[0]) * sinc(x[1]), y, epsilon = 1e-15);
    }
}

#[test]
fn the_first_gradient() {
    let (vectors, data) = (vectors(), vectors().data());
    let pass = Pass::new(&vectors.start(&data), &data, ConsequentEstimator::LeastSquares).unwrap();
    let found = pass.gradient().iter().flat_map(|d| [d.half_width, d.steepness, d.centre]);
    for (found, expected) in found.zip(vectors.gradient()) {
        assert_relative_eq!(found, expected, epsilon = 1e-14, max_relative = 1e-11);
    }
}

#[test]
fn errors_and_steps_over_250_updates() {
    let (vectors, data) = (vectors(), vectors().data());
    let training = Training {
        premise_updates: vectors.premise_updates(),
        // After 121 updates one b passes through 0; the vectors let it.
        steepness_range: SteepnessRange::Unrestricted,
        keep: Keep::Last,
        ..Training::default()
    };
    let trained = training.run(&vectors.start(&data), &data, None, to_the_end).unwrap();
    vectors.compare("rmse", &trained.history, |epoch| epoch.rmse, rmse_tolerance);
    vectors.compare("step", &trained.history, |epoch| epoch.step, step_tolerance);
}

#[test]
fn with_positive_steepness_every_set_stays_a_bell_and_the_error_comes_as_far_down() {
    let (vectors, data) = (vectors(), vectors().data());
    let training = Training { premise_updates: vectors.premise_updates(), ..Training::default() };
    let trained = training.run(&vectors.start(&data), &data, None, to_the_end).unwrap();
    let bells = trained.anfis.premises().inputs().iter().flat_map(|input| input.sets());
    assert!(bells.clone().all(|bell| bell.steepness() > 0.0 && bell.half_width() > 0.0));
    // A quarter of the start's error; the unrestricted run reaches 0.0229.
    assert!(trained.kept_epoch().rmse < 0.026, "{}", trained.kept_epoch().rmse);
}
