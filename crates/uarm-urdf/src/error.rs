//! Why a URDF is refused.

use dem_model::ParameterError;

/// A URDF that does not describe a space manipulator.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum UrdfError {
    /// It is not well-formed XML.
    #[error("not XML: {0}")]
    Xml(String),
    /// The root element is another.
    #[error("line {line}: <{found}>, expected <robot>")]
    NoRobot {
        /// The line of the element in the file, from 1.
        line: u32,
        /// The element found.
        found: String,
    },
    /// It is Xacro's source of a URDF.
    #[error("line {line}: an element of Xacro, expected the URDF that xacro makes of it")]
    Xacro {
        /// The line of the element in the file, from 1.
        line: u32,
    },
    /// There is no link.
    #[error("line {line}: <robot> has no <link>")]
    NoLinks {
        /// The line of the element in the file, from 1.
        line: u32,
    },
    /// An element lacks a child or an attribute.
    #[error("line {line}: {of} has no {what}")]
    Missing {
        /// The line of the element in the file, from 1.
        line: u32,
        /// The link or joint.
        of: String,
        /// What is missing.
        what: &'static str,
    },
    /// An attribute holds something else than it should.
    #[error("line {line}: {of}: {attribute} = {found:?}, expected {expected}")]
    Attribute {
        /// The line of the element in the file, from 1.
        line: u32,
        /// The link or joint.
        of: String,
        /// The element and its attribute.
        attribute: &'static str,
        /// What it holds.
        found: String,
        /// What it should hold.
        expected: &'static str,
    },
    /// Two elements have one name.
    #[error("line {line}: {of} is there twice")]
    Twice {
        /// The line of the second in the file, from 1.
        line: u32,
        /// The link or joint.
        of: String,
    },
    /// A joint names a link that is not there.
    #[error("line {line}: joint {joint:?}: no link {link:?}")]
    NoSuchLink {
        /// The line of the element in the file, from 1.
        line: u32,
        /// The joint.
        joint: String,
        /// The link.
        link: String,
    },
    /// A link is its own ancestor.
    #[error("line {line}: link {link:?} is outboard of itself, expected a tree")]
    Loop {
        /// The line of a joint of the loop, from 1.
        line: u32,
        /// A link of the loop.
        link: String,
    },
    /// A link has two parents.
    #[error("line {line}: link {link:?} has a second parent, expected a tree")]
    NoTree {
        /// The line of the joint that names it a second time, from 1.
        line: u32,
        /// The link.
        link: String,
    },
    /// No link, or more than one, is nobody's child.
    #[error("{found} links without a parent ({names}), expected one")]
    Roots {
        /// The number of such links.
        found: usize,
        /// Their names, quoted.
        names: String,
    },
    /// A link was asked for that is not there.
    #[error("no link {asked:?}, expected one of {names}")]
    Unknown {
        /// The link asked for.
        asked: String,
        /// Those there are.
        names: String,
    },
    /// The tip is not beyond the base.
    #[error("link {tip:?} is not outboard of link {base:?}")]
    NotOutboard {
        /// The tip asked for.
        tip: String,
        /// The base.
        base: String,
    },
    /// The arm branches, and no tip was named.
    #[error("the arm ends in {names}, expected one to be named as its tip")]
    Tips {
        /// The ends.
        names: String,
    },
    /// There is no arm.
    #[error("no joint outboard of link {base:?} moves, expected an arm")]
    NoArm {
        /// The base.
        base: String,
    },
    /// A joint of the arm has no motor of its own.
    #[error(
        "line {line}: joint {joint:?} mimics joint {mimics:?}, expected joints that move by themselves between base and tip"
    )]
    Mimic {
        /// The line of the element in the file, from 1.
        line: u32,
        /// The joint.
        joint: String,
        /// The joint that it follows.
        mimics: String,
    },
    /// A joint of the arm is of a kind that no motor drives alone.
    #[error(
        "line {line}: joint {joint:?} is {kind}, expected revolute, continuous, prismatic or fixed between base and tip"
    )]
    JointKind {
        /// The line of the element in the file, from 1.
        line: u32,
        /// The joint.
        joint: String,
        /// Its kind.
        kind: String,
        /// The link outboard of it.
        child: String,
    },
    /// The number of joints is another than asked for.
    #[error("{found} joints between base and tip, expected {expected}")]
    Joints {
        /// How many there are.
        found: usize,
        /// How many were asked for.
        expected: usize,
    },
    /// The arm leaves a plane.
    #[error("{of:?} does not move in one plane with the others: expected {expected}")]
    NotPlanar {
        /// The joint or link.
        of: String,
        /// What it should have.
        expected: String,
    },
    /// A body that moves has no mass.
    #[error("link {link:?} has no mass: with all that is fixed to it, mass_kg = {found}, expected a finite value > 0")]
    NoMass {
        /// The link at its inboard joint.
        link: String,
        /// The mass found.
        found: f64,
    },
    /// The base has no mass.
    #[error(
        "link {link:?} is no spacecraft: with all that is fixed to it, mass_kg = {found}, expected a finite value > 0"
    )]
    NoSpacecraft {
        /// The base.
        link: String,
        /// The mass found.
        found: f64,
    },
    /// The values of a link are none that a body can have.
    #[error("link {link:?}: {source}")]
    Parameters {
        /// The link at its inboard joint, or the base.
        link: String,
        /// What dem-model refuses.
        source: ParameterError,
    },
}
