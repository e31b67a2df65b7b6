//! The closed form of the paper's arm, at one state.

use crate::case;
use dem_model::{Scalar, ThreeLinkDem, regressor};
use nalgebra::{Vector2, Vector3};
use std::hint::black_box;

pub fn run<T: Scalar>(number: &str) {
    let dem = ThreeLinkDem::<T>::table_2();
    // Within the paper's motion: rad, rad/s, N·m.
    let [q, rate, force] =
        [[0.1, 0.9, 0.6], [-0.3, 0.5, 0.3], [0.0, 0.06, 0.02]].map(|values| Vector3::from(values.map(T::constant)));
    let joint_rate = Vector2::new(rate.y, rate.z);
    case(&format!("{number} model mass and coriolis"), || {
        black_box(&dem).mass_and_coriolis(black_box(&q), black_box(&rate))
    });
    case(&format!("{number} model forward dynamics"), || {
        black_box(&dem).forward_dynamics(black_box(&q), black_box(&rate), black_box(&force))
    });
    case(&format!("{number} model inverse dynamics"), || {
        black_box(&dem).inverse_dynamics(black_box(&q), black_box(&rate), black_box(&force))
    });
    case(&format!("{number} model partition"), || black_box(&dem).partition(black_box(&q), black_box(&rate)));
    case(&format!("{number} model regressor"), || {
        regressor(black_box(q.z), black_box(&joint_rate), black_box(&joint_rate), black_box(&joint_rate))
    });
    case(&format!("{number} model reduced dynamics"), || {
        black_box(&dem).reduced(black_box(&q), black_box(&joint_rate))
    });
}
