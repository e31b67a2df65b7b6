//! The motion of a URDF's arm on its floating spacecraft, as JSON, to compare with other programs: `arm_motion FILE TIP`.
//!
//! Each joint has the torque amplitude · sin(frequency · t + phase). Attitudes are x, y, z, w from base axes to inertial axes;
//! velocities are ω and ṙ of the spacecraft, in base axes, then those of the joints.

use std::error::Error;
use std::time::Duration;

use nalgebra::{SVector, UnitQuaternion, Vector3, Vector6};
use serde_json::{Value, json};
use uarm_sim::dem_model::{FreeFloatingManipulator, SerialState};
use uarm_sim::plant::FloatingPose;
use uarm_sim::{IntegrationStep, SerialBrakes, SerialImperfections, SerialMotion, SerialSpacePlant};
use uarm_urdf::{Arm, Selection};

const STEP: Duration = Duration::from_micros(500);
const ROW: Duration = Duration::from_millis(100);
const ROWS: u32 = 30;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(file), Some(tip)) = (arguments.next(), arguments.next()) else {
        return Err("usage: arm_motion FILE TIP".into());
    };
    let selection = Selection { tip: Some(tip), ..Selection::default() };
    let arm = Arm::parse(&std::fs::read_to_string(file)?, &selection)?;
    let motion = match arm.joints.len() {
        3 => motion::<3>(&arm)?,
        6 => motion::<6>(&arm)?,
        7 => motion::<7>(&arm)?,
        count => return Err(format!("{count} joints, expected 3, 6 or 7").into()),
    };
    println!("{motion}");
    Ok(())
}

fn motion<const N: usize>(arm: &Arm) -> Result<Value, Box<dyn Error>> {
    let (manipulator, joints) = arm.space_manipulator::<N>()?;
    let floating = FreeFloatingManipulator::free_floating(&manipulator, joints);
    let wave = |row: usize, phase: f64| (row as f64 * 2.1 + phase).sin();
    let start = SerialMotion {
        pose: FloatingPose {
            attitude: UnitQuaternion::from_euler_angles(0.4, -0.3, 1.1),
            place: Vector3::new(0.1, -0.2, 0.3),
        },
        state: SerialState {
            position: SVector::<f64, N>::from_fn(|row, _| wave(row, 0.0)),
            velocity: SVector::from_fn(|row, _| 0.3 * wave(row, 0.7)),
            base_velocity: Vector6::from_fn(|row, _| 0.05 * wave(row, 1.9)),
        },
    };
    // What accelerates each joint by half a rad/s², were it alone.
    let inertia = floating.dynamics(&start.state).mass_mm.diagonal();
    let amplitude = inertia * 0.5;
    let frequency = SVector::<f64, N>::from_fn(|row, _| 2.0 + row as f64);
    let phase = SVector::<f64, N>::from_fn(|row, _| 0.5 * row as f64);
    let torque = |time: f64| amplitude.component_mul(&(frequency * time + phase).map(f64::sin));

    let step = IntegrationStep::new(STEP).ok_or("the step is out of range")?;
    let plant = SerialSpacePlant::new(floating, SerialImperfections::IDEAL);
    let mut plant = plant.with_motion(start).with_integration_step(step);
    let row = |plant: &SerialSpacePlant<N>| {
        let SerialMotion { pose, state } = plant.motion();
        let velocity = [state.base_velocity.as_slice(), state.velocity.as_slice()].concat();
        json!({
            "attitude": pose.attitude.coords.as_slice(),
            "place": pose.place.as_slice(),
            "position": state.position.as_slice(),
            "velocity": velocity,
        })
    };
    let mut rows = vec![row(&plant)];
    for index in 1..=ROWS {
        plant.advance_under(ROW * index, &Vector6::zeros(), torque, SerialBrakes::RELEASED);
        rows.push(row(&plant));
    }
    Ok(json!({
        "step_s": STEP.as_secs_f64(),
        "steps_per_row": ROW.as_micros() / STEP.as_micros(),
        "amplitude": amplitude.as_slice(),
        "frequency": frequency.as_slice(),
        "phase": phase.as_slice(),
        "rows": rows,
    }))
}
