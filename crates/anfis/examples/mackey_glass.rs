//! Jang's Mackey–Glass experiment (1993, section VI-D): 16 rules, 500 training and 500 checking pairs, 500 epochs.
//! Prints his numbers beside those of both estimators.
//!
//! Run with `cargo run --release -p anfis --example mackey_glass`.

use std::error::Error;
use std::ops::ControlFlow;

use anfis::{
    ConsequentEstimator, DataSet, Firing, InitialCovariance, InputSets, Keep, PremiseSets, Training, mackey_glass,
};

const INPUTS: [&str; 4] = ["x(t-18)", "x(t-12)", "x(t-6)", "x(t)"];
/// RMSE on training and checking set as printed.
const PUBLISHED: (&str, &str) = ("0.0016", "0.0015");

fn main() -> Result<(), Box<dyn Error>> {
    let (training_set, checking_set) = mackey_glass::data_sets()?;
    let inputs = INPUTS.iter().enumerate().map(|(i, name)| InputSets::grid(*name, "1", training_set.universe(i)?, 2));
    let start = PremiseSets::new(Firing::Product, inputs.collect::<Result<_, _>>()?)?;

    println!("{:<32} {:>12} {:>12}", "RMSE after 500 epochs", "training", "checking");
    println!("{:<32} {:>12} {:>12}", "Jang 1993, as printed", PUBLISHED.0, PUBLISHED.1);
    let recursive = ConsequentEstimator::Recursive(InitialCovariance::JANG);
    report("recursive least squares (his)", recursive, &start, &training_set, &checking_set)?;
    report("exact least squares", ConsequentEstimator::LeastSquares, &start, &training_set, &checking_set)
}

fn report(
    name: &str,
    estimator: ConsequentEstimator,
    start: &PremiseSets,
    training_set: &DataSet,
    checking_set: &DataSet,
) -> Result<(), Box<dyn Error>> {
    let training = Training { premise_updates: 500, estimator, keep: Keep::Last, ..Training::default() };
    let trained = training.run(start, training_set, Some(checking_set), |_| ControlFlow::Continue(()))?;
    let last = trained.kept_epoch();
    println!("{name:<32} {:>12.7} {:>12.7}", last.rmse, last.checking_rmse.unwrap_or(f64::NAN));
    Ok(())
}
