//! One queue from the loop, with a ring for what it cannot take.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use rtrb::{Consumer, Producer, PushError, RingBuffer};

/// What the loop does when the queue is full.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FullQueue {
    /// Keep the newest in the ring: a real-time loop never waits.
    Keep,
    /// Wait for the writer: a loop in virtual time outruns any disk, and loses nothing by waiting.
    Wait,
}

/// A record with its number: all queues of a recording count together, so that the numbers tell in which order the loop pushed.
#[derive(Clone, Copy, Debug)]
pub struct Numbered<T> {
    /// How many records were pushed before it, to whichever queue.
    pub number: u64,
    /// The record.
    pub record: T,
}

/// What is common to the queues of a recording.
#[derive(Debug, Default)]
pub struct Counters {
    next_number: AtomicU64,
    /// Records lost so far.
    pub dropped: Arc<Dropped>,
}

/// How many records are lost.
#[derive(Debug, Default)]
pub struct Dropped(AtomicU64);

impl Dropped {
    /// The number of records lost so far.
    pub fn count(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }

    fn add_one(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }
}

/// How many records a queue and its ring hold.
#[derive(Clone, Copy, Debug)]
pub struct Sizes {
    /// Records that the queue holds.
    pub queue: usize,
    /// Records that the ring holds.
    pub ring: usize,
}

impl Sizes {
    /// Room for so many records in place of one.
    pub const fn times(self, records: usize) -> Self {
        Self { queue: self.queue.saturating_mul(records), ring: self.ring.saturating_mul(records) }
    }
}

/// The loop's end of a queue.
#[derive(Debug)]
pub struct Outlet<T> {
    producer: Producer<Numbered<T>>,
    full_queue: FullQueue,
    ring: Ring<T>,
    pushed: u64,
    counters: Arc<Counters>,
}

/// A queue and its ring. Allocates all that either will ever hold.
pub fn outlet<T: Copy>(
    sizes: Sizes,
    full_queue: FullQueue,
    counters: &Arc<Counters>,
) -> (Outlet<T>, Consumer<Numbered<T>>) {
    let (producer, consumer) = RingBuffer::new(sizes.queue);
    let ring = Ring { slots: Vec::with_capacity(sizes.ring), oldest: 0 };
    (Outlet { producer, full_queue, ring, pushed: 0, counters: Arc::clone(counters) }, consumer)
}

impl<T: Copy> Outlet<T> {
    /// Hands a record over.
    pub fn push(&mut self, record: T) {
        self.pushed += 1;
        // One thread pushes to all queues: the numbers need no order of their own in memory, the queues bring it.
        let number = self.counters.next_number.fetch_add(1, Ordering::Relaxed);
        let mut pending = Numbered { number, record };
        while let Err(PushError::Full(returned)) = self.producer.push(pending) {
            // An abandoned queue is one whose writer has died: waiting for it would never end.
            if self.full_queue == FullQueue::Keep || self.producer.is_abandoned() {
                self.keep(returned.record);
                return;
            }
            pending = returned;
            std::thread::yield_now();
        }
    }

    fn keep(&mut self, record: T) {
        if self.ring.keep(record) == Kept::InsteadOfTheOldest {
            self.counters.dropped.add_one();
        }
    }

    /// How many records there were.
    pub const fn pushed(&self) -> u64 {
        self.pushed
    }

    /// What the queue did not take, the oldest first.
    pub fn into_kept(self) -> Vec<T> {
        self.ring.into_ordered()
    }
}

/// The newest records, in room that was allocated at the start.
#[derive(Debug)]
struct Ring<T> {
    slots: Vec<T>,
    oldest: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kept {
    InAFreeSlot,
    InsteadOfTheOldest,
}

impl<T: Copy> Ring<T> {
    fn keep(&mut self, record: T) -> Kept {
        if self.slots.len() < self.slots.capacity() {
            self.slots.push(record);
            return Kept::InAFreeSlot;
        }
        if let Some(slot) = self.slots.get_mut(self.oldest) {
            *slot = record;
        }
        self.oldest = if self.oldest + 1 < self.slots.len() { self.oldest + 1 } else { 0 };
        Kept::InsteadOfTheOldest
    }

    fn into_ordered(mut self) -> Vec<T> {
        self.slots.rotate_left(self.oldest);
        self.slots
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZES: Sizes = Sizes { queue: 3, ring: 2 };

    #[test]
    fn what_the_queue_does_not_take_is_kept_and_the_newest_survive() {
        let counters = Arc::new(Counters::default());
        let (mut outlet, mut consumer) = outlet(SIZES, FullQueue::Keep, &counters);
        for record in 0..8 {
            outlet.push(record);
        }
        assert_eq!(counters.dropped.count(), 3, "3, 4 and 5 had to make room for 6 and 7");
        let taken = std::iter::from_fn(|| consumer.pop().ok()).map(|taken| (taken.number, taken.record));
        assert_eq!(taken.collect::<Vec<_>>(), [(0, 0), (1, 1), (2, 2)]);
        outlet.push(8);
        assert_eq!(
            consumer.pop().map(|taken| taken.record),
            Ok(8),
            "the queue takes records again as soon as there is room"
        );
        assert_eq!(outlet.into_kept(), [6, 7]);
    }

    #[test]
    fn a_dead_writer_is_not_waited_for() {
        let counters = Arc::new(Counters::default());
        let (mut outlet, consumer) = outlet(SIZES, FullQueue::Wait, &counters);
        drop(consumer);
        for record in 0..4 {
            outlet.push(record);
        }
        assert_eq!(outlet.into_kept(), [3]);
    }
}
