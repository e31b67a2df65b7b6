//! How the loop's thread is scheduled, from the command line to the log.

use anyhow::Context;
use uarm_io::realtime::{Priority, Processor, RealtimePolicy, RealtimeSettings, RealtimeThread};

use crate::commands::run::RealtimeChoice;
use crate::recording::{Notebook, Severity};
use crate::run_log::description::RealtimeRequest;

/// How the loop's thread is scheduled.
#[derive(Clone, Copy, Debug)]
pub struct Realtime(RealtimeSettings);

impl Realtime {
    /// Settings from the command line.
    ///
    /// # Errors
    /// If priority or processor are out of range.
    pub fn new(choice: RealtimeChoice, priority: u8, processor: Option<usize>) -> anyhow::Result<Self> {
        let policy = match choice {
            RealtimeChoice::Enforce => RealtimePolicy::Enforce,
            RealtimeChoice::Prefer => RealtimePolicy::Prefer,
            RealtimeChoice::Off => RealtimePolicy::Off,
        };
        let priority = Priority::new(priority).context("--priority")?;
        let processor = processor.map(Processor::new).transpose().context("--cpu")?;
        Ok(Self(RealtimeSettings { policy, priority, processor }))
    }

    /// What is asked for, for the log.
    pub fn request(&self) -> RealtimeRequest {
        let RealtimeSettings { policy, priority, processor } = &self.0;
        RealtimeRequest {
            policy: policy.to_string(),
            priority: priority.to_string(),
            processor: processor.map_or_else(|| "any".to_owned(), |processor| processor.to_string()),
        }
    }

    /// Makes the calling thread a real-time thread; tells standard error what is missing, and the log all that was found.
    ///
    /// # Errors
    /// If something is missing and all was demanded.
    pub fn enter(&self, notebook: Option<&Notebook>) -> anyhow::Result<RealtimeThread> {
        let thread = RealtimeThread::enter(&self.0)?;
        for finding in thread.report() {
            let is_missing = !finding.how_to_get_it.is_empty();
            let text = format!("real time: {finding}");
            if is_missing {
                eprintln!("  {text}");
            }
            if let Some(notebook) = notebook {
                notebook.add(if is_missing { Severity::Warning } else { Severity::Info }, text);
            }
        }
        Ok(thread)
    }
}
