//! What is wrong with a command line beyond what its parser sees.

/// Options that do not go together, or a value that the robot or the file at hand does not allow: exit code 2.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct UsageError(String);

impl UsageError {
    /// The error in words, which name the option, its value, and what was expected.
    pub fn new(message: impl Into<String>) -> Self {
        Self(message.into())
    }
}
