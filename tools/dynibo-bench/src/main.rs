//! Dynamics of free-floating arms of 1 to 8 joints, by uarm's `SerialManipulator` and by dynibo, from the same URDF.
//!
//! Joint accelerations must agree first. Then each is called many times; printed is the least time of a call over all batches, which a
//! busy machine disturbs least.

use std::error::Error;
use std::fmt::Write;
use std::hint::black_box;
use std::time::Instant;

use dem_model::nalgebra::{SVector, Vector6};
use dem_model::{FreeFloatingManipulator, SerialAcceleration, SerialState};
use dynibo::{BaseState, FloatingRobot, Frame};
use uarm_urdf::{Arm, Selection};

const BATCHES: usize = 400;
const CALLS: u32 = 500;
/// Velocities of a base that floats.
const FLOATING: usize = 6;
/// How far accelerations may differ, relative to the largest.
const AGREEMENT: f64 = 1e-9;

fn main() -> Result<(), Box<dyn Error>> {
    println!("ns per call, the least of {BATCHES} batches of {CALLS}; joint accelerations agree to {AGREEMENT:e}");
    println!("joints   forward dynamics    inverse dynamics    mass matrix");
    println!("           uarm   dynibo       uarm   dynibo      uarm   dynibo");
    arm::<1>()?;
    arm::<2>()?;
    arm::<3>()?;
    arm::<4>()?;
    arm::<5>()?;
    arm::<6>()?;
    arm::<7>()?;
    arm::<8>()
}

/// A satellite with an arm whose joints turn about z, y, x in turn.
fn urdf(joints: usize) -> String {
    let mut text = String::from("<robot name=\"chain\"><link name=\"bus\"><inertial><mass value=\"200\"/>");
    text.push_str("<inertia ixx=\"40\" iyy=\"50\" izz=\"60\" ixy=\"1\" ixz=\"2\" iyz=\"3\"/></inertial></link>");
    for joint in 1..=joints {
        let parent = if joint == 1 { "bus".to_owned() } else { format!("link{}", joint - 1) };
        let axis = ["0 0 1", "0 1 0", "1 0 0"][joint % 3];
        // Writing to a `String` does not fail.
        let _ = write!(
            text,
            "<joint name=\"joint{joint}\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"link{joint}\"/>\
             <origin xyz=\"0.5 0.1 0.2\"/><axis xyz=\"{axis}\"/><limit lower=\"-3\" upper=\"3\" effort=\"10\" velocity=\"1\"/></joint>\
             <link name=\"link{joint}\"><inertial><origin xyz=\"0.25 0.05 0.1\"/><mass value=\"{}\"/>\
             <inertia ixx=\"0.4\" iyy=\"0.5\" izz=\"0.6\" ixy=\"0.01\" ixz=\"0.02\" iyz=\"0.03\"/></inertial></link>",
            5.0 + joint as f64
        );
    }
    text + "</robot>"
}

fn arm<const N: usize>() -> Result<(), Box<dyn Error>> {
    let text = urdf(N);
    let file = std::env::temp_dir().join(format!("dynibo-bench-{}-{N}.urdf", std::process::id()));
    std::fs::write(&file, &text)?;
    let dynibo = FloatingRobot::from_urdf(&file);
    std::fs::remove_file(&file)?;
    compare::<N>(&text, dynibo?).map_err(|error| format!("{N} joints: {error}").into())
}

fn compare<const N: usize>(text: &str, mut dynibo: FloatingRobot) -> Result<(), Box<dyn Error>> {
    let (manipulator, joints) = Arm::parse(text, &Selection::default())?.space_manipulator::<N>()?;
    let uarm = FreeFloatingManipulator::free_floating(&manipulator, joints);
    let number = |row: usize, phase: f64| (row as f64 * 2.1 + phase).sin();
    let state = SerialState::<f64, N, FLOATING> {
        position: SVector::from_fn(|row, _| number(row, 0.3)),
        velocity: SVector::from_fn(|row, _| number(row, 0.7)),
        base_velocity: Vector6::zeros(),
    };
    let torque = SVector::<f64, N>::from_fn(|row, _| number(row, 2.6));
    let (q, rate) = (state.position.as_slice().to_vec(), state.velocity.as_slice().to_vec());
    let base = BaseState::stationary(Frame::identity())?;
    let size = dynibo.generalized_count();
    let forces: Vec<f64> = std::iter::repeat_n(0.0, FLOATING).chain(torque.iter().copied()).collect();
    let (mut acceleration, mut matrix) = (vec![0.0; size], vec![0.0; size * size]);

    dynibo.forward_dynamics(&base, &q, &rate, &forces, &[], &mut acceleration)?;
    let ours = uarm.recursive_forward_dynamics(&state, &Vector6::zeros(), &torque).ok_or("not finite")?;
    let theirs = SVector::<f64, N>::from_row_slice(acceleration.get(FLOATING..).ok_or("too few accelerations")?);
    if (ours.joints - theirs).amax() > AGREEMENT * theirs.amax() {
        return Err(format!("accelerations {} of uarm, {} of dynibo", ours.joints, theirs).into());
    }

    let wanted = SerialAcceleration { base: Vector6::zeros(), joints: ours.joints };
    let joint_acceleration = ours.joints.as_slice().to_vec();
    let times = [
        least(|| {
            black_box(uarm.recursive_forward_dynamics(black_box(&state), &Vector6::zeros(), &torque));
        }),
        least(|| {
            let _ = black_box(dynibo.forward_dynamics(&base, black_box(&q), &rate, &forces, &[], &mut acceleration));
        }),
        least(|| {
            black_box(uarm.inverse_dynamics(black_box(&state), &wanted));
        }),
        least(|| {
            let _ = black_box(dynibo.inverse_dynamics(
                &base,
                black_box(&q),
                &rate,
                &joint_acceleration,
                &[],
                &mut acceleration,
            ));
        }),
        least(|| {
            black_box(uarm.dynamics(black_box(&state)));
        }),
        least(|| {
            let _ = black_box(dynibo.mass_matrix(&base, black_box(&q), &mut matrix));
        }),
    ];
    let [forward, their_forward, inverse, their_inverse, mass, their_mass] = times;
    println!(
        "{N:>6} {forward:>8.0} {their_forward:>8.0}   {inverse:>8.0} {their_inverse:>8.0}  {mass:>8.0} {their_mass:>8.0}"
    );
    Ok(())
}

/// The least time of a call, ns.
fn least(mut call: impl FnMut()) -> f64 {
    let mut least = f64::INFINITY;
    for _ in 0..BATCHES {
        let begin = Instant::now();
        (0..CALLS).for_each(|_| call());
        least = least.min(begin.elapsed().as_nanos() as f64 / f64::from(CALLS));
    }
    least
}
