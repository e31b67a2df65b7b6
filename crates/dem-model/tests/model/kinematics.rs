//! Positions against their Jacobians, and the Jacobians against M.

use crate::common::random::{angles, three_link_dem};
use dem_model::ThreeLinkDem;
use nalgebra::{Matrix2x3, Matrix3, RowVector3, Vector2, Vector3};
use proptest::prelude::*;

/// A central difference at a step of 1e-5 of sums of up to 1.8 m: 1e-10 of truncation and 1e-11 of rounding.
const DIFFERENCE: f64 = 1e-9;

fn differences(position: impl Fn(&Vector3<f64>) -> Vector2<f64>, q: &Vector3<f64>) -> Matrix2x3<f64> {
    const STEP: f64 = 1e-5;
    Matrix2x3::from_columns(&[0, 1, 2].map(|index| {
        let step = Vector3::ith(index, STEP);
        (position(&(q + step)) - position(&(q - step))) / (2.0 * STEP)
    }))
}

proptest! {
    #[test]
    fn jacobians_are_derivatives(dem in three_link_dem(), q in angles::<3>()) {
        let end_effector = differences(|q| dem.end_effector(q).position, &q);
        prop_assert!((dem.end_effector_jacobian(&q) - end_effector).amax() <= DIFFERENCE);
        for (index, jacobian) in dem.centre_of_mass_jacobians(&q).iter().enumerate() {
            let expected = differences(|q| dem.centres_of_mass(q)[index], &q);
            prop_assert!((jacobian - expected).amax() <= DIFFERENCE, "link {}", index + 2);
        }
    }

    #[test]
    fn jacobians_carry_the_inertia(dem in three_link_dem(), q in angles::<3>()) {
        let turning = [RowVector3::new(1.0, 0.0, 0.0), RowVector3::new(1.0, 1.0, 0.0), RowVector3::repeat(1.0)];
        let [second, third] = dem.links();
        let inertias = [dem.base().inertia, second.inertia, third.inertia];
        let mut mass: Matrix3<f64> = turning.iter().zip(inertias).map(|(row, inertia)| row.transpose() * row * inertia).sum();
        for (jacobian, link) in dem.centre_of_mass_jacobians(&q).iter().zip(dem.links()) {
            mass += jacobian.transpose() * jacobian * link.mass;
        }
        prop_assert!((mass - dem.mass_matrix(&q)).amax() <= 1e-14 * mass.amax().max(1.0));
    }
}

#[test]
fn table_2_stretches_along_x_and_turns_counter_clockwise() {
    let dem = ThreeLinkDem::<f64>::table_2();
    let pose = dem.end_effector(&Vector3::zeros());
    assert!((pose.position - Vector2::new(3.0 * 0.203, 0.0)).amax() < 1e-15);
    let quarter = core::f64::consts::FRAC_PI_2;
    let [first, second, third] = dem.joint_positions(&Vector3::new(quarter, -quarter, quarter));
    assert_eq!(first, Vector2::zeros());
    assert!((second - Vector2::new(0.0, 0.203)).amax() < 1e-15);
    assert!((third - Vector2::new(0.203, 0.203)).amax() < 1e-15);
}
