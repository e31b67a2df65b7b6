//! The runs whose motion is shown: `uarm run --virtual-time`, kept in memory.

use anyhow::Context;
use hinf_control::Disturbance;
use hinf_control::Law;
use sim::VirtualClock;

use crate::commands::run::PlantChoice;
use crate::control_loop::LoopEnd;
use crate::control_loop::progress::Progress;
use crate::control_loop::record::CycleRecord;
use crate::experiment::report::Indices;
use crate::experiment::{Settings, embedded, run};
use crate::robot::Robot;
use crate::signals::StopRequest;

/// One law's run of the paper's experiment.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// The law.
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
pub fn simulate(robot: &Robot, plant: PlantChoice, law: Law) -> anyhow::Result<Experiment> {
    let settings = Settings::paper(law);
    let mut clock = VirtualClock::default();
    let link = embedded::link(robot, plant, Disturbance::Paper, clock.clone())?;
    let (progress, stop) = (Progress::default(), StopRequest::default());
    let (finished, records) = run(robot, &settings, link, &mut clock, Vec::new(), &progress, &stop)?;
    match finished.end.with_context(|| format!("the run of {}", law.name()))? {
        LoopEnd::Completed => Ok(Experiment { law, records, indices: finished.outcome.indices }),
        LoopEnd::Interrupted => anyhow::bail!("the run of {} was interrupted", law.name()),
    }
}

impl Experiment {
    /// One curve: time and what `value` makes of each cycle.
    pub fn curve<'a>(&'a self, value: impl Fn(&CycleRecord) -> f64 + 'a) -> impl Iterator<Item = [f64; 2]> + 'a {
        self.records.iter().map(move |record| [record.time, value(record)])
    }
}
