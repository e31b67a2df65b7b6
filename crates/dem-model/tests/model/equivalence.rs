//! Liang's theorem without integration: a space manipulator, seen from its centre of mass, and its DEM have the same
//! kinetic energy in every state, hence the same equations of motion, and the same end effector.

use crate::common::random::{angles, signals, space_manipulator};
use dem_model::{PlanarSpaceManipulator, SpaceLink, SpacecraftBody, SpatialSpaceManipulator};
use nalgebra::{Matrix3, Rotation3, SVector, Vector2, Vector3, Vector4};
use proptest::prelude::*;

/// Sums of some tens of products, relative to their greatest term.
const ROUNDING: f64 = 1e-13;

/// A planar space manipulator in one state, seen from its spacecraft's centre of mass.
struct Planar {
    masses: Vec<f64>,
    centres: Vec<Vector2<f64>>,
    velocities: Vec<Vector2<f64>>,
    turning_energy: f64,
    end_effector: Vector2<f64>,
    orientation: f64,
}

impl Planar {
    fn new<const LINKS: usize>(space: &PlanarSpaceManipulator<f64, LINKS>, q: &[f64], velocity: &[f64]) -> Self {
        let (mut angle, mut turning) = (q[0], velocity[0]);
        let along = |length: f64, angle: f64| Vector2::new(angle.cos(), angle.sin()) * length;
        let moved =
            |length: f64, angle: f64, turning: f64| Vector2::new(-angle.sin(), angle.cos()) * (length * turning);
        let first = space.spacecraft();
        let mut joint = along(first.centre_of_mass_to_joint, angle);
        let mut joint_velocity = moved(first.centre_of_mass_to_joint, angle, turning);
        let (mut masses, mut centres, mut velocities) =
            (vec![first.mass], vec![Vector2::zeros()], vec![Vector2::zeros()]);
        let mut turning_energy = 0.5 * first.inertia * turning * turning;
        for (index, link) in space.links().iter().enumerate() {
            angle += q[index + 1];
            turning += velocity[index + 1];
            let length = link.joint_to_centre_of_mass + link.centre_of_mass_to_joint;
            masses.push(link.mass);
            centres.push(joint + along(link.joint_to_centre_of_mass, angle));
            velocities.push(joint_velocity + moved(link.joint_to_centre_of_mass, angle, turning));
            joint += along(length, angle);
            joint_velocity += moved(length, angle, turning);
            turning_energy += 0.5 * link.inertia * turning * turning;
        }
        Self { masses, centres, velocities, turning_energy, end_effector: joint, orientation: angle }
    }

    fn kinetic_energy(&self) -> f64 {
        self.turning_energy + relative_energy(&self.masses, &self.velocities)
    }
}

/// The mean of the vectors, weighted with the masses.
fn mean<const SIZE: usize>(masses: &[f64], vectors: &[SVector<f64, SIZE>]) -> SVector<f64, SIZE> {
    let sum: SVector<f64, SIZE> = vectors.iter().zip(masses).map(|(vector, mass)| vector * *mass).sum();
    sum / masses.iter().sum::<f64>()
}

/// ½ Σ m |v − v̄|² with v̄ the velocity of the common centre of mass.
fn relative_energy<const SIZE: usize>(masses: &[f64], velocities: &[SVector<f64, SIZE>]) -> f64 {
    let mean = mean(masses, velocities);
    velocities.iter().zip(masses).map(|(velocity, mass)| 0.5 * mass * (velocity - mean).norm_squared()).sum()
}

/// A body's orientation and angular velocity, in the fixed frame.
type Motion = (Rotation3<f64>, Vector3<f64>);

fn turning_energy(inertia: &Matrix3<f64>, (rotation, angular_velocity): &Motion) -> f64 {
    let in_body = rotation.inverse() * angular_velocity;
    0.5 * in_body.dot(&(inertia * in_body))
}

/// The velocity by which a vector fixed in a body moves.
fn carried(vector: &Vector3<f64>, (rotation, angular_velocity): &Motion) -> Vector3<f64> {
    angular_velocity.cross(&(rotation * vector))
}

fn spatial_energies(space: &SpatialSpaceManipulator<f64, 2>, motions: &[Motion; 3]) -> (f64, f64) {
    let dem = space.dynamically_equivalent();
    let mut space_energy = turning_energy(&space.spacecraft().inertia, &motions[0]);
    let mut dem_energy = turning_energy(&dem.base().inertia, &motions[0]);
    let mut space_joint = carried(&space.spacecraft().centre_of_mass_to_joint, &motions[0]);
    let mut dem_joint = carried(&dem.base().length, &motions[0]);
    let (mut masses, mut velocities) = (vec![space.spacecraft().mass], vec![Vector3::zeros()]);
    for ((link, dem_link), motion) in space.links().iter().zip(dem.links()).zip(&motions[1..]) {
        let velocity = space_joint + carried(&link.joint_to_centre_of_mass, motion);
        space_joint = velocity + carried(&link.centre_of_mass_to_joint, motion);
        masses.push(link.mass);
        velocities.push(velocity);
        space_energy += turning_energy(&link.inertia, motion);

        let dem_velocity = dem_joint + carried(&dem_link.centre_of_mass, motion);
        dem_joint += carried(&dem_link.length, motion);
        dem_energy += turning_energy(&dem_link.inertia, motion) + 0.5 * dem_link.mass * dem_velocity.norm_squared();
    }
    (space_energy + relative_energy(&masses, &velocities), dem_energy)
}

prop_compose! {
    fn spatial_manipulator()(
        masses in proptest::array::uniform3(0.1..5.0),
        principal in proptest::array::uniform3(0.01..0.1),
        turns in proptest::array::uniform3(signals::<3>()),
        distances in proptest::array::uniform5(signals::<3>()),
    ) -> SpatialSpaceManipulator<f64, 2> {
        let inertia = |index: usize| {
            let rotation = Rotation3::new(turns[index]).into_inner();
            rotation * Matrix3::from_diagonal(&Vector3::from(principal)) * rotation.transpose()
        };
        let spacecraft = SpacecraftBody {
            mass: masses[0],
            inertia: inertia(0),
            centre_of_mass_to_joint: distances[0],
        };
        let link = |index: usize| SpaceLink {
            mass: masses[index],
            inertia: inertia(index),
            joint_to_centre_of_mass: distances[2 * index - 1],
            centre_of_mass_to_joint: distances[2 * index],
        };
        SpatialSpaceManipulator::new(spacecraft, [link(1), link(2)]).unwrap()
    }
}

fn motion() -> impl Strategy<Value = Motion> {
    (signals::<3>(), signals::<3>()).prop_map(|(turn, angular_velocity)| (Rotation3::new(turn), angular_velocity))
}

proptest! {
    #[test]
    fn planar_kinetic_energies_are_equal(space in space_manipulator(), q in angles::<4>(), velocity in signals::<4>()) {
        let dem = space.dynamically_equivalent();
        let dem_energy = 0.5 * velocity.dot(&(dem.mass_matrix(&q) * velocity));
        let space_energy = Planar::new(&space, q.as_slice(), velocity.as_slice()).kinetic_energy();
        let scale = dem.mass_matrix(&Vector4::zeros()).trace() * velocity.norm_squared();
        prop_assert!((dem_energy - space_energy).abs() <= ROUNDING * scale, "{dem_energy} is not {space_energy}");
    }

    #[test]
    fn spatial_kinetic_energies_are_equal(
        space in spatial_manipulator(), motions in [motion(), motion(), motion()],
    ) {
        let (space_energy, dem_energy) = spatial_energies(&space, &motions);
        // Velocities of up to 25 m/s of bodies of up to 15 kg.
        let scale = 1e4_f64.max(space_energy);
        prop_assert!((dem_energy - space_energy).abs() <= ROUNDING * scale, "{dem_energy} is not {space_energy}");
    }

    #[test]
    fn end_effectors_coincide(q in angles::<3>()) {
        let space = PlanarSpaceManipulator::<f64, 2>::table_1();
        let planar = Planar::new(&space, q.as_slice(), &[0.0; 3]);
        let seen = planar.end_effector - mean(&planar.masses, &planar.centres);
        let pose = space.dynamically_equivalent().closed_form().unwrap().end_effector(&q);
        prop_assert!((pose.position - seen).amax() <= 1e-15, "{} is not {seen}", pose.position);
        prop_assert!((pose.orientation - planar.orientation).abs() <= 1e-15);
    }
}
