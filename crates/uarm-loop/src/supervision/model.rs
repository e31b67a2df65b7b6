//! What the supervision must know of a manipulator: its generalised momentum and what changes it beside torques.

use std::fmt;

use hinf_control::dem_model::{BaseFreedom, BaseMotion, SerialManipulator, SerialState, ThreeLinkDem};
use nalgebra::{SMatrix, SVector, Vector3};

use crate::dimensions;

/// A model of the manipulator, M(q) q̈ + C(q, q̇) q̇ = τ: of the whole, the passive base as joint 1; where no sensor is on the base, of
/// the arm on a base without momentum. Angles in rad.
pub trait MomentumModel<const J: usize>: fmt::Debug + Send + Sync {
    /// M(q) by rows, kg·m²: symmetric and positive definite.
    fn inertia(&self, position: &[f64; J]) -> [[f64; J]; J];

    /// Cᵀ q̇, N·m, for velocities in rad/s: what changes the momentum p = M q̇ beside torques, ṗ = τ + Cᵀ q̇, since Ṁ = C + Cᵀ.
    fn velocity_torque(&self, position: &[f64; J], velocity: &[f64; J]) -> [f64; J];
}

impl MomentumModel<3> for ThreeLinkDem<f64> {
    fn inertia(&self, position: &[f64; 3]) -> [[f64; 3]; 3] {
        // By columns, which are the rows of a symmetric matrix.
        self.mass_matrix(&Vector3::from(*position)).into()
    }

    fn velocity_torque(&self, position: &[f64; 3], velocity: &[f64; 3]) -> [f64; 3] {
        let velocity = Vector3::from(*velocity);
        self.coriolis_matrix(&Vector3::from(*position), &velocity).tr_mul(&velocity).into()
    }
}

impl<const J: usize, const N: usize, const B: usize> MomentumModel<J> for SerialManipulator<f64, N, B>
where
    BaseFreedom<B>: BaseMotion<f64, B>,
{
    fn inertia(&self, position: &[f64; J]) -> [[f64; J]; J] {
        let state = state::<J, N, B>(position, &[0.0; J]);
        let dynamics = self.dynamics(&state);
        if has_base::<J, N>() {
            return assembled(&dynamics.mass_bb, &dynamics.mass_bm, &dynamics.mass_mm);
        }
        // What is no number passes no limit.
        let reduced = dynamics.base_coupling().map(|coupling| dynamics.generalised_inertia(&coupling));
        assembled::<J, N, B>(&SMatrix::zeros(), &SMatrix::zeros(), &reduced.unwrap_or(SMatrix::repeat(f64::NAN)))
    }

    fn velocity_torque(&self, position: &[f64; J], velocity: &[f64; J]) -> [f64; J] {
        let state = state::<J, N, B>(position, velocity);
        if has_base::<J, N>() {
            let dynamics = self.dynamics(&state);
            let of = |of_base: &SMatrix<f64, B, B>, of_arm: &SMatrix<f64, N, B>| {
                of_base.tr_mul(&state.base_velocity) + of_arm.tr_mul(&state.velocity)
            };
            let base = of(&dynamics.coriolis_bb, &dynamics.coriolis_mb);
            let arm = dynamics.coriolis_bm.tr_mul(&state.base_velocity) + dynamics.coriolis_mm.tr_mul(&state.velocity);
            return in_order(&base, &arm);
        }
        let reduced = self.reduced(&state.position, &state.velocity, &SVector::zeros());
        let torque = reduced.map_or(SVector::repeat(f64::NAN), |reduced| reduced.coriolis.tr_mul(&state.velocity));
        in_order(&SVector::<f64, B>::zeros(), &torque)
    }
}

const fn has_base<const J: usize, const N: usize>() -> bool {
    dimensions::passive::<J, N>() == 1
}

/// A base of more than one axis is no joint: it stands still then.
fn state<const J: usize, const N: usize, const B: usize>(
    position: &[f64; J],
    velocity: &[f64; J],
) -> SerialState<f64, N, B> {
    let base = dimensions::base::<_, J, N>(velocity);
    SerialState {
        position: dimensions::active(position),
        velocity: dimensions::active(velocity),
        base_velocity: SVector::from_fn(|row, _| if row == 0 { base } else { 0.0 }),
    }
}

/// The entries of the base's first axis, if it is a joint, and of the arm, in the order of the joints.
fn in_order<const J: usize, const N: usize, const B: usize>(base: &SVector<f64, B>, arm: &SVector<f64, N>) -> [f64; J] {
    let passive = dimensions::passive::<J, N>();
    let mut all = [0.0; J];
    for (to, from) in all.iter_mut().zip(base.iter().take(passive).chain(arm.iter())) {
        *to = *from;
    }
    all
}

/// The rows of a symmetric matrix of these blocks.
fn assembled<const J: usize, const N: usize, const B: usize>(
    base: &SMatrix<f64, B, B>,
    coupling: &SMatrix<f64, B, N>,
    arm: &SMatrix<f64, N, N>,
) -> [[f64; J]; J] {
    let passive = dimensions::passive::<J, N>();
    let of_base = base.column_iter().take(passive).zip(coupling.row_iter());
    let of_base = of_base.map(|(column, row)| in_order(&column.into_owned(), &row.transpose()));
    let of_arm = coupling.column_iter().zip(arm.column_iter());
    let of_arm = of_arm.map(|(column, of_arm)| in_order(&column.into_owned(), &of_arm.into_owned()));
    let mut rows = [[0.0; J]; J];
    for (to, row) in rows.iter_mut().zip(of_base.chain(of_arm)) {
        *to = row;
    }
    rows
}

#[cfg(test)]
mod tests {
    use hinf_control::dem_model::{PlanarBaseManipulator, PlanarSpaceManipulator};

    use super::*;

    const POSITION: [f64; 3] = [0.3, -0.7, 1.1];
    const VELOCITY: [f64; 3] = [0.9, -0.4, 1.3];

    /// ½ ∂(q̇ᵀ M q̇)/∂q by central differences: what Cᵀ q̇ is.
    fn by_differences<const J: usize>(
        model: &impl MomentumModel<J>,
        position: [f64; J],
        velocity: [f64; J],
    ) -> [f64; J] {
        const STEP: f64 = 1e-5;
        let energy = |position: &[f64; J]| {
            let velocity = SVector::from(velocity);
            0.5 * (SMatrix::<f64, J, J>::from(model.inertia(position)) * velocity).dot(&velocity)
        };
        std::array::from_fn(|joint| {
            let (mut ahead, mut behind) = (position, position);
            ahead[joint] += STEP;
            behind[joint] -= STEP;
            (energy(&ahead) - energy(&behind)) / (2.0 * STEP)
        })
    }

    fn assert_close<const J: usize>(found: [f64; J], expected: [f64; J]) {
        let difference = SVector::from(found) - SVector::from(expected);
        assert!(difference.amax() < 1e-8, "{found:?}, expected {expected:?}");
    }

    #[test]
    fn the_general_arm_is_the_papers() {
        let paper = ThreeLinkDem::<f64>::table_2();
        let serial =
            PlanarBaseManipulator::planar(&PlanarSpaceManipulator::<f64, 2>::table_1().dynamically_equivalent());
        // Tables 1 and 2 agree to their rounding.
        for (found, expected) in serial.inertia(&POSITION).iter().zip(paper.inertia(&POSITION)) {
            assert!(
                found
                    .iter()
                    .zip(expected)
                    .all(|(found, expected): (&f64, f64)| (found - expected).abs() < 0.01 * expected.abs().max(0.01))
            );
        }
        assert_close(serial.velocity_torque(&POSITION, &VELOCITY), by_differences(&serial, POSITION, VELOCITY));
        assert_close(paper.velocity_torque(&POSITION, &VELOCITY), by_differences(&paper, POSITION, VELOCITY));
    }

    /// Without a sensor on the base: M̄ = M_mm − M_mb M_bb⁻¹ M_bm, here of the same arm.
    #[test]
    fn without_a_sensor_the_base_has_no_momentum() {
        let serial =
            PlanarBaseManipulator::planar(&PlanarSpaceManipulator::<f64, 2>::table_1().dynamically_equivalent());
        let whole = MomentumModel::<3>::inertia(&serial, &POSITION);
        let arm: [[f64; 2]; 2] = serial.inertia(&[POSITION[1], POSITION[2]]);
        for (row, of_arm) in arm.iter().enumerate() {
            for (column, found) in of_arm.iter().enumerate() {
                let expected = whole[row + 1][column + 1] - whole[row + 1][0] * whole[0][column + 1] / whole[0][0];
                assert!((found - expected).abs() < 1e-12, "{found}, expected {expected}");
            }
        }
        let (position, velocity) = ([POSITION[1], POSITION[2]], [VELOCITY[1], VELOCITY[2]]);
        assert_close(serial.velocity_torque(&position, &velocity), by_differences(&serial, position, velocity));
    }
}
