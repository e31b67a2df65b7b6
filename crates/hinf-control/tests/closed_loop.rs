//! Whole runs of the paper's task against trajectories that were computed independently (`tests/vectors`).

mod common;

use common::{Sample, State, paper_run, table_3};
use dem_model::ThreeLinkDem;
use hinf_control::adaptation::{Adaptation, ScalarWeight};
use hinf_control::{
    Adaptive, AdaptiveBaseAcceleration, BaseAcceleration, Controller, Firing, Fuzzy, FuzzySets, FuzzySystem, Law,
    Neural, NonlinearHInfinity, Synthesis, TanhNetworks, WeightReading, Weights,
};
use nalgebra::{Matrix2, SMatrix, Vector2};
use serde_json::Value;

/// Two independent implementations agree to some 1e-13; the loop amplifies rounding a little.
const TOLERANCE: f64 = 1e-9;

fn cases(text: &str) -> Vec<Value> {
    let document: Value = serde_json::from_str(text).unwrap();
    let holder = document.get("closed_loop").unwrap_or(&document);
    holder["cases"].as_array().unwrap().clone()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}

fn design(case: &Value) -> Synthesis<f64> {
    let diagonal = |name: &str| Vector2::from_column_slice(&numbers(&case[name]));
    Synthesis::new(&Weights {
        velocity: Matrix2::from_diagonal(&diagonal("Q1")),
        position: Matrix2::from_diagonal(&diagonal("Q2")),
        cross: Matrix2::zeros(),
        control: Matrix2::from_diagonal(&diagonal("R")),
        attenuation_level: 2.0,
        reading: WeightReading::Factors,
    })
    .unwrap()
}

fn adaptation<const K: usize, const G: usize>(case: &Value) -> Adaptation<f64, K, G> {
    let initial = SMatrix::from_column_slice(&numbers(&case["phi0"]));
    Adaptation::new(initial, ScalarWeight::new(case["Z"].as_f64().unwrap()).unwrap()).unwrap()
}

fn controller(case: &Value) -> Box<dyn Controller<f64>> {
    let model = ThreeLinkDem::table_2();
    let design = design(case);
    let base = case["E_term"].as_str().unwrap();
    match case["controller"].as_str().unwrap() {
        "NL" => {
            let mode = match base {
                "exact" => BaseAcceleration::Eliminated,
                "omitted" => BaseAcceleration::Omitted,
                "reduced" => BaseAcceleration::Reduced,
                "reduced_momentum" => BaseAcceleration::ReducedMomentum,
                other => panic!("unknown mode {other}"),
            };
            Box::new(NonlinearHInfinity::new(model, design, mode))
        }
        "AD" => {
            let mode = match base {
                "exact" => AdaptiveBaseAcceleration::Eliminated,
                _ => AdaptiveBaseAcceleration::Omitted,
            };
            Box::new(Adaptive::new(model, design, mode, adaptation(case)))
        }
        "NN1" => Box::new(Neural::new(design, TanhNetworks::paper(), adaptation(case))),
        "FZ1" => {
            let system = FuzzySystem::new(FuzzySets::untrained(), Firing::Minimum);
            Box::new(Fuzzy::new(design, system, adaptation(case)))
        }
        other => panic!("unknown controller {other}"),
    }
}

fn worst(left: &[f64], right: &[f64]) -> f64 {
    assert_eq!(left.len(), right.len());
    left.iter().zip(right).map(|(left, right)| (left - right).abs()).fold(0.0, f64::max)
}

fn check(case: &Value) {
    let name = format!("{} {}", case["controller"], case["E_term"]);
    let expected = &case["zoh3ms"];
    let start = State::paper(case.get("qd1_0").map_or(0.0, |rate| rate.as_f64().unwrap()));
    let (samples, indices) = paper_run(controller(case).as_mut(), start);
    let rows = expected["t"].as_array().unwrap().len();
    assert_eq!(rows, 101);
    for row in 0..rows {
        let Sample { time, state, command, parameters } = &samples[10 * row];
        let found: Vec<f64> = state.q.iter().chain(state.velocity.iter()).copied().collect();
        assert!(worst(&found, &numbers(&expected["x"][row])) < TOLERANCE, "{name}: state at {time}");
        let torque = worst(command.torque.as_slice(), &numbers(&expected["tau"][row]));
        assert!(torque < TOLERANCE, "{name}: torque at {time} differs by {torque:e}");
        assert!(worst(parameters, &numbers(&expected["Phi"][row])) < TOLERANCE, "{name}: Φ at {time}");
    }
    assert!((indices.tracking() - expected["L2"].as_f64().unwrap()).abs() < TOLERANCE, "{name}: L2");
    assert!((indices.torque() - expected["E"].as_f64().unwrap()).abs() < TOLERANCE, "{name}: E");
}

#[test]
fn controllers_1_2_3_and_5_follow_their_reference_runs() {
    let cases = cases(include_str!("vectors/closed_loop.json"));
    assert_eq!(cases.len(), 6);
    cases.iter().for_each(check);
}

#[test]
fn the_reduced_law_follows_its_reference_runs() {
    let cases = cases(include_str!("vectors/reduced.json"));
    assert_eq!(cases.len(), 2);
    cases.iter().for_each(check);
}

#[test]
fn from_rest_the_momentum_form_needs_no_momentum() {
    let run = |mode| {
        let design = table_3(Law::Nonlinear, WeightReading::Blocks);
        paper_run(&mut NonlinearHInfinity::new(ThreeLinkDem::table_2(), design, mode), State::paper(0.0))
    };
    let (without, _) = run(BaseAcceleration::Reduced);
    let (with, _) = run(BaseAcceleration::ReducedMomentum);
    for (without, with) in without.iter().zip(&with) {
        assert!((without.state.q - with.state.q).amax() < TOLERANCE);
    }
}
