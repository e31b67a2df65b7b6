//! One experiment in virtual time: the one that `uarm run --virtual-time` runs, the same loop, the same emulated drives.

use uarm_loop::record::NoRecorder;
use uarm_loop::settings::Settings;

use super::variant::VariantRobot;
use crate::simulated_robot::SimulatedPlant;
use crate::simulation::{SimulatedEnd, simulate};

/// Runs one experiment with a controller variant on `plant`, which brings its disturbance along.
///
/// # Errors
/// If the experiment cannot be begun.
pub fn experiment(variant: &VariantRobot, plant: SimulatedPlant) -> anyhow::Result<SimulatedEnd> {
    let settings = Settings::paper(variant.variant.law());
    simulate(&variant.robot, &settings, plant, NoRecorder).map(|(end, NoRecorder)| end)
}
