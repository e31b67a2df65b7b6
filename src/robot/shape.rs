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
    /// Those that this program is compiled for, each of which costs the compiler about half a minute: the arms of `for_shape`.
    pub const KNOWN: [Self; 4] = [
        Self::PAPER,
        Self { active: 3, base: BaseSensor::Encoder },
        Self { active: 3, base: BaseSensor::None },
        Self { active: 7, base: BaseSensor::None },
    ];

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
        let active = joints.iter().filter(|joint| joint.role == Role::Active).count();
        let found = Self { active, base };
        if !Self::KNOWN.contains(&found) {
            let expected = "a passive base and 2 or 3 active joints, or 3 or 7 active joints alone, for which this program is compiled";
            return Err(Checker::new(name).refuse("joints", found, expected));
        }
        Ok(found)
    }
}

/// Calls `$function::<J, N>` with the numbers of joints of a robot of this `$shape`, one of [`Shape::KNOWN`].
macro_rules! for_shape {
    ($shape:expr, $function:ident($($argument:expr),* $(,)?)) => {{
        use $crate::robot::shape::{BaseSensor, Shape};
        match $shape {
            Shape { active: 2, base: BaseSensor::Encoder } => $function::<3, 2>($($argument),*),
            // Unit tests are of the paper's robot, and would be compiled for all others too.
            #[cfg(all(feature = "other-arms", not(test)))]
            Shape { active: 3, base: BaseSensor::Encoder } => $function::<4, 3>($($argument),*),
            #[cfg(all(feature = "other-arms", not(test)))]
            Shape { active: 3, base: BaseSensor::None } => $function::<3, 3>($($argument),*),
            #[cfg(all(feature = "other-arms", not(test)))]
            Shape { active: 7, base: BaseSensor::None } => $function::<7, 7>($($argument),*),
            shape => Err(anyhow::anyhow!("this program is not compiled for {shape:?}")),
        }
    }};
}
pub(crate) use for_shape;
