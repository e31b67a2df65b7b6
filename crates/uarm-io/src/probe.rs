//! The preconditions of a real-time loop on a CAN bus, found out on this machine: what `uarm doctor` prints.
//!
//! Facts are read from `/proc`, `/sys` and `/boot` below a root that the caller chooses, so that a test can describe any
//! machine as a folder. What only a system call tells (CAN sockets, netlink) is asked of the running machine alone.
//!
//! ```
//! use uarm_io::probe::{CanWish, Machine};
//!
//! let machine = Machine::this();
//! for finding in machine.realtime_findings().into_iter().chain(machine.can_findings(&CanWish::default())) {
//!     println!("[{}] {finding}", finding.verdict);
//! }
//! ```

mod can;
mod kernel;
mod limits;
mod processors;
mod wakeup;

pub use can::CanWish;
pub use wakeup::{LatencyBucket, MeasurementError, WakeupReport, measure_wakeups};

use crate::finding::Finding;
use std::path::{Path, PathBuf};

/// A machine to look at: the running one, or a folder laid out like one.
#[derive(Clone, Debug)]
pub struct Machine {
    root: PathBuf,
    source: Source,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Source {
    Running,
    Folder,
}

impl Machine {
    /// The running machine.
    pub fn this() -> Self {
        Self { root: PathBuf::from("/"), source: Source::Running }
    }

    /// A machine whose `/proc`, `/sys` and `/boot` lie below a folder.
    pub fn in_folder(root: impl Into<PathBuf>) -> Self {
        Self { root: root.into(), source: Source::Folder }
    }

    /// What a real-time thread needs of kernel, rights, processors and clocks.
    pub fn realtime_findings(&self) -> Vec<Finding> {
        let mut findings = vec![
            kernel::realtime_kernel(self),
            limits::realtime_priority(self),
            limits::locked_memory(self),
            kernel::realtime_share(self),
        ];
        findings.extend(processors::governor(self));
        findings.push(processors::sleep_states(self));
        findings.extend(processors::isolated(self));
        findings.push(kernel::clock_source(self));
        findings.extend(kernel::timers(self));
        findings
    }

    /// What the drives' bus needs: CAN in the kernel, the interfaces and how they are set up.
    pub fn can_findings(&self, wish: &CanWish) -> Vec<Finding> {
        can::findings(self, wish)
    }

    fn is_running(&self) -> bool {
        self.source == Source::Running
    }

    fn path(&self, absolute: &str) -> PathBuf {
        self.root.join(absolute.trim_start_matches('/'))
    }

    /// The text of a file without surrounding white space; `None` if it is absent or not readable.
    fn text(&self, absolute: &str) -> Option<String> {
        std::fs::read_to_string(self.path(absolute)).ok().map(|text| text.trim().to_owned())
    }

    fn number<T: core::str::FromStr>(&self, absolute: &str) -> Option<T> {
        self.text(absolute)?.parse().ok()
    }

    /// The names in a folder, sorted; empty if it is absent.
    fn names(&self, absolute: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.path(absolute)).into_iter().flatten().flatten();
        let mut names: Vec<_> = entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
        names.sort();
        names
    }

    fn exists(&self, absolute: &str) -> bool {
        Path::exists(&self.path(absolute))
    }
}

#[cfg(test)]
mod tests;
