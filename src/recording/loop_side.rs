//! What the loop and its link record into. Neither waits, locks nor allocates.

use uarm_io::frame::Frame;
use uarm_io::link::FrameDirection;
use uarm_io::time::Instant;

use super::outlet::Outlet;
use super::sink::FrameRecord;
use crate::control_loop::keyframe::Keyframe;
use crate::control_loop::record::{CycleRecord, HealthRecord, Recorder};

/// What is not recorded in each cycle.
#[derive(Clone, Copy, Debug)]
#[allow(clippy::large_enum_variant, reason = "a box would allocate; there are eleven of these a second")]
pub enum Occasion {
    /// The inner state at an instant.
    Keyframe(Keyframe, Instant),
    /// Bus and drives.
    Health(HealthRecord),
}

impl Occasion {
    /// When it was.
    pub const fn at(&self) -> Instant {
        match self {
            Self::Keyframe(_, at) => *at,
            Self::Health(health) => health.at,
        }
    }
}

/// What the loop records into.
#[derive(Debug)]
pub struct LoopRecorder {
    pub(super) cycles: Outlet<CycleRecord>,
    pub(super) occasions: Outlet<Occasion>,
}

impl Recorder for LoopRecorder {
    fn record(&mut self, record: &CycleRecord) {
        self.cycles.push(*record);
    }

    fn keyframe(&mut self, keyframe: &Keyframe, at: Instant) {
        self.occasions.push(Occasion::Keyframe(*keyframe, at));
    }

    fn health(&mut self, health: &HealthRecord) {
        self.occasions.push(Occasion::Health(*health));
    }
}

/// What the link's observer records into.
#[derive(Debug)]
pub struct FrameRecorder {
    frames: Outlet<FrameRecord>,
    next: u32,
}

impl FrameRecorder {
    pub(super) const fn new(frames: Outlet<FrameRecord>) -> Self {
        Self { frames, next: 0 }
    }

    /// Records a frame that was sent or received.
    pub fn record(&mut self, direction: FrameDirection, frame: &Frame, at: Instant) {
        self.frames.push(FrameRecord { sequence: self.next, direction, frame: *frame, at });
        self.next = self.next.wrapping_add(1);
    }
}

/// What the queues did not take, to be handed over when the run has ended.
#[derive(Debug, Default)]
pub struct Leftovers {
    /// Cycles, the oldest first.
    pub cycles: Vec<CycleRecord>,
    /// Frames, the oldest first.
    pub frames: Vec<FrameRecord>,
    /// Keyframes and health records, the oldest first.
    pub occasions: Vec<Occasion>,
    /// How many cycles were recorded, in the queue or here.
    pub cycles_recorded: u64,
}

impl Leftovers {
    /// What is left on the loop's side.
    pub fn of(loop_recorder: LoopRecorder, frame_recorder: FrameRecorder) -> Self {
        Self {
            cycles_recorded: loop_recorder.cycles.pushed(),
            cycles: loop_recorder.cycles.into_kept(),
            frames: frame_recorder.frames.into_kept(),
            occasions: loop_recorder.occasions.into_kept(),
        }
    }
}
