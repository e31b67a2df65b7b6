//! The robot to look at: frames of its links, and shapes that ride on them. The reference rides on the same base as a
//! ghost: where the links would be if the active joints followed it.
//!
//! Frames: `world` → `base` (turns by q1) → `link_2` (by q2, at the end of the base) → `link_3` (by q3); `reference_link_2`
//! and `reference_link_3` beside them. All lie in the plane z = 0 and reach along their own x.

use foxglove::messages::{
    Color, CubePrimitive, CylinderPrimitive, FrameTransform, FrameTransforms, JointState, JointStates, Pose,
    Quaternion, SceneEntity, SceneUpdate, Vector3,
};

use crate::description::JointDescription;
use crate::time_axis::timestamp;
use uarm_loop::record::CycleRecord;

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
#[derive(Clone, Debug)]
struct Link {
    frame: String,
    parent: String,
    /// Where its joint is along the parent, m.
    at: f64,
    length: f64,
    color: Color,
}

/// A planar robot to look at.
#[derive(Clone, Debug)]
pub struct Scene<const J: usize> {
    names: [String; J],
    links: Vec<Link>,
    ghosts: Vec<Link>,
}

impl<const J: usize> Scene<J> {
    /// The scene of a robot with these joints, the passive base first.
    pub fn new(joints: &[JointDescription; J]) -> Self {
        let frame = |index: usize| if index == 0 { "base".to_owned() } else { format!("link_{}", index + 1) };
        let mut links: Vec<Link> = Vec::new();
        for (index, joint) in joints.iter().enumerate() {
            let (parent, at) = links.last().map_or(("world".to_owned(), 0.0), |link| (link.frame.clone(), link.length));
            let color = if index == 0 { BASE } else { LINK };
            links.push(Link { frame: frame(index), parent, at, length: joint.link_length, color });
        }
        let mut ghosts: Vec<Link> = Vec::new();
        for link in links.iter().skip(1) {
            let parent = ghosts.last().map_or_else(|| link.parent.clone(), |ghost| ghost.frame.clone());
            ghosts.push(Link { frame: format!("reference_{}", link.frame), parent, color: GHOST, ..link.clone() });
        }
        Self { names: joints.each_ref().map(|joint| joint.name.clone()), links, ghosts }
    }

    /// Where the links are.
    pub fn transforms<const N: usize>(&self, record: &CycleRecord<J, N>, at: u64) -> FrameTransforms {
        let links = self.links.iter().zip(record.position);
        let ghosts = self.ghosts.iter().zip(record.reference_position);
        FrameTransforms { transforms: links.chain(ghosts).map(|(link, angle)| transform(link, angle, at)).collect() }
    }

    /// What they look like.
    pub fn shapes(&self, at: u64) -> SceneUpdate {
        let entities = self.links.iter().chain(&self.ghosts).map(|link| entity(link, at)).collect();
        SceneUpdate { deletions: Vec::new(), entities }
    }

    /// Angles, velocities and applied torques; the base has no torque.
    pub fn joint_states<const N: usize>(&self, record: &CycleRecord<J, N>, at: u64) -> JointStates {
        let accelerations = [Some(record.base_acceleration)].into_iter().chain(std::iter::repeat(None));
        let efforts = [0.0].into_iter().chain(record.torque_applied);
        let motion = record.position.iter().zip(record.velocity);
        let joints = self.names.iter().zip(motion).zip(accelerations.zip(efforts));
        let joints = joints.map(|((name, (position, velocity)), (acceleration, effort))| JointState {
            name: name.clone(),
            position: Some(*position),
            velocity: Some(velocity),
            acceleration,
            effort: Some(effort),
        });
        JointStates { timestamp: Some(timestamp(at)), joints: joints.collect() }
    }
}

fn transform(link: &Link, angle: f64, at: u64) -> FrameTransform {
    FrameTransform {
        timestamp: Some(timestamp(at)),
        parent_frame_id: link.parent.clone(),
        child_frame_id: link.frame.clone(),
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
        frame_id: link.frame.clone(),
        id: link.frame.clone(),
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
    use dem_model::ThreeLinkDem;
    use uarm_loop::nalgebra::{Rotation2, Vector2 as Plane, Vector3 as Angles};

    /// The chain of frames, multiplied out, ends where the model's kinematics says the end effector is.
    #[test]
    fn the_frames_agree_with_the_kinematics() {
        let model = ThreeLinkDem::<f64>::table_2();
        let lengths = [model.base().length, model.links()[0].length, model.links()[1].length];
        let scene =
            Scene::new(&lengths.map(|link_length| JointDescription { name: String::new(), node: 1, link_length }));
        let q = [0.3, -0.7, 1.1];
        let record = CycleRecord::<3, 2> { position: q, ..CycleRecord::default() };
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
