//! From the loop to files: bounded lock-free queues, and a writer thread that does all that may wait.
//!
//! The loop's side never waits, locks or allocates: what finds its queue full is kept in a ring beside it, of which the
//! newest survive, and is handed over when the run has ended. So the last seconds before a fault reach the file even if the
//! disk stood still then. What the ring had to overwrite is lost, and counted.
//!
//! | module | subject |
//! |---|---|
//! | [`outlet`] | one queue with its ring, seen from the loop |
//! | [`loop_side`] | what the loop records into |
//! | [`writer`] | the thread |
//! | [`sink`] | where entries end, and what they are |

pub mod loop_side;
pub mod outlet;
pub mod sink;
pub mod writer;

use std::io;
use std::sync::Arc;

pub use loop_side::{FrameRecorder, Leftovers, LoopRecorder, Occasion};
pub use outlet::{Dropped, FullQueue};
pub use sink::{Entry, FrameRecord, Note, RunEnd, Severity, Sink};
pub use writer::{Notebook, Writer};

use outlet::{Sizes, outlet};

/// Cycles that the queue holds: 12 s at 3 ms, so that a disk may stall that long before anything is lost; the ring beside
/// it holds the last 6 s.
const CYCLES: Sizes = Sizes { queue: 4096, ring: 2048 };
/// Frames: twelve a cycle, where eight are usual.
const FRAMES: Sizes = Sizes { queue: 12 * CYCLES.queue, ring: 12 * CYCLES.ring };
/// Keyframes and health records: eleven a second.
const OCCASIONS: Sizes = Sizes { queue: 256, ring: 64 };

/// The two ends of a recording.
pub struct Recording {
    /// What the loop records its cycles into.
    pub loop_recorder: LoopRecorder,
    /// What the link's observer records frames into.
    pub frame_recorder: FrameRecorder,
    /// The writer thread.
    pub writer: Writer,
}

/// Starts a writer for `sinks`.
///
/// # Errors
/// If no thread can be started.
pub fn start(sinks: Vec<Box<dyn Sink>>, full_queue: FullQueue) -> io::Result<Recording> {
    let dropped = Arc::new(Dropped::default());
    let (cycles, cycle_queue) = outlet(CYCLES, full_queue, &dropped);
    let (frames, frame_queue) = outlet(FRAMES, full_queue, &dropped);
    let (occasions, occasion_queue) = outlet(OCCASIONS, full_queue, &dropped);
    let queues = writer::Queues { cycles: cycle_queue, frames: frame_queue, occasions: occasion_queue };
    Ok(Recording {
        loop_recorder: LoopRecorder { cycles, occasions },
        frame_recorder: FrameRecorder::new(frames),
        writer: Writer::start(queues, sinks, full_queue, dropped)?,
    })
}
