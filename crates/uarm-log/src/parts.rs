//! A long run in several files, of which the newest are kept.
//!
//! Each part is a log by itself: it begins with all metadata and with a keyframe, from which a replay can start. A part ends where
//! a keyframe comes and the file is full; then the oldest parts make room, so that all together never have more than a limit. What a
//! writer holds in memory is the index of one part, and does not grow with the run.

use std::collections::VecDeque;
use std::io::{self, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use mcap::McapResult;
use uarm_loop::recording::{Entry, PeriodicRecord, Severity, Sink};
use uarm_loop::uarm_io::drive::DriveIdentity;
use uarm_loop::uarm_io::time::Duration;

use crate::description::{JointDescription, LogHeader, MachineDescription, RunDescription};
use crate::writer::{LogWriter, io_error};

/// The size at which a part ends at the latest, bytes: two hours of 3 ms. So long, the index in memory grows, by 100 kB a minute.
pub const MOST_PART_BYTES: u64 = 1 << 30;
/// Of how many parts a limit is the sum: what is kept is at least all but one of them.
const PARTS: u64 = 8;
/// What a cycle takes in a file at most, with its frames, bytes: twice of what the law with the most parameters takes.
const CYCLE_BYTES: u64 = 1500;
/// A part of a limited log holds so much time at least.
const LEAST_PART: Duration = Duration::from_secs(4);
/// What a part takes beside its cycles, bytes: its header and its summary.
const FIXED_BYTES: u64 = 256 * 1024;
/// More than what one entry adds, bytes.
const ENTRY_BYTES: u64 = 16 * 1024;

/// Where parts go.
pub trait PartStore: Send {
    /// A file.
    type Output: Write + Send;

    /// Creates a part behind the first, and gives it with the name that files beside it know it by.
    ///
    /// # Errors
    /// If it cannot be created. What is there is never replaced.
    fn create(&mut self, number: u32) -> io::Result<(Self::Output, String)>;

    /// Deletes the oldest part that is left.
    ///
    /// # Errors
    /// If it cannot be deleted.
    fn delete_oldest(&mut self) -> io::Result<()>;
}

/// How much the parts of a run may take together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SizeLimit {
    /// All are kept.
    Unlimited,
    /// The newest, of so many bytes.
    Newest(NewestBytes),
}

/// A limit that at least [`NewestBytes::least`] is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NewestBytes(u64);

impl NewestBytes {
    /// A limit for a loop of this `period`; nothing if it is too small.
    pub fn new(bytes: u64, period: Duration) -> Option<Self> {
        (bytes >= Self::least(period)).then_some(Self(bytes))
    }

    /// The least limit for a loop of this `period`, bytes: eight parts of four seconds each.
    pub fn least(period: Duration) -> u64 {
        let cycles = LEAST_PART.as_nanos().div_ceil(period.as_nanos().max(1));
        PARTS * (FIXED_BYTES + u64::try_from(cycles).unwrap_or(u64::MAX / (2 * PARTS * CYCLE_BYTES)) * CYCLE_BYTES)
    }

    /// Bytes.
    pub const fn bytes(self) -> u64 {
        self.0
    }
}

impl SizeLimit {
    fn of_a_part(self) -> u64 {
        match self {
            Self::Unlimited => MOST_PART_BYTES,
            Self::Newest(NewestBytes(bytes)) => MOST_PART_BYTES.min(bytes / PARTS),
        }
    }

    const fn of_all(self) -> u64 {
        match self {
            Self::Unlimited => u64::MAX,
            Self::Newest(NewestBytes(bytes)) => bytes,
        }
    }
}

/// Writes the log of a run into parts.
pub struct LogParts<S: PartStore, const J: usize, const N: usize> {
    store: S,
    limit: SizeLimit,
    template: Template<J>,
    writer: LogWriter<Counted<S::Output>, J, N>,
    written: Arc<AtomicU64>,
    number: u32,
    /// The sizes of the closed parts that are left, the oldest first.
    closed: VecDeque<u64>,
    identities: Option<[DriveIdentity; J]>,
    /// The size at the last keyframe, and how much it grew at most between two.
    at_keyframe: u64,
    growth: u64,
}

/// What each part begins with.
#[derive(Clone, Debug)]
struct Template<const J: usize> {
    run: RunDescription,
    machine: MachineDescription,
    joints: [JointDescription; J],
    robot_source: String,
}

impl<const J: usize> Template<J> {
    fn of(header: &LogHeader<'_, J>) -> Self {
        let LogHeader { run, machine, joints, robot_source, .. } = *header;
        Self {
            run: run.clone(),
            machine: machine.clone(),
            joints: joints.clone(),
            robot_source: robot_source.to_owned(),
        }
    }
}

/// Counts what is written.
struct Counted<W> {
    output: W,
    written: Arc<AtomicU64>,
}

impl<W: Write> Write for Counted<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.output.write(bytes)?;
        self.written.fetch_add(u64::try_from(count).unwrap_or(u64::MAX), Ordering::Relaxed);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.output.flush()
    }
}

impl<S: PartStore, const J: usize, const N: usize> LogParts<S, J, N> {
    /// Begins the first part, `output`, of a log; the others come from `store`.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn new(output: S::Output, store: S, limit: SizeLimit, header: &LogHeader<'_, J>) -> io::Result<Self> {
        let written = Arc::new(AtomicU64::new(0));
        let output = Counted { output, written: Arc::clone(&written) };
        let writer = LogWriter::new(output, header).map_err(io_error)?;
        let template = Template::of(header);
        Ok(Self {
            store,
            limit,
            template,
            writer,
            written,
            number: 1,
            closed: VecDeque::new(),
            identities: None,
            at_keyframe: 0,
            growth: 0,
        })
    }

    /// The size of the part in hand, were it closed now; not less than what it is then.
    fn size(&self) -> u64 {
        self.written.load(Ordering::Relaxed) + self.writer.bytes_to_close()
    }

    /// Whether another second might be too much for this part.
    fn is_full(&mut self) -> bool {
        let size = self.size();
        self.growth = self.growth.max(size.saturating_sub(self.at_keyframe));
        self.at_keyframe = size;
        size + self.growth > self.limit.of_a_part()
    }

    /// Closes the part in hand and begins the next.
    fn turn(&mut self) -> McapResult<()> {
        self.make_room(FIXED_BYTES)?;
        let number = self.number.saturating_add(1);
        let (output, name) = self.store.create(number)?;
        self.writer.close_part(&name)?;
        if self.limit != SizeLimit::Unlimited {
            self.closed.push_back(self.written.load(Ordering::Relaxed));
        }
        self.number = number;
        self.written = Arc::new(AtomicU64::new(0));
        let output = Counted { output, written: Arc::clone(&self.written) };
        let Template { run, machine, joints, robot_source } = &self.template;
        let start = self.writer.now();
        let header = LogHeader { name: &name, run, machine, joints, robot_source, start, preamble: &[] };
        let mut next = LogWriter::new(output, &header)?;
        next.continue_run(number, &self.writer)?;
        if let Some(identities) = &self.identities {
            next.identities(identities)?;
        }
        self.writer = next;
        self.at_keyframe = self.size();
        Ok(())
    }

    /// Deletes the oldest parts until there is room for the part in hand and so many bytes more.
    fn make_room(&mut self, more: u64) -> McapResult<()> {
        let wanted = self.size().saturating_add(more);
        while self.closed.iter().sum::<u64>().saturating_add(wanted) > self.limit.of_all() {
            if self.closed.pop_front().is_none() {
                break;
            }
            if let Err(error) = self.store.delete_oldest() {
                let text = format!("an old part of the log cannot be deleted, and its limit is passed: {error}");
                self.writer.note(Severity::Warning, &text)?;
            }
        }
        Ok(())
    }

    fn prepare(&mut self, entry: Entry<'_, J, N>) -> McapResult<()> {
        match entry {
            Entry::Periodic(PeriodicRecord::Identities(identities, _), _) => self.identities = Some(*identities),
            Entry::Periodic(PeriodicRecord::Keyframe(..), _) if self.is_full() => self.turn()?,
            _ => {}
        }
        self.make_room(ENTRY_BYTES)
    }
}

impl<S: PartStore, const J: usize, const N: usize> Sink<J, N> for LogParts<S, J, N> {
    fn name(&self) -> String {
        Sink::<J, N>::name(&self.writer)
    }

    fn take(&mut self, entry: Entry<'_, J, N>) -> io::Result<()> {
        self.prepare(entry).map_err(io_error)?;
        self.writer.take(entry)
    }
}
