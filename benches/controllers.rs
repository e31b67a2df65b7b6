//! How long one control step of each law takes: state in, torque out, Φ stepped.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use dem_model::ThreeLinkDem;
use hinf_control::{BaseMeasurement, BuildContext, Controller, ControllerSettings, Law, Measurement, QuinticReference};
use nalgebra::Vector2;

/// A robot a little off its way in the middle of the paper's task.
fn measurement() -> Measurement<f64> {
    Measurement {
        position: Vector2::new(0.86, 0.71),
        velocity: Vector2::new(0.63, 0.45),
        base: BaseMeasurement::planar(-0.5, 0.1),
    }
}

fn step(criterion: &mut Criterion, name: &str, law: Law, settings: &ControllerSettings) {
    let context = BuildContext::new(ThreeLinkDem::table_2());
    let mut controller = settings.build(law, &context).expect("the paper's design");
    let (measurement, reference) = (measurement(), QuinticReference::paper().at(1.5));
    criterion.bench_with_input(BenchmarkId::new("control step", name), &(), |bencher, ()| {
        // A period of zero keeps Φ where it is, so that every step is the same work on the same numbers.
        bencher.iter(|| controller.update(black_box(&measurement), black_box(&reference), black_box(0.0)));
    });
}

fn every_law(criterion: &mut Criterion) {
    for law in Law::ALL {
        let settings = ControllerSettings::default();
        step(criterion, law.name(), law, &settings);
        for variant in law.variants() {
            let mut settings = settings;
            settings.set_base_acceleration(law, variant.base_acceleration).expect("a variant of this law");
            step(criterion, variant.name, law, &settings);
        }
    }
}

criterion_group!(benches, every_law);
criterion_main!(benches);
