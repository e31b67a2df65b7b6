//! Reads the vectors of an independent implementation.

use std::ops::ControlFlow;

use anfis::{Bell, BellParameters, DataSet, Epoch, Firing, InputSets, PremiseSets};
use serde_json::Value;

pub struct Vectors(Value);

impl Vectors {
    pub fn load(name: &str) -> Self {
        let path = format!("{}/tests/vectors/{name}", env!("CARGO_MANIFEST_DIR"));
        Self(serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap())
    }

    pub fn data(&self) -> DataSet {
        let rows = list(&self.0["data"]["X"]);
        DataSet::from_rows(list(&rows[0]).len(), rows.iter().flat_map(numbers).collect(), numbers(&self.0["data"]["y"]))
            .unwrap()
    }

    /// The premises before training, with product firing.
    pub fn start(&self, data: &DataSet) -> PremiseSets {
        let inputs = list(&self.0["initial_premise"]).iter().enumerate().map(|(input, sets)| {
            let bells = list(sets).iter().map(|set| {
                let [half_width, steepness, centre] = numbers(set)[..] else { panic!("{set} is no bell") };
                Bell::new(BellParameters { half_width, steepness, centre }).unwrap()
            });
            InputSets::new(format!("x{input}"), "1", data.universe(input).unwrap(), bells.collect()).unwrap()
        });
        PremiseSets::new(Firing::Product, inputs.collect()).unwrap()
    }

    /// dE/d(a, b, c) at the start, bell by bell, E the sum of squared errors.
    pub fn gradient(&self) -> Vec<f64> {
        list(&self.0["dE_dpremise_at_start"]).iter().flat_map(list).flat_map(numbers).collect()
    }

    pub fn premise_updates(&self) -> usize {
        usize::try_from(self.0["settings"]["premise_updates"].as_u64().unwrap()).unwrap()
    }

    /// Compares one column of the history with the vectors, by number of premise updates.
    pub fn compare(
        &self,
        column: &str,
        history: &[Epoch],
        value: impl Fn(&Epoch) -> f64,
        tolerance: impl Fn(usize) -> f64,
    ) {
        for (updates, expected) in self.0[column].as_object().unwrap() {
            let (updates, expected) = (updates.parse().unwrap(), expected.as_f64().unwrap());
            let found = value(&history[updates]);
            let relative = (found / expected - 1.0).abs();
            assert!(relative <= tolerance(updates), "{column} after {updates} updates: {found}, expected {expected}");
        }
    }
}

/// The relative tolerances on RMSE that two independent implementations reached: the iteration amplifies rounding.
pub fn rmse_tolerance(updates: usize) -> f64 {
    match updates {
        0..=10 => 1e-9,
        11..=30 => 1e-8,
        31..=100 => 1e-6,
        _ => 1e-5,
    }
}

/// The step is a product of factors: the same ones in the same order but for the last bits.
pub fn step_tolerance(_updates: usize) -> f64 {
    1e-14
}

pub fn to_the_end(_: &Epoch) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn list(value: &Value) -> &Vec<Value> {
    value.as_array().unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    list(value).iter().map(|number| number.as_f64().unwrap()).collect()
}
