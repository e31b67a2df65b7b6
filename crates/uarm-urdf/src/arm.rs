//! From the tree of a URDF to a spacecraft and a serial arm.

use std::collections::BTreeMap;

use dem_model::nalgebra::{Isometry3, Matrix3, Vector3};
use dem_model::{Body, Joint, JointMotion, ParameterError, SpaceLink, SpacecraftBody, SpatialSpaceManipulator};

use crate::document::{self, Kind, Limits, Robot};
use crate::error::UrdfError;
use crate::rigid_body::RigidBody;

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
    /// In kg; > 0.
    pub mass: f64,
    /// About its centre of mass, in axes of the base link, in kg·m².
    pub inertia: Matrix3<f64>,
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

/// The tree, by the names of links.
struct Tree<'a> {
    robot: &'a Robot,
    /// The joint inboard of a link.
    inboard: BTreeMap<&'a str, &'a document::Joint>,
}

impl Arm {
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
        let tip = tree.tip(base, selection.tip.as_deref())?;
        let path = tree.path(base, tip)?;
        let moving: Vec<&document::Joint> = path.iter().copied().filter(|joint| joint.kind != Kind::Fixed).collect();
        let mut spacecraft = tree.group(base, base, &moving);
        if let Some(given) = selection.spacecraft {
            let body = RigidBody::about_centre(given.mass, &Vector3::zeros(), &given.inertia);
            spacecraft.body = spacecraft.body.joined(&body);
        }
        let arm = Self {
            name: robot.name.clone(),
            spacecraft,
            joints: moving.iter().map(|joint| tree.arm_joint(base, joint)).collect::<Result<_, _>>()?,
            links: moving.iter().map(|joint| tree.group(base, &joint.child, &moving)).collect(),
            tip: tree.pose(base, tip).translation.vector,
            locked: tree.locked(base, &moving),
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

    fn named(&self, source: ParameterError) -> UrdfError {
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

impl<'a> Tree<'a> {
    fn new(robot: &'a Robot) -> Result<Self, UrdfError> {
        let inboard: BTreeMap<_, _> = robot.joints.iter().map(|joint| (joint.child.as_str(), joint)).collect();
        let tree = Self { robot, inboard };
        // Each link leads to a link without a parent, or to itself.
        for joint in &robot.joints {
            if tree.ancestors(&joint.child).count() > robot.joints.len() {
                return Err(UrdfError::NoTree { line: joint.line, link: joint.child.clone() });
            }
        }
        Ok(tree)
    }

    /// The joints from a link inwards.
    fn ancestors(&self, link: &str) -> impl Iterator<Item = &'a document::Joint> {
        let most = self.robot.joints.len() + 1;
        let next = |joint: &&'a document::Joint| self.inboard.get(joint.parent.as_str()).copied();
        std::iter::successors(self.inboard.get(link).copied(), next).take(most)
    }

    fn base(&self, asked: Option<&str>) -> Result<&'a str, UrdfError> {
        if let Some(asked) = asked {
            return self.link(asked);
        }
        let roots: Vec<&str> =
            self.robot.links.keys().map(String::as_str).filter(|link| !self.inboard.contains_key(link)).collect();
        match roots.as_slice() {
            [root] => Ok(root),
            _ => Err(UrdfError::Roots { found: roots.len(), names: quoted(&roots) }),
        }
    }

    fn link(&self, asked: &str) -> Result<&'a str, UrdfError> {
        let names: Vec<&str> = self.robot.links.keys().map(String::as_str).collect();
        let found = names.iter().find(|name| **name == asked).copied();
        found.ok_or_else(|| UrdfError::Unknown { asked: asked.to_owned(), names: quoted(&names) })
    }

    /// The end of the arm: the tip asked for, or the outermost link of the only branch that has moving joints.
    fn tip(&self, base: &str, asked: Option<&str>) -> Result<&'a str, UrdfError> {
        if let Some(asked) = asked {
            return self.link(asked);
        }
        let is_end = |link: &&str| !self.robot.joints.iter().any(|joint| joint.parent == **link);
        let moves =
            |link: &&str| self.path(base, link).is_ok_and(|path| path.iter().any(|joint| joint.kind != Kind::Fixed));
        let ends: Vec<&'a str> = self.robot.links.keys().map(String::as_str).filter(is_end).filter(moves).collect();
        match ends.as_slice() {
            [end] => Ok(end),
            _ => Err(UrdfError::Tips { names: quoted(&ends) }),
        }
    }

    /// The joints from base to tip.
    fn path(&self, base: &str, tip: &str) -> Result<Vec<&'a document::Joint>, UrdfError> {
        let mut path: Vec<_> = self.ancestors(tip).take_while(|joint| joint.child != base).collect();
        path.reverse();
        match path.first() {
            Some(first) if first.parent == base => Ok(path),
            _ => Err(UrdfError::NotOutboard { tip: tip.to_owned(), base: base.to_owned() }),
        }
    }

    /// From a link's frame to the base's, while all coordinates are zero.
    fn pose(&self, base: &str, link: &str) -> Isometry3<f64> {
        let inwards = self.ancestors(link).take_while(|joint| joint.child != base);
        inwards.fold(Isometry3::identity(), |pose, joint| joint.origin * pose)
    }

    /// A link with all that moves as it does: the links outboard of it but for those beyond the joints that move.
    fn group(&self, base: &str, link: &'a str, moving: &[&document::Joint]) -> ArmLink {
        let mut group = ArmLink { name: link.to_owned(), merged: Vec::new(), body: RigidBody::none() };
        let mut waiting = vec![link];
        while let Some(name) = waiting.pop() {
            if let Some(body) = self.robot.links.get(name) {
                group.body = group.body.joined(&body.moved(&self.pose(base, name)));
            }
            if name != link {
                group.merged.push(name.to_owned());
            }
            let rigid = |joint: &&document::Joint| !moving.iter().any(|other| other.name == joint.name);
            let outboard = self.robot.joints.iter().filter(|joint| joint.parent == name).filter(rigid);
            waiting.extend(outboard.map(|joint| joint.child.as_str()));
        }
        group
    }

    fn arm_joint(&self, base: &str, joint: &document::Joint) -> Result<ArmJoint, UrdfError> {
        let pose = self.pose(base, &joint.child);
        let motion = match &joint.kind {
            Kind::Revolute | Kind::Continuous | Kind::Fixed => JointMotion::Revolute,
            Kind::Prismatic => JointMotion::Prismatic,
            Kind::Other(kind) => {
                let (joint, line) = (joint.name.clone(), joint.line);
                return Err(UrdfError::JointKind { line, joint, kind: kind.clone() });
            }
        };
        Ok(ArmJoint {
            name: joint.name.clone(),
            motion,
            axis: pose.rotation * joint.axis,
            place: pose.translation.vector,
            limits: joint.limits,
        })
    }

    /// Joints outboard of the base that are not fixed and not on the path.
    fn locked(&self, base: &str, moving: &[&document::Joint]) -> Vec<String> {
        let outboard = |joint: &&document::Joint| {
            joint.child != base && self.ancestors(&joint.child).any(|inner| inner.parent == base)
        };
        let beside = |joint: &&document::Joint| {
            joint.kind != Kind::Fixed && !moving.iter().any(|other| other.name == joint.name)
        };
        self.robot.joints.iter().filter(outboard).filter(beside).map(|joint| joint.name.clone()).collect()
    }
}

fn quoted(names: &[&str]) -> String {
    names.iter().map(|name| format!("{name:?}")).collect::<Vec<_>>().join(", ")
}
