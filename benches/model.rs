//! The model's cost per state: M and C, forward dynamics, partition, regressor and reduced dynamics.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use dem_model::PlanarSpaceManipulator;
use dem_model::{Scalar, ThreeLinkDem, regressor};
use nalgebra::{Vector2, Vector3};

/// A state within the paper's motion, in rad and rad/s, and torques in N·m.
fn state<T: Scalar>() -> [Vector3<T>; 3] {
    [[0.1, 0.9, 0.6], [-0.3, 0.5, 0.3], [0.0, 0.06, 0.02]].map(|values| Vector3::from(values.map(T::constant)))
}

fn closed_form<T: Scalar>(criterion: &mut Criterion, number: &str) {
    let dem = ThreeLinkDem::<T>::table_2();
    let [q, rate, force] = state::<T>();
    let joint_rate = Vector2::new(rate.y, rate.z);
    let mut group = criterion.benchmark_group(format!("model/{number}"));
    group.bench_function("mass and coriolis", |bencher| {
        bencher.iter(|| (dem.mass_matrix(black_box(&q)), dem.coriolis_matrix(black_box(&q), black_box(&rate))));
    });
    group.bench_function("forward dynamics", |bencher| {
        bencher.iter(|| dem.forward_dynamics(black_box(&q), black_box(&rate), black_box(&force)));
    });
    group.bench_function("partition", |bencher| {
        bencher.iter(|| dem.partition(black_box(&q), black_box(&rate)));
    });
    group.bench_function("regressor", |bencher| {
        bencher.iter(|| regressor(black_box(q.z), black_box(&joint_rate), black_box(&joint_rate), &joint_rate));
    });
    group.bench_function("reduced dynamics", |bencher| {
        bencher.iter(|| dem.reduced(black_box(&q), black_box(&joint_rate)));
    });
    group.finish();
}

fn jacobian_sums(criterion: &mut Criterion) {
    let dem = PlanarSpaceManipulator::<f64, 2>::table_1().dynamically_equivalent();
    let [q, rate, _] = state::<f64>();
    criterion.bench_function("model/f64/mass and coriolis by Jacobian sums", |bencher| {
        bencher.iter(|| (dem.mass_matrix(black_box(&q)), dem.coriolis_matrix(black_box(&q), black_box(&rate))));
    });
}

fn benches(criterion: &mut Criterion) {
    closed_form::<f64>(criterion, "f64");
    closed_form::<f32>(criterion, "f32");
    jacobian_sums(criterion);
}

criterion_group!(model, benches);
criterion_main!(model);
