//! Exit codes.

use std::process::ExitCode;

use crate::usage::UsageError;

/// How a command ended, as its exit code tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Everything worked: 0.
    Ok,
    /// It failed: 1.
    Failure,
    /// Wrong usage: 2. That of the argument parser too.
    Usage,
    /// Finished, but something was lost on the way: 3.
    Loss,
}

impl Exit {
    /// How a command ends with `error`.
    pub fn of(error: &anyhow::Error) -> Self {
        if error.chain().any(|cause| cause.is::<UsageError>()) { Self::Usage } else { Self::Failure }
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        match exit {
            Exit::Ok => Self::SUCCESS,
            Exit::Failure => Self::from(1),
            Exit::Usage => Self::from(2),
            Exit::Loss => Self::from(3),
        }
    }
}
