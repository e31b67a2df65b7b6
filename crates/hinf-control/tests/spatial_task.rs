//! A task in space under every law: an arm of three joints on a free-flying spacecraft of 100 kg, with derived weights.

use dem_model::nalgebra::{Matrix3, SVector, Vector3};
use dem_model::{
    Body, FreeFloatingManipulator, Joint, JointMotion, SerialState, SpaceLink, SpacecraftBody, SpatialSpaceManipulator,
    SphericalBaseManipulator,
};
use hinf_control::{
    AnyController, BaseAcceleration, BaseMeasurement, BuildContext, Controller, ControllerSettings, Law, Measurement,
    QuinticReference, TrackingError,
};

const PERIOD: f64 = 0.003;
/// Steps of the integrator within a period.
const SUBSTEPS: u32 = 1;
/// The task, s, and how long its end is held.
const DURATION: f64 = 5.0;
const HOLD: f64 = 2.0;
/// Weight of the newest base acceleration: the paper's low-pass of 27.8 rad/s at 3 ms.
const ACCELERATION_FILTER: f64 = 0.08;

type Plant = FreeFloatingManipulator<f64, 3>;
type Model = SphericalBaseManipulator<f64, 3>;
type State = SerialState<f64, 3, 6>;

/// The arm of tests/urdf/three_joints.urdf without its camera: yaw, pitch, elbow.
fn arm() -> (Plant, Model) {
    let along = |z: f64| Vector3::new(0.0, 0.0, z);
    let link = |mass, inertia: [f64; 2], to_centre: f64, length: f64| SpaceLink {
        mass,
        inertia: Matrix3::from_diagonal(&Vector3::new(inertia[0], inertia[0], inertia[1])),
        joint_to_centre_of_mass: along(to_centre),
        centre_of_mass_to_joint: along(length - to_centre),
    };
    // 60 kg at 0 m and 40 kg at 0.5 m: the centre at 0.2 m, the joint at 0.8 m.
    let spacecraft = SpacecraftBody {
        mass: 100.0,
        inertia: Matrix3::from_diagonal(&Vector3::new(16.0, 16.0, 10.0)),
        centre_of_mass_to_joint: along(0.6),
    };
    let links = [link(10.0, [0.1, 0.1], 0.1, 0.2), link(20.0, [0.9, 0.1], 0.4, 0.8), link(10.0, [0.4, 0.1], 0.3, 0.6)];
    let manipulator = SpatialSpaceManipulator::new(spacecraft, links).unwrap();
    let axes = [Vector3::z(), Vector3::x(), Vector3::x()];
    let joints =
        core::array::from_fn(|index| Joint::new(JointMotion::Revolute, axes[index], Body::Link(index + 2)).unwrap());
    (Plant::free_floating(&manipulator, joints), Model::dynamically_equivalent(&manipulator, joints))
}

fn task() -> QuinticReference<f64, 3> {
    QuinticReference::new(Vector3::new(0.0, 0.4, 0.6), Vector3::new(1.0, -0.5, 1.4), DURATION).unwrap()
}

/// The rates of joints and velocities under the joints' torque.
fn derivative(plant: &Plant, state: &State, torque: &Vector3<f64>) -> State {
    let rate = plant.forward_dynamics(state, &SVector::zeros(), torque).unwrap();
    State { position: state.velocity, velocity: rate.joints, base_velocity: rate.base }
}

fn along(state: &State, slope: &State, time: f64) -> State {
    State {
        position: state.position + slope.position * time,
        velocity: state.velocity + slope.velocity * time,
        base_velocity: state.base_velocity + slope.base_velocity * time,
    }
}

fn runge_kutta(plant: &Plant, state: &State, torque: &Vector3<f64>, step: f64) -> State {
    let k1 = derivative(plant, state, torque);
    let k2 = derivative(plant, &along(state, &k1, step / 2.0), torque);
    let k3 = derivative(plant, &along(state, &k2, step / 2.0), torque);
    let k4 = derivative(plant, &along(state, &k3, step), torque);
    [(k1, 1.0), (k2, 2.0), (k3, 2.0), (k4, 1.0)]
        .iter()
        .fold(*state, |state, (slope, weight)| along(&state, slope, step * weight / 6.0))
}

struct Errors {
    /// The largest error of a joint on the way, rad.
    worst: f64,
    /// That at the end, rad.
    end: f64,
}

/// The spacecraft turns at `base_velocity`, rad/s, at the start; then nothing acts on it.
fn run(law: &mut AnyController<f64, 3, 3, Model>, plant: &Plant, base_velocity: Vector3<f64>) -> Errors {
    let task = task();
    let mut state = State { position: *task.start(), velocity: Vector3::zeros(), base_velocity: SVector::zeros() };
    state.base_velocity.fixed_rows_mut::<3>(0).copy_from(&base_velocity);
    let mut acceleration = Vector3::zeros();
    let mut errors = Errors { worst: 0.0, end: 0.0 };
    for cycle in 0..((DURATION + HOLD) / PERIOD) as u32 {
        let base = BaseMeasurement { velocity: state.base_velocity.fixed_rows::<3>(0).into_owned(), acceleration };
        let measurement = Measurement { position: state.position, velocity: state.velocity, base };
        let reference = task.at(f64::from(cycle) * PERIOD);
        let period = if cycle == 0 { 0.0 } else { PERIOD };
        let command = law.update(&measurement, &reference, period);
        assert!(!command.adaptation.fell_back, "cycle {cycle}");
        errors.end = TrackingError::new(&measurement, &reference).position.amax();
        errors.worst = errors.worst.max(errors.end);
        // The torque makes the acceleration that the law reads in the next cycle: without a filter any delay diverges.
        let truth = derivative(plant, &state, &command.torque).base_velocity;
        acceleration += (truth.fixed_rows::<3>(0) - acceleration) * ACCELERATION_FILTER;
        for _ in 0..SUBSTEPS {
            state = runge_kutta(plant, &state, &command.torque, PERIOD / f64::from(SUBSTEPS));
        }
    }
    errors
}

/// Those that bounds are known of: a law that is added has bounds of its own.
const LAWS: [Law; 7] =
    [Law::Nonlinear, Law::Adaptive, Law::Neural, Law::NeuralModel, Law::Fuzzy, Law::FuzzyModel, Law::ComputedTorque];

fn laws(model: &Model) -> Vec<(Law, Option<BaseAcceleration>, AnyController<f64, 3, 3, Model>)> {
    let derived = ControllerSettings::derived(model, task().start()).unwrap();
    let mut laws = Vec::new();
    for law in LAWS {
        for mode in BaseAcceleration::ALL.map(Some).into_iter().chain([None]) {
            let mut settings = derived;
            if mode.is_none_or(|mode| settings.set_base_acceleration(law, mode).is_ok()) {
                laws.push((law, mode, settings.build(law, &BuildContext::new(*model)).unwrap()));
            }
        }
    }
    laws
}

/// Errors in degrees that a law may have, with a base that rests and with one that turns at 4 °/s: on the way, and at the end.
/// A law that has the base's whole effect is left with the sampling; the others with E, or what they have not learnt of it.
fn bounds(law: Law, mode: Option<BaseAcceleration>) -> [(f64, f64); 2] {
    use BaseAcceleration::{Eliminated, Measured, Omitted, Reduced, ReducedMomentum};
    let (exact, learning, blind) = ((1e-3, 1e-4), (0.1, 0.02), (0.2, 0.01));
    match (law, mode.unwrap_or(Reduced)) {
        (Law::Neural | Law::Fuzzy, _) => [learning; 2],
        (_, Measured | Omitted) => [blind, blind],
        // Their default.
        (Law::Adaptive, _) | (_, Eliminated | ReducedMomentum) => [exact; 2],
        (_, Reduced) => [exact, (0.05, 0.01)],
    }
}

#[test]
fn every_law_does_the_task_within_its_bound() {
    let (plant, model) = arm();
    for (law, mode, controller) in laws(&model) {
        let turning = Vector3::new(0.05, -0.03, 0.04);
        for (base_velocity, (worst, end)) in [Vector3::zeros(), turning].into_iter().zip(bounds(law, mode)) {
            let errors = run(&mut controller.clone(), &plant, base_velocity);
            let found = (errors.worst.to_degrees(), errors.end.to_degrees());
            assert!(found.0 <= worst && found.1 <= end, "{law:?} {mode:?}: {found:?} deg, bound {worst} and {end}");
        }
    }
}
