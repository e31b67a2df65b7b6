//! The published vectors: M, C, q̈ of Table 2, the DEM map, the reduced dynamics.

use crate::common::{assert_close, numbers, vectors};
use dem_model::{PlanarDem, PlanarSpaceManipulator, SpaceLink, SpacecraftBody, SpatialSpaceManipulator, ThreeLinkDem};
use nalgebra::{Matrix3, SMatrix, SVector, Vector2, Vector3};
use serde_json::Value;

/// What two independent implementations reached for M, C and the map.
const MATRIX_TOLERANCE: f64 = 1e-13;
/// What the reduced vectors are given to.
const REDUCED_TOLERANCE: f64 = 1e-9;

fn vector3(value: &Value) -> Vector3<f64> {
    Vector3::from_column_slice(&numbers(value))
}

fn matrix<const ROWS: usize, const COLUMNS: usize>(value: &Value) -> SMatrix<f64, ROWS, COLUMNS> {
    SMatrix::from_row_slice(&numbers(value))
}

#[test]
fn closed_form_matches_dem_mc() {
    let file = vectors("dem_mc.json");
    let dem = ThreeLinkDem::<f64>::table_2();
    let states = file["states"].as_array().unwrap();
    assert_eq!(states.len(), 40);
    for state in states {
        let (q, velocity) = (vector3(&state["q"]), vector3(&state["qd"]));
        let coriolis = dem.coriolis_matrix(&q, &velocity);
        assert_close("M", &dem.mass_matrix(&q), &matrix::<3, 3>(&state["M"]), MATRIX_TOLERANCE);
        assert_close("C", &coriolis, &matrix::<3, 3>(&state["C"]), MATRIX_TOLERANCE);
        assert_close("C q̇", &(coriolis * velocity), &vector3(&state["Cqd"]), MATRIX_TOLERANCE);
        let acceleration = dem.forward_dynamics(&q, &velocity, &vector3(&state["tau"]));
        assert_close("q̈", &acceleration, &vector3(&state["qdd"]), MATRIX_TOLERANCE);
    }
}

#[test]
fn reduced_dynamics_match_reduced_json() {
    let file = vectors("reduced.json");
    let dem = ThreeLinkDem::<f64>::table_2();
    let states = file["matrices"]["states"].as_array().unwrap();
    assert_eq!(states.len(), 15);
    for state in states {
        let (q, velocity, torque) = (vector3(&state["q"]), vector3(&state["qd"]), vector3(&state["tau"]));
        let (joint_velocity, joint_torque) =
            (velocity.fixed_rows::<2>(1).into_owned(), torque.fixed_rows::<2>(1).into_owned());
        let reduced = dem.reduced(&q, &joint_velocity);
        let momentum = dem.angular_momentum(&q, &velocity);
        assert_close("M̄", &reduced.mass, &matrix::<2, 2>(&state["Mbar"]), REDUCED_TOLERANCE);
        assert_close("C̄", &reduced.coriolis, &matrix::<2, 2>(&state["Cbar"]), REDUCED_TOLERANCE);
        assert_close("A", &reduced.base_coupling, &matrix::<1, 2>(&state["A"]), REDUCED_TOLERANCE);
        assert_close(
            "M_bb",
            &Vector2::repeat(reduced.mass_bb),
            &Vector2::repeat(state["M11"].as_f64().unwrap()),
            REDUCED_TOLERANCE,
        );
        assert_close(
            "p",
            &Vector2::repeat(momentum),
            &Vector2::repeat(state["p"].as_f64().unwrap()),
            REDUCED_TOLERANCE,
        );
        assert_close("G", &reduced.gyroscopic, &matrix::<2, 2>(&state["G_per_p"]), REDUCED_TOLERANCE);
        assert_close("g", &reduced.momentum_gradient, &matrix::<2, 1>(&state["g_per_p2"]), REDUCED_TOLERANCE);

        let acceleration = |momentum, torque| -> Vector2<f64> {
            let bias = reduced.arm_torque(&Vector2::zeros(), &joint_velocity, momentum);
            reduced.mass.cholesky().unwrap().solve(&(torque - bias))
        };
        let force = joint_torque - reduced.base_coupling.transpose() * torque.x;
        assert_close("q̈_m", &acceleration(momentum, force), &matrix::<2, 1>(&state["qdd_m"]), REDUCED_TOLERANCE);
        assert_close(
            "q̈_m at p = 0",
            &acceleration(0.0, joint_torque),
            &matrix::<2, 1>(&state["qdd_m_p0"]),
            REDUCED_TOLERANCE,
        );
    }
}

fn planar_case<const LINKS: usize, const JOINTS: usize>(case: &Value) -> PlanarDem<f64, LINKS> {
    let [mass, inertia, right, left] = ["m", "I", "R", "L"].map(|key| numbers(&case["sm"][key]));
    let spacecraft = SpacecraftBody { mass: mass[0], inertia: inertia[0], centre_of_mass_to_joint: right[0] };
    let links = core::array::from_fn(|index| SpaceLink {
        mass: mass[index + 1],
        inertia: inertia[index + 1],
        joint_to_centre_of_mass: left[index + 1],
        centre_of_mass_to_joint: right[index + 1],
    });
    let dem = PlanarSpaceManipulator::<f64, LINKS>::new(spacecraft, links).unwrap().dynamically_equivalent();

    let expected = &case["dem"];
    assert!(expected["m"][0].is_null(), "m_1 is not defined by the map");
    let near = |name: &str, index: usize, found: f64| {
        let wanted = expected[name][index].as_f64().unwrap();
        assert!((found - wanted).abs() <= MATRIX_TOLERANCE * wanted.abs(), "{name}[{index}]: {found} is not {wanted}");
    };
    near("I", 0, dem.base().inertia);
    near("W", 0, dem.base().length);
    for (index, link) in dem.links().iter().enumerate() {
        near("m", index + 1, link.mass);
        near("I", index + 1, link.inertia);
        near("W", index + 1, link.length);
        near("lc", index + 1, link.centre_of_mass);
    }

    let state = &case["state"];
    let [q, velocity] = ["q", "qd"].map(|key| SVector::<f64, JOINTS>::from_column_slice(&numbers(&state[key])));
    assert_close("M", &dem.mass_matrix(&q), &matrix::<JOINTS, JOINTS>(&state["M"]), MATRIX_TOLERANCE);
    let force = dem.coriolis_matrix(&q, &velocity) * velocity;
    assert_close("C q̇", &force, &matrix::<JOINTS, 1>(&state["Cqd"]), MATRIX_TOLERANCE);
    dem
}

#[test]
fn planar_map_matches_dem_map() {
    let file = vectors("dem_map.json");
    let cases = file["planar"].as_array().unwrap();
    assert_eq!(cases.len(), 3);
    for case in cases {
        match case["n"].as_u64().unwrap() {
            2 => {
                let dem = planar_case::<2, 3>(case).closed_form().unwrap();
                let state = &case["state"];
                let (q, velocity) = (vector3(&state["q"]), vector3(&state["qd"]));
                assert_close("M", &dem.mass_matrix(&q), &matrix::<3, 3>(&state["M"]), MATRIX_TOLERANCE);
                let coriolis: Matrix3<f64> = dem.coriolis_matrix(&q, &velocity);
                assert_close("C q̇", &(coriolis * velocity), &vector3(&state["Cqd"]), MATRIX_TOLERANCE);
            }
            3 => drop(planar_case::<3, 4>(case)),
            links => panic!("no case of {links} links is known"),
        }
    }
}

#[test]
fn spatial_map_matches_dem_map() {
    let file = vectors("dem_map.json");
    let cases = file["spatial"].as_array().unwrap();
    assert_eq!(cases.len(), 1);
    let (space, expected) = (&cases[0]["sm"], &cases[0]["dem"]);
    let mass = numbers(&space["m"]);
    let inertia = |index: usize| matrix::<3, 3>(&space["I"][index]);
    let spacecraft =
        SpacecraftBody { mass: mass[0], inertia: inertia(0), centre_of_mass_to_joint: vector3(&space["R"][0]) };
    let links: [_; 3] = core::array::from_fn(|index| SpaceLink {
        mass: mass[index + 1],
        inertia: inertia(index + 1),
        joint_to_centre_of_mass: vector3(&space["L"][index + 1]),
        centre_of_mass_to_joint: vector3(&space["R"][index + 1]),
    });
    let dem = SpatialSpaceManipulator::new(spacecraft, links).unwrap().dynamically_equivalent();

    let close = |name: &str, index: usize, found: &Vector3<f64>| {
        assert_close(name, found, &vector3(&expected[name][index]), MATRIX_TOLERANCE);
    };
    close("W", 0, &dem.base().length);
    assert_eq!(dem.base().inertia, matrix::<3, 3>(&expected["I"][0]));
    for (index, link) in dem.links().iter().enumerate() {
        let wanted = expected["m"][index + 1].as_f64().unwrap();
        assert!((link.mass - wanted).abs() <= MATRIX_TOLERANCE * wanted, "m[{}]", index + 1);
        close("W", index + 1, &link.length);
        close("lc", index + 1, &link.centre_of_mass);
        assert_eq!(link.inertia, matrix::<3, 3>(&expected["I"][index + 1]));
    }
}

#[test]
fn table_1_gives_every_printed_digit_of_table_2() {
    let dem = PlanarSpaceManipulator::<f64, 2>::table_1().dynamically_equivalent();
    let [second, third] = dem.links();
    let printed = |values: &[f64]| values.iter().map(|value| format!("{value:.3}")).collect::<Vec<_>>();
    assert_eq!(printed(&[second.mass, third.mass]), ["0.850", "0.625"]);
    assert_eq!(printed(&[dem.base().length, second.length, third.length]), ["0.203"; 3]);
    assert_eq!(printed(&[second.centre_of_mass, third.centre_of_mass]), ["0.096", "0.077"]);
    assert_eq!([dem.base().inertia, second.inertia, third.inertia], [0.0153, 0.0075, 0.0060]);

    let robot = ThreeLinkDem::<f64>::table_2();
    let [second, third] = robot.links();
    assert_eq!([second.mass, third.mass, second.centre_of_mass, third.centre_of_mass], [0.850, 0.625, 0.096, 0.077]);
    assert_eq!([robot.base().length, second.length, third.length], [0.203; 3]);
    assert_eq!([robot.base().inertia, second.inertia, third.inertia], [0.0153, 0.0075, 0.0060]);
}
