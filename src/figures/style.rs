//! How the curves of a robot look: one style for each signal and for each control law.

use hinf_control::Law;
use uarm_plot::style::{BLACK, BLUE, Dash, GREEN, ORANGE, PURPLE, SKY_BLUE, Stroke, VERMILION};

/// The base.
pub const BASE: Stroke = Stroke::solid(GREEN).dashed(Dash::DashDot);
/// Joint 2.
pub const JOINT_2: Stroke = Stroke::solid(BLUE);
/// Joint 3.
pub const JOINT_3: Stroke = Stroke::solid(VERMILION).dashed(Dash::Dashed);
/// Joint 1, if it is active, and the joints behind joint 3, which have no dots of their own in the figures of the paper.
const OTHER_JOINTS: [Stroke; 7] = [
    Stroke::solid(GREEN),
    Stroke::solid(ORANGE),
    Stroke::solid(SKY_BLUE).dashed(Dash::DashDot),
    Stroke::solid(PURPLE),
    Stroke::solid(BLACK).dashed(Dash::Dashed),
    Stroke::solid(ORANGE).dashed(Dash::DashDot),
    Stroke::solid(PURPLE).dashed(Dash::DashDot),
];

/// The joint of this number, 1 to 9.
pub const fn of_joint(number: usize) -> Stroke {
    match number {
        2 => JOINT_2,
        3 => JOINT_3,
        0 | 1 => OTHER_JOINTS[0],
        other => OTHER_JOINTS[1 + (other - 4) % (OTHER_JOINTS.len() - 1)],
    }
}

/// What the drive of that joint reported.
pub fn reported_by_joint(number: usize) -> Stroke {
    match number {
        2 => Stroke::solid(SKY_BLUE).dashed(Dash::Dotted),
        3 => Stroke::solid(PURPLE).dashed(Dash::Dotted),
        // Thinner than the torque that was sent.
        other => of_joint(other).dashed(Dash::Dotted).wide(0.9),
    }
}

/// The desired motion.
pub const REFERENCE: Stroke = Stroke::solid(BLACK).dashed(Dash::Dotted).wide(1.2);

/// What was recorded, beside what a replay makes of it.
pub const RECORDED: Stroke = Stroke::solid(BLACK);
/// What a replay makes of a record.
pub const REPLAYED: Stroke = Stroke::solid(VERMILION).dashed(Dash::Dashed);

/// The curves of the laws, in the order of [`Law::ALL`]; from the ninth on they repeat.
const LAWS: [Stroke; 8] = [
    Stroke::solid(BLACK),
    Stroke::solid(ORANGE),
    Stroke::solid(SKY_BLUE),
    Stroke::solid(BLUE).dashed(Dash::Dashed),
    Stroke::solid(PURPLE),
    Stroke::solid(VERMILION).dashed(Dash::Dashed),
    Stroke::solid(GREEN).dashed(Dash::DashDot),
    Stroke::solid(ORANGE).dashed(Dash::Dotted),
];

/// A law among the others.
pub fn of_law(law: Law) -> Stroke {
    let place = Law::ALL.iter().position(|each| *each == law).unwrap_or_default();
    LAWS[place % LAWS.len()]
}
