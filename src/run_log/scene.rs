//! The robot to look at: frames of its links, and shapes that ride on them. The reference rides on the same base as a
//! ghost: where the links would be if the driven joints followed it.
//!
//! Frames: `world` → `base` (turns by q1) → `link_2` (by q2, at the end of the base) → `link_3` (by q3); `reference_link_2`
//! and `reference_link_3` beside them. All lie in the plane z = 0 and reach along their own x.

use dem_model::ThreeLinkDem;
use foxglove::messages::{
    Color, CubePrimitive, CylinderPrimitive, FrameTransform, FrameTransforms, JointState, JointStates, Pose,
    Quaternion, SceneEntity, SceneUpdate, Vector3,
};

use super::time_axis::timestamp;
use crate::control_loop::record::CycleRecord;

/// Colours: two greys and the blue of the figures' references.
const BASE: Color = Color { r: 0.55, g: 0.57, b: 0.60, a: 1.0 };
const LINK: Color = Color { r: 0.83, g: 0.84, b: 0.86, a: 1.0 };
const JOINT: Color = Color { r: 0.25, g: 0.26, b: 0.28, a: 1.0 };
const GHOST: Color = Color { r: 0.12, g: 0.47, b: 0.71, a: 0.35 };

/// Cross-section of a link as a share of its length: to look at, no dimension of the paper.
const SLENDERNESS: f64 = 0.12;
/// Diameter of a joint in widths of the link behind it.
const JOINT_WIDTHS: f64 = 1.4;

/// A link as it is shown.
#[derive(Clone, Copy, Debug)]
struct Link {
    frame: &'static str,
    parent: &'static str,
    /// Where its joint is along the parent, m.
    at: f64,
    length: f64,
    color: Color,
}

/// Shows one robot.
#[derive(Clone, Debug)]
pub struct Scene {
    names: [String; 3],
    links: [Link; 3],
    ghosts: [Link; 2],
}

impl Scene {
    /// For a robot whose joints have these names.
    pub fn new(model: &ThreeLinkDem<f64>, names: [String; 3]) -> Self {
        let base_length = model.base().length;
        let [second, third] = model.links();
        let link = |frame, parent, at, length, color| Link { frame, parent, at, length, color };
        Self {
            names,
            links: [
                link("base", "world", 0.0, base_length, BASE),
                link("link_2", "base", base_length, second.length, LINK),
                link("link_3", "link_2", second.length, third.length, LINK),
            ],
            ghosts: [
                link("reference_link_2", "base", base_length, second.length, GHOST),
                link("reference_link_3", "reference_link_2", second.length, third.length, GHOST),
            ],
        }
    }

    /// Where the links are.
    pub fn transforms(&self, record: &CycleRecord, at: u64) -> FrameTransforms {
        let links = self.links.iter().zip(record.position);
        let ghosts = self.ghosts.iter().zip(record.reference_position);
        FrameTransforms { transforms: links.chain(ghosts).map(|(link, angle)| transform(link, angle, at)).collect() }
    }

    /// What they look like.
    pub fn shapes(&self, at: u64) -> SceneUpdate {
        let entities = self.links.iter().chain(&self.ghosts).map(|link| entity(link, at)).collect();
        SceneUpdate { deletions: Vec::new(), entities }
    }

    /// Angles, rates and applied torques; the base has no torque.
    pub fn joint_states(&self, record: &CycleRecord, at: u64) -> JointStates {
        let [torque_2, torque_3] = record.torque_applied;
        let accelerations = [Some(record.base_acceleration), None, None];
        let efforts = [Some(0.0), Some(torque_2), Some(torque_3)];
        let joints =
            self.names.iter().zip(record.position.iter().zip(record.rate)).zip(accelerations.iter().zip(efforts));
        let joints = joints.map(|((name, (position, rate)), (acceleration, effort))| JointState {
            name: name.clone(),
            position: Some(*position),
            velocity: Some(rate),
            acceleration: *acceleration,
            effort,
        });
        JointStates { timestamp: Some(timestamp(at)), joints: joints.collect() }
    }
}

fn transform(link: &Link, angle: f64, at: u64) -> FrameTransform {
    FrameTransform {
        timestamp: Some(timestamp(at)),
        parent_frame_id: link.parent.to_owned(),
        child_frame_id: link.frame.to_owned(),
        translation: Some(Vector3 { x: link.at, y: 0.0, z: 0.0 }),
        rotation: Some(Quaternion { x: 0.0, y: 0.0, z: (angle / 2.0).sin(), w: (angle / 2.0).cos() }),
    }
}

fn pose(x: f64) -> Pose {
    Pose {
        position: Some(Vector3 { x, y: 0.0, z: 0.0 }),
        orientation: Some(Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }),
    }
}

fn entity(link: &Link, at: u64) -> SceneEntity {
    let width = SLENDERNESS * link.length;
    let diameter = JOINT_WIDTHS * width;
    let joint_color = if link.color == GHOST { GHOST } else { JOINT };
    SceneEntity {
        timestamp: Some(timestamp(at)),
        frame_id: link.frame.to_owned(),
        id: link.frame.to_owned(),
        frame_locked: true,
        cubes: vec![CubePrimitive {
            pose: Some(pose(link.length / 2.0)),
            size: Some(Vector3 { x: link.length, y: width, z: width }),
            color: Some(link.color),
        }],
        cylinders: vec![CylinderPrimitive {
            pose: Some(pose(0.0)),
            size: Some(Vector3 { x: diameter, y: diameter, z: diameter }),
            bottom_scale: 1.0,
            top_scale: 1.0,
            color: Some(joint_color),
        }],
        ..SceneEntity::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use nalgebra::{Rotation2, Vector2 as Plane, Vector3 as Angles};

    /// The chain of frames, multiplied out, ends where the model's kinematics says the end effector is.
    #[test]
    fn the_frames_agree_with_the_kinematics() {
        let model = ThreeLinkDem::<f64>::table_2();
        let scene = Scene::new(&model, ["1", "2", "3"].map(str::to_owned));
        let q = [0.3, -0.7, 1.1];
        let mut record = crate::control_loop::record::tests::record();
        record.position = q;
        let mut point = Plane::zeros();
        let mut turned = 0.0_f64;
        for transform in scene.transforms(&record, 0).transforms.iter().take(3) {
            let (translation, rotation) = (transform.translation.unwrap(), transform.rotation.unwrap());
            point += Rotation2::new(turned) * Plane::new(translation.x, translation.y);
            turned += 2.0 * rotation.z.atan2(rotation.w);
        }
        let tip = point + Rotation2::new(turned) * Plane::new(model.links()[1].length, 0.0);
        // A few roundings of numbers below 1.
        assert_relative_eq!(tip, model.end_effector(&Angles::from(q)).position, epsilon = 1e-14);
    }
}
