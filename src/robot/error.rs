//! What is wrong with a robot file: the file, the field, the value, and what was expected.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use crate::usage::UsageError;

/// A robot file that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum RobotError {
    /// It cannot be read.
    #[error("{}: cannot be read: {source}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// Why it cannot be read.
        source: std::io::Error,
    },
    /// The URDF that it names cannot be read, or describes no arm that can be used.
    #[error("{}: model.urdf: {}: {error}", robot.display(), file.display())]
    Urdf {
        /// The robot file.
        robot: PathBuf,
        /// The URDF.
        file: PathBuf,
        /// What is wrong with it.
        error: String,
    },
    /// It is no TOML, or a field is unknown, missing or of another type.
    #[error("{}: {}", file.display(), in_words(&error.to_string()))]
    Syntax {
        /// The file.
        file: PathBuf,
        /// The place in the file, and what is wrong there. No source of this error: its words are in the message.
        error: Box<toml::de::Error>,
    },
    /// The command line changes it to what it cannot be.
    #[error("{0}")]
    Override(#[source] UsageError),
    /// A field has a value that it cannot have.
    #[error("{}: {field} = {value}: expected {expected}", file.display())]
    Field {
        /// The file.
        file: PathBuf,
        /// The path of the field, as in `joints[1].encoder.counter_bits`.
        field: String,
        /// Its value.
        value: String,
        /// What it may be.
        expected: String,
    },
}

/// The ranges of the types that numbers of a robot file have.
const RANGES: [(&str, &str); 8] = [
    ("expected u8", "expected a whole number from 0 to 255"),
    ("expected u16", "expected a whole number from 0 to 65535"),
    ("expected u32", "expected a whole number from 0 to 4294967295"),
    ("expected i8", "expected a whole number from -128 to 127"),
    ("expected i16", "expected a whole number from -32768 to 32767"),
    ("expected i32", "expected a whole number from -2147483648 to 2147483647"),
    ("expected i64", "expected a whole number"),
    ("expected f64", "expected a number"),
];

/// A message of the parser without the names of types of this program.
fn in_words(message: &str) -> String {
    let lines = message.lines().map(|line| {
        let range = RANGES.iter().find(|(name, _)| line.ends_with(name));
        range.map_or_else(|| line.to_owned(), |(name, words)| line.replace(name, words))
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// A number with hundreds of digits as `1e300`, any other long value cut.
fn shortened(value: String) -> String {
    const LONGEST: usize = 80;
    const MOST_DIGITS: usize = 20;
    match value.parse::<f64>() {
        Ok(number) if value.len() > MOST_DIGITS => format!("{number:e}"),
        _ if value.chars().count() > LONGEST => value.chars().take(LONGEST).chain("...".chars()).collect(),
        _ => value,
    }
}

/// Checks fields and words the errors.
#[derive(Clone, Copy, Debug)]
pub struct Checker<'a> {
    file: &'a Path,
}

impl<'a> Checker<'a> {
    /// A checker for the fields of `file`.
    pub const fn new(file: &'a Path) -> Self {
        Self { file }
    }

    /// The file.
    pub const fn file(&self) -> &'a Path {
        self.file
    }

    /// The error of a field.
    pub fn refuse(&self, field: impl Into<String>, value: impl Display, expected: impl Into<String>) -> RobotError {
        RobotError::Field {
            file: self.file.to_owned(),
            field: field.into(),
            value: shortened(value.to_string()),
            expected: expected.into(),
        }
    }

    /// The error of a field whose value another type refuses, in words that say what it expected.
    pub fn refuse_as(&self, field: impl Into<String>, value: impl Display, error: impl Display) -> RobotError {
        let error = error.to_string();
        let expected = error.split_once("expected ").map_or(error.as_str(), |(_, expected)| expected);
        self.refuse(field, value, expected)
    }

    /// A finite number within `minimum..=maximum`.
    ///
    /// # Errors
    /// [`RobotError::Field`] if it is not.
    pub fn within(&self, field: &str, value: f64, minimum: f64, maximum: f64) -> Result<f64, RobotError> {
        if (minimum..=maximum).contains(&value) {
            Ok(value)
        } else {
            Err(self.refuse(field, value, format!("a number from {minimum} to {maximum}")))
        }
    }

    /// A finite number above zero.
    ///
    /// # Errors
    /// [`RobotError::Field`] if it is not.
    pub fn positive(&self, field: &str, value: f64) -> Result<f64, RobotError> {
        if value > 0.0 && value.is_finite() {
            Ok(value)
        } else {
            Err(self.refuse(field, value, "a finite number above 0"))
        }
    }

    /// A finite number, zero or above.
    ///
    /// # Errors
    /// [`RobotError::Field`] if it is not.
    pub fn not_negative(&self, field: &str, value: f64) -> Result<f64, RobotError> {
        if value >= 0.0 && value.is_finite() {
            Ok(value)
        } else {
            Err(self.refuse(field, value, "a finite number, 0 or above"))
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::robot::overrides::Overrides;
    use crate::robot::{BUILT_IN, Robot};
    use std::path::Path;

    #[test]
    fn a_syntax_error_is_told_once() {
        let text = BUILT_IN.replacen("node = 2\n", "node = 300\n", 1);
        let error = Robot::parse(Path::new("test.toml"), &text, &Overrides::default()).unwrap_err();
        let told = crate::error_text::with_causes(&anyhow::Error::new(error));
        assert_eq!(told.matches("300").count(), 2, "the line, and what is wrong in it: {told}");
        assert_eq!(told.matches("TOML parse error").count(), 1, "{told}");
    }

    #[test]
    fn a_number_outside_its_type_is_told_the_range() {
        for (from, to, expected) in [
            ("node = 2\n", "node = 300\n", "expected a whole number from 0 to 255"),
            ("counter_bits = 32", "counter_bits = -1", "expected a whole number from 0 to 255"),
            (
                "controller_heartbeat_ms = 10",
                "controller_heartbeat_ms = 70000",
                "expected a whole number from 0 to 65535",
            ),
            ("period_us = 3000", "period_us = -3000", "expected a whole number from 0 to 4294967295"),
            ("attenuation_level = 2.0", "attenuation_level = \"two\"", "expected a number"),
        ] {
            let text = BUILT_IN.replacen(from, to, 1);
            assert_ne!(text, BUILT_IN, "{from}");
            let error = Robot::parse(Path::new("test.toml"), &text, &Overrides::default()).unwrap_err().to_string();
            assert!(error.trim_end().ends_with(expected), "{error}");
        }
    }
}
