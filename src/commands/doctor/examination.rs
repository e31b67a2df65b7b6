//! All that an examination of the machine found out.

use serde::Serialize;
use uarm_io::finding::{Finding, Verdict};
use uarm_io::probe::WakeupReport;

use crate::exit::Exit;

/// All that was found out.
#[derive(Debug, Serialize)]
pub struct Examination {
    /// The worst verdict of all findings.
    pub verdict: Verdict,
    /// Preconditions of a hard real-time loop.
    pub realtime: Vec<Finding>,
    /// Preconditions of the CAN bus.
    pub can: Vec<Finding>,
    /// What the robot file asks of the bus, and who of it was heard; empty without a robot file.
    pub robot: Vec<Finding>,
    /// How late the machine wakes up.
    pub wakeups: WakeupReport,
}

impl Examination {
    /// The examination with its overall verdict.
    pub fn new(realtime: Vec<Finding>, can: Vec<Finding>, robot: Vec<Finding>, wakeups: WakeupReport) -> Self {
        let findings = realtime.iter().chain(&can).chain(&robot).map(|finding| finding.verdict);
        let verdict = findings.chain([wakeups.verdict]).max().unwrap_or(Verdict::Good);
        Self { verdict, realtime, can, robot, wakeups }
    }

    /// The exit code: a failure if anything is bad.
    pub fn exit(&self) -> Exit {
        match self.verdict {
            Verdict::Good | Verdict::Warning => Exit::Ok,
            Verdict::Bad => Exit::Failure,
        }
    }
}
