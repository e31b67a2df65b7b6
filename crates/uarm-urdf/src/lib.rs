//! Space manipulators from URDF, and as URDF and MJCF.
//!
//! ```
//! use uarm_urdf::{Arm, Selection};
//!
//! let text = r#"<robot name="one joint">
//!   <link name="bus"><inertial><mass value="100"/><inertia ixx="9" iyy="9" izz="9"/></inertial></link>
//!   <link name="boom"><inertial><origin xyz="1 0 0"/><mass value="10"/>
//!     <inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial></link>
//!   <joint name="shoulder" type="continuous"><parent link="bus"/><child link="boom"/>
//!     <origin xyz="0.5 0 0"/><axis xyz="0 0 1"/></joint>
//! </robot>"#;
//! let arm = Arm::parse(text, &Selection::default())?;
//! let (manipulator, joints) = arm.space_manipulator::<1>()?;
//! assert_eq!(manipulator.total_mass(), 110.0);
//! assert_eq!(manipulator.spacecraft().centre_of_mass_to_joint.x, 0.5);
//! assert_eq!(joints[0].axis().z, 1.0);
//! # Ok::<(), uarm_urdf::UrdfError>(())
//! ```
//!
//! # Map
//!
//! | where | what |
//! |---|---|
//! | [`Arm`], [`Selection`] | a URDF as spacecraft and serial arm: base and tip, fixed joints merged; in space, or in the plane |
//! | [`Chain`] | what is written: bodies and joints on a base that floats, turns or stands |
//! | [`write_urdf`], [`write_mjcf`] | as URDF and MJCF |
//! | [`UrdfError`] | why a file is refused, with line, link or joint |
//!
//! Meshes, collision shapes, transmissions, friction and gravity are left out. Joint kinds: revolute, continuous, prismatic and
//! fixed. Closed loops are refused, and so are joints between base and tip that mimic another.
#![forbid(unsafe_code)]

mod arm;
mod chain;
mod document;
mod error;
mod mjcf;
mod names;
mod planar;
mod rigid_body;
mod tree;
mod urdf;

pub use arm::{Arm, ArmJoint, ArmLink, Selection, Spacecraft};
pub use chain::{Base, Chain, ChainBody, ChainJoint, Names};
pub use document::Limits;
pub use error::UrdfError;
pub use mjcf::write_mjcf;
pub use rigid_body::RigidBody;
pub use urdf::write_urdf;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
