//! How the loop's thread is scheduled, from the command line to the log.

use anyhow::Context;
use uarm_io::realtime::{Priority, Processor, RealtimePolicy, RealtimeSettings, RealtimeThread};
use uarm_log::description::MachineDescription;
use uarm_loop::choice::Choice;
use uarm_loop::recording::{LogHandle, Severity};

use crate::console;

/// How the loop's thread is scheduled.
#[derive(Clone, Copy, Debug)]
pub struct Realtime(RealtimeSettings);

impl Realtime {
    /// Settings from the command line.
    ///
    /// # Errors
    /// If priority or processor are out of range.
    pub fn new(policy: RealtimePolicy, priority: u8, processor: Option<usize>) -> anyhow::Result<Self> {
        let priority = Priority::new(priority).context("--priority")?;
        let processor = processor.map(Processor::new).transpose().context("--cpu")?;
        Ok(Self(RealtimeSettings { policy, priority, processor }))
    }

    /// This program, and what is asked for of this machine, for the log.
    pub fn machine(&self) -> MachineDescription {
        let RealtimeSettings { policy, priority, processor } = &self.0;
        MachineDescription {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: env!("UARM_COMMIT").to_owned(),
            realtime_policy: policy.name().to_owned(),
            priority: priority.to_string(),
            processor: processor.map_or_else(|| "any".to_owned(), |processor| processor.to_string()),
        }
    }

    /// Makes the calling thread a real-time thread; tells standard error what is missing, and the log all that was found.
    ///
    /// # Errors
    /// If something is missing and all was demanded.
    pub fn enter<const J: usize, const N: usize>(
        &self,
        log: Option<&LogHandle<J, N>>,
    ) -> anyhow::Result<RealtimeThread> {
        let thread = RealtimeThread::enter(&self.0)?;
        for finding in thread.report() {
            let is_missing = !finding.how_to_get_it.is_empty();
            let text = format!("real time: {finding}");
            if is_missing {
                console::tell(format_args!("  {text}"));
            }
            if let Some(log) = log {
                log.add(if is_missing { Severity::Warning } else { Severity::Info }, text);
            }
        }
        Ok(thread)
    }
}
