//! A chain as URDF.

use dem_model::JointMotion;
use dem_model::nalgebra::Vector3;
use xmlwriter::{Options, XmlWriter};

use crate::chain::{Base, Chain, ChainBody, ChainJoint};
use crate::names::{escaped, free};

/// Three numbers, each the shortest that reads back as itself.
pub(crate) fn triple(vector: &Vector3<f64>) -> String {
    format!("{} {} {}", vector.x, vector.y, vector.z)
}

/// The chain as URDF: link frames are parallel while all coordinates are zero. URDF has no joint for a base: what carries the
/// first link is said in a comment, and has to be told to the program that reads the file. A last link without mass is the end
/// effector: `tool`, with an underscore where that name is taken.
pub fn write_urdf(chain: &Chain) -> String {
    let mut xml = XmlWriter::new(Options::default());
    xml.start_element("robot");
    xml.write_attribute("name", &escaped(&chain.name));
    xml.write_comment(match chain.base {
        Base::Floating => " The first link floats. No gravity. ",
        Base::Spherical => {
            " The first link turns about a passive spherical joint at its origin. No gravity. Its mass has no effect. "
        }
        Base::Planar => {
            " The first link turns about a passive joint at its origin, axis z. No gravity. Its mass has no effect. "
        }
    });
    write_link(&mut xml, &chain.first);
    let mut parent = &chain.first.name;
    for (joint, body) in &chain.links {
        write_link(&mut xml, body);
        write_joint(&mut xml, joint, parent, &body.name);
        parent = &body.name;
    }
    let links = std::iter::once(&chain.first).chain(chain.links.iter().map(|(_, body)| body));
    let tool = free("tool", links.map(|body| body.name.as_str()));
    let flange = free("tool", chain.links.iter().map(|(joint, _)| joint.name.as_str()));
    xml.start_element("link");
    xml.write_attribute("name", &tool);
    xml.end_element();
    start_joint(&mut xml, &flange, "fixed", parent, &tool);
    write_origin(&mut xml, &chain.tip);
    xml.end_element();
    xml.end_element();
    xml.end_document()
}

fn write_origin(xml: &mut XmlWriter, place: &Vector3<f64>) {
    xml.start_element("origin");
    xml.write_attribute("xyz", &triple(place));
    xml.write_attribute("rpy", "0 0 0");
    xml.end_element();
}

fn write_link(xml: &mut XmlWriter, body: &ChainBody) {
    xml.start_element("link");
    xml.write_attribute("name", &escaped(&body.name));
    xml.start_element("inertial");
    write_origin(xml, &body.centre);
    xml.start_element("mass");
    xml.write_attribute("value", &body.mass);
    xml.end_element();
    xml.start_element("inertia");
    let inertia = &body.inertia;
    for (name, value) in [
        ("ixx", inertia.m11),
        ("ixy", inertia.m12),
        ("ixz", inertia.m13),
        ("iyy", inertia.m22),
        ("iyz", inertia.m23),
        ("izz", inertia.m33),
    ] {
        xml.write_attribute(name, &value);
    }
    xml.end_element();
    xml.end_element();
    xml.end_element();
}

fn start_joint(xml: &mut XmlWriter, name: &str, kind: &str, parent: &str, child: &str) {
    xml.start_element("joint");
    xml.write_attribute("name", &escaped(name));
    xml.write_attribute("type", kind);
    for (element, link) in [("parent", parent), ("child", child)] {
        xml.start_element(element);
        xml.write_attribute("link", &escaped(link));
        xml.end_element();
    }
}

fn write_joint(xml: &mut XmlWriter, joint: &ChainJoint, parent: &str, child: &str) {
    let range = joint.limits.and_then(|limits| Some((limits.lower?, limits.upper?)));
    let kind = match (joint.motion, range) {
        (JointMotion::Prismatic, _) => "prismatic",
        (JointMotion::Revolute, Some(_)) => "revolute",
        (JointMotion::Revolute, None) => "continuous",
    };
    start_joint(xml, &joint.name, kind, parent, child);
    write_origin(xml, &joint.place);
    xml.start_element("axis");
    xml.write_attribute("xyz", &triple(&joint.axis));
    xml.end_element();
    if let Some(limits) = joint.limits {
        xml.start_element("limit");
        if let Some((lower, upper)) = range {
            xml.write_attribute("lower", &lower);
            xml.write_attribute("upper", &upper);
        }
        xml.write_attribute("effort", &limits.effort);
        xml.write_attribute("velocity", &limits.velocity);
        xml.end_element();
    }
    xml.end_element();
}
