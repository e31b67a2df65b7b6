//! Arms that move in a plane.

use dem_model::nalgebra::{Unit, Vector3};
use dem_model::{JointMotion, PlanarSpaceManipulator, SpaceLink, SpacecraftBody};

use crate::arm::{Arm, ArmLink};
use crate::error::UrdfError;

/// How far a body may miss the plane and the line of the arm, of the arm's length, and a principal axis its direction: files
/// that a CAD program wrote have a few digits.
const TOLERANCE: f64 = 1e-3;

/// The plane that an arm moves in, and the line that it lies on while all coordinates are zero.
struct Plane {
    normal: Unit<Vector3<f64>>,
    line: Unit<Vector3<f64>>,
    /// The longest distance that is taken for none, in m.
    tolerance: f64,
}

impl Plane {
    /// How far `vector` goes along the line, 0 if it goes back.
    fn along(&self, vector: &Vector3<f64>) -> f64 {
        vector.dot(&self.line).max(0.0)
    }

    /// The same of a `vector` from one point of `of` to another that must lie on the line and not go back.
    fn distance(&self, of: &str, vector: &Vector3<f64>) -> Result<f64, UrdfError> {
        let distance = vector.dot(&self.line);
        let off = (vector - self.line.into_inner() * distance).norm();
        if off > self.tolerance || distance < -self.tolerance {
            return Err(not_planar(
                of,
                format!(
                    "its joints and its centre of mass on the line from the spacecraft outwards while all coordinates are zero; \
                     one is {:.4} m off",
                    off.max(-distance)
                ),
            ));
        }
        Ok(self.along(vector))
    }

    /// The inertia of a link about the normal of the plane, in kg·m².
    fn inertia(&self, link: &ArmLink) -> Result<f64, UrdfError> {
        let column = link.body.inertia * self.normal.into_inner();
        let about = column.dot(&self.normal);
        if (column - self.normal.into_inner() * about).norm() > TOLERANCE * link.body.inertia.trace() {
            return Err(not_planar(&link.name, "the axis of the joints as a principal axis of its inertia".to_owned()));
        }
        Ok(about)
    }
}

fn not_planar(of: &str, expected: String) -> UrdfError {
    UrdfError::NotPlanar { of: of.to_owned(), expected }
}

impl Arm {
    /// The space manipulator in the plane: of revolute joints about one axis, with the centres of mass and all joints on one
    /// line across it while all coordinates are zero, and that axis principal for each body. Such an arm stays in its plane.
    ///
    /// # Errors
    /// [`UrdfError::Joints`] if the arm has another number of joints, [`UrdfError::NotPlanar`] with the joint or link that leaves
    /// the plane, [`UrdfError::Parameters`] if a body's values are none.
    pub fn planar<const N: usize>(&self) -> Result<PlanarSpaceManipulator<f64, N>, UrdfError> {
        let (manipulator, joints) = self.space_manipulator::<N>()?;
        let plane = self.plane(joints.each_ref().map(|joint| joint.axis()))?;
        let body = manipulator.spacecraft();
        let spacecraft = SpacecraftBody {
            mass: body.mass,
            inertia: plane.inertia(&self.spacecraft)?,
            centre_of_mass_to_joint: plane.distance(&self.spacecraft.name, &body.centre_of_mass_to_joint)?,
        };
        let mut links = Vec::with_capacity(N);
        for (index, (spatial, link)) in manipulator.links().iter().zip(&self.links).enumerate() {
            let is_last = index + 1 == N;
            let end = &spatial.centre_of_mass_to_joint;
            links.push(SpaceLink {
                mass: spatial.mass,
                inertia: plane.inertia(link)?,
                joint_to_centre_of_mass: plane.distance(&link.name, &spatial.joint_to_centre_of_mass)?,
                // Where the arm ends has no effect on its motion.
                centre_of_mass_to_joint: if is_last { plane.along(end) } else { plane.distance(&link.name, end)? },
            });
        }
        let found = links.len();
        let links = links.try_into().map_err(|_| UrdfError::Joints { found, expected: N })?;
        PlanarSpaceManipulator::new(spacecraft, links).map_err(|source| self.named(source))
    }

    fn plane<const N: usize>(&self, axes: [Unit<Vector3<f64>>; N]) -> Result<Plane, UrdfError> {
        let normal = axes.first().copied().unwrap_or_else(Vector3::z_axis);
        for (joint, axis) in self.joints.iter().zip(&axes) {
            if joint.motion != JointMotion::Revolute {
                return Err(not_planar(&joint.name, "a revolute joint".to_owned()));
            }
            if (axis.into_inner() - normal.into_inner()).norm() > TOLERANCE {
                return Err(not_planar(&joint.name, "the axis of the first joint, and its sense".to_owned()));
            }
        }
        let last = self.links.last().map_or(self.tip, |link| link.body.centre);
        let reach = last - self.spacecraft.body.centre;
        let expected = "the centre of mass of its last link away from the spacecraft's";
        let line = Unit::try_new(reach, 0.0).ok_or_else(|| not_planar(&self.name, expected.to_owned()))?;
        if line.dot(&normal).abs() > TOLERANCE {
            let expected = "an arm that lies across the axis of its joints while all coordinates are zero";
            return Err(not_planar(&self.name, expected.to_owned()));
        }
        Ok(Plane { normal, line, tolerance: TOLERANCE * reach.norm() })
    }
}
