//! The runs whose motion is shown: `uarm run --virtual-time`, kept in memory.

use hinf_control::{Disturbance, Law};
use uarm_loop::outcome::Indices;
use uarm_loop::settings::Settings;

use crate::dimensions::CycleRecord;
use crate::robot::Robot;
use crate::simulated_robot::{PlantChoice, SimulatedPlant};
use crate::simulation::simulate;

/// One law's run of the paper's experiment.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// The control law.
    pub law: Law,
    /// Every cycle.
    pub records: Vec<CycleRecord>,
    /// L2 and E.
    pub indices: Indices,
}

/// Runs the paper's experiment with the paper's disturbance, in virtual time.
///
/// # Errors
/// If the run does not end as it should.
pub fn simulate_paper(robot: &Robot, plant: PlantChoice, law: Law) -> anyhow::Result<Experiment> {
    let plant = SimulatedPlant::new(robot, plant, Disturbance::Paper)?;
    let (end, records) = simulate(robot, &Settings::paper(law), plant, Vec::new())?;
    Ok(Experiment { law, records, indices: end.completed(law.name())?.indices })
}

impl Experiment {
    /// One curve: time and what `value` makes of each cycle.
    pub fn curve<'a>(&'a self, value: impl Fn(&CycleRecord) -> f64 + 'a) -> impl Iterator<Item = [f64; 2]> + 'a {
        self.records.iter().map(move |record| [record.time, value(record)])
    }
}
