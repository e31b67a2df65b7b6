//! Each controller on many plants drawn around one: does an order hold when the robot is another?

use std::num::{NonZeroU32, NonZeroUsize};
use std::time::Duration;

use anyhow::Context;
use hinf_control::Disturbance;
use serde::Serialize;
use uarm_sim::IntegrationStep;

use super::caveat::caveat;
use super::draws::{Draw, DrawnPlant, Draws, StudyHeader};
use super::experiments::experiment as run_experiment;
use super::statistics::Quantiles;
use super::variant::{ControllerVariant, Origin, RobotFiles, VariantRobot};
use crate::commands::run::SimulatedEnd;
use crate::error_text::with_causes;
use crate::robot::Robot;
use crate::robot::overrides::Overrides;
use crate::simulated_plant::{self, PlantChoice, SimulatedPlant};
use crate::study::parallel::in_parallel;
use crate::study::random::{Stream, Subject};
use crate::study::shard::Shard;
use crate::study::spread::Spread;
use crate::study::start::StartVariation;
use crate::version::VERSION;
use uarm_loop::choice::Choice;
use uarm_loop::outcome::Indices;

/// How finely the plants are integrated. The error stays far below a count of the encoders: as a rule the loop sees the same
/// counts as with the default step, and L2 and E are the same to the bit; `tests/compare.rs` looks.
pub const INTEGRATION_STEP: IntegrationStep = IntegrationStep::COARSE;

/// What is drawn, and how.
#[derive(Clone, Copy, Debug)]
pub struct MonteCarloSettings<'a> {
    /// What describes the robot.
    pub files: RobotFiles<'a>,
    /// The controller variants that are compared.
    pub variants: &'a [ControllerVariant],
    /// What disturbs the joints.
    pub disturbance: Disturbance,
    /// The number of plants drawn.
    pub draws: NonZeroU32,
    /// How far they are from the robot file's.
    pub spread: Spread,
    /// How the starts differ.
    pub variation: StartVariation,
    /// What plants and starts are drawn from.
    pub seed: u64,
    /// How many plants are worked on at a time.
    pub threads: NonZeroUsize,
}

/// What came of it: of all draws, or of a part of them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MonteCarlo {
    /// The robot's name.
    pub robot: String,
    /// The number of plants of the whole study.
    pub draws: u32,
    /// The number of plants that these numbers are of.
    pub drawn: usize,
    /// How far each parameter was from the robot file's at most, as a share of it.
    pub spread: f64,
    /// How the starts differed.
    pub variation: StartVariation,
    /// What plants and starts were drawn from.
    pub seed: u64,
    /// The plants' integration step, µs.
    pub integration_step_us: u64,
    /// CRC-32 of the trained sets of the fuzzy laws; none where they are untrained.
    pub fuzzy_sets_crc32: Option<u32>,
    /// What must be said beside these numbers.
    pub caveat: Option<String>,
    /// The controllers, in the order asked for.
    pub controllers: Vec<MonteCarloRow>,
}

/// One controller on all plants.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MonteCarloRow {
    /// The name of the controller variant.
    pub controller: &'static str,
    /// Where it comes from.
    pub origin: Origin,
    /// L2 of the tracking error in the completed experiments.
    pub l2: Option<Quantiles>,
    /// E in the completed experiments, N·m·s.
    pub e: Option<Quantiles>,
    /// On how many plants it had the smallest L2.
    pub best_l2: u32,
    /// On how many plants it had the largest L2, or did not complete.
    pub worst_l2: u32,
    /// On how many plants it did not complete.
    pub failed: u32,
}

/// Draws the plants of a part of the study and runs the experiments on them. `done` is called after each plant.
///
/// # Errors
/// If the robot file is wrong, or an experiment cannot be begun. One that the robot's limits end is counted.
pub fn run(settings: &MonteCarloSettings<'_>, shard: Shard, done: impl Fn() + Sync) -> anyhow::Result<Draws> {
    let robots = load(settings)?;
    let robot = &robots.first().context("no controller to compare")?.robot;
    let numbers: Vec<u64> = shard.of(settings.draws.get().into()).collect();
    let work = |index: usize| draw(settings, &robots, numbers[index]);
    let results = in_parallel(numbers.len(), settings.threads, work, done)?;
    Ok(Draws { header: header(settings, robot), results })
}

/// What the draws of a study on `robot` are of.
fn header(settings: &MonteCarloSettings<'_>, robot: &Robot) -> StudyHeader {
    StudyHeader {
        uarm: VERSION.to_owned(),
        robot: robot.description.name.clone(),
        robot_crc32: crc32fast::hash(robot.source.as_bytes()),
        fuzzy_sets_crc32: robot.fuzzy_sets_crc32(),
        draws: settings.draws.get(),
        spread: settings.spread.share(),
        variation: settings.variation,
        disturbance: settings.disturbance.name().to_owned(),
        seed: settings.seed,
        integration_step_us: INTEGRATION_STEP.duration().as_micros().try_into().unwrap_or(u64::MAX),
        caveat: caveat(robot, PlantChoice::Uarm).map(ToOwned::to_owned),
        controllers: settings.variants.iter().map(|variant| variant.name().to_owned()).collect(),
    }
}

/// The variants with the robot file's robot. It does not hold the end of the motion: L2 and E are over by then.
///
/// # Errors
/// If the robot file is wrong.
pub fn load(settings: &MonteCarloSettings<'_>) -> anyhow::Result<Vec<VariantRobot>> {
    let overrides = Overrides { hold: Some(Duration::ZERO), ..Overrides::default() };
    Ok(VariantRobot::load(settings.variants, settings.files, &overrides)?)
}

/// Draws plant number `index` and runs each controller on it, from the same start.
///
/// # Errors
/// If an experiment cannot be begun.
pub fn draw(settings: &MonteCarloSettings<'_>, robots: &[VariantRobot], index: u64) -> anyhow::Result<Draw> {
    let robot = &robots.first().context("no controller to compare")?.robot;
    let plant = settings.spread.draw(&robot.plant.uarm, &mut Stream::new(settings.seed, Subject::Plant, index))?;
    let offset = settings.variation.offset(robot, settings.seed, index);
    let mut indices = Vec::with_capacity(robots.len());
    for variant in robots {
        let plant = SimulatedPlant::uarm(&variant.robot, plant, settings.disturbance)?
            .starting_at(simulated_plant::start(&variant.robot) + offset)
            .with_integration_step(INTEGRATION_STEP);
        indices.push(match run_experiment(variant, plant)? {
            SimulatedEnd::Completed(outcome) => Ok(outcome.indices),
            SimulatedEnd::Failed(error) => Err(with_causes(&error)),
        });
    }
    Ok(Draw { draw: index + 1, plant: DrawnPlant::from(&plant), start_offset: offset.into(), indices })
}

impl MonteCarlo {
    /// The study of `draws`.
    ///
    /// # Errors
    /// If this version does not know one of the controllers.
    pub fn new(draws: &Draws) -> anyhow::Result<Self> {
        let Draws { header, results } = draws;
        let row = |(number, name): (usize, &String)| {
            let variant = ControllerVariant::from_name(name).with_context(|| format!("no controller {name:?}"))?;
            Ok(MonteCarloRow::new(number, &variant, results))
        };
        Ok(Self {
            robot: header.robot.clone(),
            draws: header.draws,
            drawn: results.len(),
            spread: header.spread,
            variation: header.variation,
            seed: header.seed,
            integration_step_us: header.integration_step_us,
            fuzzy_sets_crc32: header.fuzzy_sets_crc32,
            caveat: header.caveat.clone(),
            controllers: header.controllers.iter().enumerate().map(row).collect::<anyhow::Result<_>>()?,
        })
    }
}

impl MonteCarloRow {
    /// The row of controller `number` of each draw.
    fn new(number: usize, variant: &ControllerVariant, draws: &[Draw]) -> Self {
        let completed: Vec<Indices> = draws.iter().filter_map(|draw| draw.completed(number)).collect();
        let quantiles = |index: fn(&Indices) -> f64| Quantiles::of(&completed.iter().map(index).collect::<Vec<_>>());
        let count = |holds: &dyn Fn(&Draw) -> bool| draws.iter().map(|draw| u32::from(holds(draw))).sum();
        Self {
            controller: variant.name(),
            origin: variant.origin(),
            l2: quantiles(|indices| indices.l2),
            e: quantiles(|indices| indices.e),
            best_l2: count(&|draw| draw.l2(number).is_finite() && draw.l2(number) == draw.extreme(f64::min)),
            worst_l2: count(&|draw| draw.l2(number) == draw.extreme(f64::max)),
            failed: count(&|draw| !draw.l2(number).is_finite()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use uarm_sim::UarmPlantParameters;

    fn draw(l2: [Option<f64>; 3]) -> Draw {
        let indices = |l2: Option<f64>| l2.map(|l2| Indices { l2, e: 10.0 * l2 }).ok_or_else(|| "a limit".to_owned());
        let indices = l2.map(indices).to_vec();
        Draw { draw: 1, plant: DrawnPlant::from(&UarmPlantParameters::fitted()), start_offset: [0.0; 3], indices }
    }

    #[test]
    fn ranks_and_failures_are_counted() {
        let draws = [
            draw([Some(1.0), Some(2.0), Some(3.0)]),
            draw([Some(4.0), Some(2.0), None]),
            draw([Some(1.0), None, None]),
            draw([None, None, None]),
        ];
        let row = |number| MonteCarloRow::new(number, &ControllerVariant::paper().nth(number).unwrap(), &draws);
        let counts = |number| (row(number).best_l2, row(number).worst_l2, row(number).failed);
        assert_eq!(counts(0), (2, 1, 1));
        assert_eq!(counts(1), (1, 2, 2));
        assert_eq!(counts(2), (0, 4, 3));
        assert_eq!(row(0).l2.map(|quantiles| quantiles.q50), Some(1.0));
        approx::assert_relative_eq!(row(0).e.unwrap().q95, 37.0, max_relative = 1e-14);
    }
}
