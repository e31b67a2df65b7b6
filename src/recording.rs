//! From the loop to files: a bounded lock-free queue, and a writer thread that does all that may wait.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use rtrb::{Consumer, Producer, PushError, RingBuffer};

use crate::control_loop::record::{CycleRecord, Recorder};

/// Cycles that the queue holds: 12 s at 3 ms, so that a disk may stall that long before a record is dropped.
pub const QUEUE_CAPACITY: usize = 4096;
/// How long the writer rests when the queue is empty.
const WRITER_REST: Duration = Duration::from_millis(2);

/// Where records end.
pub trait Sink: Send {
    /// Takes one record.
    ///
    /// # Errors
    /// If it cannot be written; the sink is then closed and the run goes on.
    fn write(&mut self, record: &CycleRecord) -> io::Result<()>;

    /// Called when no more records come.
    ///
    /// # Errors
    /// If what is buffered cannot be written.
    fn finish(&mut self) -> io::Result<()>;
}

/// What the loop does when the queue is full.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FullQueue {
    /// Drop the record and count it: a real-time loop never waits.
    Drop,
    /// Wait for the writer: a loop in virtual time outruns any disk, and loses nothing by waiting.
    Wait,
}

/// The loop's end of the queue.
#[derive(Debug)]
pub struct QueueRecorder {
    producer: Producer<CycleRecord>,
    full_queue: FullQueue,
    dropped: u64,
}

impl QueueRecorder {
    /// Records that did not fit the queue.
    pub const fn dropped(&self) -> u64 {
        self.dropped
    }
}

impl Recorder for QueueRecorder {
    fn record(&mut self, record: &CycleRecord) {
        let mut pending = *record;
        while let Err(PushError::Full(returned)) = self.producer.push(pending) {
            // An abandoned queue is one whose writer has died: waiting for it would never end.
            if self.full_queue == FullQueue::Drop || self.producer.is_abandoned() {
                self.dropped += 1;
                return;
            }
            pending = returned;
            std::thread::yield_now();
        }
    }
}

/// The writer thread.
#[derive(Debug)]
pub struct Writer {
    thread: JoinHandle<Vec<io::Error>>,
    closing: Arc<AtomicBool>,
}

impl Writer {
    /// Waits until all that was recorded is written. Returns what could not be.
    pub fn finish(self) -> Vec<io::Error> {
        self.closing.store(true, Ordering::Release);
        self.thread.join().unwrap_or_else(|_| vec![io::Error::other("the writer thread panicked")])
    }
}

/// Starts a writer for `sinks`.
///
/// # Errors
/// If no thread can be started.
pub fn start(sinks: Vec<Box<dyn Sink>>, full_queue: FullQueue) -> io::Result<(QueueRecorder, Writer)> {
    let (producer, consumer) = RingBuffer::new(QUEUE_CAPACITY);
    let closing = Arc::new(AtomicBool::new(false));
    let thread = {
        let closing = Arc::clone(&closing);
        std::thread::Builder::new().name("uarm-writer".into()).spawn(move || drain(consumer, sinks, &closing))?
    };
    Ok((QueueRecorder { producer, full_queue, dropped: 0 }, Writer { thread, closing }))
}

fn drain(mut queue: Consumer<CycleRecord>, mut sinks: Vec<Box<dyn Sink>>, closing: &AtomicBool) -> Vec<io::Error> {
    let mut failures = Vec::new();
    loop {
        // Read before the queue is found empty: a record pushed before closing is then never missed.
        let last_round = closing.load(Ordering::Acquire);
        while let Ok(record) = queue.pop() {
            sinks.retain_mut(|sink| sink.write(&record).map_err(|failure| failures.push(failure)).is_ok());
        }
        if last_round {
            break;
        }
        std::thread::sleep(WRITER_REST);
    }
    for mut sink in sinks {
        failures.extend(sink.finish().err());
    }
    failures
}
