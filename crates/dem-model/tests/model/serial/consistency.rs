//! One way of computing against another.

use dem_model::{
    BaseFreedom, BaseMotion, FreeFloatingManipulator, PlanarBaseManipulator, SerialAcceleration, SerialDynamics,
    SerialManipulator, SerialState, SphericalBaseManipulator, regressor,
};
use nalgebra::{SMatrix, SVector, Vector2, Vector3};
use proptest::prelude::*;

use super::random_arm::{Draws, NUMBERS, draws};
use crate::common::assert_close;
use crate::common::random::{angles, planar_dem, signals, space_manipulator};

/// Sums of some hundreds of products.
const ROUNDING: f64 = 1e-11;
/// Central differences of the fourth order with a step of 1e-3.
const DIFFERENCES: f64 = 1e-8;

/// M or C as one matrix.
fn whole<const N: usize, const B: usize>([bb, bm, mb, mm]: [&dyn Fn(usize, usize) -> f64; 4]) -> Vec<Vec<f64>> {
    let entry = |row: usize, column: usize| match (row < B, column < B) {
        (true, true) => bb(row, column),
        (true, false) => bm(row, column - B),
        (false, true) => mb(row - B, column),
        (false, false) => mm(row - B, column - B),
    };
    (0..B + N).map(|row| (0..B + N).map(|column| entry(row, column)).collect()).collect()
}

fn mass<const N: usize, const B: usize>(dynamics: &SerialDynamics<f64, N, B>) -> Vec<Vec<f64>> {
    whole::<N, B>([
        &|row, column| dynamics.mass_bb[(row, column)],
        &|row, column| dynamics.mass_bm[(row, column)],
        &|row, column| dynamics.mass_bm[(column, row)],
        &|row, column| dynamics.mass_mm[(row, column)],
    ])
}

fn coriolis<const N: usize, const B: usize>(dynamics: &SerialDynamics<f64, N, B>) -> Vec<Vec<f64>> {
    whole::<N, B>([
        &|row, column| dynamics.coriolis_bb[(row, column)],
        &|row, column| dynamics.coriolis_bm[(row, column)],
        &|row, column| dynamics.coriolis_mb[(row, column)],
        &|row, column| dynamics.coriolis_mm[(row, column)],
    ])
}

/// d/dt of a function of the joints' position, along a velocity.
fn along<const N: usize>(
    position: &SVector<f64, N>,
    velocity: &SVector<f64, N>,
    function: impl Fn(&SVector<f64, N>) -> Vec<f64>,
) -> Vec<f64> {
    let step = 1e-3;
    let at = |steps: f64| function(&(position + velocity * (step * steps)));
    let (near, far) = ((at(1.0), at(-1.0)), (at(2.0), at(-2.0)));
    let difference = |index: usize| 8.0 * (near.0[index] - near.1[index]) - (far.0[index] - far.1[index]);
    (0..near.0.len()).map(|index| difference(index) / (12.0 * step)).collect()
}

fn assert_skew<const N: usize, const B: usize>(arm: &SerialManipulator<f64, N, B>, state: &SerialState<f64, N, B>)
where
    BaseFreedom<B>: BaseMotion<f64, B>,
{
    let rate = along(&state.position, &state.velocity, |position| {
        mass(&arm.dynamics(&SerialState { position: *position, ..*state })).concat()
    });
    let coriolis = coriolis(&arm.dynamics(state));
    for row in 0..N + B {
        for column in 0..N + B {
            let left = rate[row * (N + B) + column];
            let right = coriolis[row][column] + coriolis[column][row];
            assert!((left - right).abs() < DIFFERENCES * 100.0, "({row}, {column}): {left} {right}");
        }
    }
}

fn assert_inverse<const N: usize, const B: usize>(
    arm: &SerialManipulator<f64, N, B>,
    state: &SerialState<f64, N, B>,
    acceleration: &SerialAcceleration<f64, N, B>,
) where
    BaseFreedom<B>: BaseMotion<f64, B>,
{
    let (on_base, on_arm) = arm.inverse_dynamics(state, acceleration);
    let dynamics = arm.dynamics(state);
    let (base_inertial, inertial) = dynamics.momentum(&acceleration.base, &acceleration.joints);
    let (base_coriolis, coriolis) = dynamics.coriolis_torque(&state.base_velocity, &state.velocity);
    assert_close("τ_b", &on_base, &(base_inertial + base_coriolis), ROUNDING);
    assert_close("τ_m", &on_arm, &(inertial + coriolis), ROUNDING);
    let back = arm.forward_dynamics(state, &on_base, &on_arm).unwrap();
    let recursive = arm.recursive_forward_dynamics(state, &on_base, &on_arm).unwrap();
    let scale = 1.0 + back.base.amax().max(back.joints.amax());
    assert!((recursive.base - back.base).amax() < ROUNDING * scale, "{recursive:?} {back:?}");
    assert!((recursive.joints - back.joints).amax() < ROUNDING * scale, "{recursive:?} {back:?}");
    assert_close("v̇_b", &back.base, &acceleration.base, 1e-9);
    assert_close("q̈_m", &back.joints, &acceleration.joints, 1e-9);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn recursion_and_matrices_agree_and_the_energy_balance_holds(numbers in draws()) {
        let mut draws = Draws::new(numbers);
        let (space, joints) = (draws.space_manipulator::<4>(), draws.joints::<4>());
        let dem = SphericalBaseManipulator::dynamically_equivalent(&space, joints);
        let state = draws.state();
        let acceleration = SerialAcceleration { base: draws.vector::<3>(), joints: draws.vector::<4>() };
        assert_inverse(&dem, &state, &acceleration);
        assert_skew(&dem, &state);
        let floating = FreeFloatingManipulator::free_floating(&space, joints);
        let state = draws.state();
        let acceleration = SerialAcceleration { base: draws.vector::<6>(), joints: draws.vector::<4>() };
        assert_inverse(&floating, &state, &acceleration);
        assert_skew(&floating, &state);
    }

    /// Liang's theorem, with sliding joints too: the space manipulator without linear momentum, and its DEM.
    #[test]
    fn the_dem_accelerates_as_the_space_manipulator(numbers in draws()) {
        let mut draws = Draws::new(numbers);
        let (space, joints) = (draws.space_manipulator::<4>(), draws.joints::<4>());
        let dem = SphericalBaseManipulator::dynamically_equivalent(&space, joints);
        let floating = FreeFloatingManipulator::free_floating(&space, joints);
        let state = draws.state::<4, 3>();
        let mut base_velocity = SVector::<f64, 6>::zeros();
        base_velocity.fixed_rows_mut::<3>(0).copy_from(&state.base_velocity);
        let mut afloat = SerialState { position: state.position, velocity: state.velocity, base_velocity };
        let dynamics = floating.dynamics(&afloat);
        let (momentum, _) = dynamics.momentum(&base_velocity, &state.velocity);
        let drift = momentum.fixed_rows::<3>(3) / -dynamics.mass_bb[(3, 3)];
        afloat.base_velocity.fixed_rows_mut::<3>(3).copy_from(&drift);

        let torque = draws.vector::<4>();
        let of_dem = dem.forward_dynamics(&state, &Vector3::zeros(), &torque).unwrap();
        let of_space = floating.forward_dynamics(&afloat, &SVector::zeros(), &torque).unwrap();
        assert_close("q̈", &of_dem.joints, &of_space.joints, ROUNDING * 100.0);
        assert_close("ω̇", &of_dem.base, &of_space.base.fixed_rows::<3>(0).into_owned(), ROUNDING * 100.0);

        let jacobians = (dem.generalised_jacobian(&state.position), floating.generalised_jacobian(&state.position));
        assert_close("J*", &jacobians.0.unwrap(), &jacobians.1.unwrap(), ROUNDING * 100.0);
    }

    /// The reduced dynamics are those of the whole with the momentum that it has: M̄ q̈ + C̃ q̇ + c_h = τ_m − Aᵀ τ_b.
    #[test]
    fn reduced_and_full_dynamics_agree(numbers in draws()) {
        let mut draws = Draws::new(numbers);
        let dem = SphericalBaseManipulator::dynamically_equivalent(&draws.space_manipulator::<4>(), draws.joints::<4>());
        let state = draws.state::<4, 3>();
        let (on_base, torque) = (draws.vector::<3>(), draws.vector::<4>());
        let (momentum, _) = dem.dynamics(&state).momentum(&state.base_velocity, &state.velocity);
        let reduced = dem.reduced(&state.position, &state.velocity, &momentum).unwrap();
        let acceleration = dem.forward_dynamics(&state, &on_base, &torque).unwrap();
        let left = reduced.mass * acceleration.joints + reduced.coriolis * state.velocity + reduced.momentum_torque;
        assert_close("reduced", &left, &(torque - reduced.base_coupling.tr_mul(&on_base)), 1e-9);

        // dM̄/dt along the motion is C̃ + C̃ᵀ.
        let rate = along(&state.position, &state.velocity, |position| {
            dem.reduced(position, &state.velocity, &momentum).unwrap().mass.iter().copied().collect()
        });
        let sum = reduced.coriolis + reduced.coriolis.transpose();
        assert_close("Ṁ̄", &SMatrix::<f64, 4, 4>::from_column_slice(&rate), &sum, DIFFERENCES * 100.0);
    }

    /// F = M_mm x_1 + C_mm x_2 of the locked base is ΞΦ.
    #[test]
    fn the_regressor_gives_the_torque_of_the_locked_arm(numbers in draws()) {
        let mut draws = Draws::new(numbers);
        let dem = SphericalBaseManipulator::dynamically_equivalent(&draws.space_manipulator::<4>(), draws.joints::<4>());
        let state = SerialState { base_velocity: Vector3::zeros(), ..draws.state::<4, 3>() };
        let (x1, x2) = (draws.vector::<4>(), draws.vector::<4>());
        let dynamics = dem.dynamics(&state);
        let regressor = dem.regressor(&state.position, &state.velocity, &x1, &x2);
        let parameters = dem.inertial_parameters();
        let torque = regressor.iter().zip(&parameters).map(|(block, parameters)| block * parameters).sum();
        assert_close("ΞΦ", &(dynamics.mass_mm * x1 + dynamics.coriolis_mm * x2), &torque, ROUNDING);
    }

    /// The paper's Φ for three links in the plane is redundant; it gives the same F.
    #[test]
    fn the_papers_regressor_gives_the_same_torque(
        dem in planar_dem(), q in angles::<3>(), velocity in signals::<2>(), x1 in signals::<2>(), x2 in signals::<2>(),
    ) {
        let arm = PlanarBaseManipulator::planar(&dem);
        let position = q.fixed_rows::<2>(1).into_owned();
        let general = arm.regressor(&position, &velocity, &x1, &x2);
        let torque: Vector2<f64> =
            general.iter().zip(&arm.inertial_parameters()).map(|(block, parameters)| block * parameters).sum();
        let closed = dem.closed_form().unwrap();
        let paper = regressor(q.z, &velocity, &x1, &x2) * closed.regressor_parameters();
        let scale = closed.mass_matrix(&q).amax() * (x1.amax() + velocity.amax() * x2.amax());
        prop_assert!((torque - paper).amax() <= ROUNDING * scale, "{torque} {paper}");
    }

    /// In the plane, against sums over Jacobians that share no code with these.
    #[test]
    fn the_planar_arm_is_the_one_of_jacobian_sums(
        space in space_manipulator(), q in angles::<4>(), velocity in signals::<4>(),
    ) {
        let dem = space.dynamically_equivalent();
        let state = SerialState {
            position: q.fixed_rows::<3>(1).into_owned(),
            velocity: velocity.fixed_rows::<3>(1).into_owned(),
            base_velocity: velocity.fixed_rows::<1>(0).into_owned(),
        };
        let dynamics = PlanarBaseManipulator::planar(&dem).dynamics(&state);
        let (expected_mass, expected_coriolis) = (dem.mass_matrix(&q), dem.coriolis_matrix(&q, &velocity));
        let from = |rows: Vec<Vec<f64>>| SMatrix::<f64, 4, 4>::from_row_slice(&rows.concat());
        assert_close("M", &from(mass(&dynamics)), &expected_mass, ROUNDING);
        let scale = expected_coriolis.amax().max(expected_mass.amax() * velocity.amax());
        prop_assert!((from(coriolis(&dynamics)) - expected_coriolis).amax() <= ROUNDING * scale);
    }
}

/// J* is the derivative of the end effector's place in inertial axes, about the common centre of mass.
#[test]
fn the_generalised_jacobian_is_how_the_tool_moves() {
    let mut draws = Draws::new((0..NUMBERS as u32).map(|index| (f64::from(index) * 1.7).sin()).collect());
    let dem = SphericalBaseManipulator::dynamically_equivalent(&draws.space_manipulator::<3>(), draws.joints::<3>());
    let (position, velocity) = (draws.vector::<3>(), draws.vector::<3>());
    let twist = dem.generalised_jacobian(&position).unwrap() * velocity;
    let reduced = dem.reduced(&position, &velocity, &Vector3::zeros()).unwrap();
    // ṙ in inertial axes that coincide with base axes now: the place's own rate and the base's turning.
    let rate = along(&position, &velocity, |position| dem.tool(position).place.iter().copied().collect());
    let turning = reduced.base_velocity.cross(&dem.tool(&position).place);
    let expected = Vector3::from_column_slice(&rate) + turning;
    assert_close("velocity", &twist.fixed_rows::<3>(3).into_owned(), &expected, 1e-8);
}
