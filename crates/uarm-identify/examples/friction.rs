//! A robot of known numbers is simulated, recorded with encoders, and found again.

use core::time::Duration;
use dem_model::ThreeLinkDem;
use uarm_identify::{Gain, Sample, Uarm, identify};
use uarm_sim::{Brake, Plant, UarmPlant, UarmPlantParameters};

const PERIOD: Duration = Duration::from_millis(3);
const RESOLUTION: f64 = core::f64::consts::TAU / 33_739.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let nominal = ThreeLinkDem::table_2();
    let mut plant = UarmPlant::new(&nominal, UarmPlantParameters::fitted())?;
    let mut samples = Vec::new();
    let mut torque_before = [0.0; 3];
    for cycle in 0..1_500_u32 {
        let at = PERIOD.as_secs_f64() * f64::from(cycle);
        let torque = [0.0, 0.12 * (6.0 * at).sin(), 0.09 * (9.0 * at).cos()];
        let position = plant.position().map(|angle| (angle / RESOLUTION).round() * RESOLUTION).into();
        samples.push(Sample { at, position, torque_before, torque, torque_at: at, disturbance: [0.0; 3] });
        plant.advance(PERIOD * (cycle + 1), &torque.into(), [Brake::Released; 3]);
        torque_before = torque;
    }
    let gain = Gain::Known(UarmPlantParameters::fitted().gain());
    let found = identify(&Uarm::new(nominal, gain), &[samples], [RESOLUTION; 3], |_| ())?;
    for estimate in &found.estimates {
        println!("{estimate}");
    }
    println!("residual {:.2}, {} windows, {} steps", found.residual, found.windows, found.steps);
    Ok(())
}
