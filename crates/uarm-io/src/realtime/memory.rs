//! Memory that is there before it is needed.

use super::system_calls;
use crate::finding::{Finding, Verdict};
use rustix::mm::{MlockAllFlags, mlockall};
use rustix::process::{Resource, getrlimit};
use rustix::thread::{CapabilitySet, capabilities, disable_transparent_huge_pages};

/// Stack touched in advance, bytes. The loop's deepest call chain needs a small part of it; a thread has 2 MiB by default.
const STACK_BYTES: usize = 256 * 1024;
/// Smallest page of any Linux system that this runs on, bytes.
const PAGE_BYTES: usize = 4096;

/// Keeps freed memory in the process, where it is locked. `None` where the allocator is not glibc's.
pub(super) fn keep_allocated() -> Option<Finding> {
    let kept = system_calls::keep_freed_memory()?;
    let finding = |found| Finding::good("allocator keeps freed memory", found, "no trimming, no mmap per allocation");
    Some(if kept {
        finding("kept")
    } else {
        finding("mallopt refused").but(Verdict::Warning, "unset GLIBC_TUNABLES and MALLOC_* in the environment")
    })
}

/// Keeps the process to small pages. The kernel clears a huge page in one piece, two megabytes, and on a kernel that is not
/// PREEMPT_RT nothing else runs on that processor meanwhile, whichever thread asked for the memory.
pub(super) fn small_pages() -> Finding {
    let finding = |found: String| Finding::good("transparent huge pages", found, "none in this process");
    match disable_transparent_huge_pages(true) {
        Ok(()) => finding("none in this process".to_owned()),
        Err(errno) => finding(format!("not switched off: {errno}"))
            .but(Verdict::Warning, "`echo never > /sys/kernel/mm/transparent_hugepage/enabled`"),
    }
}

/// Locks all memory of the process, present and future.
pub(super) fn lock() -> Finding {
    const ADVICE: &str =
        "put `@realtime - memlock unlimited` into /etc/security/limits.conf, join that group and log in again";
    let finding = |found: String| Finding::good("memory locked", found, "all, present and future");
    // Under a finite limit the lock may succeed now and let a later allocation fail in the middle of a run: refuse.
    if let (false, Some(limit)) = (may_lock_without_limit(), getrlimit(Resource::Memlock).current) {
        return finding(format!("not locked: limit (ulimit -l) is {} KiB", limit / 1024)).but(Verdict::Bad, ADVICE);
    }
    match mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE) {
        Ok(()) => finding("all".to_owned()),
        Err(errno) => finding(format!("not locked: {errno}")).but(Verdict::Bad, ADVICE),
    }
}

fn may_lock_without_limit() -> bool {
    capabilities(None).is_ok_and(|sets| sets.effective.contains(CapabilitySet::IPC_LOCK))
}

/// Touches the stack that the thread may need, so that no page of it is missing later.
pub(super) fn touch_stack() -> Finding {
    let touched = touch_stack_below();
    let size = format!("{} KiB", touched / 1024);
    Finding::good("stack touched in advance", size.clone(), size)
}

#[inline(never)]
fn touch_stack_below() -> usize {
    let mut stack = [0_u8; STACK_BYTES];
    for page in stack.chunks_mut(PAGE_BYTES) {
        // Opaque to the optimiser: each page is written.
        core::hint::black_box(page).fill(1);
    }
    stack.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::realtime::PageFaults;

    #[test]
    fn touched_stack_faults_no_more() {
        let (first, second) = std::thread::spawn(|| {
            let start = PageFaults::of_this_thread();
            touch_stack();
            let middle = PageFaults::of_this_thread();
            touch_stack();
            (middle.since(start), PageFaults::of_this_thread().since(middle))
        })
        .join()
        .unwrap();
        // Where memory is already locked by another test, the new stack was there from the start and nothing faults at all.
        assert!(second.minor <= first.minor && second.minor < 8, "{first:?}, then {second:?}");
    }
}
