//! The paper's table with its spread: each controller, some repetitions, one plant.

use std::num::{NonZeroU32, NonZeroUsize};
use std::path::Path;

use anyhow::Context;
use hinf_control::Disturbance;
use hinf_control::Law;
use serde::Serialize;
use sim::UarmPlantParameters;

use super::contestant::{Contestant, Entrant, Origin};
use super::start::StartVariation;
use super::statistics::Summary;
use super::trial::{self, Trial};
use super::{FITTED_PLANT_CAVEAT, parallel};
use crate::commands::run::PlantChoice;
use crate::experiment::Outcome;
use crate::experiment::embedded::{self, EmbeddedPlant};
use crate::experiment::place::plant_name;
use crate::experiment::report::Indices;
use crate::robot::Robot;
use crate::robot::overrides::Overrides;

/// What is compared, and how.
#[derive(Clone, Copy, Debug)]
pub struct ComparisonSettings<'a> {
    /// The robot file; without it the paper's UARM.
    pub robot: Option<&'a Path>,
    /// Who is compared.
    pub contestants: &'a [Contestant],
    /// What the robot is.
    pub plant: PlantChoice,
    /// What disturbs its joints.
    pub disturbance: Disturbance,
    /// Experiments for each controller.
    pub repetitions: NonZeroU32,
    /// What differs between them.
    pub variation: StartVariation,
    /// What it is drawn from.
    pub seed: u64,
    /// How many experiments run at a time.
    pub threads: NonZeroUsize,
}

/// What came of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// The robot's name.
    pub robot: String,
    /// What moved.
    pub plant: &'static str,
    /// Experiments for each controller.
    pub repetitions: u32,
    /// What differed between them.
    pub variation: StartVariation,
    /// What it was drawn from.
    pub seed: u64,
    /// What must be said beside these numbers.
    pub caveat: Option<&'static str>,
    /// The controllers, in the order asked for.
    pub controllers: Vec<ControllerRow>,
}

/// One controller's experiments.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ControllerRow {
    /// Its name.
    pub controller: &'static str,
    /// Where it comes from.
    pub origin: Origin,
    /// L2 of the tracking error.
    pub l2: Summary,
    /// E, N·m·s.
    pub e: Summary,
    /// Table 4, for a row of it.
    pub paper: Option<Indices>,
    /// Means over Table 4.
    pub ratio: Option<Indices>,
    /// Largest torque of joints 2 and 3, N·m.
    pub peak_torque_nm: [Summary; 2],
    /// Size of the tracking error of joints 2 and 3 in the last cycle, degrees.
    pub final_error_deg: [Summary; 2],
    /// How far the base turned, degrees.
    pub base_drift_deg: Summary,
    /// The experiments themselves.
    pub experiments: Vec<ExperimentRow>,
}

/// One experiment.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ExperimentRow {
    /// How far joints 1 to 3 were from the nominal start, degrees.
    pub start_offset_deg: [f64; 3],
    /// L2 of the tracking error.
    pub l2: f64,
    /// E, N·m·s.
    pub e: f64,
    /// Largest torque of joints 2 and 3, N·m.
    pub peak_torque_nm: [f64; 2],
    /// Tracking error of joints 2 and 3 in the last cycle, degrees.
    pub final_error_deg: [f64; 2],
    /// How far the base turned, degrees.
    pub base_drift_deg: f64,
}

/// Runs the experiments. `done` is called after each.
///
/// Repetition k starts in the same place for every controller.
///
/// # Errors
/// If the robot file is wrong, or an experiment does not come to its end.
pub fn run(settings: &ComparisonSettings<'_>, done: impl Fn() + Sync) -> anyhow::Result<Comparison> {
    let entrants = Entrant::load(settings.contestants, settings.robot, &Overrides::default())?;
    let first = &entrants.first().context("no controller to compare")?.robot;
    let repetitions = settings.repetitions.get() as usize;
    let experiment = |job: usize| experiment(settings, &entrants[job / repetitions], (job % repetitions) as u64);
    let experiments = parallel::map(entrants.len() * repetitions, settings.threads, experiment, done)?;
    let controllers = (settings.contestants.iter().zip(experiments.chunks(repetitions)))
        .map(|(contestant, experiments)| ControllerRow::new(contestant, experiments))
        .collect::<Option<_>>()
        .context("no experiments")?;
    Ok(Comparison {
        robot: first.name.clone(),
        plant: plant_name(settings.plant),
        repetitions: settings.repetitions.get(),
        variation: settings.variation,
        seed: settings.seed,
        caveat: caveat(first, settings.plant),
        controllers,
    })
}

/// What must be said of numbers of this plant: something, if it was fitted to the paper's.
pub fn caveat(robot: &Robot, plant: PlantChoice) -> Option<&'static str> {
    (plant == PlantChoice::Uarm && robot.plant == UarmPlantParameters::fitted()).then_some(FITTED_PLANT_CAVEAT)
}

fn experiment(settings: &ComparisonSettings<'_>, entrant: &Entrant, repetition: u64) -> anyhow::Result<ExperimentRow> {
    let robot = &entrant.robot;
    let offset = settings.variation.offset(robot, settings.seed, repetition);
    let plant =
        EmbeddedPlant::new(robot, settings.plant, settings.disturbance)?.starting_at(embedded::start(robot) + offset);
    match trial::run(entrant, plant)? {
        Trial::Completed(outcome) => Ok(ExperimentRow::new(offset.into(), &outcome)),
        Trial::Failed(error) => {
            Err(error.context(format!("controller {}, experiment {}", entrant.contestant.name(), repetition + 1)))
        }
    }
}

impl ExperimentRow {
    fn new(offset: [f64; 3], outcome: &Outcome) -> Self {
        Self {
            start_offset_deg: offset.map(f64::to_degrees),
            l2: outcome.indices.l2,
            e: outcome.indices.e,
            peak_torque_nm: outcome.peak_torque,
            final_error_deg: outcome.final_error.map(f64::to_degrees),
            base_drift_deg: outcome.base_drift.to_degrees(),
        }
    }
}

impl ControllerRow {
    fn new(contestant: &Contestant, experiments: &[ExperimentRow]) -> Option<Self> {
        let summary =
            |value: &dyn Fn(&ExperimentRow) -> f64| Summary::of(&experiments.iter().map(value).collect::<Vec<_>>());
        let (l2, e) = (summary(&|row| row.l2)?, summary(&|row| row.e)?);
        let paper = table_4(contestant);
        Some(Self {
            controller: contestant.name(),
            origin: contestant.origin(),
            l2,
            e,
            paper,
            ratio: paper.map(|paper| Indices { l2: l2.mean / paper.l2, e: e.mean / paper.e }),
            peak_torque_nm: [summary(&|row| row.peak_torque_nm[0])?, summary(&|row| row.peak_torque_nm[1])?],
            final_error_deg: [
                summary(&|row| row.final_error_deg[0].abs())?,
                summary(&|row| row.final_error_deg[1].abs())?,
            ],
            base_drift_deg: summary(&|row| row.base_drift_deg)?,
            experiments: experiments.to_vec(),
        })
    }
}

/// Table 4, for the paper's six alone: another form of a law is not what the paper measured.
fn table_4(contestant: &Contestant) -> Option<Indices> {
    let law: Law = contestant.law();
    (contestant.origin() == Origin::Paper).then(|| Indices::published(law)).flatten()
}
