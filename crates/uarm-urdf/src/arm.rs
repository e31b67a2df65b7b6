//! From the tree of a URDF to a spacecraft and a serial arm.

use std::collections::BTreeSet;

use dem_model::nalgebra::{Matrix3, Vector3};
use dem_model::{Body, Joint, JointMotion, ParameterError, SpaceLink, SpacecraftBody, SpatialSpaceManipulator};

use crate::document::{self, Kind, Limits, Robot};
use crate::error::UrdfError;
use crate::rigid_body::{RigidBody, misses_triangle_inequality};
use crate::tree::{Outboard, Tree};

/// Which part of the tree is the space manipulator.
#[derive(Debug, Clone, Default)]
pub struct Selection {
    /// The link that is the spacecraft, or that is fixed to it; the root where none is named.
    pub base: Option<String>,
    /// The link whose frame is the end effector's; the only end of the arm where none is named.
    pub tip: Option<String>,
    /// A spacecraft that the file does not have, joined to the base link: its centre of mass is at the origin of the base
    /// link's frame. For an arm that is described without one.
    pub spacecraft: Option<Spacecraft>,
}

/// A spacecraft that a URDF does not have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spacecraft {
    mass: f64,
    inertia: Matrix3<f64>,
}

impl Spacecraft {
    /// A spacecraft of `mass` kg, with the `inertia` about its centre of mass, in axes of the base link, in kg·m².
    ///
    /// None unless the mass is finite and positive, and the inertia finite, symmetric, positive definite, and without a principal
    /// moment that is larger than the two others together.
    pub fn new(mass: f64, inertia: Matrix3<f64>) -> Option<Self> {
        let is_symmetric = inertia == inertia.transpose() && inertia.iter().all(|entry| entry.is_finite());
        let is_inertia = is_symmetric && inertia.cholesky().is_some() && !misses_triangle_inequality(&inertia);
        (mass > 0.0 && mass.is_finite() && is_inertia).then_some(Self { mass, inertia })
    }
}

/// A joint of the arm.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmJoint {
    /// Its name.
    pub name: String,
    /// How it moves.
    pub motion: JointMotion,
    /// Its axis in axes of the base, while all coordinates are zero.
    pub axis: Vector3<f64>,
    /// Its place in the base link's frame in m, while all coordinates are zero.
    pub place: Vector3<f64>,
    /// What the file says of its range and motor, if it does.
    pub limits: Option<Limits>,
}

/// A link of the arm with all that is fixed to it.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmLink {
    /// The name of the link at the inboard joint.
    pub name: String,
    /// The links that are joined to it.
    pub merged: Vec<String>,
    /// In the base link's frame, while all coordinates are zero.
    pub body: RigidBody,
}

impl ArmJoint {
    fn new(joint: &document::Joint, outboard: &Outboard<'_>) -> Result<Self, UrdfError> {
        let motion = match &joint.kind {
            Kind::Revolute | Kind::Continuous | Kind::Fixed => JointMotion::Revolute,
            Kind::Prismatic => JointMotion::Prismatic,
            Kind::Other(kind) => {
                return Err(UrdfError::JointKind {
                    line: joint.line,
                    joint: joint.name.clone(),
                    kind: kind.clone(),
                    child: joint.child.clone(),
                });
            }
        };
        if let Some(mimics) = joint.mimics.clone() {
            return Err(UrdfError::Mimic { line: joint.line, joint: joint.name.clone(), mimics });
        }
        let pose = outboard.pose(&joint.child);
        Ok(Self {
            name: joint.name.clone(),
            motion,
            axis: pose.rotation * joint.axis,
            place: pose.translation.vector,
            limits: joint.limits,
        })
    }
}

impl ArmLink {
    /// The first of these links, with the others.
    fn group(robot: &Robot, outboard: &Outboard<'_>, links: &[&str]) -> Self {
        let bodies = links.iter().filter_map(|link| Some(robot.links.get(*link)?.moved(&outboard.pose(link))));
        let body = bodies.fold(RigidBody::none(), |group, body| group.joined(&body));
        let mut names = links.iter().map(|link| (*link).to_owned());
        Self { name: names.next().unwrap_or_default(), merged: names.collect(), body }
    }

    /// Whether no body can have this inertia: one of its principal moments is larger than the two others together, by more
    /// than files round.
    pub fn has_impossible_inertia(&self) -> bool {
        misses_triangle_inequality(&self.body.inertia)
    }
}

/// A spacecraft and a serial arm, all in the base link's frame while all coordinates are zero.
#[derive(Debug, Clone, PartialEq)]
pub struct Arm {
    /// The robot's name.
    pub name: String,
    /// The spacecraft.
    pub spacecraft: ArmLink,
    /// The joints, from the spacecraft outwards.
    pub joints: Vec<ArmJoint>,
    /// The link outboard of each joint.
    pub links: Vec<ArmLink>,
    /// Where the end effector is, in m.
    pub tip: Vector3<f64>,
    /// Joints that could move and are taken as fixed at zero, since they are not between base and tip.
    pub locked: Vec<String>,
}

impl Arm {
    /// The names of the bodies whose inertia no body can have, from the spacecraft outwards.
    pub fn impossible_inertias(&self) -> Vec<String> {
        let bodies = [&self.spacecraft].into_iter().chain(&self.links);
        bodies.filter(|link| link.has_impossible_inertia()).map(|link| link.name.clone()).collect()
    }

    /// Reads a URDF.
    ///
    /// Links joined by fixed joints become one body. Joints beside the path from base to tip are taken as fixed at zero, and
    /// named in [`Arm::locked`].
    ///
    /// # Errors
    /// [`UrdfError`] if the file is no URDF of a serial arm, with the line or the link.
    pub fn parse(text: &str, selection: &Selection) -> Result<Self, UrdfError> {
        let robot = Robot::parse(text)?;
        let tree = Tree::new(&robot)?;
        let base = tree.base(selection.base.as_deref())?;
        let outboard = tree.outboard_of(base);
        let tip = tree.tip(base, &outboard, selection.tip.as_deref())?;
        let path = tree.path(base, tip)?;
        let moving: Vec<&document::Joint> = path.into_iter().filter(|joint| joint.kind != Kind::Fixed).collect();
        let names: BTreeSet<&str> = moving.iter().map(|joint| joint.name.as_str()).collect();
        let is_moving = |joint: &document::Joint| names.contains(joint.name.as_str());
        let group = |link| ArmLink::group(&robot, &outboard, &tree.walk(link, |joint| !is_moving(joint)));
        let mut spacecraft = group(base);
        if let Some(given) = selection.spacecraft {
            let body = RigidBody::about_centre(given.mass, &Vector3::zeros(), &given.inertia);
            spacecraft.body = spacecraft.body.joined(&body);
        }
        let is_locked = |joint: &&document::Joint| {
            let is_outboard = joint.child != base && outboard.poses.contains_key(joint.child.as_str());
            is_outboard && joint.kind != Kind::Fixed && !is_moving(joint)
        };
        let arm = Self {
            name: robot.name.clone(),
            spacecraft,
            joints: moving.iter().map(|joint| ArmJoint::new(joint, &outboard)).collect::<Result<_, _>>()?,
            links: moving.iter().map(|joint| group(&joint.child)).collect(),
            tip: outboard.pose(tip).translation.vector,
            locked: robot.joints.iter().filter(is_locked).map(|joint| joint.name.clone()).collect(),
        };
        let lacks = |link: &&ArmLink| link.body.mass <= 0.0;
        if lacks(&&arm.spacecraft) {
            let ArmLink { name, body, .. } = arm.spacecraft;
            return Err(UrdfError::NoSpacecraft { link: name, found: body.mass });
        }
        if let Some(ArmLink { name, body, .. }) = arm.links.iter().find(lacks) {
            return Err(UrdfError::NoMass { link: name.clone(), found: body.mass });
        }
        Ok(arm)
    }

    /// The space manipulator and its joints for `dem-model`. The frame of the spacecraft lies in its centre of mass and is
    /// parallel to the base link's; the frames of the links are parallel to it while all coordinates are zero.
    ///
    /// # Errors
    /// [`UrdfError::Joints`] if the arm has another number of joints, [`UrdfError::Parameters`] if a body's inertia is none.
    pub fn space_manipulator<const N: usize>(
        &self,
    ) -> Result<(SpatialSpaceManipulator<f64, N>, [Joint<f64>; N]), UrdfError> {
        let count = UrdfError::Joints { found: self.joints.len(), expected: N };
        let ends = self.joints.iter().skip(1).map(|joint| joint.place).chain([self.tip]);
        let links: Vec<_> = self
            .links
            .iter()
            .zip(&self.joints)
            .zip(ends)
            .map(|((link, joint), end)| SpaceLink {
                mass: link.body.mass,
                inertia: link.body.inertia,
                joint_to_centre_of_mass: link.body.centre - joint.place,
                centre_of_mass_to_joint: end - link.body.centre,
            })
            .collect();
        let links: [SpaceLink<f64, Vector3<f64>, Matrix3<f64>>; N] = links.try_into().map_err(|_| count.clone())?;
        let joints: Vec<_> = self
            .joints
            .iter()
            .enumerate()
            .map(|(index, joint)| Joint::new(joint.motion, joint.axis, Body::Link(index + 2)))
            .collect::<Result<_, _>>()
            .map_err(|source| self.named(source))?;
        let body = &self.spacecraft.body;
        let first = self.joints.first().map_or(self.tip, |joint| joint.place);
        let spacecraft =
            SpacecraftBody { mass: body.mass, inertia: body.inertia, centre_of_mass_to_joint: first - body.centre };
        let manipulator = SpatialSpaceManipulator::new(spacecraft, links).map_err(|source| self.named(source))?;
        Ok((manipulator, joints.try_into().map_err(|_| count)?))
    }

    pub(crate) fn named(&self, source: ParameterError) -> UrdfError {
        let body = match &source {
            ParameterError::OutOfRange { body, .. }
            | ParameterError::InertiaNotPositiveDefinite { body }
            | ParameterError::NoAxis { body } => Some(*body),
            _ => None,
        };
        let link = match body {
            Some(Body::Link(number)) => self.links.get(number.saturating_sub(2)),
            _ => Some(&self.spacecraft),
        };
        UrdfError::Parameters { link: link.map_or_else(String::new, |link| link.name.clone()), source }
    }
}
