//! Liang's theorem on the paper's robot: the space manipulator, simulated directly, and its dynamically equivalent
//! manipulator move alike under the same joint torques. Compared with each other and with independent references.

use core::time::Duration;
use dem_model::PlanarSpaceManipulator;
use dem_model::ThreeLinkDem;
use nalgebra::Vector3;
use serde::Deserialize;
use std::collections::BTreeMap;
use uarm_sim::{Brake, DemPlant, FreeFloatingPlant, InitialState, MechanicalPlant, Mechanism, Plant};

/// What two independent implementations reached.
const TOLERANCE: f64 = 1e-9;
const FREE: [Brake; 3] = [Brake::Released; 3];

#[derive(Deserialize)]
struct Vectors {
    q0: [f64; 3],
    tau: String,
    #[serde(flatten)]
    cases: BTreeMap<String, Case>,
}

#[derive(Deserialize)]
struct Case {
    v0: [f64; 3],
    t: Vec<f64>,
    dem_map: Vec<[f64; 6]>,
    dem_table2: Vec<[f64; 6]>,
    sm_planar_x_y_th_q2_q3_and_rates: Vec<[f64; 10]>,
}

fn vectors() -> Vectors {
    let vectors: Vectors = serde_json::from_str(include_str!("vectors/free_floating_vs_dem.json")).unwrap();
    assert!(vectors.tau.starts_with("tau2=0.06*sin(2*pi*t)+0.02; tau3=-0.03*cos(3*pi*t)+0.015*sin(7*t)"));
    assert_eq!(vectors.cases.len(), 2);
    vectors
}

/// The torques that the vectors were made with.
fn torque(t: f64) -> Vector3<f64> {
    use core::f64::consts::PI;
    Vector3::new(0.0, 0.06 * (2.0 * PI * t).sin() + 0.02, -0.03 * (3.0 * PI * t).cos() + 0.015 * (7.0 * t).sin())
}

fn initial(vectors: &Vectors, case: &Case) -> InitialState {
    InitialState { position: vectors.q0.into(), velocity: case.v0.into() }
}

/// The largest difference of any coordinate or velocity from the rows, over the whole motion.
fn largest_difference<M: Mechanism<DOF>, const DOF: usize, const COLUMNS: usize>(
    mut plant: MechanicalPlant<M, DOF>,
    times: &[f64],
    rows: &[[f64; COLUMNS]],
) -> f64 {
    assert_eq!((times.len(), rows.len(), 2 * DOF), (101, 101, COLUMNS));
    let mut largest: f64 = 0.0;
    for (time, row) in times.iter().zip(rows) {
        let until = Duration::from_millis((time * 1e3).round() as u64);
        plant.advance_under(until, torque, FREE);
        let state = plant.motion_state();
        for (value, expected) in state.position.iter().chain(state.velocity.iter()).zip(row) {
            largest = largest.max((value - expected).abs());
        }
    }
    largest
}

#[test]
fn dem_of_the_map_follows_the_reference() {
    let vectors = vectors();
    let dem = PlanarSpaceManipulator::table_1().dynamically_equivalent().closed_form().unwrap();
    for case in vectors.cases.values() {
        let plant = DemPlant::new(dem).with_initial_state(initial(&vectors, case));
        let difference = largest_difference(plant, &case.t, &case.dem_map);
        assert!(difference < TOLERANCE, "{difference:e}");
    }
}

#[test]
fn dem_of_table_2_follows_the_reference() {
    let vectors = vectors();
    for case in vectors.cases.values() {
        let plant = DemPlant::new(ThreeLinkDem::table_2()).with_initial_state(initial(&vectors, case));
        let difference = largest_difference(plant, &case.t, &case.dem_table2);
        assert!(difference < TOLERANCE, "{difference:e}");
    }
}

#[test]
fn space_manipulator_follows_the_reference() {
    let vectors = vectors();
    for case in vectors.cases.values() {
        let plant = FreeFloatingPlant::new(&PlanarSpaceManipulator::table_1());
        let plant = plant.with_initial_state(initial(&vectors, case));
        let difference = largest_difference(plant, &case.t, &case.sm_planar_x_y_th_q2_q3_and_rates);
        assert!(difference < TOLERANCE, "{difference:e}");
    }
}

/// The theorem itself, with no reference in between.
#[test]
fn space_manipulator_and_its_dem_move_alike() {
    let vectors = vectors();
    let manipulator = PlanarSpaceManipulator::table_1();
    for case in vectors.cases.values() {
        let initial = initial(&vectors, case);
        let mut space = FreeFloatingPlant::new(&manipulator).with_initial_state(initial);
        let dem = manipulator.dynamically_equivalent().closed_form().unwrap();
        let mut dem = DemPlant::new(dem).with_initial_state(initial);
        for milliseconds in (30..=3000).step_by(30) {
            let until = Duration::from_millis(milliseconds);
            space.advance_under(until, torque, FREE);
            dem.advance_under(until, torque, FREE);
            approx::assert_abs_diff_eq!(space.position(), dem.position(), epsilon = 1e-11);
            approx::assert_abs_diff_eq!(space.velocity(), dem.velocity(), epsilon = 1e-10);
            approx::assert_abs_diff_eq!(space.kinetic_energy(), dem.kinetic_energy(), epsilon = 1e-12);
        }
    }
}

#[test]
fn space_manipulator_conserves_momentum() {
    let vectors = vectors();
    for case in vectors.cases.values() {
        let initial = initial(&vectors, case);
        let mut plant = FreeFloatingPlant::new(&PlanarSpaceManipulator::table_1()).with_initial_state(initial);
        let angular = plant.angular_momentum();
        for milliseconds in (30..=3000).step_by(30) {
            plant.advance_under(Duration::from_millis(milliseconds), torque, FREE);
            approx::assert_abs_diff_eq!(plant.linear_momentum().norm(), 0.0, epsilon = 1e-12);
            approx::assert_abs_diff_eq!(plant.angular_momentum(), angular, epsilon = 1e-12);
        }
    }
}
