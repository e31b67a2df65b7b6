//! A chain as MJCF, the format of MuJoCo.

use dem_model::JointMotion;
use xmlwriter::{Options, XmlWriter};

use crate::chain::{Base, Chain, ChainBody, ChainJoint};
use crate::names::{escaped, free};
use crate::urdf::triple;

/// The chain as MJCF: with its base's joint, a motor of gear one on each joint, no gravity, and a site `tool` at the end
/// effector.
pub fn write_mjcf(chain: &Chain) -> String {
    let mut xml = XmlWriter::new(Options::default());
    xml.start_element("mujoco");
    xml.write_attribute("model", &escaped(&chain.name));
    xml.start_element("compiler");
    xml.write_attribute("angle", "radian");
    xml.end_element();
    xml.start_element("option");
    xml.write_attribute("gravity", "0 0 0");
    xml.write_attribute("integrator", "RK4");
    xml.end_element();

    xml.start_element("worldbody");
    start_body(&mut xml, &chain.first, "0 0 0");
    let base = free("base", chain.links.iter().map(|(joint, _)| joint.name.as_str()));
    write_base(&mut xml, chain.base, &base);
    write_inertial(&mut xml, &chain.first);
    for (joint, body) in &chain.links {
        start_body(&mut xml, body, &triple(&joint.place));
        write_joint(&mut xml, joint);
        write_inertial(&mut xml, body);
    }
    xml.start_element("site");
    xml.write_attribute("name", "tool");
    xml.write_attribute("pos", &triple(&chain.tip));
    xml.end_element();
    for _ in &chain.links {
        xml.end_element();
    }
    xml.end_element();
    xml.end_element();

    xml.start_element("actuator");
    for (joint, _) in &chain.links {
        xml.start_element("motor");
        xml.write_attribute("joint", &escaped(&joint.name));
        xml.end_element();
    }
    xml.end_element();
    xml.end_element();
    xml.end_document()
}

fn start_body(xml: &mut XmlWriter, body: &ChainBody, place: &str) {
    xml.start_element("body");
    // MuJoCo's own body has that name.
    xml.write_attribute("name", &escaped(&free(&body.name, std::iter::once("world"))));
    xml.write_attribute("pos", place);
}

fn write_base(xml: &mut XmlWriter, base: Base, name: &str) {
    xml.start_element(if base == Base::Floating { "freejoint" } else { "joint" });
    xml.write_attribute("name", name);
    match base {
        Base::Floating => {}
        Base::Spherical => xml.write_attribute("type", "ball"),
        Base::Planar => {
            xml.write_attribute("type", "hinge");
            xml.write_attribute("axis", "0 0 1");
        }
    }
    xml.end_element();
}

fn write_joint(xml: &mut XmlWriter, joint: &ChainJoint) {
    xml.start_element("joint");
    xml.write_attribute("name", &escaped(&joint.name));
    let kind = match joint.motion {
        JointMotion::Revolute => "hinge",
        JointMotion::Prismatic => "slide",
    };
    xml.write_attribute("type", kind);
    xml.write_attribute("axis", &triple(&joint.axis));
    xml.end_element();
}

fn write_inertial(xml: &mut XmlWriter, body: &ChainBody) {
    let inertia = &body.inertia;
    let full =
        [inertia.m11, inertia.m22, inertia.m33, inertia.m12, inertia.m13, inertia.m23].map(|entry| entry.to_string());
    xml.start_element("inertial");
    xml.write_attribute("pos", &triple(&body.centre));
    xml.write_attribute("mass", &body.mass);
    xml.write_attribute("fullinertia", &full.join(" "));
    xml.end_element();
}
