//! Makes the calling thread a real-time thread, and says honestly how far it got.
//!
//! In this order: the allocator keeps its memory, in small pages, all memory is locked, the thread's stack is touched, the
//! thread is bound to its processor, processors are kept out of deep sleep (`/dev/cpu_dma_latency`), timers get exact, and
//! last the thread becomes `SCHED_FIFO`.
//!
//! ```
//! use uarm_io::realtime::{RealtimePolicy, RealtimeSettings, RealtimeThread};
//!
//! let settings = RealtimeSettings { policy: RealtimePolicy::Prefer, ..RealtimeSettings::default() };
//! let thread = RealtimeThread::enter(&settings).expect("`prefer` takes what it gets");
//! for item in thread.report() {
//!     println!("{item}");
//! }
//! // Scheduling, processor and sleep states are given back when `thread` is dropped.
//! ```

mod memory;
mod processor;
mod scheduling;
mod system_calls;

pub use processor::{Processor, ProcessorError};
pub use scheduling::{Priority, PriorityError, let_others_go_first};
pub use system_calls::PageFaults;

use crate::finding::{Finding, Verdict};
use core::fmt;
use core::marker::PhantomData;

/// What to do where the system does not grant a real-time thread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RealtimePolicy {
    /// Anything missing is an error: for hardware.
    Enforce,
    /// Take what is granted and report what is missing.
    #[default]
    Prefer,
    /// Ask for nothing.
    Off,
}

/// A text that is not the name of a policy.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
#[error("`{found}` is not a real-time policy: expected `enforce`, `prefer` or `off`")]
pub struct RealtimePolicyError {
    found: String,
}

impl core::str::FromStr for RealtimePolicy {
    type Err = RealtimePolicyError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text {
            "enforce" => Ok(Self::Enforce),
            "prefer" => Ok(Self::Prefer),
            "off" => Ok(Self::Off),
            _ => Err(RealtimePolicyError { found: text.to_owned() }),
        }
    }
}

impl fmt::Display for RealtimePolicy {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(match self {
            Self::Enforce => "enforce",
            Self::Prefer => "prefer",
            Self::Off => "off",
        })
    }
}

/// What to ask the system for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RealtimeSettings {
    /// What to do where something is missing.
    pub policy: RealtimePolicy,
    /// Priority of the thread under `SCHED_FIFO`.
    pub priority: Priority,
    /// The processor that the thread shall run on; any if `None`.
    pub processor: Option<Processor>,
}

/// The system does not grant what [`RealtimePolicy::Enforce`] demands.
#[derive(Debug)]
pub struct RealtimeError {
    missing: Vec<Finding>,
}

impl RealtimeError {
    /// What is missing, with how to get it.
    pub fn missing(&self) -> &[Finding] {
        &self.missing
    }
}

impl fmt::Display for RealtimeError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "no real-time thread (the policy `prefer` would go on without):")?;
        self.missing.iter().try_for_each(|finding| write!(formatter, "\n  {finding}"))
    }
}

impl std::error::Error for RealtimeError {}

/// The calling thread as a real-time thread, until dropped.
///
/// Dropping it restores the thread's scheduling and processors and lets processors sleep deeply again. Memory stays locked:
/// that belongs to the process.
#[derive(Debug)]
#[must_use = "the thread is a real-time thread only as long as this value lives"]
pub struct RealtimeThread {
    report: Vec<Finding>,
    /// Undone in this order: out of `SCHED_FIFO` first.
    _scheduling: Option<scheduling::Fifo>,
    _binding: Option<processor::Binding>,
    _awake: Option<processor::Awake>,
    /// Scheduling belongs to the thread that entered: it must be the one that leaves.
    _not_send: PhantomData<*const ()>,
}

impl RealtimeThread {
    /// Makes the calling thread a real-time thread. Allocates and makes system calls: before the loop.
    ///
    /// # Errors
    /// Under [`RealtimePolicy::Enforce`], if anything is missing; the thread is then as before (memory stays locked).
    pub fn enter(settings: &RealtimeSettings) -> Result<Self, RealtimeError> {
        let mut thread =
            Self { report: Vec::new(), _scheduling: None, _binding: None, _awake: None, _not_send: PhantomData };
        if settings.policy == RealtimePolicy::Off {
            return Ok(thread);
        }
        let report = &mut thread.report;
        report.extend(memory::keep_allocated());
        report.push(memory::small_pages());
        report.push(memory::lock());
        report.push(memory::touch_stack());
        if let Some(processor) = settings.processor {
            thread._binding = note(report, processor::Binding::to(processor));
        }
        thread._awake = note(report, processor::Awake::hold());
        report.push(scheduling::exact_timers());
        thread._scheduling = note(report, scheduling::Fifo::enter(settings.priority));
        if settings.policy == RealtimePolicy::Enforce { thread.demand_all() } else { Ok(thread) }
    }

    fn demand_all(self) -> Result<Self, RealtimeError> {
        let missing: Vec<_> = self.report.iter().filter(|item| item.verdict != Verdict::Good).cloned().collect();
        if missing.is_empty() { Ok(self) } else { Err(RealtimeError { missing }) }
    }

    /// What was asked for, what was got, and how to get the rest. Empty under [`RealtimePolicy::Off`].
    pub fn report(&self) -> &[Finding] {
        &self.report
    }

    /// Whether everything asked for was granted. False under [`RealtimePolicy::Off`].
    pub fn is_complete(&self) -> bool {
        !self.report.is_empty() && self.report.iter().all(|item| item.verdict == Verdict::Good)
    }
}

/// Puts the finding on the report and gives the thing that came with it.
fn note<T>(report: &mut Vec<Finding>, (thing, finding): (Option<T>, Finding)) -> Option<T> {
    report.push(finding);
    thing
}

#[cfg(test)]
mod tests {
    use super::*;

    fn in_own_thread<T: Send + 'static>(task: impl FnOnce() -> T + Send + 'static) -> T {
        std::thread::spawn(task).join().unwrap()
    }

    #[test]
    fn policies_are_read_as_they_are_written() {
        for policy in [RealtimePolicy::Enforce, RealtimePolicy::Prefer, RealtimePolicy::Off] {
            assert_eq!(policy.to_string().parse(), Ok(policy));
        }
        assert!("Enforce".parse::<RealtimePolicy>().unwrap_err().to_string().contains("`Enforce`"));
    }

    #[test]
    fn off_asks_for_nothing() {
        let settings = RealtimeSettings { policy: RealtimePolicy::Off, ..Default::default() };
        let (empty, complete) = in_own_thread(move || {
            let thread = RealtimeThread::enter(&settings).unwrap();
            (thread.report().is_empty(), thread.is_complete())
        });
        assert!(empty && !complete);
    }

    #[test]
    fn the_report_tells_what_the_kernel_says_and_dropping_restores() {
        let (report, during, after) = in_own_thread(|| {
            let thread = RealtimeThread::enter(&RealtimeSettings::default()).unwrap();
            let during = system_calls::scheduler();
            let report = thread.report().to_vec();
            drop(thread);
            (report, during, system_calls::scheduler())
        });
        let fifo = report.iter().find(|item| item.name.contains("SCHED_FIFO")).unwrap();
        assert_eq!(fifo.verdict == Verdict::Good, during == libc::SCHED_FIFO, "{fifo}");
        assert_eq!(after, libc::SCHED_OTHER);
        assert!(report.iter().all(|item| (item.verdict == Verdict::Good) == item.how_to_get_it.is_empty()));
    }

    #[test]
    fn enforce_refuses_exactly_when_prefer_reports_something_missing() {
        // No machine of this size: binding to its last possible processor cannot succeed.
        let absent = Processor::new(Processor::LAST).unwrap();
        let (preferred, enforced, after) = in_own_thread(move || {
            let settings = RealtimeSettings { processor: Some(absent), ..Default::default() };
            let preferred = RealtimeThread::enter(&settings).unwrap().report().to_vec();
            let enforced = RealtimeThread::enter(&RealtimeSettings { policy: RealtimePolicy::Enforce, ..settings });
            (preferred, enforced.map(drop).unwrap_err(), system_calls::scheduler())
        });
        let missing: Vec<_> = preferred.into_iter().filter(|item| item.verdict != Verdict::Good).collect();
        assert!(missing.iter().any(|item| item.name.contains("processor 1023")), "{missing:?}");
        assert_eq!(enforced.missing(), missing);
        assert!(enforced.to_string().contains("processor 1023"));
        assert_eq!(after, libc::SCHED_OTHER);
    }
}
