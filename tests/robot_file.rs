//! Bad robot files: the error names the file, the field, the value and what was expected.

use std::path::Path;

use proptest::prelude::*;
use uarm::robot::model::Mechanics;
use uarm::robot::overrides::Overrides;
use uarm::robot::{BUILT_IN, Robot};

fn error_of(text: &str) -> String {
    let parsed = Robot::parse(Path::new("test.toml"), text, &Overrides::default());
    let message = parsed.map(|_| ()).expect_err("the file is wrong").to_string();
    assert!(message.starts_with("test.toml"), "the message names the file: {message}");
    message
}

/// The built-in file with one piece of text replaced.
fn changed(from: &str, to: &str) -> String {
    assert!(BUILT_IN.contains(from), "the robot file has {from:?}");
    BUILT_IN.replacen(from, to, 1)
}

fn refuses(from: &str, to: &str, names: &[&str]) {
    let message = error_of(&changed(from, to));
    for name in names {
        assert!(message.contains(name), "{to:?}: the message names {name:?}: {message}");
    }
}

/// The model and the space manipulator of a robot like the paper's.
fn three_links(robot: &Robot) -> (dem_model::ThreeLinkDem<f64>, Option<dem_model::PlanarSpaceManipulator<f64, 2>>) {
    match robot.mechanics {
        Mechanics::ThreeLinks { dem, space } => (dem, space),
        _ => panic!("{} is another arm", robot.description.name),
    }
}

#[test]
fn the_built_in_robot_is_the_papers() {
    let robot = Robot::load(None).unwrap();
    assert_eq!(robot.description.name, "UARM");
    assert_eq!(three_links(&robot).0, dem_model::ThreeLinkDem::table_2());
    assert_eq!(three_links(&robot).1, Some(dem_model::PlanarSpaceManipulator::table_1()));
    assert_eq!(robot.description.period.seconds(1), 0.003);
    assert_eq!(robot.plant.uarm, uarm_sim::UarmPlantParameters::fitted());
}

#[test]
fn the_weights_are_table_3() {
    let controllers = Robot::<3, 2>::load(None).unwrap().controllers;
    // Table 3 by hand: Q1, Q2 and z of controllers 1 to 6; R and gamma are the same for all.
    let table_3 = [
        ([0.64, 0.64], [9.0, 7.0], None),
        ([0.64, 0.64], [9.0, 7.0], Some(10.0)),
        ([0.64, 0.64], [9.0, 7.0], Some(10.0)),
        ([4.0, 4.0], [9.0, 7.0], Some(100.0)),
        ([1.0, 1.0], [9.0, 7.0], Some(0.8)),
        ([4.0, 4.0], [25.0, 7.0], Some(20.0)),
    ];
    for (law, (q1, q2, z)) in hinf_control::Law::PAPER.into_iter().zip(table_3) {
        let weights = controllers.weights::<f64>(law);
        assert_eq!(weights.velocity.diagonal().as_slice(), q1, "{}", law.name());
        assert_eq!(weights.position.diagonal().as_slice(), q2, "{}", law.name());
        assert_eq!(weights.control.diagonal().as_slice(), [0.9, 2.5], "{}", law.name());
        assert_eq!(controllers.adaptation(law).map(|adaptation| adaptation.z), z, "{}", law.name());
    }
}

#[test]
fn unknown_and_missing_fields_are_named() {
    refuses("period_us = 3000", "period_us = 3000\nperiod_ms = 3", &["period_ms", "period_us"]);
    refuses("length_m = 0.203 }", "length_mm = 203.0 }", &["length_mm", "length_m"]);
    refuses("[controllers.adaptive]\nq1 = [0.64, 0.64]\n", "[controllers.adaptive]\n", &["q1", "missing"]);
    refuses("hold_s = 0.5", "", &["hold_s", "missing"]);
    refuses("{ torque_nm = 0.2,", "{ torque_nm = 0.2, torque_Nm = 0.2,", &["joints[1].limits.torque_Nm", "torque_nm"]);
    refuses(
        "[controllers.fuzzy]\n",
        "[controllers.fuzy]\nz = 1.0\n[controllers.fuzzy]\n",
        &["controllers.fuzy", "fuzzy"],
    );
}

#[test]
fn values_out_of_range_are_named_with_what_was_expected() {
    refuses("period_us = 3000", "period_us = 20", &["control.period_us", "20", "100 to 100000"]);
    refuses("node = 2", "node = 1", &["joints[1].node", "1", "no other joint"]);
    refuses("node = 3", "node = 127", &["joints[2].node", "127", "1 to 126"]);
    refuses("counter_bits = 32", "counter_bits = 33", &["joints[0].encoder.counter_bits", "33", "8 to 32"]);
    refuses("counts_per_revolution = 33739", "counts_per_revolution = 0", &["counts_per_revolution", "0"]);
    refuses("role = \"active\"", "role = \"passive\"", &["joints[1].role", "Passive", "active"]);
    refuses("{ torque_nm = 0.2,", "{ torque_nm = -0.2,", &["joints[1].limits.torque_nm", "-0.2", "above 0"]);
    refuses("rated_torque_nm = 0.2,", "rated_torque_nm = 0.0002,", &["rated_torque_nm", "0.0002", "whole number"]);
    refuses("bitrate_hz = 1000000", "bitrate_hz = 123", &["bus.bitrate_hz", "123", "1000000"]);
    refuses("mass_kg = 0.850", "mass_kg = -0.850", &["link 2", "mass", "-0.85"]);
    refuses("duration_s = 3.0", "duration_s = nan", &["task.duration_s", "NaN"]);
    refuses("torque_gain = 1.0022", "torque_gain = 0.0", &["plant", "gain", "0"]);
    refuses("cutoff_rad_per_s = 27.81882", "cutoff_rad_per_s = -1.0", &["estimator", "-1"]);
    refuses("\nkind = \"low-pass\"", "\nkind = \"high-pass\"", &["high-pass", "low-pass"]);
    refuses("schema = 1", "schema = 2", &["schema", "2", "1"]);
}

#[test]
fn weights_without_a_solution_are_refused_with_the_reason() {
    refuses("r = [0.9, 2.5]", "r = [0.9, 4.5]", &["controllers.nonlinear"]);
    refuses("q1 = [0.64, 0.64]", "q1 = [[0.64, 0.1], [0.2, 0.64]]", &["controllers.nonlinear"]);
    refuses("q1 = [0.64, 0.64]", "q1 = \"large\"", &["q1", "[a, b]"]);
}

#[test]
fn a_cycle_that_does_not_fit_the_bus_is_refused() {
    let slow = changed("bitrate_hz = 1000000", "bitrate_hz = 125000");
    let message = error_of(&slow);
    assert!(message.contains("control.period_us") && message.contains("125000 bit/s"), "{message}");
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let message = Robot::load(Some(Path::new("no/such/robot.toml"))).map(|_| ()).unwrap_err().to_string();
    assert!(message.contains("no/such/robot.toml"), "{message}");
}

proptest! {
    /// Whatever stands in the file, it is parsed or refused.
    #[test]
    fn no_text_panics(text in ".{0,400}") {
        let _ = Robot::parse(Path::new("fuzz.toml"), &text, &Overrides::default());
    }

    /// The built-in file with one byte changed.
    #[test]
    fn no_mutation_panics(position in 0..BUILT_IN.len(), byte in 0x20_u8..0x7F) {
        let mut bytes = BUILT_IN.as_bytes().to_vec();
        bytes[position] = byte;
        if let Ok(text) = String::from_utf8(bytes) {
            let _ = Robot::parse(Path::new("fuzz.toml"), &text, &Overrides::default());
        }
    }
}

/// A list is no table, though its values could be taken one after the other.
#[test]
fn a_list_is_no_table() {
    let base = "base = { inertia_kg_m2 = 0.0153, length_m = 0.203 }";
    refuses(base, "base = [0.0153, 0.203]", &["model.base = a list: expected a table with inertia_kg_m2, length_m"]);
    let spacecraft = "{ mass_kg = 4.816, inertia_kg_m2 = 0.0153, centre_of_mass_to_joint_m = 0.253 }";
    refuses(spacecraft, "[4.816, 0.0153, 0.253]", &["space_manipulator.spacecraft = a list", "mass_kg"]);
    let link = "{ mass_kg = 0.618, inertia_kg_m2 = 0.0075, joint_to_centre_of_mass_m = 0.120, centre_of_mass_to_joint_m = 0.118 }";
    refuses(link, "[0.618, 0.0075, 0.120, 0.118]", &["space_manipulator.links[0] = a list"]);
}

/// The text of a robot file without a table.
fn cut(text: &str, table: &str) -> String {
    let start = text.find(&format!("\n[{table}]\n")).expect("the robot file has the table") + 1;
    let (before, behind) = text.split_at(start);
    format!("{before}{}", behind.split_once("\n\n").map_or("", |(_, rest)| rest))
}

fn without(table: &str) -> String {
    cut(BUILT_IN, table)
}

fn parsed(text: &str) -> Robot {
    Robot::parse(Path::new("test.toml"), text, &Overrides::default()).unwrap()
}

/// Table 2 is Table 1 by eq. 1, to the three digits that are printed.
fn is_table_2(robot: &Robot) {
    let close = |found: f64, printed: f64| assert!((found - printed).abs() < 6e-4, "{found} for {printed}");
    let table = dem_model::ThreeLinkDem::<f64>::table_2();
    close(three_links(robot).0.base().inertia, table.base().inertia);
    close(three_links(robot).0.base().length, table.base().length);
    for (link, printed) in three_links(robot).0.links().iter().zip(table.links()) {
        close(link.mass, printed.mass);
        close(link.inertia, printed.inertia);
        close(link.length, printed.length);
        close(link.centre_of_mass, printed.centre_of_mass);
    }
}

#[test]
fn a_space_manipulator_alone_gives_the_model() {
    let robot = parsed(&without("model"));
    is_table_2(&robot);
    assert_ne!(three_links(&robot).0, dem_model::ThreeLinkDem::table_2(), "not rounded");
    assert!(!robot.is_the_papers());
}

#[test]
fn a_model_alone_has_no_space_manipulator() {
    let robot = parsed(&without("space_manipulator"));
    assert_eq!(three_links(&robot), (dem_model::ThreeLinkDem::table_2(), None));
    assert!(robot.is_the_papers());
}

#[test]
fn a_file_without_an_arm_or_with_two_is_refused() {
    let message = error_of(&without("model").replace("[space_manipulator]", "[spaces]"));
    assert!(message.contains("spaces"), "{message}");
    let message = error_of(&cut(&without("model"), "space_manipulator"));
    assert_eq!(message, "test.toml: model = no such table: expected [model], [space_manipulator], or both");

    refuses("mass_kg = 0.850", "mass_kg = 0.860", &["model.links[0].mass_kg = 0.86", "0.850129", "eq. 1"]);
    refuses("centre_of_mass_m = 0.077", "centre_of_mass_m = 0.078", &["model.links[1].centre_of_mass_m", "0.076982"]);
    refuses("length_m = 0.203 }", "length_m = 0.206 }", &["model.base.length_m = 0.206", "0.203075"]);
    refuses("inertia_kg_m2 = 0.0060, length_m", "inertia_kg_m2 = 0.0061, length_m", &["model.links[1].inertia_kg_m2"]);
    // Papers round, and the length of the last link moves nothing.
    parsed(&changed("mass_kg = 0.850", "mass_kg = 0.858"));
    parsed(&changed("length_m = 0.203, centre_of_mass_m = 0.077", "length_m = 0.300, centre_of_mass_m = 0.077"));
}

#[test]
fn without_a_plant_the_simulated_robot_has_no_imperfections() {
    let robot = parsed(&without("plant"));
    assert_eq!(robot.plant.uarm, uarm_sim::UarmPlantParameters::ideal());
}

#[test]
fn a_urdf_gives_the_model_and_the_log_can_do_without_it() {
    let folder = std::path::PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("model-urdf");
    std::fs::create_dir_all(folder.join("arms")).unwrap();
    let (urdf, path) = (folder.join("arms/arm.urdf"), folder.join("robot.toml"));
    std::fs::write(&urdf, include_str!("urdf/table-1.urdf")).unwrap();
    let with = |table: &str| {
        let text = cut(&without("model"), "space_manipulator");
        std::fs::write(&path, text.replace("[task]\n", &format!("[model]\n{table}\n\n[task]\n"))).unwrap();
        Robot::load(Some(&path)).map_err(|error| error.to_string())
    };
    let robot = with("urdf = \"arms/arm.urdf\"\nbase = \"bus\"\ntip = \"tool\"").unwrap();
    is_table_2(&robot);
    let logged = robot.for_log().unwrap();
    std::fs::remove_file(&urdf).unwrap();
    let again = Robot::from_log(Path::new("run.mcap"), &logged).unwrap();
    assert_eq!(three_links(&again), three_links(&robot));

    let missing = with("urdf = \"arms/arm.urdf\"").unwrap_err();
    assert!(missing.contains("arms/arm.urdf: cannot be read"), "{missing}");
    std::fs::write(&urdf, include_str!("urdf/table-1.urdf")).unwrap();
    let base = with("urdf = \"arms/arm.urdf\"\nbase = \"hull\"").unwrap_err();
    assert!(base.contains("robot.toml: model.urdf: "), "{base}");
    assert!(base.contains("arm.urdf: no link \"hull\""), "{base}");
    let none = with("urdf = \"\"").unwrap_err();
    assert!(none.ends_with("model.urdf = \"\": expected the path of a URDF, relative to the robot file"), "{none}");
    let numbers = with("urdf = \"arms/arm.urdf\"\nbase = { inertia_kg_m2 = 1.0, length_m = 1.0 }").unwrap_err();
    assert!(numbers.contains("model.base = numbers: expected the name of a link"), "{numbers}");
    let both = with(
        "urdf = \"arms/arm.urdf\"\nlinks = [{ mass_kg = 1.0, inertia_kg_m2 = 1.0, length_m = 1.0, centre_of_mass_m = 0.5 }]",
    );
    assert!(both.unwrap_err().contains("expected the arm once"));
    let tip = with("tip = \"tool\"\nbase = \"bus\"").unwrap_err();
    assert!(tip.contains("model.tip = tool: expected model.urdf beside it"), "{tip}");
    let two = with("base = \"bus\"").unwrap_err();
    assert!(two.contains("model.base = no numbers"), "{two}");
    std::fs::write(&urdf, include_str!("../robots/planar-four-link.urdf")).unwrap();
    let four = with("urdf = \"arms/arm.urdf\"").unwrap_err();
    assert!(four.contains("joints between base and tip, expected 2"), "{four}");
}
