//! The paper's table with its spread: each controller, some repetitions, one plant.

use std::num::{NonZeroU32, NonZeroUsize};
use std::ops::RangeInclusive;

use anyhow::Context;
use hinf_control::Disturbance;
use nalgebra::SVector;
use serde::Serialize;

use super::caveat::caveat;
use super::experiments::experiment as run_experiment;
use super::statistics::Summary;
use super::variant::{ControllerVariant, Origin, RobotFiles, UNSENSED, VariantRobot};
use crate::commands::run::SimulatedEnd;
use crate::dimensions::Outcome;
use crate::error_text::with_causes;
use crate::robot::Robot;
use crate::robot::overrides::Overrides;
use crate::simulated_plant::{self, PlantChoice, SimulatedPlant, usual_disturbance};
use crate::study::parallel::in_parallel;
use crate::study::start::StartVariation;
use uarm_loop::dimensions;
use uarm_loop::outcome::Indices;

/// What is compared, and how.
#[derive(Clone, Copy, Debug)]
pub struct ComparisonSettings<'a> {
    /// What describes the robot.
    pub files: RobotFiles<'a>,
    /// The controller variants that are compared.
    pub variants: &'a [ControllerVariant],
    /// Those that the robot lacks a sensor for.
    pub left_out: &'a [ControllerVariant],
    /// What the robot is, if not what it is by default.
    pub plant: Option<PlantChoice>,
    /// What disturbs its joints, if not what does by default.
    pub disturbance: Option<Disturbance>,
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
    /// Its joints with drives, a passive base included.
    pub joints: usize,
    /// Those with a motor, the last of them.
    pub active_joints: usize,
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
    /// Controllers that the robot lacks a sensor for, and why.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<LeftOut>,
    /// The controllers, in the order asked for, each with what it completed; without those that completed nothing.
    pub controllers: Vec<ControllerRow>,
    /// The experiments that did not come to their end.
    pub failures: Vec<Failure>,
}

/// A controller that was not tried.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// The name of the controller variant.
    pub controller: &'static str,
    /// What the robot lacks.
    pub reason: &'static str,
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
    /// Largest torque of each active joint, N·m.
    pub peak_torque_nm: Vec<Summary>,
    /// Size of the tracking error of each active joint in the last cycle, degrees.
    pub final_error_deg: Vec<Summary>,
    /// How far the base turned, degrees; nothing where no encoder is on it.
    pub base_drift_deg: Option<Summary>,
    /// The experiments themselves.
    pub experiments: Vec<ExperimentRow>,
}

/// The result of one experiment.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ExperimentRow {
    /// The number of the experiment, counted from 1.
    pub experiment: u64,
    /// How far each joint was from the nominal start, degrees.
    pub start_offset_deg: Vec<f64>,
    /// L2 of the tracking error.
    pub l2: f64,
    /// E, N·m·s.
    pub e: f64,
    /// Largest torque of each active joint, N·m.
    pub peak_torque_nm: Vec<f64>,
    /// Tracking error of each active joint in the last cycle, degrees.
    pub final_error_deg: Vec<f64>,
    /// How far the base turned, degrees; nothing where no encoder is on it.
    pub base_drift_deg: Option<f64>,
}

impl Comparison {
    /// The numbers of the joints with a motor, counted from 1.
    pub const fn active_numbers(&self) -> RangeInclusive<usize> {
        self.joints - self.active_joints + 1..=self.joints
    }

    /// Is an encoder on the base?
    pub const fn has_base(&self) -> bool {
        self.joints > self.active_joints
    }
}

/// Runs the experiments. `done` is called after each.
///
/// Repetition k starts in the same place for every controller.
///
/// # Errors
/// If the robot file is wrong, or an experiment cannot be begun. One that does not come to its end is listed.
pub fn run<const J: usize, const N: usize>(
    settings: &ComparisonSettings<'_>,
    done: impl Fn() + Sync,
) -> anyhow::Result<Comparison> {
    let robots = VariantRobot::<J, N>::load(settings.variants, settings.files, &Overrides::default())?;
    let first = &robots.first().context("no controller to compare")?.robot;
    let plant = PlantChoice::asked(settings.plant, first)?;
    let disturbance = settings.disturbance.unwrap_or(usual_disturbance(first));
    let repetitions = settings.repetitions.get() as usize;
    let experiment = |job: usize| {
        let (variant, repetition) = (&robots[job / repetitions], (job % repetitions) as u64);
        let offset = settings.variation.offset(&variant.robot, settings.seed, repetition);
        let plant = SimulatedPlant::new(&variant.robot, plant, disturbance)?;
        experiment(variant, plant, repetition + 1, offset)
    };
    let experiments = in_parallel(robots.len() * repetitions, settings.threads, experiment, done)?;
    let row = |(variant, experiments): (&ControllerVariant, &[Result<ExperimentRow, Failure>])| {
        let completed = experiments.iter().filter_map(|one| one.as_ref().ok().cloned()).collect();
        ControllerRow::new(variant, table_4(variant, first), completed)
    };
    let controllers = settings.variants.iter().zip(experiments.chunks(repetitions)).filter_map(row).collect();
    let failures = experiments.into_iter().filter_map(Result::err).collect();
    Ok(Comparison {
        robot: first.description.name.clone(),
        joints: J,
        active_joints: N,
        plant: plant.label(),
        repetitions: settings.repetitions.get(),
        variation: settings.variation,
        seed: settings.seed,
        fuzzy_sets_crc32: first.fuzzy_sets_crc32(),
        caveat: caveat(first, plant),
        left_out: settings
            .left_out
            .iter()
            .map(|variant| LeftOut { controller: variant.name(), reason: UNSENSED })
            .collect(),
        controllers,
        failures,
    })
}

fn experiment<const J: usize, const N: usize>(
    variant: &VariantRobot<J, N>,
    plant: SimulatedPlant<N>,
    number: u64,
    offset: SVector<f64, J>,
) -> anyhow::Result<Result<ExperimentRow, Failure>> {
    let plant = plant.starting_at(simulated_plant::start(&variant.robot) + offset);
    Ok(match run_experiment(variant, plant)? {
        SimulatedEnd::Completed(outcome) => Ok(ExperimentRow::new(number, offset, &outcome)),
        SimulatedEnd::Failed(error) => Err(Failure {
            controller: variant.variant.name(),
            origin: variant.variant.origin(),
            experiment: number,
            reason: with_causes(&error),
        }),
    })
}

impl ExperimentRow {
    fn new<const J: usize, const N: usize>(experiment: u64, offset: SVector<f64, J>, outcome: &Outcome<N>) -> Self {
        let drift = outcome.base_drift.to_degrees();
        Self {
            experiment,
            start_offset_deg: offset.iter().map(|angle| angle.to_degrees()).collect(),
            l2: outcome.indices.l2,
            e: outcome.indices.e,
            peak_torque_nm: outcome.peak_torque.to_vec(),
            final_error_deg: outcome.final_error.map(f64::to_degrees).to_vec(),
            base_drift_deg: (dimensions::passive::<J, N>() > 0).then_some(drift),
        }
    }
}

impl ControllerRow {
    /// The row of what a variant completed; `None` if that is nothing.
    fn new(variant: &ControllerVariant, paper: Option<Indices>, experiments: Vec<ExperimentRow>) -> Option<Self> {
        let of = |value: &dyn Fn(&ExperimentRow) -> Option<f64>| {
            Summary::of(&experiments.iter().filter_map(value).collect::<Vec<_>>())
        };
        let joints = experiments.first()?.peak_torque_nm.len();
        let of_joints = |value: &dyn Fn(&ExperimentRow, usize) -> Option<f64>| {
            (0..joints).map(|joint| of(&|row| value(row, joint))).collect::<Option<Vec<_>>>()
        };
        let (l2, e) = (of(&|row| Some(row.l2))?, of(&|row| Some(row.e))?);
        Some(Self {
            controller: variant.name(),
            origin: variant.origin(),
            l2,
            e,
            paper,
            ratio: paper.map(|paper| Indices { l2: l2.mean / paper.l2, e: e.mean / paper.e }),
            peak_torque_nm: of_joints(&|row, joint| row.peak_torque_nm.get(joint).copied())?,
            final_error_deg: of_joints(&|row, joint| row.final_error_deg.get(joint).map(|error| error.abs()))?,
            base_drift_deg: of(&|row| row.base_drift_deg),
            experiments,
        })
    }
}

/// Table 4, for the paper's six on the paper's robot alone: another form of a law, or another robot, is not what the paper
/// measured.
fn table_4<const J: usize, const N: usize>(variant: &ControllerVariant, robot: &Robot<J, N>) -> Option<Indices> {
    (variant.origin() == Origin::Paper && robot.is_the_papers()).then(|| Indices::published(variant.law())).flatten()
}
