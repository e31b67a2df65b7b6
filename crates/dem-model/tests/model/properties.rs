//! What holds for every manipulator in every state.

use crate::common::random::{angles, signals, three_link_dem};
use dem_model::{Partition, REGRESSOR_PARAMETERS, ThreeLinkDem, regressor};
use nalgebra::{Matrix2, Matrix3, SMatrix, SVector, Vector2, Vector3};
use proptest::prelude::*;

/// Sums of some tens of products, relative to their greatest term.
const ROUNDING: f64 = 1e-13;
/// A fourth-order difference at a step of 1e-3 of functions of angles: 1e-12 of its greatest fifth derivative along the
/// motion (some 3 rad/s per joint, so up to 9⁵) and 1e-13 of rounding, both relative.
const DIFFERENCE: f64 = 1e-7;

/// The derivative of `function` at zero by fourth-order central differences.
fn slope<const ROWS: usize, const COLUMNS: usize>(
    function: impl Fn(f64) -> SMatrix<f64, ROWS, COLUMNS>,
) -> SMatrix<f64, ROWS, COLUMNS> {
    const STEP: f64 = 1e-3;
    let central = |step: f64| (function(step) - function(-step)) / (2.0 * step);
    (central(STEP) * 4.0 - central(2.0 * STEP)) / 3.0
}

fn joints(vector: &Vector3<f64>) -> Vector2<f64> {
    Vector2::new(vector.y, vector.z)
}

/// The scale of what M and C make of these signals, in N·m; sums that cancel are measured against it.
fn torque_scale(dem: &ThreeLinkDem<f64>, signals: &[&Vector3<f64>]) -> f64 {
    let greatest = signals.iter().map(|signal| signal.amax()).fold(1.0, f64::max);
    10.0 * dem.mass_matrix(&Vector3::zeros()).m11 * greatest * greatest
}

fn require_skew<const SIZE: usize>(
    what: &str,
    matrix: &SMatrix<f64, SIZE, SIZE>,
    scale: f64,
) -> Result<(), TestCaseError> {
    let off = (matrix + matrix.transpose()).amax();
    prop_assert!(off <= DIFFERENCE * scale, "{what} is not skew by {off:e}:{matrix}");
    Ok(())
}

fn full_mass(parts: &Partition<f64>) -> Matrix3<f64> {
    let mut mass = Matrix3::zeros();
    mass.m11 = parts.mass_bb;
    mass.fixed_view_mut::<1, 2>(0, 1).copy_from(&parts.mass_bm);
    mass.fixed_view_mut::<2, 1>(1, 0).copy_from(&parts.mass_mb);
    mass.fixed_view_mut::<2, 2>(1, 1).copy_from(&parts.mass_mm);
    mass
}

proptest! {
    #[test]
    fn mass_is_symmetric_positive_definite(dem in three_link_dem(), q in angles::<3>(), turn in -3.0..3.0) {
        let mass = dem.mass_matrix(&q);
        prop_assert_eq!(mass, mass.transpose());
        prop_assert!(mass.symmetric_eigenvalues().min() > 0.0);
        prop_assert_eq!(mass, dem.mass_matrix(&Vector3::new(q.x + turn, q.y, q.z)), "M depends on the base's angle");
    }

    #[test]
    fn mass_derivative_less_twice_coriolis_is_skew(dem in three_link_dem(), q in angles::<3>(), velocity in signals::<3>()) {
        let mass_derivative = slope(|time| dem.mass_matrix(&(q + velocity * time)));
        let scale = torque_scale(&dem, &[&velocity]);
        require_skew("Ṁ − 2C", &(mass_derivative - dem.coriolis_matrix(&q, &velocity) * 2.0), scale)?;
        let parts_at = |time: f64| dem.partition(&(q + velocity * time), &velocity);
        let arm_mass_derivative: Matrix2<f64> = slope(|time| parts_at(time).mass_mm);
        require_skew("N_mm", &(arm_mass_derivative - parts_at(0.0).coriolis_mm * 2.0), scale)?;
    }

    #[test]
    fn partition_sums_to_the_whole(dem in three_link_dem(), q in angles::<3>(), velocity in signals::<3>()) {
        let parts = dem.partition(&q, &velocity);
        prop_assert_eq!(full_mass(&parts), dem.mass_matrix(&q));
        let whole = dem.inverse_dynamics(&q, &velocity, &Vector3::zeros());
        let base = parts.coriolis_bb * velocity.x + (parts.coriolis_bm * joints(&velocity)).x;
        let arm = parts.base_reaction(0.0, velocity.x) + parts.arm_torque(&Vector2::zeros(), &joints(&velocity));
        let sum = Vector3::new(base, arm.x, arm.y);
        prop_assert!((sum - whole).amax() <= ROUNDING * torque_scale(&dem, &[&velocity]), "{sum} is not {whole}");
    }

    #[test]
    fn arm_coriolis_does_not_know_the_base_velocity(
        dem in three_link_dem(), q in angles::<3>(), velocity in signals::<3>(), base_velocity in -3.0..3.0,
    ) {
        let other = Vector3::new(base_velocity, velocity.y, velocity.z);
        prop_assert_eq!(dem.partition(&q, &velocity).coriolis_mm, dem.partition(&q, &other).coriolis_mm);
    }

    #[test]
    fn forward_and_inverse_dynamics_undo_each_other(
        dem in three_link_dem(), q in angles::<3>(), velocity in signals::<3>(), force in signals::<3>(),
    ) {
        let acceleration = dem.forward_dynamics(&q, &velocity, &force);
        let back = dem.inverse_dynamics(&q, &velocity, &acceleration);
        let scale = torque_scale(&dem, &[&velocity]).max(10.0 * dem.mass_matrix(&q).amax() * acceleration.amax());
        prop_assert!((back - force).amax() <= ROUNDING * scale, "{back} is not {force}");
    }

    /// dT/dt = q̇ᵀ f and dp/dt = f_1 along the motion; without torque on the base the angular momentum stays.
    #[test]
    fn energy_and_angular_momentum_balance(
        dem in three_link_dem(), q in angles::<3>(), velocity in signals::<3>(), acceleration in signals::<3>(),
    ) {
        let force = dem.inverse_dynamics(&q, &velocity, &acceleration);
        let at = |time: f64| (q + velocity * time + acceleration * (0.5 * time * time), velocity + acceleration * time);
        let change: Vector2<f64> = slope(|time| {
            let (q, velocity) = at(time);
            Vector2::new(dem.kinetic_energy(&q, &velocity), dem.angular_momentum(&q, &velocity))
        });
        let expected = Vector2::new(velocity.dot(&force), force.x);
        let scale = torque_scale(&dem, &[&velocity, &acceleration]) * velocity.amax().max(1.0);
        prop_assert!((change - expected).amax() <= DIFFERENCE * scale, "{change} is not {expected}");

        let free = dem.forward_dynamics(&q, &velocity, &Vector3::new(0.0, force.y, force.z));
        let torque_on_base = dem.inverse_dynamics(&q, &velocity, &free).x;
        let scale = scale.max(10.0 * dem.mass_matrix(&q).amax() * free.amax());
        prop_assert!(torque_on_base.abs() <= ROUNDING * scale, "momentum changes by {torque_on_base:e} N m");
    }

    #[test]
    fn regressor_is_linear_in_any_parameters(
        dem in three_link_dem(), q in angles::<3>(), velocity in signals::<3>(),
        x1 in signals::<2>(), x2 in signals::<2>(), estimate in signals::<REGRESSOR_PARAMETERS>(),
    ) {
        let matrix = regressor(q.z, &joints(&velocity), &x1, &x2);
        let nominal = matrix * dem.regressor_parameters();
        let expected = dem.partition(&q, &velocity).arm_torque(&x1, &x2);
        prop_assert!((nominal - expected).amax() <= ROUNDING * torque_scale(&dem, &[&velocity]).max(100.0), "{nominal}{expected}");

        let estimated = dem.with_regressor_parameters(&estimate).partition(&q, &velocity).arm_torque(&x1, &x2);
        let scale = 100.0 * estimate.amax().max(1.0);
        prop_assert!((matrix * estimate - estimated).amax() <= ROUNDING * scale, "ΞΦ is not {estimated}");
    }

    #[test]
    fn nominal_parameters_give_the_nominal_model(dem in three_link_dem(), q in angles::<3>()) {
        let back = dem.with_regressor_parameters(&dem.regressor_parameters()).mass_matrix(&q);
        prop_assert!((back - dem.mass_matrix(&q)).amax() <= ROUNDING * back.amax());
        let other = dem.with_regressor_parameters(&(dem.regressor_parameters() + SVector::repeat(0.1)));
        prop_assert!((other.mass_matrix(&q) - back).amax() > 0.1, "an estimate has no effect");
    }

    /// Eqs. 20 and 21 undo the base: the whole manipulator answers the compensated torque as the arm alone would τ̄.
    #[test]
    fn base_compensation_makes_the_arm_answer_as_if_alone(
        dem in three_link_dem(), q in angles::<3>(), velocity in signals::<3>(), arm_torque in signals::<2>(),
    ) {
        let parts = dem.partition(&q, &velocity);
        let torque = parts.base_compensated_torque(&arm_torque, velocity.x, &joints(&velocity)).unwrap();
        let acceleration = joints(&dem.forward_dynamics(&q, &velocity, &Vector3::new(0.0, torque.x, torque.y)));
        let wanted = parts.mass_mm.try_inverse().unwrap() * (arm_torque - parts.coriolis_mm * joints(&velocity));
        // Two solves with M, one of them with its Schur complement: both lose M's condition number.
        let eigenvalues = dem.mass_matrix(&q).symmetric_eigenvalues();
        let tolerance = ROUNDING * (eigenvalues.max() / eigenvalues.min()) * wanted.amax().max(1.0)
            * (1.0 + torque_scale(&dem, &[&velocity]));
        prop_assert!((acceleration - wanted).amax() <= tolerance, "{acceleration} is not {wanted}");
    }
}

#[test]
fn an_estimate_without_inertia_gives_no_torque() {
    let dem = ThreeLinkDem::<f64>::table_2();
    let parts = dem
        .with_regressor_parameters(&SVector::zeros())
        .partition(&Vector3::new(0.0, 0.3, 0.2), &Vector3::new(0.1, 0.2, 0.3));
    assert_eq!(parts.base_compensated_torque(&Vector2::new(0.1, 0.1), 0.1, &Vector2::new(0.2, 0.3)), None);
}
