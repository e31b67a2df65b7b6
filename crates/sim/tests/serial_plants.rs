//! Arms of N joints on bases that float and turn: what moves alike, what is conserved, what holds.

use core::time::Duration;
use dem_model::{
    Body, FreeFloatingManipulator, Joint, JointMotion, PlanarBaseManipulator, PlanarSpaceManipulator, SerialState,
    SpatialSpaceManipulator, SphericalBaseManipulator,
};
use hinf_control::Disturbance;
use nalgebra::{SVector, UnitQuaternion, Vector3, Vector6};
use std::path::Path;
use uarm_sim::plant::FloatingPose;
use uarm_sim::{
    Brake, DemPlant, InitialState, IntegrationStep, JointImperfections, ParameterScale, PlanarBasePlant, Plant,
    SerialBrakes, SerialImperfections, SerialMotion, SerialSpacePlant, SphericalBasePlant,
};
use uarm_urdf::{Arm, Selection};

/// A space manipulator with its joints.
type Model<const N: usize> = (SpatialSpaceManipulator<f64, N>, [Joint<f64>; N]);

fn read<const N: usize>(file: &str, tip: &str) -> Model<N> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(file);
    let selection = Selection { tip: Some(tip.to_owned()), ..Selection::default() };
    let arm = Arm::parse(&std::fs::read_to_string(path).unwrap(), &selection).unwrap();
    arm.space_manipulator().unwrap()
}

fn wave(index: usize, phase: f64) -> f64 {
    (2.1 * index as f64 + phase).sin()
}

/// A moving start: joints, their rates, the base's attitude and its rate.
fn start<const N: usize>() -> (UnitQuaternion<f64>, SerialState<f64, N, 3>) {
    let state = SerialState {
        position: SVector::from_fn(|row, _| wave(row, 0.0)),
        velocity: SVector::from_fn(|row, _| 0.3 * wave(row, 0.7)),
        base_velocity: Vector3::new(0.02, -0.03, 0.05),
    };
    (UnitQuaternion::from_euler_angles(0.4, -0.3, 1.1), state)
}

/// Both plants of a space manipulator, each at the same start, the spacecraft's centre of mass put where the whole rests.
fn plants<const N: usize>((manipulator, joints): &Model<N>) -> (SerialSpacePlant<N>, SphericalBasePlant<N>) {
    let (attitude, state) = start();
    let dem = SphericalBaseManipulator::dynamically_equivalent(manipulator, *joints);
    let dem = SphericalBasePlant::new(dem, SerialImperfections::IDEAL);
    let SerialState { position, velocity, base_velocity: turning } = state;
    let base_velocity = Vector6::new(turning.x, turning.y, turning.z, 0.0, 0.0, 0.0);
    let floating = SerialMotion {
        pose: FloatingPose { attitude, place: Vector3::zeros() },
        state: SerialState { position, velocity, base_velocity },
    };
    let space = FreeFloatingManipulator::free_floating(manipulator, *joints);
    let space = SerialSpacePlant::new(space, SerialImperfections::IDEAL).with_motion(floating).about_centre_of_mass();
    (space, dem.with_motion(SerialMotion { pose: attitude, state }))
}

/// Torques that accelerate each joint by up to about 0.5 rad/s², were it alone.
fn torque<const N: usize>(plant: &SphericalBasePlant<N>) -> impl Fn(f64) -> SVector<f64, N> + use<N> {
    let inertia = plant.arm().dynamics(&plant.motion().state).mass_mm.diagonal();
    move |time| SVector::from_fn(|row, _| 0.5 * inertia[row] * wave(row, (2.0 + row as f64) * time))
}

/// Liang's theorem in space, for one arm over 3 s, and what is conserved meanwhile.
fn move_alike<const N: usize>(file: &str, tip: &str) {
    let (space, dem) = plants(&read::<N>(file, tip));
    let torque = torque(&dem);
    let step = IntegrationStep::new(Duration::from_micros(200)).unwrap();
    let (mut space, mut dem) = (space.with_integration_step(step), dem.with_integration_step(step));
    let (angular, size) = (space.angular_momentum(), space.kinetic_energy());
    assert!((angular - dem.angular_momentum()).norm() < 1e-12 * angular.norm());
    for milliseconds in (100..=3_000).step_by(100) {
        let until = Duration::from_millis(milliseconds);
        space.advance_under(until, &Vector6::zeros(), &torque, SerialBrakes::RELEASED);
        dem.advance_under(until, &Vector3::zeros(), &torque, SerialBrakes::RELEASED);
        let (ours, theirs) = (space.motion().state, dem.motion().state);
        let at = format!("{file} at {milliseconds} ms");
        let close = |difference: f64, bound: f64, what| assert!(difference < bound, "{at}: {what} {difference:e}");
        close((ours.position - theirs.position).amax(), 1e-9, "joints");
        close((ours.velocity - theirs.velocity).amax(), 1e-9, "rates");
        close(space.attitude().angle_to(&dem.attitude()), 1e-9, "attitude");
        close(space.kinetic_energy() - dem.kinetic_energy(), 1e-9 * (1.0 + size), "energy");
        for (plant, momentum) in [("space", space.angular_momentum()), ("DEM", dem.angular_momentum())] {
            close((momentum - angular).norm(), 1e-11 * (1.0 + angular.norm()), plant);
        }
        close(space.linear_momentum().norm(), 1e-9, "linear momentum");
        close(space.centre_of_mass().norm(), 1e-10, "centre of mass");
    }
    assert!((dem.motion().state.position - start::<N>().1.position).amax() > 0.3, "{file}: it has moved");
    assert!(dem.attitude().angle_to(&start::<N>().0) > 0.05, "{file}: the base has turned");
}

#[test]
fn three_joints_move_as_their_equivalent() {
    move_alike::<3>("tests/urdf/three_joints.urdf", "tool");
}

#[test]
fn seven_joints_move_as_their_equivalent() {
    move_alike::<7>("tests/urdf/seven_joints.urdf", "tool");
}

#[test]
fn ets_vii_moves_as_its_equivalent() {
    move_alike::<6>("robots/ets-vii.urdf", "tool");
    move_alike::<3>("robots/ets-vii.urdf", "forearm");
}

#[test]
fn the_satellite_with_seven_joints_moves_as_its_equivalent() {
    move_alike::<7>("robots/seven-joint.urdf", "tool");
}

#[test]
fn the_planar_robot_moves_as_its_equivalent() {
    move_alike::<3>("robots/planar-four-link.urdf", "tool");
}

/// A joint that slides: its link in the DEM moves by a part of its coordinate.
#[test]
fn a_sliding_joint_moves_as_its_equivalent() {
    let (manipulator, mut joints) = read::<3>("tests/urdf/three_joints.urdf", "tool");
    joints[1] = Joint::new(JointMotion::Prismatic, Vector3::new(0.3, 0.2, 1.0), Body::Link(3)).unwrap();
    let (mut space, mut dem) = plants(&(manipulator, joints));
    let torque = torque(&dem);
    let until = Duration::from_secs(1);
    space.advance_under(until, &Vector6::zeros(), &torque, SerialBrakes::RELEASED);
    dem.advance_under(until, &Vector3::zeros(), &torque, SerialBrakes::RELEASED);
    approx::assert_abs_diff_eq!(space.motion().state.position, dem.motion().state.position, epsilon = 1e-10);
    assert!(space.attitude().angle_to(&dem.attitude()) < 1e-10);
}

/// The paper's arm as one of any kind is the closed form's plant, with disturbance, brakes and a torque on the base.
#[test]
fn two_joints_in_the_plane_are_the_papers_arm() {
    let planar = PlanarSpaceManipulator::<f64, 2>::table_1().dynamically_equivalent();
    let initial = InitialState { position: Vector3::new(0.2, 0.4, -0.3), velocity: Vector3::new(0.3, -0.6, 0.9) };
    let closed = DemPlant::new(planar.closed_form().unwrap());
    let mut closed = closed.with_initial_state(initial).with_disturbance(Disturbance::Paper);
    let serial = PlanarBasePlant::new(PlanarBaseManipulator::planar(&planar), SerialImperfections::IDEAL);
    let state = SerialState {
        position: initial.position.yz(),
        velocity: initial.velocity.yz(),
        base_velocity: initial.velocity.fixed_rows::<1>(0).into_owned(),
    };
    let motion = SerialMotion { pose: initial.position.x, state };
    let mut serial = serial.with_motion(motion).with_disturbance(Disturbance::Paper);
    let (free, held) = (Brake::Released, Brake::Engaged);
    let torque = Vector3::new(0.01, 0.03, -0.02);
    for (milliseconds, brakes) in [(1_200, [free; 3]), (1_500, [free, held, free]), (2_000, [held, free, free])] {
        let until = Duration::from_millis(milliseconds);
        closed.advance(until, &torque, brakes);
        serial.advance(until, &torque, brakes);
        approx::assert_abs_diff_eq!(Plant::<3>::position(&serial), closed.position(), epsilon = 1e-11);
        approx::assert_abs_diff_eq!(Plant::<3>::velocity(&serial), closed.velocity(), epsilon = 1e-11);
        approx::assert_abs_diff_eq!(serial.kinetic_energy(), closed.kinetic_energy(), epsilon = 1e-12);
    }
}

/// Work of motors and friction = gain of kinetic energy (Simpson's rule for the work), on each base in space.
#[test]
fn energy_balance_with_friction_and_gains() {
    let (manipulator, joints) = read::<3>("tests/urdf/three_joints.urdf", "tool");
    let joint = JointImperfections { viscous_friction: 0.8, coulomb_friction: 0.1, gain: 1.1 };
    let imperfections = SerialImperfections::new([joint; 3]).unwrap().with_base_friction(3.0, 0.2).unwrap();
    let dem = SphericalBaseManipulator::dynamically_equivalent(&manipulator, joints);
    let (attitude, state) = start();
    let mut plant = SphericalBasePlant::new(dem, imperfections).with_motion(SerialMotion { pose: attitude, state });
    let torque = Vector3::new(1.0, -0.7, 0.4);
    let power = |plant: &SphericalBasePlant<3>| {
        let SerialState { velocity, base_velocity, .. } = plant.motion().state;
        let smoothed = |speed: f64| (speed / 0.02).tanh();
        let friction = velocity.map(|velocity| -0.8 * velocity - 0.1 * smoothed(velocity));
        let speed = base_velocity.norm();
        velocity.dot(&(torque * 1.1 + friction)) - 3.0 * speed * speed - 0.2 * speed * smoothed(speed)
    };
    let (before, mut work) = (plant.kinetic_energy(), 0.0);
    for pair in 0..5_000_u32 {
        let at = |step: u32| Duration::from_micros(100) * (2 * pair + step);
        let first = power(&plant);
        plant.advance(at(1), &torque, [Brake::Released; 3]);
        let middle = power(&plant);
        plant.advance(at(2), &torque, [Brake::Released; 3]);
        work += (first + 4.0 * middle + power(&plant)) * 2e-4 / 6.0;
    }
    assert!(work.abs() > 0.1, "{work}");
    approx::assert_abs_diff_eq!(plant.kinetic_energy() - before, work, epsilon = 1e-9);
}

/// A brake of a joint is an inner force: it stops the joint, takes energy and leaves the momenta.
#[test]
fn braking_in_space_keeps_the_momenta() {
    let (mut space, _) = plants(&read::<7>("tests/urdf/seven_joints.urdf", "tool"));
    let (angular, energy) = (space.angular_momentum(), space.kinetic_energy());
    let held = space.motion().state.position[2];
    let mut brakes = [Brake::Released; 7];
    brakes[2] = Brake::Engaged;
    space.advance(Duration::from_millis(200), &SVector::zeros(), brakes);
    assert_eq!((space.position()[2], space.velocity()[2]), (held, 0.0));
    assert!(space.velocity()[3].abs() > 1e-3, "the others move on");
    assert!(space.kinetic_energy() < energy - 1e-4);
    space.advance(Duration::from_millis(400), &SVector::zeros(), [Brake::Engaged; 7]);
    assert_eq!(space.velocity(), SVector::<f64, 7>::zeros());
    approx::assert_abs_diff_eq!(space.angular_momentum(), angular, epsilon = 1e-11);
    assert!(space.linear_momentum().norm() < 1e-11);
    assert!(space.motion().state.base_velocity.norm() > 1e-3, "the locked robot spins on");
}

#[test]
fn a_held_base_stays_and_a_robot_that_stands_stands_for_days() {
    let (_, mut dem) = plants(&read::<3>("tests/urdf/three_joints.urdf", "tool"));
    let attitude = dem.attitude();
    let held = SerialBrakes { base: Brake::Engaged, ..SerialBrakes::RELEASED };
    dem.advance_under(Duration::from_millis(100), &Vector3::repeat(5.0), |_| Vector3::repeat(1.0), held);
    assert_eq!((dem.attitude(), dem.motion().state.base_velocity), (attitude, Vector3::zeros()));
    assert!(dem.motion().state.velocity.amax() > 1e-2);
    let (space, _) = plants(&read::<3>("tests/urdf/three_joints.urdf", "tool"));
    let mut standing = space.with_motion(SerialMotion::at_rest(Vector3::repeat(0.3)));
    standing.advance(Duration::from_secs(86_400), &Vector3::repeat(1.0), [Brake::Engaged; 3]);
    assert_eq!((Plant::time(&standing), standing.position()), (Duration::from_secs(86_400), Vector3::repeat(0.3)));
}

/// 20 rad/s in steps of 10 ms: without the division by its norm the quaternion would shrink by 1e-8 in each.
#[test]
fn the_attitudes_norm_does_not_drift() {
    let (_, dem) = plants(&read::<3>("tests/urdf/three_joints.urdf", "tool"));
    let mut motion = *dem.motion();
    motion.state.base_velocity = Vector3::new(0.0, 0.0, 20.0);
    let step = IntegrationStep::new(IntegrationStep::LONGEST).unwrap();
    let mut dem = dem.with_motion(motion).with_integration_step(step);
    Plant::<3>::advance(&mut dem, Duration::from_secs(3), &Vector3::zeros(), [Brake::Engaged; 3]);
    assert!((dem.attitude().norm() - 1.0).abs() < 1e-15, "{:e}", dem.attitude().norm() - 1.0);
}

/// Each period in 1 or 30 calls, across the disturbance's onset: the same bits.
#[test]
fn calls_do_not_show_in_the_bits() {
    let run = |calls: u32| {
        let (space, dem) = plants(&read::<3>("tests/urdf/three_joints.urdf", "tool"));
        let torque = torque(&dem);
        let mut space = space.with_disturbance(Disturbance::Paper);
        let period = Duration::from_millis(3);
        for k in 0..340 {
            for call in 1..=calls {
                let until = period * k + period / calls * call;
                space.advance(until, &torque(f64::from(k) * 0.003), [Brake::Released; 3]);
            }
        }
        *space.motion()
    };
    assert_eq!(run(30), run(1));
}

/// The disturbance is a torque at the first two joints: by 0.1 s after its onset it has changed their rates.
#[test]
fn the_disturbance_acts_at_the_first_joints() {
    let (space, _) = plants(&read::<3>("tests/urdf/three_joints.urdf", "tool"));
    let mut alone = space.with_motion(SerialMotion::at_rest(Vector3::repeat(0.3)));
    let mut disturbed = alone.clone().with_disturbance(Disturbance::Paper);
    for (until, moves) in [(1_000, false), (1_100, true)] {
        let until = Duration::from_millis(until);
        alone.advance(until, &Vector3::zeros(), [Brake::Released; 3]);
        disturbed.advance(until, &Vector3::zeros(), [Brake::Released; 3]);
        assert_eq!(alone.velocity(), Vector3::zeros());
        assert_eq!(disturbed.velocity().x > 1e-5, moves, "{}", disturbed.velocity());
    }
}

/// Halving the step divides the error by 2⁴, in the joints and in the attitude.
#[test]
fn convergence_is_of_fourth_order() {
    let end = |milliseconds| {
        let (space, dem) = plants(&read::<3>("robots/ets-vii.urdf", "forearm"));
        let torque = torque(&dem);
        let mut motion = *space.motion();
        motion.state.base_velocity *= 20.0;
        let step = IntegrationStep::new(Duration::from_micros(milliseconds)).unwrap();
        let mut space = space.with_motion(motion).with_integration_step(step);
        space.advance_under(Duration::from_secs(1), &Vector6::zeros(), torque, SerialBrakes::RELEASED);
        *space.motion()
    };
    let reference = end(200);
    let errors = |step| {
        let end = end(step);
        let attitude = end.pose.attitude.angle_to(&reference.pose.attitude);
        ((end.state.position - reference.state.position).norm(), attitude)
    };
    let (coarse, fine) = (errors(10_000), errors(5_000));
    let orders = ((coarse.0 / fine.0).log2(), (coarse.1 / fine.1).log2());
    assert!((3.7..4.3).contains(&orders.0) && (3.7..4.3).contains(&orders.1), "{orders:?}");
}

/// Twice the masses and inertias under twice the torques move alike; a factor of zero is refused.
#[test]
fn other_parameters_make_another_arm() {
    let (manipulator, joints) = read::<3>("tests/urdf/three_joints.urdf", "tool");
    let twice = ParameterScale { base: 2.0, links: 2.0 };
    let nominal = plants(&(manipulator, joints));
    let heavy = plants(&(twice.space_manipulator(&manipulator).unwrap(), joints));
    let dem = twice.dem(&manipulator.dynamically_equivalent()).unwrap();
    let built = SphericalBaseManipulator::new(&dem, joints).unwrap();
    let built = SphericalBasePlant::new(built, SerialImperfections::IDEAL).with_motion(*nominal.1.motion());
    let (mut nominal, mut heavy, mut built) = (nominal.0, heavy.0, built);
    let until = Duration::from_millis(500);
    nominal.advance(until, &Vector3::new(1.0, -2.0, 0.5), [Brake::Released; 3]);
    heavy.advance(until, &Vector3::new(2.0, -4.0, 1.0), [Brake::Released; 3]);
    built.advance(until, &Vector3::new(2.0, -4.0, 1.0), [Brake::Released; 3]);
    approx::assert_abs_diff_eq!(heavy.position(), nominal.position(), epsilon = 1e-12);
    approx::assert_abs_diff_eq!(built.position(), nominal.position(), epsilon = 1e-11);
    assert!(ParameterScale { base: 1.0, links: 0.0 }.space_manipulator(&manipulator).is_err());
    assert!(ParameterScale { base: f64::NAN, links: 1.0 }.dem(&manipulator.dynamically_equivalent()).is_err());
}
