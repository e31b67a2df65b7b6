//! `uarm compare`: the paper's Table 4 from one plant, and plants drawn around it.

mod support;

use std::num::{NonZeroU32, NonZeroUsize};
use std::sync::LazyLock;
use std::time::Duration;

use serde_json::Value;
use uarm::commands::compare::comparison::{self, Comparison, ComparisonSettings};
use uarm::commands::compare::experiments::experiment;
use uarm::commands::compare::monte_carlo::{self, MonteCarloSettings};
use uarm::commands::compare::variant::{ControllerVariant, RobotFiles, VariantRobot};
use uarm::commands::run::SimulatedEnd;
use uarm::robot::overrides::Overrides;
use uarm::simulated_plant::PlantChoice;
use uarm::simulated_plant::SimulatedPlant;
use uarm::study::parallel::all_cores;
use uarm::study::spread::Spread;
use uarm::study::start::StartVariation;

use hinf_control::Disturbance;
use support::{scratch, standard_output, text, uarm};

/// The sets that are shipped.
const TRAINED_SETS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/uarm-fuzzy-sets.toml");

static PAPER: LazyLock<Vec<ControllerVariant>> = LazyLock::new(|| ControllerVariant::paper().collect());

fn json(arguments: &[&str]) -> Value {
    serde_json::from_str(&standard_output(arguments)).unwrap()
}

fn compare(plant: PlantChoice, repetitions: u32, variation: StartVariation) -> Comparison {
    let settings = ComparisonSettings {
        files: RobotFiles::default(),
        variants: &PAPER,
        left_out: &[],
        plant: Some(plant),
        disturbance: None,
        repetitions: NonZeroU32::new(repetitions).unwrap(),
        variation,
        seed: 1,
        threads: all_cores(),
    };
    comparison::run::<3, 2>(&settings, || ()).unwrap()
}

fn monte_carlo_settings(spread: f64, variation: StartVariation) -> MonteCarloSettings<'static> {
    MonteCarloSettings {
        files: RobotFiles::default(),
        variants: PAPER.as_slice(),
        disturbance: Disturbance::Paper,
        draws: NonZeroU32::MIN,
        spread: Spread::new(spread).unwrap(),
        variation,
        seed: 1,
        threads: NonZeroUsize::MIN,
    }
}

#[test]
fn one_plant_gives_the_papers_table() {
    let comparison = compare(PlantChoice::Uarm, 5, StartVariation::Full);
    assert!(comparison.caveat.is_some());
    for row in &comparison.controllers {
        let ratio = row.ratio.unwrap();
        assert!((ratio.l2 - 1.0).abs() < 0.15, "{}: L2 is {:.3} of Table 4", row.controller, ratio.l2);
        assert!((ratio.e - 1.0).abs() < 0.20, "{}: E is {:.3} of Table 4", row.controller, ratio.e);
        assert!(row.l2.deviation.unwrap() > 0.0, "{}: repetitions differ", row.controller);
    }
    let (nonlinear, others) = comparison.controllers.split_first().unwrap();
    assert_eq!(nonlinear.controller, "nonlinear");
    assert!(others.iter().all(|other| other.l2.maximum < nonlinear.l2.minimum), "nonlinear is worst in L2, always");
}

#[test]
fn the_reference_simulation_gave_the_same() {
    let reference: Value = serde_json::from_str(include_str!("vectors/uarm_plant.json")).unwrap();
    let rows = reference["rows"].as_array().unwrap();
    // The reference ends with the motion.
    let no_hold = Overrides { hold: Some(Duration::ZERO), ..Overrides::default() };
    let robots = VariantRobot::<3, 2>::load(&PAPER, RobotFiles::default(), &no_hold).unwrap();
    assert_eq!(rows.len(), robots.len());
    for (variant, row) in robots.iter().zip(rows) {
        let plant = SimulatedPlant::new(&variant.robot, PlantChoice::Uarm, Disturbance::Paper).unwrap();
        let SimulatedEnd::Completed(outcome) = experiment(variant, plant).unwrap() else { panic!("{variant:?}") };
        let base = outcome.base_drift.to_degrees();
        // 1 %: a quantised loop is chaotic at the count.
        for (found, name) in [(outcome.indices.l2, "L2"), (outcome.indices.e, "E"), (base, "base_deg_3s")] {
            approx::assert_relative_eq!(found, row[name].as_f64().unwrap(), max_relative = 0.01);
        }
    }
}

#[test]
fn without_variation_it_is_the_experiment_of_uarm_run() {
    let forms = [
        ("adaptive", vec!["--controller", "adaptive"]),
        ("fuzzy", vec!["--controller", "fuzzy", "--fuzzy-sets", TRAINED_SETS]),
        ("nonlinear-reduced", vec!["--controller", "nonlinear", "--base-acceleration", "reduced"]),
        ("fuzzy-model-reduced", vec!["--controller", "fuzzy-model", "--base-acceleration", "reduced"]),
    ];
    for (name, form) in forms {
        let run = &json(&[&["run", "--virtual-time", "--json"], &form[..]].concat())[0];
        let trained = form.contains(&"--fuzzy-sets");
        let sets: &[&str] = if trained { &["--fuzzy-sets", TRAINED_SETS] } else { &[] };
        let compare = ["compare", "--variation", "none", "--repeat", "2", "--json", "--controllers", name];
        let study = json(&[&compare, sets].concat());
        assert_eq!(study["fuzzy_sets_crc32"].is_number(), trained, "{name}");
        let row = &study["controllers"][0];
        assert_eq!(row["l2"]["deviation"], 0.0);
        for experiment in row["experiments"].as_array().unwrap() {
            assert_eq!(experiment["l2"], run["indices"]["l2"], "{name}");
            assert_eq!(experiment["e"], run["indices"]["e"], "{name}");
            for field in ["peak_torque_nm", "final_error_deg", "base_drift_deg"] {
                assert_eq!(experiment[field], run[field], "{name}: {field}");
            }
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let studies: [&[&str]; 2] = [
        &["compare", "--controllers", "nonlinear,neural", "--repeat", "3", "--plant", "ideal"],
        &["compare", "--controllers", "nonlinear,fuzzy", "--monte-carlo", "5"],
    ];
    let bytes = |study: &[&str], threads: &str, seed: &str| {
        let file = scratch(&format!("study-{threads}-{seed}.csv"));
        let common = ["--json", "--threads", threads, "--seed", seed, "--force", "--csv", file.to_str().unwrap()];
        (standard_output(&[study, &common].concat()), std::fs::read(&file).unwrap())
    };
    for study in studies {
        let one = bytes(study, "1", "42");
        assert_eq!(one, bytes(study, "2", "42"), "{study:?}");
        assert_eq!(one, bytes(study, "5", "42"), "{study:?}");
        assert_ne!(one.1, bytes(study, "2", "43").1, "{study:?}");
    }
}

/// The columns `names` of a CSV file, row by row.
fn columns<const N: usize>(text: &str, names: [&str; N]) -> Vec<[String; N]> {
    let mut lines = text.lines();
    let header: Vec<_> = lines.next().unwrap().split(',').collect();
    let places = names.map(|name| header.iter().position(|column| *column == name).unwrap());
    let row = |line: &str| {
        let cells: Vec<_> = line.split(',').collect();
        assert_eq!(cells.len(), header.len());
        places.map(|place| cells[place].to_owned())
    };
    lines.map(row).collect()
}

#[test]
fn quantiles_and_ranks_are_those_of_the_written_draws() {
    let file = scratch("draws.csv");
    let (names, draws) = (["nonlinear", "adaptive", "neural-model"], 9);
    let study = json(&[
        "compare",
        "--controllers",
        &names.join(","),
        "--monte-carlo",
        &draws.to_string(),
        "--spread",
        "20%",
        "--json",
        "--force",
        "--csv",
        file.to_str().unwrap(),
    ]);
    let written =
        columns(&std::fs::read_to_string(&file).unwrap(), ["draw", "controller", "l2", "e_nms", "link_scale"]);
    assert_eq!(written.len(), names.len() * draws);
    let of = |name: &str, column: usize| -> Vec<f64> {
        written.iter().filter(|row| row[1] == name).map(|row| row[column].parse().unwrap()).collect()
    };
    let l2 = names.map(|name| of(name, 2));
    for (number, name) in names.iter().enumerate() {
        assert_eq!(of(names[0], 4), of(name, 4), "all controllers meet the same plants");
        let row = &study["controllers"][number];
        assert_eq!(row["controller"], **name);
        assert_eq!(row["failed"], 0);
        for (column, index) in [(2, "l2"), (3, "e")] {
            let values = of(name, column);
            for (key, probability) in [("q05", 0.05), ("q25", 0.25), ("q50", 0.5), ("q75", 0.75), ("q95", 0.95)] {
                let expected = quantile_by_weights(&values, probability);
                approx::assert_relative_eq!(row[index][key].as_f64().unwrap(), expected, max_relative = 1e-12);
            }
        }
        let counted = |wins: fn(f64, f64) -> bool| {
            (0..draws).filter(|draw| l2.iter().all(|other| wins(l2[number][*draw], other[*draw]))).count()
        };
        assert_eq!(row["best_l2"], counted(|mine, other| mine <= other));
        assert_eq!(row["worst_l2"], counted(|mine, other| mine >= other));
    }
    assert_eq!(study["controllers"][0]["worst_l2"], draws, "nonlinear is worst on every robot drawn");
}

/// The quantile as a weighted sum over the sample: a value's rank is the number of smaller ones, and those within one rank
/// of p(n - 1) count by how near they are. The values must differ from each other.
fn quantile_by_weights(values: &[f64], probability: f64) -> f64 {
    let target = probability * (values.len() - 1) as f64;
    let weighted = |value: &f64| {
        let rank = values.iter().filter(|other| *other < value).count() as f64;
        value * (1.0 - (rank - target).abs()).max(0.0)
    };
    values.iter().map(weighted).sum()
}

#[test]
fn the_coarse_step_of_the_draws_changes_less_than_the_encoder_phase_does() {
    let fine = compare(PlantChoice::Uarm, 1, StartVariation::None);
    let settings = monte_carlo_settings(0.0, StartVariation::None);
    let robots = monte_carlo::load(&settings).unwrap();
    let coarse = monte_carlo::draw(&settings, &robots, 0).unwrap();
    for (row, coarse) in fine.controllers.iter().zip(&coarse.indices) {
        let coarse = coarse.as_ref().unwrap();
        // As a rule they are equal to the bit; this much may come of one count that falls otherwise.
        approx::assert_relative_eq!(coarse.l2, row.l2.mean, max_relative = 2e-3);
        approx::assert_relative_eq!(coarse.e, row.e.mean, max_relative = 2e-3);
    }
}

#[test]
fn parts_of_a_monte_carlo_study_merge_to_the_bytes_of_the_whole() {
    let folder = scratch("monte-carlo-parts");
    // Of an earlier test run; outputs are never replaced.
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let file = |name: &str| folder.join(name).display().to_string();
    let study = ["compare", "--controllers", "nonlinear,fuzzy", "--monte-carlo", "5"];
    let run = |more: &[&str]| standard_output(&[&study, more].concat());
    let whole = run(&["--draws", &file("whole.jsonl"), "--csv", &file("whole.csv")]);
    let part = run(&["--shard", "1/2", "--draws", &file("1.jsonl"), "--threads", "1"]);
    assert!(part.starts_with("UARM, 3 of 5 times,"), "{part}");
    run(&["--shard", "2/2", "--draws", &file("2.jsonl"), "--threads", "2"]);
    let merge = ["compare", "merge", &file("2.jsonl"), &file("1.jsonl")];
    let outputs = ["--draws", &file("merged.jsonl"), "--csv", &file("merged.csv")];
    assert_eq!(standard_output(&[&merge[..], &outputs].concat()), whole);
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    assert_eq!(read("merged.jsonl"), read("whole.jsonl"));
    assert_eq!(read("merged.csv"), read("whole.csv"));
    let output = uarm(&merge[..3]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output).contains("experiment 1 stands in no file"), "{}", text(&output));
    run(&["--shard", "1/2", "--fuzzy-sets", TRAINED_SETS, "--draws", &file("trained.jsonl")]);
    let output = uarm(&["compare", "merge", &file("2.jsonl"), &file("trained.jsonl")]);
    assert_eq!(output.status.code(), Some(1), "parts with other sets");
    assert!(text(&output).contains("fuzzy_sets_crc32"), "{}", text(&output));
    assert_eq!(uarm(&[&study[..], &["--shard", "1/2"]].concat()).status.code(), Some(2), "a part that is not kept");
    let repeated = ["compare", "--repeat", "2", "--shard", "1/2", "--draws", &file("none.jsonl")];
    assert_eq!(uarm(&repeated).status.code(), Some(2), "repetitions have no parts");
}

#[test]
fn tables_bring_the_caveat_where_the_plant_is_fitted() {
    let table = standard_output(&["compare", "--controllers", "fuzzy,computed-torque", "--repeat", "1"]);
    for part in ["L2 of the tracking error", "0.0340", "0.1563", "baseline", "13 parameters to the 12 numbers"] {
        assert!(table.contains(part), "{part}: {table}");
    }
    let table = standard_output(&["compare", "--controllers", "fuzzy", "--repeat", "1", "--plant", "ideal"]);
    assert!(!table.contains("13 parameters"), "{table}");
    let table = standard_output(&["compare", "--controllers", "fuzzy", "--monte-carlo", "2"]);
    assert!(table.contains("median") && table.contains("13 parameters"), "{table}");
}

#[test]
fn trained_sets_are_for_fuzzy_laws() {
    let sets = ["--fuzzy-sets", TRAINED_SETS];
    for command in [&["compare", "--controllers", "nonlinear,neural"][..], &["run", "--virtual-time", "--log", "none"]]
    {
        let output = uarm(&[command, &sets].concat());
        assert_eq!(output.status.code(), Some(1), "{command:?}");
        assert!(text(&output).contains("expected one with fuzzy sets: fuzzy, fuzzy-model"), "{}", text(&output));
    }
    let run = uarm(&[&["run", "--virtual-time", "--log", "none", "--controller", "fuzzy"], &sets[..]].concat());
    assert!(text(&run).contains("fuzzy laws with trained sets (CRC-32"), "{}", text(&run));
}

#[test]
fn wrong_arguments_are_named() {
    let wrong: [(&[&str], &str); 9] = [
        (&["--controllers", "pid"], "nonlinear-reduced"),
        (&["--controllers", "fuzzy,fuzzy"], "twice"),
        (&["--repeat", "0"], "--repeat"),
        (&["--threads", "0"], "--threads"),
        (&["--monte-carlo", "0"], "--monte-carlo"),
        (&["--monte-carlo", "2", "--spread", "100%"], "below 100%"),
        (&["--monte-carlo", "2", "--repeat", "2"], "--repeat"),
        (&["--monte-carlo", "2", "--plant", "ideal"], "--plant uarm"),
        (&["--spread", "10%"], "--monte-carlo"),
    ];
    for (arguments, named) in wrong {
        let output = uarm(&[&["compare"], arguments].concat());
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success(), "{arguments:?}");
        assert!(message.contains(named), "{arguments:?}: the message names {named:?}: {message}");
        assert!(output.stdout.is_empty(), "{arguments:?}");
    }
}

/// 2.5 degrees of tracking error are too little for controller 1, and enough for the others.
#[test]
fn an_experiment_that_fails_is_listed_and_the_others_are_made() {
    let robot = uarm::robot::BUILT_IN.replacen("tracking_error_limit_deg = 30.0", "tracking_error_limit_deg = 2.5", 1);
    assert_ne!(robot, uarm::robot::BUILT_IN);
    let (file, csv) = (scratch("narrow-compare.toml"), scratch("narrow-compare.csv"));
    std::fs::write(&file, robot).unwrap();
    let compare = |arguments: &[&str]| {
        let common = ["compare", "--controllers", "nonlinear,neural", "--robot", file.to_str().unwrap()];
        let csv = ["--force", "--csv", csv.to_str().unwrap()];
        let output = support::uarm(&[&common[..], arguments, &csv].concat());
        (
            output.status.code().unwrap(),
            support::text(&output),
            std::fs::read_to_string(scratch("narrow-compare.csv")).unwrap(),
        )
    };
    let (code, told, csv) = compare(&["--repeat", "2"]);
    assert_eq!(code, 3, "{told}");
    assert!(told.contains("2 experiments did not come to the end"), "{told}");
    assert!(told.contains("nonlinear, experiment 2: joint ") && told.contains("tracking error"), "{told}");
    assert!(told.contains("\n  neural "), "{told}");
    let failures: Vec<_> = csv.lines().filter(|line| line.starts_with("nonlinear,paper,")).collect();
    assert_eq!((failures.len(), csv.lines().count()), (2, 5));
    let commas = |line: &str| line.split('"').next().unwrap().matches(',').count();
    assert_eq!(commas(failures[0]), commas(csv.lines().next().unwrap()), "{csv}");
    assert!(failures[1].contains("tracking error"), "{csv}");
    let (code, told, csv) = compare(&["--monte-carlo", "2"]);
    assert_eq!(code, 0, "{told}");
    let failed: Vec<_> = csv.lines().filter(|line| line.contains("nonlinear,paper,,,")).collect();
    assert!(!failed.is_empty() && failed.iter().all(|line| line.contains("tracking error")), "{csv}");
}
