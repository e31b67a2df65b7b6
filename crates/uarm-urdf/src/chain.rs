//! What is written: bodies in a chain on a base.

use dem_model::nalgebra::{Matrix3, Vector3};
use dem_model::{DemBase, Joint, JointMotion, SpatialDem, SpatialSpaceManipulator};

use crate::document::Limits;

/// How the first body is carried.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Base {
    /// It floats: a space manipulator.
    Floating,
    /// It turns about a fixed spherical joint at its origin: the DEM in space.
    Spherical,
    /// It turns about the z axis of a fixed joint at its origin: the DEM in the plane.
    Planar,
}

/// A body; its frame's origin is its inboard joint, that of the first its centre of mass.
#[derive(Debug, Clone, PartialEq)]
pub struct ChainBody {
    /// Its name.
    pub name: String,
    /// In kg.
    pub mass: f64,
    /// Its centre of mass in m.
    pub centre: Vector3<f64>,
    /// About the centre of mass in kg·m².
    pub inertia: Matrix3<f64>,
}

/// A joint between a body and the one before.
#[derive(Debug, Clone, PartialEq)]
pub struct ChainJoint {
    /// Its name.
    pub name: String,
    /// How it moves.
    pub motion: JointMotion,
    /// Its unit axis.
    pub axis: Vector3<f64>,
    /// Its place in the frame of the body before, in m.
    pub place: Vector3<f64>,
    /// Range and motor.
    pub limits: Option<Limits>,
}

/// Bodies and joints from the base outwards; all frames are parallel while all coordinates are zero.
#[derive(Debug, Clone, PartialEq)]
pub struct Chain {
    /// The robot's name.
    pub name: String,
    /// How the first body is carried.
    pub base: Base,
    /// The first body.
    pub first: ChainBody,
    /// The joints, each with the body outboard of it.
    pub links: Vec<(ChainJoint, ChainBody)>,
    /// The end effector in the frame of the last body, in m.
    pub tip: Vector3<f64>,
}

/// What the bodies and joints of a chain are called.
#[derive(Debug, Clone, PartialEq)]
pub struct Names {
    /// The robot.
    pub robot: String,
    /// The spacecraft, or the base.
    pub first: String,
    /// Each joint, its limits, and the link outboard of it.
    pub links: Vec<(String, Option<Limits>, String)>,
}

impl Names {
    /// Numbers, as in the paper: the spacecraft is link 1, joint i is inboard of link i.
    pub fn numbered(robot: &str, first: &str, joints: usize) -> Self {
        let link = |number| (format!("joint_{number}"), None, format!("link_{number}"));
        Self { robot: robot.to_owned(), first: first.to_owned(), links: (2..joints + 2).map(link).collect() }
    }
}

/// A body without a name, and where the next joint or the end effector is.
struct Segment {
    mass: f64,
    centre: Vector3<f64>,
    inertia: Matrix3<f64>,
    length: Vector3<f64>,
}

impl Segment {
    fn named(self, name: &str) -> ChainBody {
        ChainBody { name: name.to_owned(), mass: self.mass, centre: self.centre, inertia: self.inertia }
    }
}

impl Chain {
    /// A space manipulator.
    pub fn space_manipulator<const N: usize>(
        names: &Names,
        manipulator: &SpatialSpaceManipulator<f64, N>,
        joints: &[Joint<f64>; N],
    ) -> Self {
        let spacecraft = manipulator.spacecraft();
        let bodies = manipulator.links().map(|link| Segment {
            mass: link.mass,
            centre: link.joint_to_centre_of_mass,
            inertia: link.inertia,
            length: link.joint_to_centre_of_mass + link.centre_of_mass_to_joint,
        });
        let first = Segment {
            mass: spacecraft.mass,
            centre: Vector3::zeros(),
            inertia: spacecraft.inertia,
            length: spacecraft.centre_of_mass_to_joint,
        };
        Self::new(names, Base::Floating, first, bodies, joints)
    }

    /// A DEM of revolute joints on a `base` that turns. The mass of the base has no effect and is `base_mass`, in kg.
    ///
    /// None for a prismatic joint: it moves the DEM's link by a part of its coordinate, which neither format can say.
    pub fn equivalent<const N: usize>(
        names: &Names,
        base: Base,
        base_mass: f64,
        dem: &SpatialDem<f64, N>,
        joints: &[Joint<f64>; N],
    ) -> Option<Self> {
        if joints.iter().any(|joint| joint.motion() == JointMotion::Prismatic) {
            return None;
        }
        let bodies = dem.links().map(|link| Segment {
            mass: link.mass,
            centre: link.centre_of_mass,
            inertia: link.inertia,
            length: link.length,
        });
        let DemBase { inertia, length } = *dem.base();
        let first = Segment { mass: base_mass, centre: Vector3::zeros(), inertia, length };
        Some(Self::new(names, base, first, bodies, joints))
    }

    fn new<const N: usize>(
        names: &Names,
        base: Base,
        first: Segment,
        bodies: [Segment; N],
        joints: &[Joint<f64>; N],
    ) -> Self {
        let mut place = first.length;
        let mut links = Vec::with_capacity(N);
        for ((body, joint), (joint_name, limits, name)) in bodies.into_iter().zip(joints).zip(&names.links) {
            let length = body.length;
            let joint = ChainJoint {
                name: joint_name.clone(),
                motion: joint.motion(),
                axis: joint.axis().into_inner(),
                place,
                limits: *limits,
            };
            links.push((joint, body.named(name)));
            place = length;
        }
        Self { name: names.robot.clone(), base, first: first.named(&names.first), links, tip: place }
    }
}
