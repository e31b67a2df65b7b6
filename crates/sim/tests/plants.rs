//! What every plant owes its callers: the same bits each time, whatever the calls, and brakes that hold.

use core::time::Duration;
use dem_model::PlanarSpaceManipulator;
use dem_model::ThreeLinkDem;
use hinf_control::Disturbance;
use nalgebra::Vector3;
use uarm_sim::{
    Brake, DemPlant, FreeFloatingPlant, InitialState, IntegrationStep, MechanicalPlant, Mechanism, Plant, UarmPlant,
    UarmPlantParameters,
};

const FREE: [Brake; 3] = [Brake::Released; 3];
const HELD: [Brake; 3] = [Brake::Engaged; 3];

fn moving() -> InitialState {
    InitialState { position: Vector3::new(0.2, 0.4, -0.3), velocity: Vector3::new(0.3, -0.6, 0.9) }
}

fn dem() -> DemPlant {
    DemPlant::new(ThreeLinkDem::table_2()).with_initial_state(moving()).with_disturbance(Disturbance::Paper)
}

fn uarm() -> UarmPlant {
    let plant = UarmPlant::new(&ThreeLinkDem::table_2(), UarmPlantParameters::fitted()).unwrap();
    plant.with_initial_state(moving()).with_disturbance(Disturbance::Paper)
}

fn space() -> FreeFloatingPlant {
    let plant = FreeFloatingPlant::new(&PlanarSpaceManipulator::table_1());
    plant.with_initial_state(moving()).with_disturbance(Disturbance::Paper)
}

/// The torque of period `k`.
fn held_torque(k: u32) -> Vector3<f64> {
    let phase = f64::from(k) * 0.01;
    Vector3::new(0.0, 0.03 * phase.sin(), -0.02 * phase.cos())
}

fn run<P: Plant>(mut plant: P, calls_per_period: u32) -> P {
    let period = Duration::from_millis(3);
    for k in 0..500 {
        for call in 1..=calls_per_period {
            plant.advance(period * k + period / calls_per_period * call, &held_torque(k), FREE);
        }
    }
    plant
}

fn bits<M: Mechanism<DOF>, const DOF: usize>(plant: &MechanicalPlant<M, DOF>) -> Vec<u64> {
    let state = plant.motion_state();
    state.position.iter().chain(state.velocity.iter()).map(|value| value.to_bits()).collect()
}

/// 3 ms in 1, 3 and 30 calls: the cuts lie on the grid, the first disturbed period (0.999 s to 1.002 s) is among them.
#[test]
fn calls_do_not_show_in_the_bits() {
    for calls in [1, 3, 30] {
        assert_eq!(bits(&run(dem(), calls)), bits(&run(dem(), 1)));
        assert_eq!(bits(&run(uarm(), calls)), bits(&run(uarm(), 1)));
        assert_eq!(bits(&run(space(), calls)), bits(&run(space(), 1)));
    }
}

/// A grid that does not hold t = 1 s: the integrator must step onto the event, or the cut at the event would show.
#[test]
fn the_integrator_steps_onto_the_disturbance() {
    let off_grid = || dem().with_integration_step(IntegrationStep::new(Duration::from_millis(3)).unwrap());
    let mut through = off_grid();
    through.advance(Duration::from_millis(1_500), &Vector3::zeros(), FREE);
    let mut cut = off_grid();
    cut.advance(Disturbance::PAPER_ONSET, &Vector3::zeros(), FREE);
    cut.advance(Duration::from_millis(1_500), &Vector3::zeros(), FREE);
    assert_eq!(bits(&through), bits(&cut));
    assert_eq!(through.time(), Duration::from_millis(1_500));
}

/// Halving the step divides the error by 2⁴, also across the disturbance's onset.
#[test]
fn convergence_is_of_fourth_order() {
    let end = |step_microseconds| {
        let step = IntegrationStep::new(Duration::from_micros(step_microseconds)).unwrap();
        let mut plant = dem().with_integration_step(step);
        plant.advance(Duration::from_millis(1_500), &Vector3::new(0.0, 0.02, -0.01), FREE);
        *plant.motion_state()
    };
    let reference = end(100);
    let error =
        |step| (end(step).position - reference.position).norm() + (end(step).velocity - reference.velocity).norm();
    // 7 ms and 3.5 ms: t = 1 s lies on neither grid.
    let order = (error(7_000) / error(3_500)).log2();
    assert!((3.7..4.3).contains(&order), "order {order}");
}

fn all_brakes_hold<M: Mechanism<DOF>, const DOF: usize>(mut plant: MechanicalPlant<M, DOF>) {
    let start = plant.position();
    plant.advance(Duration::from_millis(1_200), &Vector3::new(0.0, 0.5, -0.5), HELD);
    assert_eq!(plant.position(), start);
    assert_eq!(plant.velocity(), Vector3::zeros());
    assert_eq!(plant.time(), Duration::from_millis(1_200));
}

/// Hours of standing still cost nothing: integrating them would take this test minutes.
#[test]
fn a_held_robot_stands_for_hours() {
    let mut plant = uarm();
    let day = Duration::from_secs(86_400);
    plant.advance(day, &Vector3::zeros(), HELD);
    assert_eq!(plant.time(), day);
    assert_eq!(plant.position(), moving().position);
}

#[test]
fn nothing_moves_with_all_brakes_engaged() {
    all_brakes_hold(dem());
    all_brakes_hold(uarm());
    all_brakes_hold(space());
}

fn one_brake_holds_one_joint<M: Mechanism<DOF>, const DOF: usize>(mut plant: MechanicalPlant<M, DOF>) {
    let start = plant.position();
    let energy = plant.kinetic_energy();
    plant.advance(Duration::from_nanos(1), &Vector3::zeros(), [Brake::Released, Brake::Engaged, Brake::Released]);
    assert!(plant.kinetic_energy() < energy, "a brake takes energy out");
    plant.advance(Duration::from_secs(1), &held_torque(7), [Brake::Released, Brake::Engaged, Brake::Released]);
    let end = plant.position();
    assert_eq!(end.y, start.y);
    assert!((end - start).x.abs() > 1e-3 && (end - start).z.abs() > 1e-3, "the others move on: {end}");
}

#[test]
fn a_brake_holds_its_joint_only() {
    one_brake_holds_one_joint(dem());
    one_brake_holds_one_joint(space());
}

/// A joint's brake is an inner force: engaging it changes no momentum of a free-floating robot.
#[test]
fn braking_a_joint_in_space_keeps_the_momenta() {
    let mut plant = space().with_disturbance(Disturbance::None);
    let angular = plant.angular_momentum();
    plant.advance(Duration::from_secs(1), &Vector3::zeros(), [Brake::Released, Brake::Engaged, Brake::Engaged]);
    approx::assert_abs_diff_eq!(plant.linear_momentum().norm(), 0.0, epsilon = 1e-12);
    approx::assert_abs_diff_eq!(plant.angular_momentum(), angular, epsilon = 1e-12);
    assert!(plant.velocity().x.abs() > 0.1, "the locked robot spins: {}", plant.velocity());
}

/// Work of the motors = gain of kinetic energy, without friction or disturbance (Simpson's rule for the work).
#[test]
fn energy_balance_of_the_ideal_plants() {
    fn imbalance<M: Mechanism<DOF>, const DOF: usize>(mut plant: MechanicalPlant<M, DOF>) -> f64 {
        let torque = Vector3::new(0.0, 0.03, -0.02);
        let start = plant.kinetic_energy();
        let mut work = 0.0;
        for pair in 0..5_000_u32 {
            let before = torque.dot(&plant.velocity());
            plant.advance(Duration::from_micros(100) * (2 * pair + 1), &torque, FREE);
            let middle = torque.dot(&plant.velocity());
            plant.advance(Duration::from_micros(100) * (2 * pair + 2), &torque, FREE);
            work += (before + 4.0 * middle + torque.dot(&plant.velocity())) * 2e-4 / 6.0;
        }
        plant.kinetic_energy() - start - work
    }
    // Rounding of 10 000 steps; the energy is about 0.05 J.
    approx::assert_abs_diff_eq!(imbalance(dem().with_disturbance(Disturbance::None)), 0.0, epsilon = 1e-12);
    approx::assert_abs_diff_eq!(imbalance(space().with_disturbance(Disturbance::None)), 0.0, epsilon = 1e-12);
}

/// At rest, the acceleration under a torque is M⁻¹τ of the model; a held joint's is zero.
#[test]
fn acceleration_is_that_of_the_model() {
    let model = ThreeLinkDem::table_2();
    let plant = DemPlant::new(model).with_initial_state(moving());
    let torque = Vector3::new(0.0, 0.04, -0.03);
    let expected = model.forward_dynamics(&moving().position, &moving().velocity, &torque);
    approx::assert_relative_eq!(plant.acceleration(&torque, FREE), expected, max_relative = 1e-12);
    assert_eq!(plant.acceleration(&torque, HELD), Vector3::zeros());
}
