//! What could not be read.

use std::fmt;

/// A line or a value that was left out, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// The file's name.
    pub file: String,
    /// The line, from 1.
    pub line: usize,
    /// The section, without brackets; empty before the first.
    pub section: String,
    /// The key; empty if the line has none.
    pub key: String,
    /// What stands there.
    pub value: String,
    /// What was expected instead.
    pub expected: String,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { file, line, section, key, value, expected } = self;
        write!(f, "{file}, line {line}, [{section}]")?;
        if !key.is_empty() {
            write!(f, " {key}")?;
        }
        write!(f, ": found {value:?}, expected {expected}")
    }
}
