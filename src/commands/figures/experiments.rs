//! The runs whose motion is shown: `uarm run --virtual-time`, kept in memory.

use hinf_control::{Disturbance, Law};
use uarm_loop::outcome::Indices;
use uarm_loop::settings::Settings;

use crate::bought::Bought;
use crate::commands::run::simulate;
use crate::dimensions::CycleRecord;
use crate::robot::Robot;
use crate::simulated_plant::{PlantChoice, SimulatedPlant};

/// One law's run of a robot's task.
#[derive(Clone, Debug)]
pub struct Experiment<const J: usize = 3, const N: usize = 2> {
    /// The control law.
    pub law: Law,
    /// Every cycle.
    pub records: Vec<CycleRecord<J, N>>,
    /// L2 and E.
    pub indices: Indices,
}

/// Runs the task of `robot` on `plant`, disturbed as said, in virtual time.
///
/// # Errors
/// If the run does not end as it should.
pub fn simulated<const J: usize, const N: usize>(
    robot: &Robot<J, N>,
    plant: PlantChoice,
    disturbance: Disturbance,
    law: Law,
) -> anyhow::Result<Experiment<J, N>> {
    let plant = SimulatedPlant::new(robot, plant, disturbance)?;
    let mut records = Vec::new();
    let end = simulate(robot, &Bought::default(), &Settings::paper(law), plant, Some(&mut records))?;
    Ok(Experiment { law, records, indices: end.completed(law.name())?.indices })
}

/// Runs the paper's experiment with the paper's disturbance.
///
/// # Errors
/// As [`simulated`].
pub fn simulate_paper(robot: &Robot, plant: PlantChoice, law: Law) -> anyhow::Result<Experiment> {
    simulated(robot, plant, Disturbance::Paper, law)
}

impl<const J: usize, const N: usize> Experiment<J, N> {
    /// One curve: time and what `value` makes of each cycle.
    pub fn curve<'a>(&'a self, value: impl Fn(&CycleRecord<J, N>) -> f64 + 'a) -> impl Iterator<Item = [f64; 2]> + 'a {
        self.records.iter().map(move |record| [record.time, value(record)])
    }
}
