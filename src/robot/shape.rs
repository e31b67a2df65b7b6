//! How many joints a robot has: known only when its file is read.

use std::fmt;
use std::path::Path;

use serde::Deserialize;

use super::error::{Checker, RobotError};
use super::file::Role;
use super::reading::read;

/// The joints of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    /// Those with a motor.
    pub active: usize,
    /// Whether a passive base with an encoder comes before them.
    pub base: BaseSensor,
}

/// What is known of the base's motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BaseSensor {
    /// An encoder on a joint that it turns about.
    Encoder,
    /// Nothing.
    None,
}

#[derive(Deserialize)]
struct Joints {
    joints: Vec<Joint>,
}

#[derive(Deserialize)]
struct Joint {
    role: Role,
}

impl fmt::Display for Shape {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let behind = if self.base == BaseSensor::Encoder { "a passive base and " } else { "" };
        write!(formatter, "{behind}{} active joints", self.active)
    }
}

impl Shape {
    /// The most active joints that a robot may have: the arms of `for_shape`.
    pub const MOST_ACTIVE: usize = 8;

    /// The paper's robot.
    pub const PAPER: Self = Self { active: 2, base: BaseSensor::Encoder };

    /// That of `J` joints, of which `N` are active.
    pub const fn of_joints<const J: usize, const N: usize>() -> Self {
        Self { active: N, base: if J > N { BaseSensor::Encoder } else { BaseSensor::None } }
    }

    /// The shape of the robot whose file `name` has this `text`.
    ///
    /// # Errors
    /// [`RobotError`] if the text is no list of joints, or there are none or too many.
    pub fn of(name: &Path, text: &str) -> Result<Self, RobotError> {
        let (Joints { joints }, _) = read(name, text)?;
        let base = match joints.first() {
            Some(Joint { role: Role::Passive }) => BaseSensor::Encoder,
            _ => BaseSensor::None,
        };
        let passive = joints.iter().skip(1).position(|joint| joint.role == Role::Passive);
        if let Some(behind_first) = passive {
            let field = format!("joints[{}].role", behind_first + 1);
            return Err(Checker::new(name).refuse(field, "passive", "active: only the first joint may be passive"));
        }
        let active = joints.iter().filter(|joint| joint.role == Role::Active).count();
        let found = Self { active, base };
        if !(1..=Self::MOST_ACTIVE).contains(&active) {
            let expected = format!("1 to {} active joints, alone or behind a passive base", Self::MOST_ACTIVE);
            return Err(Checker::new(name).refuse("joints", found, expected));
        }
        Ok(found)
    }
}

/// Calls `$function::<J, N>` with the numbers of joints of a robot of this `$shape`. Each costs the compiler about ten seconds: the
/// others than the paper's are left out without the feature `other-arms`, and in unit tests, which are of the paper's robot.
macro_rules! for_shape {
    ($shape:expr, $function:ident($($argument:expr),* $(,)?)) => {{
        use $crate::robot::shape::Shape;
        #[cfg(all(feature = "other-arms", not(test)))]
        use $crate::robot::shape::BaseSensor;
        #[cfg(all(feature = "other-arms", not(test)))]
        let result = match $shape {
            Shape { active: 1, base: BaseSensor::Encoder } => $function::<2, 1>($($argument),*),
            Shape { active: 2, base: BaseSensor::Encoder } => $function::<3, 2>($($argument),*),
            Shape { active: 3, base: BaseSensor::Encoder } => $function::<4, 3>($($argument),*),
            Shape { active: 4, base: BaseSensor::Encoder } => $function::<5, 4>($($argument),*),
            Shape { active: 5, base: BaseSensor::Encoder } => $function::<6, 5>($($argument),*),
            Shape { active: 6, base: BaseSensor::Encoder } => $function::<7, 6>($($argument),*),
            Shape { active: 7, base: BaseSensor::Encoder } => $function::<8, 7>($($argument),*),
            Shape { active: 8, base: BaseSensor::Encoder } => $function::<9, 8>($($argument),*),
            Shape { active: 1, base: BaseSensor::None } => $function::<1, 1>($($argument),*),
            Shape { active: 2, base: BaseSensor::None } => $function::<2, 2>($($argument),*),
            Shape { active: 3, base: BaseSensor::None } => $function::<3, 3>($($argument),*),
            Shape { active: 4, base: BaseSensor::None } => $function::<4, 4>($($argument),*),
            Shape { active: 5, base: BaseSensor::None } => $function::<5, 5>($($argument),*),
            Shape { active: 6, base: BaseSensor::None } => $function::<6, 6>($($argument),*),
            Shape { active: 7, base: BaseSensor::None } => $function::<7, 7>($($argument),*),
            Shape { active: 8, base: BaseSensor::None } => $function::<8, 8>($($argument),*),
            shape => Err(anyhow::anyhow!("{shape}: expected 1 to {} active joints", Shape::MOST_ACTIVE)),
        };
        #[cfg(not(all(feature = "other-arms", not(test))))]
        let result = match $shape {
            Shape::PAPER => $function::<3, 2>($($argument),*),
            shape => Err(anyhow::anyhow!("{shape}: this program is compiled for {} only", Shape::PAPER)),
        };
        result
    }};
}
pub(crate) use for_shape;
