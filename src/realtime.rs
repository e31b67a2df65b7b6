//! How the thread of a loop is scheduled, from the command line to the log.

use anyhow::{Context, bail};
use uarm_io::probe::{CanWish, Machine};
use uarm_io::realtime::{Priority, Processor, RealtimePolicy, RealtimeSettings, RealtimeThread};
use uarm_log::description::MachineDescription;
use uarm_loop::choice::Choice;
use uarm_loop::recording::{LogHandle, Severity};

use crate::console;
use crate::dimensions::{ACTIVE, JOINTS};
use crate::options::choice;

/// What a command line says of it.
#[derive(Debug, clap::Args)]
pub struct RealtimeArguments {
    /// Real-time scheduling of the loop; by default "enforce" with --can and "prefer" otherwise
    #[arg(long, value_parser = choice::<RealtimePolicy>(), value_name = "POLICY")]
    rt: Option<RealtimePolicy>,
    /// SCHED_FIFO priority of the loop
    #[arg(long, default_value_t = 80, value_parser = clap::value_parser!(u8).range(1..=98), value_name = "1..98")]
    priority: u8,
    /// Keep the loop on this CPU
    #[arg(long, value_name = "CPU")]
    cpu: Option<usize>,
}

impl RealtimeArguments {
    /// What it says, with `default` where it leaves the policy open.
    ///
    /// # Errors
    /// If priority or processor are out of range.
    pub fn settings(&self, default: RealtimePolicy) -> anyhow::Result<Realtime> {
        Realtime::new(self.rt.unwrap_or(default), self.priority, self.cpu)
    }
}

/// How the loop's thread is scheduled.
#[derive(Clone, Copy, Debug)]
pub struct Realtime(RealtimeSettings);

impl Realtime {
    /// Settings from the command line.
    ///
    /// # Errors
    /// If priority or processor are out of range.
    fn new(policy: RealtimePolicy, priority: u8, processor: Option<usize>) -> anyhow::Result<Self> {
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

    /// Looks at what `uarm doctor` calls bad on `machine`, and with a `wish` on the bus: each is told and logged.
    ///
    /// # Errors
    /// If something is bad and all was demanded.
    pub fn examine<const J: usize, const N: usize>(
        &self,
        machine: &Machine,
        wish: Option<&CanWish>,
        log: Option<&LogHandle<J, N>>,
    ) -> anyhow::Result<()> {
        if self.0.policy == RealtimePolicy::Off {
            return Ok(());
        }
        let obstacles = machine.obstacles(wish);
        if self.0.policy == RealtimePolicy::Enforce && !obstacles.is_empty() {
            let list: String = obstacles.iter().map(|finding| format!("\n  {finding}")).collect();
            bail!("this machine is not ready (--rt prefer would go on; `uarm doctor` tells all):{list}");
        }
        for finding in &obstacles {
            let text = format!("machine: {finding}");
            console::tell(format_args!("  {text}"));
            if let Some(log) = log {
                log.add(Severity::Warning, text);
            }
        }
        Ok(())
    }

    /// Makes the calling thread a real-time thread; tells standard error what is missing.
    ///
    /// # Errors
    /// If something is missing and all was demanded.
    pub fn enter_unrecorded(&self) -> anyhow::Result<RealtimeThread> {
        self.enter(None::<&LogHandle<JOINTS, ACTIVE>>)
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

#[cfg(test)]
mod tests {
    use uarm_io::finding::Verdict;

    use super::*;

    /// A real-time share that lets the loop stand still for 300 ms of each second, and nothing else that is bad but what an empty folder
    /// lacks.
    #[test]
    fn enforce_refuses_what_the_doctor_calls_bad_and_prefer_tells_it() {
        let folder = std::env::temp_dir().join(format!("uarm-enforce-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("proc/sys/kernel")).unwrap();
        std::fs::write(folder.join("proc/sys/kernel/sched_rt_runtime_us"), "700000").unwrap();
        let machine = Machine::in_folder(&folder);
        let examine = |policy| {
            let realtime = Realtime::new(policy, 80, None).unwrap();
            realtime.examine::<3, 2>(&machine, None, None).map_err(|error| error.to_string())
        };
        let refused = examine(RealtimePolicy::Enforce).unwrap_err();
        for bad in machine.realtime_findings().iter().filter(|finding| finding.verdict == Verdict::Bad) {
            assert!(refused.contains(&bad.to_string()), "{bad} in {refused}");
        }
        assert!(refused.contains("share for real-time threads: found 70 %, wanted at least 90 %"), "{refused}");
        assert_eq!((examine(RealtimePolicy::Prefer), examine(RealtimePolicy::Off)), (Ok(()), Ok(())));
        std::fs::remove_dir_all(folder).unwrap();
    }
}
