//! The robot to look at: frames of its links, and shapes that ride on them. The reference rides on the same base as a
//! ghost: where the links would be if the active joints followed it.
//!
//! Frames of the paper's robot: `world` → `base` (turns by q1) → `link_2` (by q2, at the end of the base) → `link_3` (by q3);
//! `reference_link_2` and `reference_link_3` beside them. All lie in the plane z = 0 and reach along their own x. Of a robot
//! without a sensor on its base: `base`, in whose axes all is shown, → `link_1` → …

use foxglove::messages::{
    Color, CubePrimitive, CylinderPrimitive, FrameTransform, FrameTransforms, JointState, JointStates, Pose,
    Quaternion, SceneEntity, SceneUpdate, Vector3,
};

use crate::description::{JointDescription, LinkDescription};
use crate::time_axis::timestamp;
use uarm_loop::dimensions;
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
    shape: LinkDescription,
    color: Color,
}

/// A robot to look at.
#[derive(Clone, Debug)]
pub struct Scene<const J: usize, const N: usize> {
    names: [String; J],
    links: Vec<Link>,
    ghosts: Vec<Link>,
}

impl<const J: usize, const N: usize> Scene<J, N> {
    /// The scene of a robot with these joints, a passive base first.
    pub fn new(joints: &[JointDescription; J]) -> Self {
        let passive = dimensions::passive::<J, N>();
        let is_base = |index: usize| index < passive;
        let root = if passive == 0 { "base" } else { "world" };
        let frame = |index: usize| if is_base(index) { "base".to_owned() } else { format!("link_{}", index + 1) };
        let mut links: Vec<Link> = Vec::new();
        for (index, joint) in joints.iter().enumerate() {
            let parent = links.last().map_or(root.to_owned(), |link| link.frame.clone());
            let color = if is_base(index) { BASE } else { LINK };
            links.push(Link { frame: frame(index), parent, shape: joint.link, color });
        }
        let mut ghosts: Vec<Link> = Vec::new();
        for link in links.iter().skip(passive) {
            let parent = ghosts.last().map_or_else(|| link.parent.clone(), |ghost| ghost.frame.clone());
            ghosts.push(Link { frame: format!("reference_{}", link.frame), parent, color: GHOST, ..link.clone() });
        }
        Self { names: joints.each_ref().map(|joint| joint.name.clone()), links, ghosts }
    }

    /// Where the links are.
    pub fn transforms(&self, record: &CycleRecord<J, N>, at: u64) -> FrameTransforms {
        let links = self.links.iter().zip(record.position);
        let ghosts = self.ghosts.iter().zip(record.reference_position);
        FrameTransforms { transforms: links.chain(ghosts).map(|(link, angle)| transform(link, angle, at)).collect() }
    }

    /// What they look like.
    pub fn shapes(&self, at: u64) -> SceneUpdate {
        let entities = self.links.iter().chain(&self.ghosts).map(|link| entity(link, at)).collect();
        SceneUpdate { deletions: Vec::new(), entities }
    }

    /// Angles, velocities and applied torques; a base has no torque.
    pub fn joint_states(&self, record: &CycleRecord<J, N>, at: u64) -> JointStates {
        let passive = dimensions::passive::<J, N>();
        let of_base = std::iter::repeat_n(Some(record.base_acceleration), passive);
        let accelerations = of_base.chain(std::iter::repeat(None));
        let efforts = std::iter::repeat_n(0.0, passive).chain(record.torque_applied);
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
        translation: Some(vector(link.shape.from_parent)),
        rotation: Some(turned(link.shape.axis, angle)),
    }
}

fn vector([x, y, z]: [f64; 3]) -> Vector3 {
    Vector3 { x, y, z }
}

fn turned(axis: [f64; 3], angle: f64) -> Quaternion {
    let [x, y, z] = axis.map(|component| component * (angle / 2.0).sin() + 0.0); // no negative zero
    Quaternion { x, y, z, w: (angle / 2.0).cos() }
}

/// The rotation from the x axis to a direction of this length, m; none for a link without length.
fn pointing([x, y, z]: [f64; 3], length: f64) -> Quaternion {
    // Half the way between both directions is the axis of half a turn.
    let (x, y, z) = if length > 0.0 { (x / length, y / length, z / length) } else { (1.0, 0.0, 0.0) };
    let norm = (2.0 * (1.0 + x)).sqrt();
    if norm < 1e-9 {
        return Quaternion { x: 0.0, y: 0.0, z: 1.0, w: 0.0 };
    }
    Quaternion { x: 0.0, y: 0.0 - z / norm, z: y / norm, w: norm / 2.0 }
}

fn entity(link: &Link, at: u64) -> SceneEntity {
    let reach = link.shape.reach;
    let length = reach.iter().map(|component| component * component).sum::<f64>().sqrt();
    let orientation = pointing(reach, length);
    let pose = |share: f64| Pose {
        position: Some(vector(reach.map(|component| component * share))),
        orientation: Some(orientation),
    };
    let width = SLENDERNESS * length;
    let diameter = JOINT_WIDTHS * width;
    let joint_color = if link.color == GHOST { GHOST } else { JOINT };
    SceneEntity {
        timestamp: Some(timestamp(at)),
        frame_id: link.frame.clone(),
        id: link.frame.clone(),
        frame_locked: true,
        cubes: vec![CubePrimitive {
            pose: Some(pose(0.5)),
            size: Some(Vector3 { x: length, y: width, z: width }),
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
        let scene = Scene::<3, 2>::new(&[0, 1, 2].map(|index: usize| {
            let before = index.checked_sub(1).map_or(0.0, |before| lengths[before]);
            let link = LinkDescription::along_x(before, lengths[index]);
            JointDescription { name: String::new(), node: 1, link }
        }));
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
