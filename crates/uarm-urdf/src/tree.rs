//! The tree of links, walked from the base outwards.

use std::collections::{BTreeMap, BTreeSet};

use dem_model::nalgebra::Isometry3;

use crate::document::{Joint, Kind, Robot};
use crate::error::UrdfError;

/// Links by their names, and the joints between them.
pub(crate) struct Tree<'a> {
    robot: &'a Robot,
    /// The joint inboard of a link.
    inboard: BTreeMap<&'a str, &'a Joint>,
    /// The joints outboard of a link, in the order of the file.
    outboard: BTreeMap<&'a str, Vec<&'a Joint>>,
}

/// The base, and what is outboard of it, while all coordinates are zero.
pub(crate) struct Outboard<'a> {
    /// From a link's frame to the base's.
    pub poses: BTreeMap<&'a str, Isometry3<f64>>,
    /// Links that some joint moves.
    moved: BTreeSet<&'a str>,
}

impl<'a> Tree<'a> {
    pub fn new(robot: &'a Robot) -> Result<Self, UrdfError> {
        let mut outboard: BTreeMap<_, Vec<_>> = BTreeMap::new();
        for joint in &robot.joints {
            outboard.entry(joint.parent.as_str()).or_default().push(joint);
        }
        let inboard = robot.joints.iter().map(|joint| (joint.child.as_str(), joint)).collect();
        let tree = Self { robot, inboard, outboard };
        // Each link has one parent at most: what no root leads to is a loop, or outboard of one.
        let reached: BTreeSet<_> = tree.roots().flat_map(|root| tree.walk(root, |_| true)).collect();
        match robot.joints.iter().find(|joint| !reached.contains(joint.child.as_str())) {
            Some(joint) => Err(UrdfError::Loop { line: joint.line, link: joint.child.clone() }),
            None => Ok(tree),
        }
    }

    fn links(&self) -> impl Iterator<Item = &'a str> {
        self.robot.links.keys().map(String::as_str)
    }

    fn roots(&self) -> impl Iterator<Item = &'a str> {
        self.links().filter(|link| !self.inboard.contains_key(link))
    }

    fn joints_of(&self, link: &str) -> &[&'a Joint] {
        self.outboard.get(link).map_or(&[], Vec::as_slice)
    }

    /// A link and those that joints lead to which are `through`, each after the one inboard of it.
    pub fn walk(&self, from: &'a str, through: impl Fn(&Joint) -> bool) -> Vec<&'a str> {
        let (mut waiting, mut walked) = (vec![from], Vec::new());
        while let Some(link) = waiting.pop() {
            walked.push(link);
            waiting
                .extend(self.joints_of(link).iter().filter(|joint| through(joint)).map(|joint| joint.child.as_str()));
        }
        walked
    }

    /// The base asked for, or the only root.
    pub fn base(&self, asked: Option<&str>) -> Result<&'a str, UrdfError> {
        if let Some(asked) = asked {
            return self.link(asked);
        }
        let roots: Vec<&str> = self.roots().collect();
        match roots.as_slice() {
            [root] => Ok(root),
            _ => Err(UrdfError::Roots { found: roots.len(), names: quoted(&roots) }),
        }
    }

    fn link(&self, asked: &str) -> Result<&'a str, UrdfError> {
        self.links().find(|name| *name == asked).ok_or_else(|| UrdfError::Unknown {
            asked: asked.to_owned(),
            names: quoted(&self.links().collect::<Vec<_>>()),
        })
    }

    /// What is outboard of a base.
    pub fn outboard_of(&self, base: &'a str) -> Outboard<'a> {
        let mut found = Outboard { poses: BTreeMap::from([(base, Isometry3::identity())]), moved: BTreeSet::new() };
        for link in self.walk(base, |_| true).into_iter().skip(1) {
            let Some(joint) = self.inboard.get(link) else { continue };
            let parent = joint.parent.as_str();
            found.poses.insert(link, found.pose(parent) * joint.origin);
            if joint.kind != Kind::Fixed || found.moved.contains(parent) {
                found.moved.insert(link);
            }
        }
        found
    }

    /// The end of the arm: the tip asked for, or the outermost link of the only branch that has moving joints.
    pub fn tip(&self, base: &str, outboard: &Outboard<'a>, asked: Option<&str>) -> Result<&'a str, UrdfError> {
        if let Some(asked) = asked {
            return self.link(asked);
        }
        let ends: Vec<&str> = outboard.moved.iter().copied().filter(|link| self.joints_of(link).is_empty()).collect();
        match ends.as_slice() {
            [end] => Ok(end),
            [] => Err(UrdfError::NoArm { base: base.to_owned() }),
            _ => Err(UrdfError::Tips { names: quoted(&ends) }),
        }
    }

    /// The joints from base to tip.
    pub fn path(&self, base: &str, tip: &str) -> Result<Vec<&'a Joint>, UrdfError> {
        let inwards = |joint: &&'a Joint| self.inboard.get(joint.parent.as_str()).copied();
        let mut path: Vec<_> = std::iter::successors(self.inboard.get(tip).copied(), inwards)
            .take_while(|joint| joint.child != base)
            .collect();
        path.reverse();
        match path.first() {
            Some(first) if first.parent == base => Ok(path),
            _ => Err(UrdfError::NotOutboard { tip: tip.to_owned(), base: base.to_owned() }),
        }
    }
}

impl Outboard<'_> {
    /// From a link's frame to the base's.
    pub fn pose(&self, link: &str) -> Isometry3<f64> {
        self.poses.get(link).copied().unwrap_or_default()
    }
}

fn quoted(names: &[&str]) -> String {
    names.iter().map(|name| format!("{name:?}")).collect::<Vec<_>>().join(", ")
}
