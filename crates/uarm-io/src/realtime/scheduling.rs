//! The thread's turn on its processor.

use super::system_calls;
use crate::finding::{Finding, Verdict};
use core::fmt;
use core::num::NonZeroU64;
use rustix::thread::{current_timer_slack, set_current_timer_slack};

/// A `SCHED_FIFO` priority, 1 to [`Priority::HIGHEST`]; higher runs first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Priority(u8);

/// A number outside the range of priorities.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
#[error("{found} is not a real-time priority: expected 1 to {highest}", highest = Priority::HIGHEST)]
pub struct PriorityError {
    found: u8,
}

impl Priority {
    /// The highest that may be asked for. 99 belongs to the kernel's own watchdog and migration threads.
    pub const HIGHEST: u8 = 98;

    /// The priority of the control loop unless asked otherwise: above the kernel's interrupt threads (50), so that no disk
    /// or network interrupt delays a cycle, and below the kernel's own most urgent threads.
    pub const LOOP: Self = Self(80);

    /// The priority with this number.
    ///
    /// # Errors
    /// If it is not from 1 to [`Priority::HIGHEST`].
    pub const fn new(number: u8) -> Result<Self, PriorityError> {
        if matches!(number, 1..=Self::HIGHEST) { Ok(Self(number)) } else { Err(PriorityError { found: number }) }
    }

    /// The priority as a number, 1 to 98.
    pub const fn number(self) -> u8 {
        self.0
    }
}

impl Default for Priority {
    fn default() -> Self {
        Self::LOOP
    }
}

impl fmt::Display for Priority {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.0, formatter)
    }
}

impl core::str::FromStr for Priority {
    type Err = Box<dyn std::error::Error + Send + Sync>;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(Self::new(text.parse()?)?)
    }
}

/// A tenth of an ordinary thread's share when both want the processor, and all of it when nobody else does.
const NICENESS: i32 = 10;

/// Lets all other ordinary threads go first from now on: for what works beside a loop, so that on a machine without free
/// processors neither the loop nor emulated drives wait for it. Never refused: anyone may be nicer.
pub fn let_others_go_first() {
    // Linux takes "this process" for "this thread" here.
    let _ = rustix::process::setpriority_process(None, NICENESS);
}

/// The thread under `SCHED_FIFO`; ordinary again when dropped.
#[derive(Debug)]
pub(super) struct Fifo(());

impl Fifo {
    pub(super) fn enter(priority: Priority) -> (Option<Self>, Finding) {
        let finding = |found: String| Finding::good("thread under SCHED_FIFO", found, format!("priority {priority}"));
        match system_calls::set_fifo(priority.number()) {
            Ok(()) => (Some(Self(())), finding(format!("priority {priority}"))),
            Err(error) => {
                let advice =
                    "put `@realtime - rtprio 98` into /etc/security/limits.conf, join that group and log in again";
                (None, finding(format!("ordinary scheduling: {error}")).but(Verdict::Bad, advice))
            }
        }
    }
}

impl Drop for Fifo {
    fn drop(&mut self) {
        // Giving up a priority is always allowed.
        let _ = system_calls::set_ordinary();
    }
}

/// Tells the kernel not to gather this thread's timers with others'. `SCHED_FIFO` implies it; without, it saves 50 µs.
pub(super) fn exact_timers() -> Finding {
    let set = set_current_timer_slack(Some(NonZeroU64::MIN)).and_then(|()| current_timer_slack());
    let finding = |found: String| Finding::good("timer slack", found, "1 ns");
    match set {
        Ok(1) => finding("1 ns".to_owned()),
        Ok(other) => finding(format!("{other} ns")).but(Verdict::Warning, "use a kernel with CONFIG_HIGH_RES_TIMERS"),
        Err(errno) => {
            finding(format!("not set: {errno}")).but(Verdict::Warning, "allow prctl in the container's policy")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn priorities_have_a_range() {
        assert!(Priority::new(0).is_err() && Priority::new(99).is_err());
        assert_eq!("98".parse::<Priority>().unwrap().number(), 98);
        assert!("300".parse::<Priority>().is_err());
    }
}
