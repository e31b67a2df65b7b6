//! What one period of the paper, 3 ms in steps of 100 µs, costs on each plant.

use criterion::{Criterion, criterion_group, criterion_main};
use dem_model::PlanarSpaceManipulator;
use dem_model::ThreeLinkDem;
use hinf_control::Disturbance;
use nalgebra::Vector3;
use std::hint::black_box;
use std::time::Duration;
use uarm_sim::{Brake, DemPlant, FreeFloatingPlant, Plant, UarmPlant, UarmPlantParameters};

const PERIOD: Duration = Duration::from_millis(3);

/// One period from where the disturbance starts, always from the same state.
fn period<P: Plant + Clone>(criterion: &mut Criterion, name: &str, mut plant: P) {
    plant.advance(Disturbance::PAPER_ONSET, &Vector3::new(0.0, 0.01, 0.005), [Brake::Released; 3]);
    criterion.bench_function(name, |bencher| {
        bencher.iter_batched_ref(
            || plant.clone(),
            |plant| {
                let until = plant.time() + PERIOD;
                plant.advance(until, black_box(&Vector3::new(0.0, 0.02, -0.01)), [Brake::Released; 3]);
            },
            criterion::BatchSize::SmallInput,
        );
    });
}

fn plants(criterion: &mut Criterion) {
    let nominal = ThreeLinkDem::table_2();
    period(criterion, "plant/ideal/3ms", DemPlant::new(nominal).with_disturbance(Disturbance::Paper));
    match UarmPlant::new(&nominal, UarmPlantParameters::fitted()) {
        Ok(plant) => period(criterion, "plant/uarm/3ms", plant.with_disturbance(Disturbance::Paper)),
        Err(error) => panic!("the fitted plant is refused: {error}"),
    }
    let space = FreeFloatingPlant::new(&PlanarSpaceManipulator::table_1());
    period(criterion, "plant/space/3ms", space.with_disturbance(Disturbance::Paper));
}

criterion_group!(benches, plants);
criterion_main!(benches);
