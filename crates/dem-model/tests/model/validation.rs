//! What is refused, and what the messages say.

use dem_model::{
    Body, DemBase, DemLink, Joint, JointMotion, ParameterError, PlanarDem, PlanarSpaceManipulator, SpaceLink,
    SpacecraftBody, SpatialDem, SpatialSpaceManipulator, SphericalBaseManipulator, ThreeLinkDem,
};
use nalgebra::{Matrix3, Vector3};

fn table_2() -> (DemBase<f64>, [DemLink<f64>; 2]) {
    let dem = ThreeLinkDem::table_2();
    (*dem.base(), *dem.links())
}

#[test]
fn table_parameters_pass_their_own_checks() {
    let (base, links) = table_2();
    assert_eq!(ThreeLinkDem::new(base, links), Ok(ThreeLinkDem::table_2()));
    let dem = ThreeLinkDem::<f32>::table_2();
    assert_eq!(ThreeLinkDem::new(*dem.base(), *dem.links()), Ok(dem));
    let space = PlanarSpaceManipulator::<f64, 2>::table_1();
    assert_eq!(PlanarSpaceManipulator::new(*space.spacecraft(), *space.links()), Ok(space));
}

#[test]
fn each_field_of_a_dem_is_checked() {
    type Change = fn(&mut DemBase<f64>, &mut [DemLink<f64>; 2]);
    let changes: [(Change, &str); 8] = [
        (|base, _| base.inertia = 0.0, "base (link 1): inertia is 0, expected a finite value > 0"),
        (|base, _| base.length = -0.2, "base (link 1): length is -0.2, expected a finite value >= 0"),
        (|_, links| links[0].mass = -1.0, "link 2: mass is -1, expected a finite value > 0"),
        (|_, links| links[1].mass = f64::NAN, "link 3: mass is NaN, expected a finite value > 0"),
        (|_, links| links[0].inertia = f64::INFINITY, "link 2: inertia is inf, expected a finite value > 0"),
        (|_, links| links[1].length = -0.1, "link 3: length is -0.1, expected a finite value >= 0"),
        (|_, links| links[0].centre_of_mass = -0.1, "link 2: centre_of_mass is -0.1, expected a finite value >= 0"),
        (|_, links| links[1].centre_of_mass = f64::NAN, "link 3: centre_of_mass is NaN, expected a finite value >= 0"),
    ];
    for (change, message) in changes {
        let (mut base, mut links) = table_2();
        change(&mut base, &mut links);
        assert_eq!(ThreeLinkDem::new(base, links).unwrap_err().to_string(), message);
        assert_eq!(PlanarDem::new(base, links).unwrap_err().to_string(), message);
    }
}

#[test]
fn each_field_of_a_planar_space_manipulator_is_checked() {
    let table = PlanarSpaceManipulator::<f64, 2>::table_1();
    let mut spacecraft = *table.spacecraft();
    spacecraft.mass = 0.0;
    let error = PlanarSpaceManipulator::new(spacecraft, *table.links()).unwrap_err();
    assert_eq!(error.to_string(), "spacecraft (link 1): mass is 0, expected a finite value > 0");
    let mut links = *table.links();
    links[1].joint_to_centre_of_mass = -0.085;
    let error = PlanarSpaceManipulator::new(*table.spacecraft(), links).unwrap_err();
    assert_eq!(error.to_string(), "link 3: joint_to_centre_of_mass is -0.085, expected a finite value >= 0");
}

#[test]
fn inertia_tensors_are_checked() {
    let spacecraft =
        |inertia| SpacecraftBody { mass: 1.0, inertia, centre_of_mass_to_joint: Vector3::new(0.1, -0.2, 0.3) };
    let accepted = |inertia| SpatialSpaceManipulator::<f64, 0>::new(spacecraft(inertia), []);
    assert!(accepted(Matrix3::identity()).is_ok());
    let refused = ParameterError::InertiaNotPositiveDefinite { body: Body::Spacecraft };
    assert_eq!(accepted(Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, 1.0))), Err(refused));
    // Relative to its entries, a rotated tensor is symmetric but for rounding.
    let mut rotated = Matrix3::from_diagonal_element(1e3);
    rotated.m12 = 1e-6;
    assert!(accepted(rotated).is_ok());
    let mut skewed = Matrix3::identity();
    skewed.m12 = 0.1;
    assert_eq!(accepted(skewed), Err(refused));
    skewed.m12 = f64::NAN;
    let message = accepted(skewed).unwrap_err().to_string();
    assert_eq!(message, "spacecraft (link 1): inertia is NaN, expected a finite value");
}

/// Any finite vector is a distance in space, and nothing else.
#[test]
fn distances_in_space_are_checked() {
    let space = |joint, centre_of_mass| {
        let inertia = Matrix3::identity();
        let spacecraft = SpacecraftBody { mass: 1.0, inertia, centre_of_mass_to_joint: joint };
        let (joint_to_centre_of_mass, centre_of_mass_to_joint) = (centre_of_mass, Vector3::zeros());
        let link = SpaceLink { mass: 1.0, inertia, joint_to_centre_of_mass, centre_of_mass_to_joint };
        SpatialSpaceManipulator::<f64, 1>::new(spacecraft, [link])
    };
    let (legal, illegal) = (Vector3::new(-0.1, 0.0, 0.3), Vector3::new(0.1, 0.2, f64::INFINITY));
    assert!(space(legal, legal).is_ok());
    let message = space(illegal, legal).unwrap_err().to_string();
    assert_eq!(message, "spacecraft (link 1): centre_of_mass_to_joint is inf, expected a finite value");
    let message = space(legal, illegal).unwrap_err().to_string();
    assert_eq!(message, "link 2: joint_to_centre_of_mass is inf, expected a finite value");
}

/// The least inertia that is taken keeps M positive definite in floating point, in every configuration.
#[test]
fn an_inertia_lost_in_rounding_is_refused() {
    let with_inertia = |inertia: f32| {
        let (mass, length, centre_of_mass) = (3.0, 0.7, 0.7);
        let link = DemLink { mass, inertia, length, centre_of_mass };
        ThreeLinkDem::new(DemBase { inertia, length }, [link; 2])
    };
    let Err(ParameterError::InertiaLostInRounding { least, .. }) = with_inertia(1e-9) else {
        panic!("an inertia of 1e-9 kg m^2 beside 10 kg m^2 cannot be told apart in f32");
    };
    let dem = with_inertia(least as f32 * 1.01).unwrap();
    for step in 0..1_000 {
        let (q2, q3) = ((step % 40) as f32 * 0.16, (step / 40) as f32 * 0.26);
        let q = Vector3::new(0.3, q2, q3);
        assert!(dem.mass_matrix(&q).cholesky().is_some(), "M is not positive definite at {q}");
        let acceleration = dem.forward_dynamics(&q, &Vector3::new(1.0, -2.0, 1.5), &Vector3::repeat(1.0));
        assert!(acceleration.iter().all(|entry| entry.is_finite()), "no acceleration at {q}");
    }
}

/// The least inertia that is taken, at each body alone and at all: what is solved differs from M q̈ = f by some roundings of the
/// largest that a term of the row can be, √(M_ii M_jj) |q̈_j|.
#[test]
fn forward_dynamics_is_backward_stable_up_to_the_least_inertia() {
    let with_inertias = |inertias: [f32; 3]| {
        let [base, second, third] = inertias;
        let link = |inertia| DemLink { mass: 3.0, inertia, length: 0.7, centre_of_mass: 0.7 };
        ThreeLinkDem::new(DemBase { inertia: base, length: 0.7 }, [link(second), link(third)])
    };
    let few_of = |inertias: fn(f32) -> [f32; 3]| {
        let Err(ParameterError::InertiaLostInRounding { least, .. }) = with_inertias(inertias(1e-9)) else {
            panic!("an inertia of 1e-9 kg m^2 beside 10 kg m^2 cannot be told apart in f32");
        };
        with_inertias(inertias(least as f32 * 1.01)).unwrap()
    };
    let bodies: [fn(f32) -> [f32; 3]; 5] = [
        |least| [least; 3],
        |least| [least, 1.0, 1.0],
        |least| [1.0, least, 1.0],
        |least| [1.0, 1.0, least],
        |least| [1e4, least, least],
    ];
    for (number, dem) in bodies.map(few_of).into_iter().enumerate() {
        for step in 0..1_000 {
            let (q2, q3) = ((step % 40) as f32 * 0.16, (step / 40) as f32 * 0.26);
            let (q, force) = (Vector3::new(0.3, q2, q3), Vector3::new(1.0, -0.5, 0.25));
            let acceleration = dem.forward_dynamics(&q, &Vector3::zeros(), &force).cast::<f64>();
            let mass = dem.mass_matrix(&q).cast::<f64>();
            let residual = mass * acceleration - force.cast::<f64>();
            for row in 0..3 {
                let terms = (0..3)
                    .map(|column| (mass[(row, row)] * mass[(column, column)]).sqrt() * acceleration[column].abs());
                let allowed = 4.0 * f64::from(f32::EPSILON) * terms.sum::<f64>();
                assert!(residual[row].abs() <= allowed, "case {number} at {q}: {:e} > {allowed:e}", residual[row]);
            }
        }
    }
}

#[test]
fn mass_and_coriolis_of_one_state_are_those_of_each() {
    let (dem, q, velocity) =
        (ThreeLinkDem::<f64>::table_2(), Vector3::new(0.1, 0.9, 0.6), Vector3::new(-0.3, 0.5, 0.3));
    assert_eq!(dem.mass_and_coriolis(&q, &velocity), (dem.mass_matrix(&q), dem.coriolis_matrix(&q, &velocity)));
}

/// A heavy spacecraft under a light arm: badly scaled, but not badly conditioned.
#[test]
fn a_heavy_spacecraft_is_taken_in_single_precision() {
    fn heavy<T: dem_model::Scalar>() -> ThreeLinkDem<T> {
        let value = T::constant;
        let link = |mass, inertia| DemLink {
            mass: value(mass),
            inertia: value(inertia),
            length: value(0.5),
            centre_of_mass: value(0.25),
        };
        let base = DemBase { inertia: value(6200.0), length: value(1.0) };
        ThreeLinkDem::new(base, [link(5.0, 0.1), link(2.0, 0.05)]).unwrap()
    }
    let (single, double) = (heavy::<f32>(), heavy::<f64>());
    let velocity = Vector3::new(0.01, 0.3, -0.2);
    let force = Vector3::new(0.0, 0.5, -0.25);
    for step in 0..400 {
        let q = Vector3::new(0.0, f64::from(step % 20) * 0.3, f64::from(step / 20) * 0.3);
        let expected = double.forward_dynamics(&q, &velocity, &force);
        let found = single.forward_dynamics(&q.cast(), &velocity.cast(), &force.cast());
        for (found, expected) in found.iter().zip(expected.iter()) {
            assert!(
                (f64::from(*found) - expected).abs() < 1e-4 * expected.abs().max(1e-2),
                "{found} {expected} at {q}"
            );
        }
    }
}

#[test]
fn what_is_not_finite_stays_so() {
    let dem = ThreeLinkDem::<f64>::table_2();
    let at_nan = dem.forward_dynamics(&Vector3::new(0.0, f64::NAN, 0.0), &Vector3::zeros(), &Vector3::zeros());
    assert!(at_nan.iter().all(|entry| entry.is_nan()));
}

#[test]
fn an_axis_has_a_direction_and_any_length() {
    let joint = |axis: [f64; 3]| Joint::new(JointMotion::Revolute, axis.into(), Body::Link(3));
    for length in [1e-300, 1.0, 1e300] {
        let axis = joint([0.0, -length, length]).unwrap().axis();
        assert!((axis.y + 0.5_f64.sqrt()).abs() < 1e-15 && (axis.z - 0.5_f64.sqrt()).abs() < 1e-15, "{axis:?}");
    }
    for axis in [[0.0; 3], [f64::NAN, 1.0, 0.0], [f64::INFINITY, 0.0, 0.0]] {
        let error = joint(axis).unwrap_err().to_string();
        assert_eq!(error, "link 3: joint axis has no direction, expected a finite vector other than zero", "{axis:?}");
    }
}

#[test]
fn a_dem_of_given_parameters_has_no_prismatic_joint() {
    let vector = Vector3::new(0.1, 0.0, 0.2);
    let inertia = Matrix3::from_diagonal_element(0.01);
    let link = DemLink { mass: 1.0, inertia, length: vector, centre_of_mass: vector };
    let dem = SpatialDem::new(DemBase { inertia, length: vector }, [link; 2]).unwrap();
    let joint = |motion| Joint::new(motion, Vector3::z(), Body::Link(2)).unwrap();
    let joints = [joint(JointMotion::Revolute), joint(JointMotion::Prismatic)];
    let error = SphericalBaseManipulator::new(&dem, joints).unwrap_err();
    assert_eq!(error, ParameterError::PrismaticDem { body: Body::Link(3) });
    assert!(SphericalBaseManipulator::new(&dem, [joints[0]; 2]).is_ok());
}
