//! Links and joints of a URDF, as they stand.

use std::collections::{BTreeMap, BTreeSet};

use dem_model::nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};
use roxmltree::{Document, Node, ParsingOptions};

use crate::error::UrdfError;
use crate::rigid_body::RigidBody;

/// Numbers in a URDF are at most so large: beyond it, products of masses and lengths lose their meaning.
const LARGEST: f64 = 1e12;
/// What Xacro's elements are in.
const XACRO: &str = "xacro";

/// How a joint of a URDF moves.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Kind {
    Fixed,
    Revolute,
    Continuous,
    Prismatic,
    /// Any other, by its name.
    Other(String),
}

/// The range of a joint's coordinate, and what its motor can do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// The least coordinate in rad or m; none where the joint is continuous, or the file has neither this nor the largest.
    pub lower: Option<f64>,
    /// The largest coordinate in rad or m.
    pub upper: Option<f64>,
    /// The largest torque in N·m, or force in N.
    pub effort: f64,
    /// The largest velocity in rad/s or m/s.
    pub velocity: f64,
}

#[derive(Debug, Clone)]
pub(crate) struct Joint {
    pub name: String,
    pub line: u32,
    pub kind: Kind,
    pub parent: String,
    pub child: String,
    /// From the child's frame to the parent's while the coordinate is zero.
    pub origin: Isometry3<f64>,
    /// In the child's frame.
    pub axis: Vector3<f64>,
    pub limits: Option<Limits>,
    /// The joint whose motion it follows.
    pub mimics: Option<String>,
}

/// A URDF.
#[derive(Debug, Clone)]
pub(crate) struct Robot {
    pub name: String,
    /// What each link weighs, in its own frame.
    pub links: BTreeMap<String, RigidBody>,
    pub joints: Vec<Joint>,
}

/// Where the lines of a text end. Found once: a document knows the line of an element by reading all before it.
struct Lines(Vec<usize>);

impl Lines {
    fn of(text: &str) -> Self {
        Self(text.match_indices('\n').map(|(end, _)| end).collect())
    }

    /// The line in which an element begins, from 1.
    fn line(&self, node: &Node<'_, '_>) -> u32 {
        let before = self.0.partition_point(|end| *end < node.range().start);
        u32::try_from(before + 1).unwrap_or(u32::MAX)
    }
}

/// An element, with the name of the link or joint that it belongs to.
struct Part<'a, 'input> {
    node: Node<'a, 'input>,
    of: &'a str,
    lines: &'a Lines,
}

fn number(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|number: &f64| number.abs() <= LARGEST)
}

impl<'a> Part<'a, '_> {
    fn line(&self) -> u32 {
        self.lines.line(&self.node)
    }

    /// The only child of this name.
    fn child(&self, name: &str) -> Result<Option<Self>, UrdfError> {
        let mut found = self.node.children().filter(|child| child.has_tag_name(name));
        let first = found.next();
        match found.next() {
            None => Ok(first.map(|node| Self { node, ..*self })),
            Some(second) => {
                Err(UrdfError::Twice { line: self.lines.line(&second), of: format!("<{name}> of {:?}", self.of) })
            }
        }
    }

    fn required(&self, name: &'static str, what: &'static str) -> Result<Self, UrdfError> {
        self.child(name)?.ok_or_else(|| self.missing(what))
    }

    fn missing(&self, what: &'static str) -> UrdfError {
        UrdfError::Missing { line: self.line(), of: self.of.to_owned(), what }
    }

    fn text(&self, attribute: &str, what: &'static str) -> Result<&'a str, UrdfError> {
        match self.node.attribute(attribute) {
            None => Err(self.missing(what)),
            Some("") => Err(self.refuse(what, "", "a name")),
            Some(text) => Ok(text),
        }
    }

    fn number(&self, attribute: &str, what: &'static str) -> Result<Option<f64>, UrdfError> {
        let Some(found) = self.node.attribute(attribute) else { return Ok(None) };
        number(found).map(Some).ok_or_else(|| self.refuse(what, found, "a number of at most 1e12"))
    }

    /// A number that cannot be negative, 0 where there is none.
    fn magnitude(&self, attribute: &str, what: &'static str) -> Result<f64, UrdfError> {
        match self.number(attribute, what)? {
            Some(number) if number < 0.0 => Err(self.refuse(what, &number.to_string(), "a number >= 0")),
            number => Ok(number.unwrap_or(0.0)),
        }
    }

    fn vector(&self, attribute: &str, what: &'static str) -> Result<Option<Vector3<f64>>, UrdfError> {
        let Some(found) = self.node.attribute(attribute) else { return Ok(None) };
        let numbers: Option<Vec<f64>> = found.split_whitespace().map(number).collect();
        match numbers.as_deref() {
            Some([x, y, z]) => Ok(Some(Vector3::new(*x, *y, *z))),
            _ => Err(self.refuse(what, found, "three numbers of at most 1e12")),
        }
    }

    fn refuse(&self, attribute: &'static str, found: &str, expected: &'static str) -> UrdfError {
        UrdfError::Attribute { line: self.line(), of: self.of.to_owned(), attribute, found: found.to_owned(), expected }
    }

    /// The pose of the element's `<origin>`: roll, pitch and yaw about the fixed axes x, y and z, in this order.
    fn origin(&self) -> Result<Isometry3<f64>, UrdfError> {
        let Some(origin) = self.child("origin")? else { return Ok(Isometry3::identity()) };
        let place = origin.vector("xyz", "origin xyz")?.unwrap_or_default();
        let turn = origin.vector("rpy", "origin rpy")?.unwrap_or_default();
        Ok(Isometry3::from_parts(Translation3::from(place), UnitQuaternion::from_euler_angles(turn.x, turn.y, turn.z)))
    }

    fn inertial(&self) -> Result<RigidBody, UrdfError> {
        let Some(inertial) = self.child("inertial")? else { return Ok(RigidBody::none()) };
        let mass = inertial.required("mass", "<mass> in <inertial>")?;
        mass.text("value", "value in <mass>")?;
        let mass = mass.magnitude("value", "mass value")?;
        let tensor = inertial.required("inertia", "<inertia> in <inertial>")?;
        let mut entries = [0.0; 6];
        for (entry, name) in entries.iter_mut().zip(["ixx", "ixy", "ixz", "iyy", "iyz", "izz"]) {
            *entry = tensor.number(name, "inertia ixx to izz")?.unwrap_or(0.0);
        }
        let [xx, xy, xz, yy, yz, zz] = entries;
        let inertia = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        Ok(RigidBody::about_centre(mass, &Vector3::zeros(), &inertia).moved(&inertial.origin()?))
    }

    fn limits(&self, kind: &Kind) -> Result<Option<Limits>, UrdfError> {
        let Some(limit) = self.child("limit")? else { return Ok(None) };
        let has_range =
            *kind != Kind::Continuous && ["lower", "upper"].iter().any(|name| limit.node.has_attribute(*name));
        let bound = |attribute, what| {
            let bound = limit.number(attribute, what)?;
            Ok::<_, UrdfError>(has_range.then(|| bound.unwrap_or(0.0)))
        };
        let limits = Limits {
            lower: bound("lower", "limit lower")?,
            upper: bound("upper", "limit upper")?,
            effort: limit.magnitude("effort", "limit effort")?,
            velocity: limit.magnitude("velocity", "limit velocity")?,
        };
        match (limits.lower, limits.upper) {
            (Some(lower), Some(upper)) if lower > upper => {
                Err(limit.refuse("limit upper", &upper.to_string(), "no less than lower"))
            }
            _ => Ok(Some(limits)),
        }
    }
}

impl Robot {
    /// Reads a document. Meshes, transmissions and other elements are left out.
    pub fn parse(text: &str) -> Result<Self, UrdfError> {
        let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
        let document =
            Document::parse_with_options(text, options).map_err(|error| UrdfError::Xml(error.to_string()))?;
        let lines = Lines::of(text);
        let line = |node: &Node<'_, '_>| lines.line(node);
        let root = document.root_element();
        if !root.has_tag_name("robot") {
            return Err(UrdfError::NoRobot { line: line(&root), found: root.tag_name().name().to_owned() });
        }
        let of_xacro = |node: &Node<'_, '_>| node.tag_name().namespace().is_some_and(|name| name.contains(XACRO));
        if let Some(node) = root.descendants().find(of_xacro) {
            return Err(UrdfError::Xacro { line: line(&node) });
        }
        let mut robot = Self {
            name: root.attribute("name").unwrap_or("robot").to_owned(),
            links: BTreeMap::new(),
            joints: Vec::new(),
        };
        for node in root.children().filter(|node| node.has_tag_name("link")) {
            let lines = &lines;
            let name = Part { node, of: "a link", lines }.text("name", "name")?;
            let body = Part { node, of: name, lines }.inertial()?;
            if robot.links.insert(name.to_owned(), body).is_some() {
                return Err(UrdfError::Twice { line: line(&node), of: format!("link {name:?}") });
            }
        }
        if robot.links.is_empty() {
            return Err(UrdfError::NoLinks { line: line(&root) });
        }
        let (mut names, mut children) = (BTreeSet::new(), BTreeSet::new());
        for node in root.children().filter(|node| node.has_tag_name("joint")) {
            let joint = robot.joint(node, &lines)?;
            if !names.insert(joint.name.clone()) {
                return Err(UrdfError::Twice { line: joint.line, of: format!("joint {:?}", joint.name) });
            }
            if !children.insert(joint.child.clone()) {
                return Err(UrdfError::NoTree { line: joint.line, link: joint.child });
            }
            robot.joints.push(joint);
        }
        Ok(robot)
    }

    fn joint(&self, node: Node<'_, '_>, lines: &Lines) -> Result<Joint, UrdfError> {
        let name = Part { node, of: "a joint", lines }.text("name", "name")?;
        let part = Part { node, of: name, lines };
        let kind = match part.text("type", "type")? {
            "fixed" => Kind::Fixed,
            "revolute" => Kind::Revolute,
            "continuous" => Kind::Continuous,
            "prismatic" => Kind::Prismatic,
            other => Kind::Other(other.to_owned()),
        };
        let link =
            |name, what| part.required(name, what)?.text("link", "link in <parent> or <child>").map(str::to_owned);
        let (parent, child) = (link("parent", "<parent>")?, link("child", "<child>")?);
        for link in [&parent, &child] {
            if !self.links.contains_key(link) {
                let (joint, link) = (name.to_owned(), link.clone());
                return Err(UrdfError::NoSuchLink { line: part.line(), joint, link });
            }
        }
        let mimics = match part.child("mimic")? {
            Some(mimic) => Some(mimic.text("joint", "joint in <mimic>")?.to_owned()),
            None => None,
        };
        let axis = match part.child("axis")? {
            Some(axis) => axis.vector("xyz", "axis xyz")?.unwrap_or_else(Vector3::x),
            None => Vector3::x(),
        };
        Ok(Joint {
            name: name.to_owned(),
            line: part.line(),
            limits: part.limits(&kind)?,
            kind,
            parent,
            child,
            origin: part.origin()?,
            axis,
            mimics,
        })
    }
}
