//! From the loop to files: bounded lock-free queues, and a writer thread that does all that may wait.
//!
//! The loop's side never waits, locks or allocates: what finds its queue full is kept in a ring beside it, of which the
//! newest survive, and is handed over when the run has ended. So the last seconds before a fault reach the file even if the
//! disk stood still then. What the ring had to overwrite is lost, and counted.
//!
//! | module | subject |
//! |---|---|
//! | [`mod@outlet`] | one queue with its ring, seen from the loop |
//! | [`loop_side`] | what the loop records into |
//! | [`writer`] | the thread |
//! | [`sink`] | where entries end, and what they are |

pub mod loop_side;
pub mod outlet;
pub mod sink;
pub mod writer;

use std::io;
use std::sync::Arc;
use std::time::Duration;

pub use loop_side::{FrameRecorder, Leftovers, LoopRecorder};
pub use outlet::{Dropped, FullQueue};
pub use sink::{Entry, FrameRecord, Note, PeriodicRecord, RunEnd, Severity, Sink};
pub use writer::{LogHandle, Writer};

use outlet::{Counters, Sizes, outlet};

/// How long a disk may stand still before anything is lost.
const QUEUE_SPAN: Duration = Duration::from_secs(12);
/// How much the ring beside the queue holds: the flight recorder's five seconds, and one more.
const RING_SPAN: Duration = Duration::from_secs(6);
/// Frames in a cycle for which there is room; eight are usual.
const FRAMES_PER_CYCLE: usize = 12;
/// How often there is a keyframe or a health record: eleven times a second.
const PERIODIC_INTERVAL: Duration = Duration::from_millis(90);

/// Room for records that come once in each `interval`.
fn sizes(interval: Duration) -> Sizes {
    let of =
        |span: Duration| usize::try_from(span.as_nanos().div_ceil(interval.as_nanos().max(1))).unwrap_or(usize::MAX);
    Sizes { queue: of(QUEUE_SPAN), ring: of(RING_SPAN) }
}

/// The two ends of a recording.
pub struct Recording<const J: usize, const N: usize> {
    /// What the loop records its cycles into.
    pub loop_recorder: LoopRecorder<J, N>,
    /// What the link's observer records frames into.
    pub frame_recorder: FrameRecorder,
    /// The writer thread.
    pub writer: Writer<J, N>,
}

/// Starts a writer for `sinks`, and makes room for a loop of this `period`.
///
/// # Errors
/// If no thread can be started.
pub fn start<const J: usize, const N: usize>(
    sinks: Vec<Box<dyn Sink<J, N>>>,
    full_queue: FullQueue,
    period: Duration,
) -> io::Result<Recording<J, N>> {
    let counters = Arc::new(Counters::default());
    let per_cycle = sizes(period);
    let (cycles, cycle_queue) = outlet(per_cycle, full_queue, &counters);
    let (frames, frame_queue) = outlet(per_cycle.times(FRAMES_PER_CYCLE), full_queue, &counters);
    let (periodic, record_queue) = outlet(sizes(PERIODIC_INTERVAL), full_queue, &counters);
    let queues = writer::Queues { cycles: cycle_queue, frames: frame_queue, periodic: record_queue };
    Ok(Recording {
        loop_recorder: LoopRecorder { cycles, periodic },
        frame_recorder: FrameRecorder::new(frames),
        writer: Writer::start(queues, sinks, full_queue, Arc::clone(&counters.dropped))?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_room_is_measured_in_time_and_not_in_cycles() {
        for (period, cycles) in [(3_000, 2_000), (1_000, 6_000), (7_000, 858)] {
            let Sizes { queue, ring } = sizes(Duration::from_micros(period));
            assert_eq!(ring, cycles, "{period} us");
            assert!(queue.abs_diff(2 * cycles) <= 1, "{period} us: {queue}");
        }
    }
}
