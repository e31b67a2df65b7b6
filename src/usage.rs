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

    /// For a node id that no joint of the robot has: `option` with its value, such as `--node 9`, and the robot's nodes.
    pub fn no_such_node(option: &str, nodes: &[u8]) -> Self {
        Self(format!("{option}: expected one of the robot's nodes, {nodes:?}"))
    }
}
