//! What is watched of an axis, and whose turn it is to be asked.

use crate::drive::readings::ReadingLimits;
use crate::time::Instant;

/// Whose turn it is to be asked for what it measures.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Inquiry {
    pub(super) next: usize,
    pub(super) next_at: Instant,
}

/// A quantity of an axis that is watched.
#[derive(Clone, Copy, Debug)]
pub(super) struct Watched {
    pub(super) limits: ReadingLimits,
    /// Requests since the last answer.
    pub(super) unanswered: u8,
}

impl Watched {
    pub(super) const fn new(limits: ReadingLimits) -> Self {
        Self { limits, unanswered: 0 }
    }
}
