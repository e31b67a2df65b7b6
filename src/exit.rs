//! Exit codes.

use std::process::ExitCode;

/// How a command ended, as its exit code tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Everything worked: 0.
    Ok,
    /// It failed: 1.
    Failure,
    /// Finished, but something was lost on the way: 3. (2, wrong usage, is the argument parser's.)
    Loss,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        match exit {
            Exit::Ok => Self::SUCCESS,
            Exit::Failure => Self::from(1),
            Exit::Loss => Self::from(3),
        }
    }
}
