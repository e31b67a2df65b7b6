//! What was found, what is wanted, and how to get it.

use core::fmt;

/// How a finding is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// As wanted.
    Good,
    /// The loop can run, with less margin or less safety than it could have.
    Warning,
    /// The loop cannot run as asked, or will miss deadlines.
    Bad,
}

impl fmt::Display for Verdict {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(match self {
            Self::Good => "good",
            Self::Warning => "warning",
            Self::Bad => "bad",
        })
    }
}

/// One precondition of the loop, as it was found.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Finding {
    /// The precondition.
    pub name: String,
    /// What was found, or got.
    pub found: String,
    /// What is wanted.
    pub wanted: String,
    /// The judgement.
    pub verdict: Verdict,
    /// How to get what is wanted; empty where it is there already.
    pub how_to_get_it: String,
}

impl Finding {
    pub(crate) fn good(name: impl Into<String>, found: impl Into<String>, wanted: impl Into<String>) -> Self {
        let (name, found, wanted) = (name.into(), found.into(), wanted.into());
        Self { name, found, wanted, verdict: Verdict::Good, how_to_get_it: String::new() }
    }

    /// The same precondition judged worse, with advice.
    pub(crate) fn but(self, verdict: Verdict, how_to_get_it: impl Into<String>) -> Self {
        Self { verdict, how_to_get_it: how_to_get_it.into(), ..self }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}: found {}, wanted {}", self.name, self.found, self.wanted)?;
        if self.how_to_get_it.is_empty() { Ok(()) } else { write!(formatter, "; {}", self.how_to_get_it) }
    }
}
