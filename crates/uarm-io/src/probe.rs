//! The preconditions of a real-time loop on a CAN bus, found out on this machine.
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
mod groups;
mod kernel;
mod limits;
mod machine;
mod processors;
mod wakeup;

pub use can::CanWish;
pub use machine::Machine;
pub use wakeup::{LatencyBucket, MeasurementError, WakeupReport, measure_wakeups};

use crate::finding::{Finding, Verdict};

impl Machine {
    /// What a real-time thread needs of kernel, rights, processors and clocks.
    pub fn realtime_findings(&self) -> Vec<Finding> {
        let mut findings = vec![
            kernel::realtime_kernel(self),
            limits::realtime_priority(self),
            limits::locked_memory(self),
            kernel::realtime_share(self),
        ];
        findings.extend(groups::realtime_share(self));
        findings.extend(groups::quota(self));
        findings.extend(processors::governor(self));
        findings.push(processors::sleep_states(self));
        findings.extend(processors::isolated(self));
        findings.push(kernel::clock_source(self));
        findings.extend(kernel::timers(self));
        findings
    }

    /// What no real-time loop may begin with: all that is bad in [`realtime_findings`](Self::realtime_findings), and, for a loop on
    /// an interface, in [`can_findings`](Self::can_findings).
    pub fn obstacles(&self, wish: Option<&CanWish>) -> Vec<Finding> {
        let can = wish.map_or_else(Vec::new, |wish| self.can_findings(wish));
        let all = self.realtime_findings().into_iter().chain(can);
        all.filter(|finding| finding.verdict == Verdict::Bad).collect()
    }

    /// What is wrong with the bit rate of the interface that is wished for, if it is known: at another rate than the bus's it disturbs
    /// all who are on it.
    pub fn wrong_bit_rate(&self, wish: &CanWish) -> Option<Finding> {
        can::wrong_bit_rate(self, wish)
    }

    /// What the drives' bus needs: CAN in the kernel, the interfaces and how they are set up.
    pub fn can_findings(&self, wish: &CanWish) -> Vec<Finding> {
        can::findings(self, wish)
    }
}

#[cfg(test)]
mod tests;
