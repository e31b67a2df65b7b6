//! The writer thread: takes entries from the queues to the sinks, and may wait for a disk as long as it likes.

use std::io::{self, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, TryRecvError, channel};
use std::time::Duration;

use rtrb::Consumer;
use uarm_io::realtime::let_others_go_first;

use super::loop_side::Leftovers;
use super::outlet::{Dropped, FullQueue, Numbered};
use super::sink::{Entry, FrameRecord, Note, PeriodicRecord, RunEnd, Severity, Sink};
use crate::record::CycleRecord;

/// How long the writer rests when the queues are empty.
const REST: Duration = Duration::from_millis(2);

/// How long the end of a run waits for the writer.
pub const FINISH_LIMIT: Duration = Duration::from_secs(10);

/// The writer's ends of the queues.
pub(super) struct Queues<const J: usize, const N: usize> {
    pub cycles: Consumer<Numbered<CycleRecord<J, N>>>,
    pub frames: Consumer<Numbered<FrameRecord>>,
    pub periodic: Consumer<Numbered<PeriodicRecord<J, N>>>,
}

/// What the writer is asked for by threads that may wait.
enum Request<const J: usize, const N: usize> {
    /// Write this line.
    Note(Note),
    /// Write what is left, and end.
    Finish(Box<(Leftovers<J, N>, RunEnd)>),
}

/// The writer thread, seen from outside.
pub struct Writer<const J: usize, const N: usize> {
    requests: Sender<Request<J, N>>,
    failures: Receiver<Vec<String>>,
    dropped: Arc<Dropped>,
    cycles_taken: Arc<AtomicU64>,
}

/// A way to add lines of text to a recording.
#[derive(Clone)]
pub struct LogHandle<const J: usize, const N: usize>(Sender<Request<J, N>>);

impl<const J: usize, const N: usize> LogHandle<J, N> {
    /// Adds a line. Not for the loop: it allocates.
    pub fn add(&self, severity: Severity, text: String) {
        // A writer that has ended can take no more notes; its failures tell why.
        let _ = self.0.send(Request::Note(Note { severity, text }));
    }
}

impl<const J: usize, const N: usize> Writer<J, N> {
    pub(super) fn start(
        queues: Queues<J, N>,
        sinks: Vec<Box<dyn Sink<J, N>>>,
        full_queue: FullQueue,
        dropped: Arc<Dropped>,
    ) -> io::Result<Self> {
        let (requests, inbox) = channel();
        let (outbox, failures) = channel();
        let cycles_taken = Arc::new(AtomicU64::new(0));
        let work = Work {
            queues,
            outputs: Outputs { sinks, failures: Vec::new(), cycles_taken: Arc::clone(&cycles_taken) },
            full_queue,
            dropped: Arc::clone(&dropped),
            drops_told: 0,
        };
        std::thread::Builder::new().name("uarm-writer".into()).spawn(move || {
            // In virtual time the loop waits for the writer, and not the other way round.
            if full_queue == FullQueue::Keep {
                let_others_go_first();
            }
            // Nobody is left to tell if the other end has gone.
            let _ = outbox.send(work.run(&inbox));
        })?;
        Ok(Self { requests, failures, dropped, cycles_taken })
    }

    /// A way to add lines of text, for any thread but the loop's.
    pub fn log_handle(&self) -> LogHandle<J, N> {
        LogHandle(self.requests.clone())
    }

    /// Records lost so far.
    pub fn dropped(&self) -> u64 {
        self.dropped.count()
    }

    /// Waits until all that was recorded is written, for at most [`FINISH_LIMIT`]. Returns what could not be.
    pub fn finish(self, leftovers: Leftovers<J, N>, end: RunEnd) -> Vec<String> {
        let recorded = leftovers.cycles_recorded;
        // A writer that has ended has sent its failures already.
        let _ = self.requests.send(Request::Finish(Box::new((leftovers, end))));
        match self.failures.recv_timeout(FINISH_LIMIT) {
            Ok(failures) => failures,
            Err(RecvTimeoutError::Timeout) => {
                let lost = recorded.saturating_sub(self.cycles_taken.load(Ordering::Relaxed));
                vec![format!(
                    "the disk is too slow or stands still: {FINISH_LIMIT:?} after the run it had not taken the last of \
                     it; at least {lost} of {recorded} cycles are lost, and the log has no end"
                )]
            }
            Err(RecvTimeoutError::Disconnected) => vec!["the writer thread panicked".to_owned()],
        }
    }
}

/// The sinks that still work, and why others do not.
struct Outputs<const J: usize, const N: usize> {
    sinks: Vec<Box<dyn Sink<J, N>>>,
    failures: Vec<String>,
    cycles_taken: Arc<AtomicU64>,
}

impl<const J: usize, const N: usize> Outputs<J, N> {
    fn take(&mut self, entry: Entry<'_, J, N>) {
        let failures = &mut self.failures;
        self.sinks.retain_mut(|sink| {
            sink.take(entry)
                .inspect_err(|error| {
                    let failure = format!("{}: {error}", sink.name());
                    // The failure is in the report as well: nothing depends on whether somebody reads this.
                    let _ = writeln!(std::io::stderr(), "uarm: {failure}; the run goes on without it");
                    failures.push(failure);
                })
                .is_ok()
        });
        if matches!(entry, Entry::Cycle(_)) {
            self.cycles_taken.fetch_add(1, Ordering::Relaxed);
        }
    }
}

/// What the thread works with.
struct Work<const J: usize, const N: usize> {
    queues: Queues<J, N>,
    outputs: Outputs<J, N>,
    full_queue: FullQueue,
    dropped: Arc<Dropped>,
    drops_told: u64,
}

impl<const J: usize, const N: usize> Work<J, N> {
    fn run(mut self, requests: &Receiver<Request<J, N>>) -> Vec<String> {
        loop {
            // Read before the queues are found empty: what was pushed before the end is then never missed.
            let request = requests.try_recv();
            self.drain();
            self.tell_of_drops();
            match request {
                Ok(Request::Note(note)) => self.outputs.take(Entry::Note(&note)),
                Ok(Request::Finish(finish)) => {
                    let (leftovers, end) = *finish;
                    self.finish(&leftovers, &end);
                    return self.outputs.failures;
                }
                Err(TryRecvError::Empty) => std::thread::sleep(REST),
                // Whoever started the recording has given it up without an end: keep what there is.
                Err(TryRecvError::Disconnected) => {
                    self.outputs.take(Entry::Pause);
                    return self.outputs.failures;
                }
            }
        }
    }

    /// Takes what the queues hold, in the order in which the loop pushed it: the same in each run in virtual time.
    fn drain(&mut self) {
        while let Some(queue) = self.queues.earliest() {
            self.take_from(queue);
        }
        // In virtual time the log does not depend on when the writer found nothing to do.
        if self.full_queue == FullQueue::Keep {
            self.outputs.take(Entry::Pause);
        }
    }

    fn take_from(&mut self, queue: Queue) {
        match queue {
            Queue::Cycles => {
                if let Ok(Numbered { record, .. }) = self.queues.cycles.pop() {
                    self.outputs.take(Entry::Cycle(&record));
                }
            }
            Queue::Frames => {
                if let Ok(Numbered { record, .. }) = self.queues.frames.pop() {
                    self.outputs.take(Entry::Frame(&record));
                }
            }
            Queue::Periodic => {
                if let Ok(Numbered { record, .. }) = self.queues.periodic.pop() {
                    self.outputs.take(Entry::Periodic(&record, self.dropped.count()));
                }
            }
        }
    }

    fn tell_of_drops(&mut self) {
        let dropped = self.dropped.count();
        if dropped > self.drops_told {
            let text = format!("{} records lost: the disk is too slow ({dropped} so far)", dropped - self.drops_told);
            self.drops_told = dropped;
            self.outputs.take(Entry::Note(&Note { severity: Severity::Warning, text }));
        }
    }

    fn finish(&mut self, leftovers: &Leftovers<J, N>, end: &RunEnd) {
        self.drain();
        for frame in &leftovers.frames {
            self.outputs.take(Entry::Frame(frame));
        }
        for cycle in &leftovers.cycles {
            self.outputs.take(Entry::Cycle(cycle));
        }
        for record in &leftovers.periodic {
            self.outputs.take(Entry::Periodic(record, self.dropped.count()));
        }
        self.outputs.take(Entry::End(end));
    }
}

/// Which queue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Queue {
    Cycles,
    Frames,
    Periodic,
}

impl<const J: usize, const N: usize> Queues<J, N> {
    /// The queue whose first record was pushed before those of the others.
    fn earliest(&self) -> Option<Queue> {
        // Looked at twice: what was pushed before a record that is seen the first time is seen the second time.
        self.first()?;
        self.first()
    }

    fn first(&self) -> Option<Queue> {
        let heads = [
            (Queue::Cycles, self.cycles.peek().ok().map(|head| head.number)),
            (Queue::Frames, self.frames.peek().ok().map(|head| head.number)),
            (Queue::Periodic, self.periodic.peek().ok().map(|head| head.number)),
        ];
        let numbered = heads.into_iter().filter_map(|(queue, number)| Some((number?, queue)));
        numbered.min_by_key(|(number, _)| *number).map(|(_, queue)| queue)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::outlet::{Counters, Sizes, outlet};
    use uarm_io::time::Instant;

    /// Equal instants say nothing of the order: the numbers do.
    #[test]
    fn records_leave_in_the_order_in_which_they_were_pushed() {
        let counters = Arc::new(Counters::default());
        let sizes = Sizes { queue: 8, ring: 1 };
        let (_, cycles) = outlet(sizes, FullQueue::Wait, &counters);
        let (mut frame, frames) = outlet(sizes, FullQueue::Wait, &counters);
        let (mut record, periodic) = outlet(sizes, FullQueue::Wait, &counters);
        let mut queues = Queues::<3, 2> { cycles, frames, periodic };
        let at = Instant::from_nanoseconds(7);
        let identity = PeriodicRecord::Identities([uarm_io::drive::DriveIdentity::default(); 3], at);
        let sent = FrameRecord {
            sequence: 0,
            direction: uarm_io::link::FrameDirection::Sent,
            frame: uarm_io::frame::Frame::with(uarm_io::embedded_can::StandardId::ZERO, []),
            at,
        };
        record.push(identity);
        frame.push(sent);
        frame.push(sent);
        record.push(identity);
        frame.push(sent);
        let mut order = Vec::new();
        while let Some(queue) = queues.earliest() {
            order.push(queue);
            match queue {
                Queue::Cycles => panic!("no cycle was pushed"),
                Queue::Frames => drop(queues.frames.pop()),
                Queue::Periodic => drop(queues.periodic.pop()),
            }
        }
        use Queue::{Frames, Periodic};
        assert_eq!(order, [Periodic, Frames, Frames, Periodic, Frames]);
    }
}
