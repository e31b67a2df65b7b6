//! System calls that no safe library wraps. The only unsafe code of the workspace.
#![allow(unsafe_code)]

use core::mem::MaybeUninit;
use std::io;

/// Turns the ordinary answer of a system call into a result.
fn checked(answer: libc::c_long) -> io::Result<()> {
    if answer == 0 { Ok(()) } else { Err(io::Error::last_os_error()) }
}

fn set_scheduler(policy: libc::c_int, priority: u8) -> io::Result<()> {
    const CALLING_THREAD: libc::pid_t = 0;
    // SAFETY: a structure of integers, for which all bits zero is a value; C libraries other than glibc have more of them.
    let mut parameters: libc::sched_param = unsafe { core::mem::zeroed() };
    parameters.sched_priority = priority.into();
    // SAFETY: the kernel only reads `parameters`, which is a live, initialised value of the type that the call expects. The
    // call changes the scheduling of the calling thread and touches no memory of the process. The system call is made
    // directly, since musl's wrapper refuses.
    checked(unsafe { libc::syscall(libc::SYS_sched_setscheduler, CALLING_THREAD, policy, &raw const parameters) })
}

/// Puts the calling thread under `SCHED_FIFO` with a priority of 1 to 99. Threads and processes that it starts are ordinary again.
pub(super) fn set_fifo(priority: u8) -> io::Result<()> {
    set_scheduler(libc::SCHED_FIFO | libc::SCHED_RESET_ON_FORK, priority)
}

/// Puts the calling thread under ordinary scheduling.
pub(super) fn set_ordinary() -> io::Result<()> {
    set_scheduler(libc::SCHED_OTHER, 0)
}

/// The scheduling policy of the calling thread (`SCHED_…`), without flags.
#[cfg(test)]
pub(super) fn scheduler() -> libc::c_int {
    // SAFETY: the call takes a plain number and only reads kernel state.
    let policy = unsafe { libc::sched_getscheduler(0) };
    policy & !libc::SCHED_RESET_ON_FORK
}

/// Makes glibc's allocator keep freed memory and serve all sizes from it; whether it took both wishes. `None` where the
/// allocator is another.
pub(super) fn keep_freed_memory() -> Option<bool> {
    #[cfg(target_env = "gnu")]
    {
        const NEVER: libc::c_int = -1;
        const NONE: libc::c_int = 0;
        // SAFETY: mallopt takes plain numbers, locks the allocator itself, and these two parameters only change where later
        // allocations come from, never the validity of present ones.
        let answers = unsafe { [libc::mallopt(libc::M_TRIM_THRESHOLD, NEVER), libc::mallopt(libc::M_MMAP_MAX, NONE)] };
        Some(answers == [1, 1])
    }
    #[cfg(not(target_env = "gnu"))]
    None
}

/// Page faults of a thread so far: none may be added while the loop runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PageFaults {
    /// Served from memory: some microseconds each.
    pub minor: u64,
    /// Served from a disk: milliseconds each.
    pub major: u64,
}

impl PageFaults {
    /// The page faults of the calling thread so far (`getrusage(RUSAGE_THREAD)`).
    pub fn of_this_thread() -> Self {
        let mut usage = MaybeUninit::<libc::rusage>::zeroed();
        // SAFETY: `usage` is valid for writes of a whole `rusage`, which is what the kernel writes at most.
        let answer = unsafe { libc::getrusage(libc::RUSAGE_THREAD, usage.as_mut_ptr()) };
        // The call cannot fail with a valid place and who; were it to, zeros are a valid `rusage` and the counts stay 0.
        debug_assert_eq!(answer, 0);
        // SAFETY: `rusage` consists of integers only, for which zeroed memory is a valid value, whatever the kernel wrote.
        let usage = unsafe { usage.assume_init() };
        let count = |faults: libc::c_long| u64::try_from(faults).unwrap_or(0);
        Self { minor: count(usage.ru_minflt), major: count(usage.ru_majflt) }
    }

    /// The page faults added since `earlier`.
    pub const fn since(self, earlier: Self) -> Self {
        Self { minor: self.minor.saturating_sub(earlier.minor), major: self.major.saturating_sub(earlier.major) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same counts by another way: fields 10 and 12 of the thread's `stat`.
    fn faults_in_proc() -> PageFaults {
        let stat = std::fs::read_to_string("/proc/thread-self/stat").unwrap();
        let (_, fields) = stat.rsplit_once(')').unwrap();
        let field = |number: usize| fields.split_whitespace().nth(number - 3).unwrap().parse().unwrap();
        PageFaults { minor: field(10), major: field(12) }
    }

    #[test]
    fn page_faults_agree_with_proc_and_are_the_threads_own() {
        std::thread::spawn(|| {
            let (before, faults, after) = (faults_in_proc(), PageFaults::of_this_thread(), faults_in_proc());
            assert!((before.minor..=after.minor).contains(&faults.minor), "{before:?} {faults:?} {after:?}");
            assert!((before.major..=after.major).contains(&faults.major), "{before:?} {faults:?} {after:?}");
        })
        .join()
        .unwrap();
    }
}
