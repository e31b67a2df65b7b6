//! M and C three ways that share no code: closed form, sums over Jacobians, and the kinetic energy differentiated
//! automatically.

use crate::common::assert_close;
use crate::common::hyper_dual::HyperDual;
use crate::common::random::{angles, planar_dem, signals};
use dem_model::PlanarDem;
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;

/// Some tens of roundings of f64 of the greatest entry.
const TOLERANCE: f64 = 1e-14;

/// The kinetic energy, link by link, from the velocities of the centres of mass.
fn kinetic_energy(dem: &PlanarDem<f64, 2>, q: [HyperDual; 3], velocity: [HyperDual; 3]) -> HyperDual {
    let fixed = HyperDual::fixed;
    let mut energy = fixed(0.5 * dem.base().inertia) * velocity[0] * velocity[0];
    let (mut angle, mut turning) = (q[0], velocity[0]);
    let along = |length: f64, angle: HyperDual, turning: HyperDual| {
        let speed = fixed(length) * turning;
        (speed * angle.sin() * fixed(-1.0), speed * angle.cos())
    };
    let mut joint = along(dem.base().length, angle, turning);
    for (index, link) in dem.links().iter().enumerate() {
        angle = angle + q[index + 1];
        turning = turning + velocity[index + 1];
        let centre = along(link.centre_of_mass, angle, turning);
        let (x, y) = (joint.0 + centre.0, joint.1 + centre.1);
        energy = energy + fixed(0.5 * link.mass) * (x * x + y * y) + fixed(0.5 * link.inertia) * turning * turning;
        let tip = along(link.length, angle, turning);
        joint = (joint.0 + tip.0, joint.1 + tip.1);
    }
    energy
}

/// M_ij = ∂²T/∂q̇_i∂q̇_j.
fn mass_by_differentiation(dem: &PlanarDem<f64, 2>, q: &Vector3<f64>) -> Matrix3<f64> {
    let unit = |index: usize, chosen: usize| f64::from(u8::from(index == chosen));
    Matrix3::from_fn(|row, column| {
        let velocity = core::array::from_fn(|index| HyperDual::new(0.0, unit(index, row), unit(index, column)));
        kinetic_energy(dem, core::array::from_fn(|index| HyperDual::fixed(q[index])), velocity).mixed
    })
}

/// h = C q̇ by Lagrange: h_i = Σ_k ∂²T/∂q̇_i∂q_k q̇_k − ∂T/∂q_i.
fn bias_by_differentiation(dem: &PlanarDem<f64, 2>, q: &Vector3<f64>, velocity: &Vector3<f64>) -> Vector3<f64> {
    let unit = |index: usize, chosen: usize| f64::from(u8::from(index == chosen));
    Vector3::from_fn(|row, _| {
        let along_velocity = kinetic_energy(
            dem,
            core::array::from_fn(|index| HyperDual::new(q[index], 0.0, velocity[index])),
            core::array::from_fn(|index| HyperDual::new(velocity[index], unit(index, row), 0.0)),
        );
        let along_angle = kinetic_energy(
            dem,
            core::array::from_fn(|index| HyperDual::new(q[index], unit(index, row), 0.0)),
            core::array::from_fn(|index| HyperDual::fixed(velocity[index])),
        );
        along_velocity.mixed - along_angle.first
    })
}

/// The Christoffel C from h: it is the one matrix, linear in q̇, with C(q̇)v = C(v)q̇, so polarisation of h gives it.
fn coriolis_by_differentiation(dem: &PlanarDem<f64, 2>, q: &Vector3<f64>, velocity: &Vector3<f64>) -> Matrix3<f64> {
    let bias = |velocity: &Vector3<f64>| bias_by_differentiation(dem, q, velocity);
    let columns = [0, 1, 2].map(|index| {
        let unit = Vector3::ith(index, 1.0);
        (bias(&(velocity + unit)) - bias(velocity) - bias(&unit)) * 0.5
    });
    Matrix3::from_columns(&columns)
}

/// A bound of C's entries for this velocity, as C itself may vanish: |C_ij| ≤ 3 max|∂M| max|q̇|, and ∂M is bounded by M_11.
fn coriolis_scale(mass: &Matrix3<f64>, velocity: &Vector3<f64>) -> f64 {
    10.0 * mass.trace() * (1.0 + velocity.amax())
}

proptest! {
    #[test]
    fn mass_matrices_agree(dem in planar_dem(), q in angles::<3>()) {
        let closed = dem.closed_form().unwrap().mass_matrix(&q);
        assert_close("Jacobian sums", &dem.mass_matrix(&q), &closed, TOLERANCE);
        assert_close("differentiation", &mass_by_differentiation(&dem, &q), &closed, TOLERANCE);
    }

    #[test]
    fn coriolis_matrices_agree(dem in planar_dem(), q in angles::<3>(), velocity in signals::<3>()) {
        let closed_form = dem.closed_form().unwrap();
        let closed = closed_form.coriolis_matrix(&q, &velocity);
        let tolerance = TOLERANCE * coriolis_scale(&closed_form.mass_matrix(&q), &velocity);
        let by_jacobians = (dem.coriolis_matrix(&q, &velocity) - closed).amax();
        let by_differentiation = (coriolis_by_differentiation(&dem, &q, &velocity) - closed).amax();
        prop_assert!(by_jacobians <= tolerance, "Jacobian sums are off by {by_jacobians:e}");
        prop_assert!(by_differentiation <= tolerance, "differentiation is off by {by_differentiation:e}");
    }
}
