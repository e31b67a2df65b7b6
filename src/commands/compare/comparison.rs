//! The paper's table with its spread: each controller, some repetitions, one plant.

use std::num::{NonZeroU32, NonZeroUsize};

use anyhow::Context;
use hinf_control::Disturbance;
use serde::Serialize;

use super::caveat::caveat;
use super::experiments::experiment as run_experiment;
use super::statistics::Summary;
use super::variant::{ControllerVariant, Origin, RobotFiles, VariantRobot};
use crate::dimensions::Outcome;
use crate::error_text::with_causes;
use crate::robot::Robot;
use crate::robot::overrides::Overrides;
use crate::simulated_robot::{self, PlantChoice, SimulatedPlant};
use crate::simulation::SimulatedEnd;
use crate::study::parallel::in_parallel;
use crate::study::start::StartVariation;
use uarm_loop::outcome::Indices;

/// What is compared, and how.
#[derive(Clone, Copy, Debug)]
pub struct ComparisonSettings<'a> {
    /// What describes the robot.
    pub files: RobotFiles<'a>,
    /// The controller variants that are compared.
    pub variants: &'a [ControllerVariant],
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
    /// The plant that moved.
    pub plant: &'static str,
    /// Experiments for each controller.
    pub repetitions: u32,
    /// What differed between them.
    pub variation: StartVariation,
    /// What it was drawn from.
    pub seed: u64,
    /// CRC-32 of the trained sets of the fuzzy laws; none where they are untrained.
    pub fuzzy_sets_crc32: Option<u32>,
    /// What must be said beside these numbers.
    pub caveat: Option<&'static str>,
    /// The controllers, in the order asked for, each with what it completed; without those that completed nothing.
    pub controllers: Vec<ControllerRow>,
    /// The experiments that did not come to their end.
    pub failures: Vec<Failure>,
}

/// An experiment that did not come to its end.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Failure {
    /// The name of the controller variant.
    pub controller: &'static str,
    /// Where it comes from.
    pub origin: Origin,
    /// The number of the experiment, counted from 1.
    pub experiment: u64,
    /// Which joint did what.
    pub reason: String,
}

/// One controller's experiments.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ControllerRow {
    /// The name of the controller variant.
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

/// The result of one experiment.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ExperimentRow {
    /// The number of the experiment, counted from 1.
    pub experiment: u64,
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
/// If the robot file is wrong, or an experiment cannot be begun. One that does not come to its end is listed.
pub fn run(settings: &ComparisonSettings<'_>, done: impl Fn() + Sync) -> anyhow::Result<Comparison> {
    let robots = VariantRobot::load(settings.variants, settings.files, &Overrides::default())?;
    let first = &robots.first().context("no controller to compare")?.robot;
    let repetitions = settings.repetitions.get() as usize;
    let experiment = |job: usize| experiment(settings, &robots[job / repetitions], (job % repetitions) as u64);
    let experiments = in_parallel(robots.len() * repetitions, settings.threads, experiment, done)?;
    let row = |(variant, experiments): (&ControllerVariant, &[Result<ExperimentRow, Failure>])| {
        let completed: Vec<_> = experiments.iter().filter_map(|one| one.as_ref().ok().copied()).collect();
        ControllerRow::new(variant, first, &completed)
    };
    let controllers = settings.variants.iter().zip(experiments.chunks(repetitions)).filter_map(row).collect();
    let failures = experiments.into_iter().filter_map(Result::err).collect();
    Ok(Comparison {
        robot: first.description.name.clone(),
        plant: settings.plant.label(),
        repetitions: settings.repetitions.get(),
        variation: settings.variation,
        seed: settings.seed,
        fuzzy_sets_crc32: first.fuzzy_sets_crc32(),
        caveat: caveat(first, settings.plant),
        controllers,
        failures,
    })
}

fn experiment(
    settings: &ComparisonSettings<'_>,
    variant: &VariantRobot,
    repetition: u64,
) -> anyhow::Result<Result<ExperimentRow, Failure>> {
    let robot = &variant.robot;
    let offset = settings.variation.offset(robot, settings.seed, repetition);
    let plant = SimulatedPlant::new(robot, settings.plant, settings.disturbance)?
        .starting_at(simulated_robot::start(robot) + offset);
    let number = repetition + 1;
    Ok(match run_experiment(variant, plant)? {
        SimulatedEnd::Completed(outcome) => Ok(ExperimentRow::new(number, offset.into(), &outcome)),
        SimulatedEnd::Failed(error) => Err(Failure {
            controller: variant.variant.name(),
            origin: variant.variant.origin(),
            experiment: number,
            reason: with_causes(&error),
        }),
    })
}

impl ExperimentRow {
    fn new(experiment: u64, offset: [f64; 3], outcome: &Outcome) -> Self {
        Self {
            experiment,
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
    fn new(variant: &ControllerVariant, robot: &Robot, experiments: &[ExperimentRow]) -> Option<Self> {
        let summary =
            |value: &dyn Fn(&ExperimentRow) -> f64| Summary::of(&experiments.iter().map(value).collect::<Vec<_>>());
        let (l2, e) = (summary(&|row| row.l2)?, summary(&|row| row.e)?);
        let paper = table_4(variant, robot);
        Some(Self {
            controller: variant.name(),
            origin: variant.origin(),
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

/// Table 4, for the paper's six on the paper's robot alone: another form of a law, or another robot, is not what the paper
/// measured.
fn table_4(variant: &ControllerVariant, robot: &Robot) -> Option<Indices> {
    (variant.origin() == Origin::Paper && robot.is_the_papers()).then(|| Indices::published(variant.law())).flatten()
}
