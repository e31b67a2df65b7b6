//! Whole experiments in virtual time: the loop, the drives and the plant, 3 s of motion each.

use std::hint::black_box;
use std::num::{NonZeroU32, NonZeroUsize};

use criterion::{Criterion, criterion_group, criterion_main};
use hinf_control::Disturbance;
use uarm::commands::compare::experiments::experiment;
use uarm::commands::compare::monte_carlo::{self, MonteCarloSettings};
use uarm::commands::compare::variant::{ControllerVariant, RobotFiles, VariantRobot};
use uarm::robot::overrides::Overrides;
use uarm::simulated_plant::PlantChoice;
use uarm::simulated_plant::SimulatedPlant;
use uarm::study::spread::Spread;
use uarm::study::start::StartVariation;

/// `uarm run --virtual-time`, with 0.5 s of hold, for each of the paper's controllers.
fn virtual_time(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("experiment/virtual time");
    group.sample_size(20);
    for variant in VariantRobot::<3, 2>::load(
        &ControllerVariant::paper().collect::<Vec<_>>(),
        RobotFiles::default(),
        &Overrides::default(),
    )
    .expect("the built-in robot")
    {
        group.bench_function(variant.variant.name(), |bencher| {
            bencher.iter(|| {
                let plant = SimulatedPlant::new(&variant.robot, PlantChoice::Uarm, Disturbance::Paper);
                experiment(black_box(&variant), plant.expect("the built-in plant"))
            });
        });
    }
    group.finish();
}

/// One plant of `uarm compare --monte-carlo`, met by the paper's six.
fn one_draw(criterion: &mut Criterion) {
    let settings = MonteCarloSettings {
        files: RobotFiles::default(),
        variants: &ControllerVariant::paper().collect::<Vec<_>>(),
        disturbance: Disturbance::Paper,
        draws: NonZeroU32::MIN,
        spread: Spread::new(0.2).expect("below 1"),
        variation: StartVariation::Full,
        seed: 1,
        threads: NonZeroUsize::MIN,
    };
    let robots = monte_carlo::load(&settings).expect("the built-in robot");
    let mut group = criterion.benchmark_group("experiment/Monte Carlo");
    group.sample_size(20);
    group.bench_function("one draw, six controllers", |bencher| {
        bencher.iter(|| monte_carlo::draw(black_box(&settings), &robots, 0));
    });
    group.finish();
}

criterion_group!(benches, virtual_time, one_draw);
criterion_main!(benches);
