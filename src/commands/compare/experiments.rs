//! One experiment in virtual time: the one that `uarm run --virtual-time` runs, the same loop, the same emulated drives.

use uarm_loop::settings::Settings;

use super::variant::VariantRobot;
use crate::bought::Bought;
use crate::commands::run::{SimulatedEnd, simulate};
use crate::simulated_plant::SimulatedPlant;

/// Runs one experiment with a controller variant on `plant`, which brings its disturbance along.
///
/// # Errors
/// If the experiment cannot be begun.
pub fn experiment<const J: usize, const N: usize>(
    variant: &VariantRobot<J, N>,
    plant: SimulatedPlant<N>,
) -> anyhow::Result<SimulatedEnd<N>> {
    simulate(&variant.robot, &Bought::default(), &Settings::paper(variant.variant.law()), plant, None)
}
