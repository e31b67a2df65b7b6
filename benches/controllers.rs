//! How long one control step of each law takes: state in, torque out, Φ stepped.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use dem_model::ThreeLinkDem;
use hinf_control::{
    AnyController, BaseAcceleration, BaseMeasurement, Controller, ControllerOptions, Law, Measurement, NominalForm,
    QuinticReference, WeightReading, Weights,
};
use nalgebra::Vector2;

/// A robot a little off its way in the middle of the paper's task.
fn measurement() -> Measurement<f64> {
    Measurement {
        position: Vector2::new(0.86, 0.71),
        velocity: Vector2::new(0.63, 0.45),
        base: BaseMeasurement { position: -0.4, velocity: -0.5, acceleration: 0.1 },
    }
}

fn step(criterion: &mut Criterion, name: &str, law: Law, options: &ControllerOptions<'_, f64>) {
    let weights = Weights::table_3(law, WeightReading::Blocks);
    let mut controller =
        AnyController::new(law, ThreeLinkDem::table_2(), &weights, options).expect("the paper's design");
    let (measurement, reference) = (measurement(), QuinticReference::paper().at(1.5));
    criterion.bench_with_input(BenchmarkId::new("control step", name), &(), |bencher, ()| {
        // A period of zero keeps Φ where it is, so that every step is the same work on the same numbers.
        bencher.iter(|| controller.update(black_box(&measurement), black_box(&reference), black_box(0.0)));
    });
}

fn every_law(criterion: &mut Criterion) {
    for law in Law::ALL {
        step(criterion, law.name(), law, &ControllerOptions::paper(law));
    }
}

fn our_forms(criterion: &mut Criterion) {
    for (name, base_acceleration) in [
        ("nonlinear omitted", BaseAcceleration::Omitted),
        ("nonlinear reduced", BaseAcceleration::Reduced),
        ("nonlinear reduced-momentum", BaseAcceleration::ReducedMomentum),
    ] {
        let options = ControllerOptions { base_acceleration, ..ControllerOptions::paper(Law::Nonlinear) };
        step(criterion, name, Law::Nonlinear, &options);
    }
    for law in [Law::NeuralModel, Law::FuzzyModel] {
        let options = ControllerOptions { nominal_form: NominalForm::Reduced, ..ControllerOptions::paper(law) };
        step(criterion, &format!("{} reduced", law.name()), law, &options);
    }
}

criterion_group!(benches, every_law, our_forms);
criterion_main!(benches);
