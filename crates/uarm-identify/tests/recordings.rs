//! Robots of known numbers are recorded, and found again to within the errors that are stated.

use core::time::Duration;
use dem_model::ThreeLinkDem;
use hinf_control::Disturbance;
use nalgebra::Vector3;
use uarm_identify::{Gain, Identified, IdentifyError, Sample, Told, Uarm, UarmParameter, identify};
use uarm_sim::{Brake, InitialState, Plant, UarmImperfections, UarmPlant, UarmPlantParameters};

const PERIOD: Duration = Duration::from_millis(3);
/// The paper's encoders, rad.
const RESOLUTION: f64 = core::f64::consts::TAU / 33_739.0;

fn fitted() -> UarmImperfections {
    UarmPlantParameters::fitted().imperfections()
}

/// The values of `imperfections` in the order of [`UarmParameter::ALL`].
fn truth(imperfections: &UarmImperfections) -> Vec<f64> {
    let UarmImperfections { viscous_friction, coulomb_friction, base_inertia_scale, link_inertia_scale, gain, tilt } =
        *imperfections;
    let scales = [base_inertia_scale, link_inertia_scale];
    viscous_friction.into_iter().chain(coulomb_friction).chain(scales).chain(tilt).chain([gain]).collect()
}

/// A recording of `cycles` of a robot under `torque` of joints 2 and 3 at a time, s; torques act `late` after the counts.
fn recorded(
    imperfections: UarmImperfections,
    disturbance: Disturbance,
    cycles: u32,
    late: Duration,
    torque: impl Fn(f64) -> [f64; 2],
) -> Vec<Sample<3>> {
    let parameters = UarmPlantParameters::new(imperfections).unwrap();
    let start = InitialState { position: Vector3::new(0.0, 0.3, 0.4), velocity: Vector3::zeros() };
    let mut plant = UarmPlant::new(&ThreeLinkDem::table_2(), parameters)
        .unwrap()
        .with_initial_state(start)
        .with_disturbance(disturbance);
    let mut torque_before = [0.0; 3];
    let mut samples = Vec::new();
    for cycle in 0..cycles {
        let at = PERIOD.as_secs_f64() * f64::from(cycle);
        let [second, third] = torque(at);
        let told = [0.0, second, third];
        let [disturbed_2, disturbed_3] = disturbance.torque::<2>(PERIOD * cycle, 0.0).into();
        samples.push(Sample {
            at,
            position: plant.position().map(|angle| (angle / RESOLUTION).round() * RESOLUTION).into(),
            torque_before,
            torque: told,
            torque_at: at + late.as_secs_f64(),
            disturbance: [0.0, disturbed_2, disturbed_3],
        });
        plant.advance(PERIOD * cycle + late, &torque_before.into(), [Brake::Released; 3]);
        plant.advance(PERIOD * (cycle + 1), &told.into(), [Brake::Released; 3]);
        torque_before = told;
    }
    samples
}

/// Turns both joints to and fro at frequencies that are no multiples of each other.
fn sweep(at: f64) -> [f64; 2] {
    [0.13 * (6.0 * at).sin() + 0.04 * (17.3 * at).sin(), 0.08 * (9.1 * at).cos() + 0.03 * (23.7 * at).sin()]
}

fn find(gain: Gain, recordings: &[Vec<Sample<3>>]) -> Identified {
    identify(&Uarm::new(ThreeLinkDem::table_2(), gain), recordings, [RESOLUTION; 3], |_| ()).unwrap()
}

/// Every number within five standard errors, and told.
fn assert_found(found: &Identified, truth: &[f64]) {
    assert_eq!(found.estimates.iter().map(|estimate| estimate.told).collect::<Vec<_>>(), vec![Told::Well; truth.len()]);
    for (estimate, truth) in found.estimates.iter().zip(truth) {
        let off = (estimate.value - truth).abs() / estimate.standard_error;
        assert!(off < 5.0, "{estimate}, truly {truth}: {off} standard errors");
    }
    assert!((found.residual - 1.0).abs() < 0.2, "nothing but rounding is left: {}", found.residual);
    assert!(found.explains());
}

#[test]
fn a_robot_with_every_imperfection_is_found() {
    let recording = recorded(fitted(), Disturbance::None, 1_500, Duration::ZERO, sweep);
    let found = find(Gain::Known(1.0022), &[recording]);
    assert_found(&found, &truth(&fitted())[..10]);
    let smallest = |parameter, error: f64| {
        let estimate = found.estimate(parameter).unwrap();
        assert!(estimate.standard_error < error, "{estimate}");
    };
    smallest(UarmParameter::Viscous(1), 1e-4);
    smallest(UarmParameter::Coulomb(1), 1e-4);
    smallest(UarmParameter::Links, 1e-3);
}

#[test]
fn another_robot_whose_torques_come_late_is_found_in_two_recordings() {
    let other = UarmImperfections {
        viscous_friction: [0.01, 0.03, 0.005],
        coulomb_friction: [0.01, 0.02, 0.04],
        base_inertia_scale: 0.8,
        link_inertia_scale: 0.9,
        gain: 1.0,
        tilt: [0.1, 0.2],
    };
    let late = Duration::from_micros(1_700);
    let recordings = [0.0, 0.7].map(|phase| recorded(other, Disturbance::None, 700, late, |at| sweep(at + phase)));
    let found = find(Gain::Known(1.0), &recordings);
    assert_found(&found, &truth(&other)[..10]);
    // Whoever takes the torques for undelayed sees a robot that does not explain the motion.
    let undelayed = recordings.map(|recording| {
        recording.into_iter().map(|sample| Sample { torque_at: sample.at, ..sample }).collect::<Vec<_>>()
    });
    assert!(find(Gain::Known(1.0), &undelayed).residual > 1.5 * found.residual);
}

#[test]
fn a_disturbance_that_is_known_tells_the_gain() {
    let strong = UarmImperfections { gain: 1.2, ..fitted() };
    let recordings =
        [0.0, 0.3].map(|phase| recorded(strong, Disturbance::Paper, 1_200, Duration::ZERO, |at| sweep(at + phase)));
    assert_found(&find(Gain::Sought, &recordings), &truth(&strong));
}

/// Twice the gain, inertia and friction: the same motion.
#[test]
fn without_a_disturbance_the_scale_is_not_told_and_the_tilt_is() {
    let recording = recorded(fitted(), Disturbance::None, 1_500, Duration::ZERO, sweep);
    let found = find(Gain::Sought, &[recording]);
    let told = |parameter| found.estimate(parameter).unwrap().told;
    assert_eq!(told(UarmParameter::Gain), Told::NotTold);
    assert_eq!(told(UarmParameter::Links), Told::NotTold);
    assert_eq!(told(UarmParameter::Tilt(0)), Told::Well);
    let [_, gain] = [UarmParameter::Links, UarmParameter::Gain]
        .map(|parameter| found.estimates.iter().position(|estimate| estimate.name == parameter.name()).unwrap());
    assert!(found.confounded.iter().any(|(_, other, _)| *other == gain), "{:?}", found.confounded);
}

#[test]
fn a_joint_that_does_not_move_tells_nothing_of_its_friction() {
    // Joint 3 sticks: its torque stays below its Coulomb friction, and that of the others shakes it little.
    let stiff =
        UarmImperfections { coulomb_friction: [0.02, 0.02, 0.3], viscous_friction: [0.01, 0.01, 0.01], ..fitted() };
    let recording = recorded(stiff, Disturbance::None, 700, Duration::ZERO, |at| [0.1 * (8.0 * at).sin(), 0.0]);
    let found = find(Gain::Known(1.0022), &[recording]);
    println!("{found:#?}");
    assert_ne!(found.estimate(UarmParameter::Viscous(2)).unwrap().told, Told::Well);
    assert_eq!(found.estimate(UarmParameter::Coulomb(1)).unwrap().told, Told::Well);
}

#[test]
fn a_robot_at_rest_tells_that_the_table_is_level_and_no_more() {
    let still = UarmImperfections { tilt: [0.0; 2], ..fitted() };
    let recording = recorded(still, Disturbance::None, 300, Duration::ZERO, |_| [0.0; 2]);
    let found = find(Gain::Known(1.0), &[recording]);
    let told = found.estimates.iter().filter(|estimate| estimate.told == Told::Well);
    // A tilted table would move it.
    assert!(told.map(|estimate| &estimate.name).all(|name| name.starts_with("tilt")), "{:?}", found.estimates);
}

#[test]
fn what_is_no_recording_is_refused() {
    let model = Uarm::new(ThreeLinkDem::table_2(), Gain::Known(1.0));
    let whole = recorded(fitted(), Disturbance::None, 40, Duration::ZERO, sweep);
    let refused = |samples: &[Sample<3>]| identify(&model, &[samples], [RESOLUTION; 3], |_| ()).unwrap_err();
    assert_eq!(refused(&whole[..5]), IdentifyError::TooShort);
    let mut twice = whole.clone();
    twice[7].at = twice[6].at;
    assert_eq!(refused(&twice), IdentifyError::Sample { recording: 1, sample: 8 });
    let mut infinite = whole;
    infinite[0].torque[1] = f64::NAN;
    assert_eq!(refused(&infinite), IdentifyError::Sample { recording: 1, sample: 1 });
}
