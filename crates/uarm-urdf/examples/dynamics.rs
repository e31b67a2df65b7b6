//! The dynamics of a URDF's arm at some states, as JSON, to compare with other programs: `dynamics FILE TIP`.
//!
//! Velocities are ω and ṙ of the base, in base axes about its centre of mass, then those of the joints.

use std::error::Error;

use dem_model::nalgebra::{SVector, Vector6};
use dem_model::{FreeFloatingManipulator, SerialState, SphericalBaseManipulator};
use serde_json::{Value, json};
use uarm_urdf::{Arm, Selection};

const STATES: u32 = 20;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(file), Some(tip)) = (arguments.next(), arguments.next()) else {
        return Err("usage: dynamics FILE TIP".into());
    };
    let selection = Selection { tip: Some(tip), ..Selection::default() };
    let arm = Arm::parse(&std::fs::read_to_string(file)?, &selection)?;
    let states = match arm.joints.len() {
        3 => states::<3>(&arm)?,
        6 => states::<6>(&arm)?,
        7 => states::<7>(&arm)?,
        count => return Err(format!("{count} joints, expected 3, 6 or 7").into()),
    };
    println!("{}", serde_json::to_string(&states)?);
    Ok(())
}

fn states<const N: usize>(arm: &Arm) -> Result<Vec<Value>, Box<dyn Error>> {
    let (manipulator, joints) = arm.space_manipulator::<N>()?;
    let floating = FreeFloatingManipulator::free_floating(&manipulator, joints);
    let dem = SphericalBaseManipulator::dynamically_equivalent(&manipulator, joints);
    (0..STATES)
        .map(|index| {
            let number = |row: usize, phase: f64| (f64::from(index) * 1.3 + row as f64 * 2.1 + phase).sin();
            let state = SerialState::<f64, N, 6> {
                position: SVector::from_fn(|row, _| 3.0 * number(row, 0.0)),
                velocity: SVector::from_fn(|row, _| number(row, 0.7)),
                base_velocity: Vector6::from_fn(|row, _| number(row, 1.9)),
            };
            let torque = SVector::<f64, N>::from_fn(|row, _| number(row, 2.6));
            let dynamics = floating.dynamics(&state);
            let (base, joints) = dynamics.coriolis_torque(&state.base_velocity, &state.velocity);
            let acceleration = floating.forward_dynamics(&state, &Vector6::zeros(), &torque).ok_or("not finite")?;
            let turning = SerialState {
                position: state.position,
                velocity: state.velocity,
                base_velocity: state.base_velocity.fixed_rows::<3>(0).into_owned(),
            };
            let of_dem = dem.forward_dynamics(&turning, &SVector::zeros(), &torque).ok_or("not finite")?;
            let rows = |row: usize| -> Vec<f64> {
                if row < 6 {
                    dynamics.mass_bb.row(row).iter().chain(dynamics.mass_bm.row(row).iter()).copied().collect()
                } else {
                    let row = row - 6;
                    dynamics.mass_bm.column(row).iter().chain(dynamics.mass_mm.row(row).iter()).copied().collect()
                }
            };
            let list = |first: &[f64], second: &[f64]| [first, second].concat();
            Ok(json!({
                "position": state.position.as_slice(),
                "velocity": list(state.base_velocity.as_slice(), state.velocity.as_slice()),
                "torque": torque.as_slice(),
                "mass": (0..6 + N).map(rows).collect::<Vec<_>>(),
                "coriolis_torque": list(base.as_slice(), joints.as_slice()),
                "acceleration": list(acceleration.base.as_slice(), acceleration.joints.as_slice()),
                "dem_acceleration": list(of_dem.base.as_slice(), of_dem.joints.as_slice()),
            }))
        })
        .collect()
}
