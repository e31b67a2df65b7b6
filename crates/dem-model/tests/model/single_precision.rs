//! f32 computes what f64 does, to f32's accuracy.

use crate::common::random::{angles, signals};
use dem_model::PlanarSpaceManipulator;
use dem_model::{ThreeLinkDem, regressor};
use nalgebra::{SMatrix, Vector2, Vector3};
use proptest::prelude::*;

/// Angles of 3 rad carry 1.2e-7 of rounding, sums of them and their products some times that.
const SUMS: f64 = 3e-6;
/// What a solve with M loses beside, whose condition number is below 150 for Table 2.
const SOLVE: f64 = 150.0 * SUMS;

fn require_close<const ROWS: usize, const COLUMNS: usize>(
    what: &str,
    single: &SMatrix<f32, ROWS, COLUMNS>,
    double: &SMatrix<f64, ROWS, COLUMNS>,
    tolerance: f64,
) -> Result<(), TestCaseError> {
    let off = (single.cast::<f64>() - double).amax();
    prop_assert!(off <= tolerance, "{what} is off by {off:e}:{single}{double}");
    Ok(())
}

proptest! {
    #[test]
    fn single_precision_agrees(
        q in angles::<3>(), velocity in signals::<3>(), force in signals::<3>(), x1 in signals::<2>(), x2 in signals::<2>(),
    ) {
        let (single, double) = (ThreeLinkDem::<f32>::table_2(), ThreeLinkDem::<f64>::table_2());
        let (q32, velocity32, force32) = (q.cast::<f32>(), velocity.cast::<f32>(), force.cast::<f32>());
        let (joint_velocity, joint_velocity32) = (Vector2::new(velocity.y, velocity.z), Vector2::new(velocity32.y, velocity32.z));

        require_close("M", &single.mass_matrix(&q32), &double.mass_matrix(&q), SUMS)?;
        require_close("C", &single.coriolis_matrix(&q32, &velocity32), &double.coriolis_matrix(&q, &velocity), SUMS)?;
        let acceleration = double.forward_dynamics(&q, &velocity, &force);
        let tolerance = SOLVE * acceleration.amax().max(1.0);
        require_close("q̈", &single.forward_dynamics(&q32, &velocity32, &force32), &acceleration, tolerance)?;
        let matrix = regressor(q.z, &joint_velocity, &x1, &x2);
        let (x1, x2) = (x1.cast::<f32>(), x2.cast::<f32>());
        require_close("Ξ", &regressor(q32.z, &joint_velocity32, &x1, &x2), &matrix, 30.0 * SUMS)?;
        let (reduced32, reduced) = (single.reduced(&q32, &joint_velocity32), double.reduced(&q, &joint_velocity));
        require_close("M̄", &reduced32.mass, &reduced.mass, SUMS)?;
        require_close("C̄", &reduced32.coriolis, &reduced.coriolis, 10.0 * SUMS)?;
        require_close("end effector", &single.end_effector(&q32).position, &double.end_effector(&q).position, SUMS)?;
    }
}

#[test]
fn the_map_agrees() {
    let single = PlanarSpaceManipulator::<f32, 2>::table_1().dynamically_equivalent();
    let double = PlanarSpaceManipulator::<f64, 2>::table_1().dynamically_equivalent();
    for (single, double) in single.links().iter().zip(double.links()) {
        assert!((f64::from(single.mass) - double.mass).abs() < SUMS);
        assert!((f64::from(single.length) - double.length).abs() < SUMS);
        assert!((f64::from(single.centre_of_mass) - double.centre_of_mass).abs() < SUMS);
    }
    let zero = Vector3::zeros();
    assert!((f64::from(single.mass_matrix(&zero.cast::<f32>()).m11) - double.mass_matrix(&zero).m11).abs() < SUMS);
}
