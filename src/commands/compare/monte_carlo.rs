//! Each controller on many plants drawn around one: does an order hold when the robot is another?

use std::num::{NonZeroU32, NonZeroUsize};
use std::path::Path;
use std::time::Duration;

use anyhow::Context;
use hinf_control::Disturbance;
use serde::Serialize;
use uarm_sim::{IntegrationStep, UarmPlantParameters};

use super::caveat::caveat;
use super::experiments::experiment as run_experiment;
use super::statistics::Quantiles;
use super::variant::{ControllerVariant, Origin, VariantRobot};
use crate::error_text::with_causes;
use crate::robot::overrides::Overrides;
use crate::simulated_robot::{self, PlantChoice, SimulatedPlant};
use crate::simulation::SimulatedEnd;
use crate::study::parallel::in_parallel;
use crate::study::random::{Stream, Subject};
use crate::study::spread::Spread;
use crate::study::start::StartVariation;
use uarm_loop::outcome::Indices;

/// How finely the plants are integrated. The error stays far below a count of the encoders: as a rule the loop sees the same
/// counts as with the default step, and L2 and E are the same to the bit; `tests/compare.rs` looks.
pub const INTEGRATION_STEP: IntegrationStep = IntegrationStep::COARSE;

/// What is drawn, and how.
#[derive(Clone, Copy, Debug)]
pub struct MonteCarloSettings<'a> {
    /// The robot file; without it the paper's UARM.
    pub robot: Option<&'a Path>,
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

/// What came of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MonteCarlo {
    /// The robot's name.
    pub robot: String,
    /// The number of plants drawn.
    pub draws: u32,
    /// How far each parameter was from the robot file's at most, as a share of it.
    pub spread: f64,
    /// How the starts differed.
    pub variation: StartVariation,
    /// What plants and starts were drawn from.
    pub seed: u64,
    /// The plants' integration step, µs.
    pub integration_step_us: u128,
    /// What must be said beside these numbers.
    pub caveat: Option<&'static str>,
    /// The controllers, in the order asked for.
    pub controllers: Vec<MonteCarloRow>,
    /// The draws themselves: for the CSV file.
    #[serde(skip)]
    pub experiments: Vec<Draw>,
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

/// One plant, and how each controller did on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Draw {
    /// The plant that was drawn.
    pub plant: UarmPlantParameters,
    /// How far joints 1 to 3 were from the nominal start, rad.
    pub start_offset: [f64; 3],
    /// L2 and E of each controller, or why the experiment did not come to its end.
    pub indices: Vec<Result<Indices, String>>,
}

/// Draws the plants and runs the experiments. `done` is called after each plant.
///
/// # Errors
/// If the robot file is wrong, or an experiment cannot be begun. One that the robot's limits end is counted.
pub fn run(settings: &MonteCarloSettings<'_>, done: impl Fn() + Sync) -> anyhow::Result<MonteCarlo> {
    let robots = load(settings)?;
    let first = &robots.first().context("no controller to compare")?.robot;
    let work = |index: usize| draw(settings, &robots, index as u64);
    let experiments = in_parallel(settings.draws.get() as usize, settings.threads, work, done)?;
    let row = |(number, variant): (usize, &ControllerVariant)| MonteCarloRow::new(number, variant, &experiments);
    Ok(MonteCarlo {
        robot: first.description.name.clone(),
        draws: settings.draws.get(),
        spread: settings.spread.share(),
        variation: settings.variation,
        seed: settings.seed,
        integration_step_us: INTEGRATION_STEP.duration().as_micros(),
        caveat: caveat(first, PlantChoice::Uarm),
        controllers: settings.variants.iter().enumerate().map(row).collect(),
        experiments,
    })
}

/// The variants with the robot file's robot. It does not hold the end of the motion: L2 and E are over by then.
///
/// # Errors
/// If the robot file is wrong.
pub fn load(settings: &MonteCarloSettings<'_>) -> anyhow::Result<Vec<VariantRobot>> {
    let overrides = Overrides { hold: Some(Duration::ZERO), ..Overrides::default() };
    Ok(VariantRobot::load(settings.variants, settings.robot, &overrides)?)
}

/// Draws plant number `index` and runs each controller on it, from the same start.
///
/// # Errors
/// If an experiment cannot be begun.
pub fn draw(settings: &MonteCarloSettings<'_>, robots: &[VariantRobot], index: u64) -> anyhow::Result<Draw> {
    let robot = &robots.first().context("no controller to compare")?.robot;
    let plant = settings.spread.draw(&robot.plant, &mut Stream::new(settings.seed, Subject::Plant, index))?;
    let offset = settings.variation.offset(robot, settings.seed, index);
    let mut indices = Vec::with_capacity(robots.len());
    for variant in robots {
        let plant = SimulatedPlant::uarm(&variant.robot, plant, settings.disturbance)?
            .starting_at(simulated_robot::start(&variant.robot) + offset)
            .with_integration_step(INTEGRATION_STEP);
        indices.push(match run_experiment(variant, plant)? {
            SimulatedEnd::Completed(outcome) => Ok(outcome.indices),
            SimulatedEnd::Failed(error) => Err(with_causes(&error)),
        });
    }
    Ok(Draw { plant, start_offset: offset.into(), indices })
}

impl Draw {
    fn completed(&self, number: usize) -> Option<Indices> {
        self.indices.get(number)?.as_ref().ok().copied()
    }

    /// L2 of controller `number`: beyond all others if it did not complete.
    fn l2(&self, number: usize) -> f64 {
        self.completed(number).map_or(f64::INFINITY, |indices| indices.l2)
    }

    fn extreme(&self, pick: fn(f64, f64) -> f64) -> f64 {
        (0..self.indices.len()).map(|number| self.l2(number)).reduce(pick).unwrap_or(f64::NAN)
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

    fn draw(l2: [Option<f64>; 3]) -> Draw {
        let indices = |l2: Option<f64>| l2.map(|l2| Indices { l2, e: 10.0 * l2 }).ok_or_else(|| "a limit".to_owned());
        let indices = l2.map(indices).to_vec();
        Draw { plant: UarmPlantParameters::fitted(), start_offset: [0.0; 3], indices }
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
