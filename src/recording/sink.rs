//! Where entries end, and what they are.

use std::io;

use uarm_io::frame::Frame;
use uarm_io::link::FrameDirection;
use uarm_io::time::Instant;

use super::loop_side::Occasion;
use crate::control_loop::record::CycleRecord;

/// A frame that the controller sent or received.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRecord {
    /// Counts the frames of a run in the order in which the controller sent and received them; wraps.
    pub sequence: u32,
    /// Which way it went.
    pub direction: FrameDirection,
    /// The frame.
    pub frame: Frame,
    /// When it was handed to the link, or seen by it.
    pub at: Instant,
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
    /// How much it matters.
    pub severity: Severity,
    /// What it says.
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
    /// Frames that were.
    pub frames_kept: u64,
    /// Records lost.
    pub dropped: u64,
}

/// What a sink is given. Entries of one kind come in the order of their instants, but for what was kept for the writer.
#[derive(Clone, Copy, Debug)]
pub enum Entry<'a> {
    /// A cycle.
    Cycle(&'a CycleRecord),
    /// A frame.
    Frame(&'a FrameRecord),
    /// A keyframe or a health record, and how many records were lost until then.
    Occasion(&'a Occasion, u64),
    /// A line of text.
    Note(&'a Note),
    /// Nothing happens: what is buffered may as well be written.
    Pause,
    /// No more entries come.
    End(&'a RunEnd),
}

/// Where records end.
pub trait Sink: Send {
    /// What it is called in messages.
    fn name(&self) -> String;

    /// Takes one entry.
    ///
    /// # Errors
    /// If it cannot be written; the sink is then closed and the run goes on.
    fn take(&mut self, entry: Entry<'_>) -> io::Result<()>;
}
