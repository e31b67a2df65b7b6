//! What the loop and its link record into. Neither waits, locks nor allocates.

use uarm_io::drive::DriveIdentity;
use uarm_io::frame::Frame;
use uarm_io::link::FrameDirection;
use uarm_io::time::Instant;

use super::outlet::Outlet;
use super::sink::{FrameRecord, PeriodicRecord};
use crate::keyframe::Keyframe;
use crate::record::{CycleRecord, HealthRecord, Recorder};

/// What the loop records into.
#[derive(Debug)]
pub struct LoopRecorder<const J: usize, const N: usize> {
    pub(super) cycles: Outlet<CycleRecord<J, N>>,
    pub(super) periodic: Outlet<PeriodicRecord<J, N>>,
}

impl<const J: usize, const N: usize> Recorder<J, N> for LoopRecorder<J, N> {
    fn record(&mut self, record: &CycleRecord<J, N>) {
        self.cycles.push(*record);
    }

    fn keyframe(&mut self, keyframe: &Keyframe<J, N>, at: Instant) {
        self.periodic.push(PeriodicRecord::Keyframe(*keyframe, at));
    }

    fn identities(&mut self, identities: &[DriveIdentity; J], at: Instant) {
        self.periodic.push(PeriodicRecord::Identities(*identities, at));
    }

    fn health(&mut self, health: &HealthRecord<J>) {
        self.periodic.push(PeriodicRecord::Health(*health));
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
#[derive(Debug)]
pub struct Leftovers<const J: usize, const N: usize> {
    /// Cycles, the oldest first.
    pub cycles: Vec<CycleRecord<J, N>>,
    /// Frames, the oldest first.
    pub frames: Vec<FrameRecord>,
    /// Keyframes and health records, the oldest first.
    pub periodic: Vec<PeriodicRecord<J, N>>,
    /// How many cycles were recorded, in the queue or here.
    pub cycles_recorded: u64,
}

impl<const J: usize, const N: usize> Leftovers<J, N> {
    /// What is left on the loop's side.
    pub fn of(loop_recorder: LoopRecorder<J, N>, frame_recorder: FrameRecorder) -> Self {
        Self {
            cycles_recorded: loop_recorder.cycles.pushed(),
            cycles: loop_recorder.cycles.into_kept(),
            frames: frame_recorder.frames.into_kept(),
            periodic: loop_recorder.periodic.into_kept(),
        }
    }
}
