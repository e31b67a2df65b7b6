//! The text of a robot file: the built-in one, or of a file.

use std::path::{Path, PathBuf};

use super::error::RobotError;
use super::shape::Shape;
use crate::text_file;

/// The name under which the built-in robot file appears in messages.
pub const BUILT_IN_NAME: &str = "robots/uarm.toml (built in)";
/// The paper's robot, built in.
pub const BUILT_IN: &str = include_str!("../../robots/uarm.toml");

/// The text of a robot file, not looked at yet.
#[derive(Clone, Debug)]
pub struct RobotText {
    /// What messages call the file.
    pub name: PathBuf,
    /// The text.
    pub text: String,
}

impl RobotText {
    /// The text of `file`, or the built-in one.
    ///
    /// # Errors
    /// [`RobotError::Read`] if it cannot be read.
    pub fn read(file: Option<&Path>) -> Result<Self, RobotError> {
        let Some(path) = file else { return Ok(Self { name: BUILT_IN_NAME.into(), text: BUILT_IN.to_owned() }) };
        let text = text_file::read(path).map_err(|source| RobotError::Read { file: path.to_owned(), source })?;
        Ok(Self { name: path.to_owned(), text })
    }

    /// How many joints the robot has.
    ///
    /// # Errors
    /// [`RobotError`] if the text is no list of joints, or there are none or too many.
    pub fn shape(&self) -> Result<Shape, RobotError> {
        Shape::of(&self.name, &self.text)
    }
}
