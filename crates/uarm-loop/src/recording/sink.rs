//! Where entries end, and what they are.

use std::io;

use uarm_io::drive::DriveIdentity;
use uarm_io::frame::Frame;
use uarm_io::link::FrameDirection;
use uarm_io::time::Instant;

use crate::keyframe::Keyframe;
use crate::record::{CycleRecord, HealthRecord};

/// A frame that the controller sent or received.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRecord {
    /// Counts the frames of a run in the order in which the controller sent and received them; wraps.
    pub sequence: u32,
    /// Whether it was sent or received.
    pub direction: FrameDirection,
    /// The frame itself.
    pub frame: Frame,
    /// When it was handed to the link, or seen by it.
    pub at: Instant,
}

/// What is not recorded in each cycle.
#[derive(Clone, Copy, Debug)]
#[allow(clippy::large_enum_variant, reason = "a box would allocate; there are eleven of these a second")]
pub enum PeriodicRecord<const J: usize, const N: usize> {
    /// The inner state at an instant.
    Keyframe(Keyframe<J, N>, Instant),
    /// What the drives said of themselves, once, before the first cycle.
    Identities([DriveIdentity; J], Instant),
    /// The health of bus and drives.
    Health(HealthRecord<J>),
}

impl<const J: usize, const N: usize> PeriodicRecord<J, N> {
    /// The instant that it belongs to.
    pub const fn at(&self) -> Instant {
        match self {
            Self::Keyframe(_, at) | Self::Identities(_, at) => *at,
            Self::Health(health) => health.at,
        }
    }
}

/// How much a note matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// It belongs to the story.
    Info,
    /// Something was lost or late.
    Warning,
    /// The run failed.
    Fatal,
}

/// A line of text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// The severity.
    pub severity: Severity,
    /// The text.
    pub text: String,
}

/// How a run ended.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RunEnd {
    /// The end in words.
    pub text: String,
    /// The first cause, if it ended other than planned.
    pub fault: Option<String>,
    /// Figures of the run by name, as the report has them.
    pub figures: Vec<(String, String)>,
    /// Cycles that were kept for the writer, since its queue was full.
    pub cycles_kept: u64,
    /// Frames that were kept for the writer.
    pub frames_kept: u64,
    /// Records that were lost.
    pub dropped: u64,
}

/// What a sink is given, in the order in which the loop recorded it: a cycle comes behind its frames, a keyframe behind the cycle that
/// it follows and before all frames of the next. What was kept for the writer comes last.
#[derive(Clone, Copy, Debug)]
pub enum Entry<'a, const J: usize, const N: usize> {
    /// The record of a cycle.
    Cycle(&'a CycleRecord<J, N>),
    /// A frame that was sent or received.
    Frame(&'a FrameRecord),
    /// A keyframe or a health record, and how many records were lost until then.
    Periodic(&'a PeriodicRecord<J, N>, u64),
    /// A line of text.
    Note(&'a Note),
    /// Nothing happens: what is buffered may as well be written.
    Pause,
    /// No more entries come.
    End(&'a RunEnd),
}

/// Where records end.
pub trait Sink<const J: usize, const N: usize>: Send {
    /// What it is called in messages.
    fn name(&self) -> String;

    /// Takes one entry: writes it, or keeps it to be written.
    ///
    /// # Errors
    /// If it cannot be written; the sink is then closed and the run goes on.
    fn take(&mut self, entry: Entry<'_, J, N>) -> io::Result<()>;
}
