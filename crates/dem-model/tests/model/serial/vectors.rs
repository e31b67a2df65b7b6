//! `spatial.json` and `reduced_spatial.json`: the DEM of an arm with three joints of skew axes, its Euler coordinates, its
//! motion under torques, the same of the space manipulator itself, and its reduced dynamics.

use dem_model::{
    Body, DemBase, DemLink, EulerAngles, EulerSequence, FreeFloatingManipulator, Joint, JointMotion, SerialState,
    SpaceLink, SpacecraftBody, SpatialDem, SpatialSpaceManipulator, SphericalBaseManipulator,
};
use nalgebra::{Matrix3, Quaternion, SMatrix, SVector, UnitQuaternion, Vector3};
use serde_json::Value;

use super::integration::{Moving, run};
use crate::common::{assert_close, numbers, vectors};

const TOLERANCE: f64 = 1e-9;
/// A step of the classical Runge-Kutta method that is exact to the tolerance over 3 s.
const STEP: f64 = 1e-3;

fn vector<const ROWS: usize>(value: &Value) -> SVector<f64, ROWS> {
    SVector::from_column_slice(&numbers(value))
}

fn matrix<const ROWS: usize, const COLUMNS: usize>(value: &Value) -> SMatrix<f64, ROWS, COLUMNS> {
    SMatrix::from_row_slice(&numbers(value))
}

fn spatial_case() -> Value {
    vectors("spatial.json")["cases"][0].clone()
}

fn joints(case: &Value) -> [Joint<f64>; 3] {
    core::array::from_fn(|index| {
        let axis = vector(&case["sm"]["axis"][index]);
        Joint::new(JointMotion::Revolute, axis, Body::Link(index + 2)).unwrap()
    })
}

fn space_manipulator(case: &Value) -> SpatialSpaceManipulator<f64, 3> {
    let body = &case["sm"];
    let spacecraft = SpacecraftBody {
        mass: body["m"][0].as_f64().unwrap(),
        inertia: matrix(&body["I"][0]),
        centre_of_mass_to_joint: vector(&body["R"][0]),
    };
    let links = core::array::from_fn(|index| SpaceLink {
        mass: body["m"][index + 1].as_f64().unwrap(),
        inertia: matrix(&body["I"][index + 1]),
        joint_to_centre_of_mass: vector(&body["L"][index + 1]),
        centre_of_mass_to_joint: vector(&body["R"][index + 1]),
    });
    SpatialSpaceManipulator::new(spacecraft, links).unwrap()
}

/// From the file's own parameters of the DEM, not from the map.
fn dem(case: &Value) -> SphericalBaseManipulator<f64, 3> {
    let body = &case["dem"];
    let base = DemBase { inertia: matrix(&body["I"][0]), length: vector(&body["W"][0]) };
    let links = core::array::from_fn(|index| DemLink {
        mass: body["m"][index + 1].as_f64().unwrap(),
        inertia: matrix::<3, 3>(&body["I"][index + 1]),
        length: vector::<3>(&body["W"][index + 1]),
        centre_of_mass: vector::<3>(&body["lc"][index + 1]),
    });
    SphericalBaseManipulator::new(&SpatialDem::new(base, links).unwrap(), joints(case)).unwrap()
}

#[test]
fn reduced_dynamics_match_reduced_spatial_json() {
    let dem = dem(&spatial_case());
    let file = vectors("reduced_spatial.json");
    let states = file["states"].as_array().unwrap();
    assert_eq!(states.len(), 10);
    for expected in states {
        let state = SerialState {
            position: vector(&expected["th"]),
            velocity: vector(&expected["thd"]),
            base_velocity: vector(&expected["omega_body"]),
        };
        let (momentum, _) = dem.dynamics(&state).momentum(&state.base_velocity, &state.velocity);
        assert_close("h", &momentum, &vector::<3>(&expected["h_body"]), TOLERANCE);

        let at_rest = dem.reduced(&state.position, &state.velocity, &Vector3::zeros()).unwrap();
        assert_close("M̄", &at_rest.mass, &matrix::<3, 3>(&expected["Mbar"]), TOLERANCE);
        assert_close("A", &at_rest.base_coupling, &matrix::<3, 3>(&expected["A"]), TOLERANCE);
        assert_close("C̄", &at_rest.coriolis, &matrix::<3, 3>(&expected["Cbar"]), TOLERANCE);
        assert_eq!(at_rest.momentum_torque, Vector3::zeros());

        // The file's curvature terms come from differences, to 1e-8.
        let reduced = dem.reduced(&state.position, &state.velocity, &momentum).unwrap();
        assert_close("v_b", &reduced.base_velocity, &state.base_velocity, TOLERANCE);
        let torque = reduced.coriolis * state.velocity + reduced.momentum_torque;
        let sum = ["Cbar_thd", "curvature_term", "g_h"].map(|term| vector::<3>(&expected[term])).iter().sum();
        assert_close("C̃ q̇ + c_h", &torque, &sum, 1e-7);

        let torque: SVector<f64, 6> = vector(&expected["tau"]);
        let (on_base, on_arm) = (torque.fixed_rows::<3>(0).into_owned(), torque.fixed_rows::<3>(3).into_owned());
        let acceleration = dem.forward_dynamics(&state, &on_base, &on_arm).unwrap();
        assert_close("q̈", &acceleration.joints, &vector::<3>(&expected["thdd"]), TOLERANCE);
    }
}

#[test]
fn euler_coordinates_match_spatial_json() {
    let case = spatial_case();
    let dem = dem(&case);
    let states = case["euler_states"].as_array().unwrap();
    assert_eq!(states.len(), 20);
    for expected in states {
        let sequence = match expected["conv"].as_str().unwrap() {
            "ZXZ" => EulerSequence::Zxz,
            "ZYZ" => EulerSequence::Zyz,
            other => panic!("{other}"),
        };
        let (attitude, rates) =
            (EulerAngles { sequence, angles: vector(&expected["angles"]) }, vector(&expected["rates"]));
        let state = SerialState {
            position: vector(&expected["th"]),
            velocity: vector(&expected["thd"]),
            base_velocity: attitude.velocity_map() * rates,
        };
        let euler = dem.dynamics(&state).in_euler_angles(&attitude, &rates);
        let mut mass = SMatrix::<f64, 6, 6>::zeros();
        mass.fixed_view_mut::<3, 3>(0, 0).copy_from(&euler.mass_bb);
        mass.fixed_view_mut::<3, 3>(0, 3).copy_from(&euler.mass_bm);
        mass.fixed_view_mut::<3, 3>(3, 0).copy_from(&euler.mass_bm.transpose());
        mass.fixed_view_mut::<3, 3>(3, 3).copy_from(&euler.mass_mm);
        assert_close("M", &mass, &matrix::<6, 6>(&expected["M"]), TOLERANCE);
        let (base, arm) = euler.coriolis_torque(&rates, &state.velocity);
        let both = SVector::<f64, 6>::from_iterator(base.iter().chain(arm.iter()).copied());
        assert_close("C q̇", &both, &vector::<6>(&expected["Cqd"]), TOLERANCE);
    }
}

/// The motion of the file, in rows of a tenth of a second.
fn assert_motion<const B: usize>(case: &Value, start: Moving<3, B>, step: impl Fn(f64, &Moving<3, B>) -> Moving<3, B>) {
    let times = numbers(&case["t"]);
    assert_eq!(times.len(), 31);
    let mut state = start;
    for (row, time) in times.iter().enumerate() {
        if row > 0 {
            state = run(state, times[row - 1], *time, STEP, &step);
        }
        let attitude = state.attitude.coords;
        let expected: SVector<f64, 4> = vector(&case["quat_xyzw"][row]);
        let nearer = if attitude.dot(&expected) < 0.0 { -attitude } else { attitude };
        assert_close(&format!("attitude at {time} s"), &nearer, &expected, TOLERANCE);
        assert_close(&format!("joints at {time} s"), &state.joints.position, &vector::<3>(&case["th"][row]), TOLERANCE);
        assert_close(&format!("rates at {time} s"), &state.joints.velocity, &vector::<3>(&case["thd"][row]), TOLERANCE);
        let angular = state.joints.base_velocity.fixed_rows::<1>(0).into_owned();
        let omega: SVector<f64, 3> = vector(&case["omega_body"][row]);
        assert!((angular.x - omega.x).abs() <= TOLERANCE * omega.amax(), "{angular} {omega} at {time} s");
    }
}

fn torque(case: &Value, time: f64) -> Vector3<f64> {
    let [amplitude, frequency, phase] = ["amp", "freq", "phase"].map(|key| vector::<3>(&case["tau"][key]));
    amplitude.component_mul(&(frequency * time + phase).map(f64::sin))
}

fn start<const B: usize>(case: &Value, base_velocity: SVector<f64, B>) -> Moving<3, B> {
    let attitude: SVector<f64, 4> = vector(&case["quat_xyzw0"]);
    Moving {
        attitude: UnitQuaternion::new_unchecked(Quaternion::from_vector(attitude)),
        joints: SerialState { position: vector(&case["th0"]), velocity: vector(&case["thd0"]), base_velocity },
    }
}

#[test]
fn the_dem_moves_as_in_spatial_json() {
    let case = spatial_case();
    let dem = dem(&case);
    assert_motion(&case, start(&case, vector::<3>(&case["omega_body0"])), |time, state| {
        Moving::rate(state, &dem.forward_dynamics(&state.joints, &Vector3::zeros(), &torque(&case, time)).unwrap())
    });
}

/// The spacecraft starts without linear momentum: its own velocity is what the arm's motion makes it.
#[test]
fn so_does_the_space_manipulator_itself() {
    let case = spatial_case();
    let floating = FreeFloatingManipulator::free_floating(&space_manipulator(&case), joints(&case));
    let angular: Vector3<f64> = vector(&case["omega_body0"]);
    let mut begin = start(&case, SVector::<f64, 6>::from_iterator(angular.iter().copied().chain([0.0; 3])));
    let mass = floating.dynamics(&begin.joints);
    let (momentum, _) = mass.momentum(&begin.joints.base_velocity, &begin.joints.velocity);
    let total: f64 = mass.mass_bb[(3, 3)];
    let drift = momentum.fixed_rows::<3>(3) / -total;
    begin.joints.base_velocity.fixed_rows_mut::<3>(3).copy_from(&drift);
    let none = SVector::<f64, 6>::zeros();
    assert_motion(&case, begin, |time, state| {
        Moving::rate(state, &floating.forward_dynamics(&state.joints, &none, &torque(&case, time)).unwrap())
    });
}

#[test]
fn the_map_gives_the_dem_of_spatial_json() {
    let case = spatial_case();
    let mapped = SphericalBaseManipulator::dynamically_equivalent(&space_manipulator(&case), joints(&case));
    let state = SerialState {
        position: Vector3::new(0.3, -1.0, 2.0),
        velocity: Vector3::new(-0.4, 0.5, 0.6),
        base_velocity: Vector3::new(0.1, 0.2, -0.3),
    };
    let (ours, theirs) = (mapped.dynamics(&state), dem(&case).dynamics(&state));
    assert_close("M_bb", &ours.mass_bb, &theirs.mass_bb, 1e-13);
    assert_close("M_mm", &ours.mass_mm, &theirs.mass_mm, 1e-13);
    assert_close("C_mb", &ours.coriolis_mb, &theirs.coriolis_mb, 1e-12);
    let _: Matrix3<f64> = ours.mass_bm;
}
