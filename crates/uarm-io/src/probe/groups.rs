//! What the control groups of this process leave to its threads (Linux, `cgroup-v1` and `cgroup-v2`).

use super::kernel::{DEFAULT_RT_PERIOD, percent_of, share};
use super::machine::Machine;
use crate::finding::{Finding, Verdict};

/// Where the `cpu` controller of version 1 is mounted, and where version 2 is, alone or beside version 1.
const VERSION_1: [&str; 2] = ["/sys/fs/cgroup/cpu", "/sys/fs/cgroup/cpu,cpuacct"];
const VERSION_2: [&str; 2] = ["/sys/fs/cgroup", "/sys/fs/cgroup/unified"];

/// The group of this process by its line in `/proc/self/cgroup`, `number:controllers:/path`; the line of version 2 has no controllers.
fn group(machine: &Machine, controller: &str) -> Option<String> {
    let groups = machine.text("/proc/self/cgroup")?;
    groups.lines().find_map(|line| {
        let (_, rest) = line.split_once(':')?;
        let (controllers, path) = rest.split_once(':')?;
        controllers.split(',').any(|name| name == controller).then(|| path.to_owned())
    })
}

/// The folders of a group and of those above it, the innermost first. In a container its path may be the host's: the mount's root is
/// then the last.
fn folders(mounts: [&str; 2], group: &str) -> Vec<String> {
    let mut paths = vec![group.trim_end_matches('/')];
    while let Some((above, _)) = paths.last().and_then(|path| path.rsplit_once('/')) {
        paths.push(above);
    }
    mounts.iter().flat_map(|mount| paths.iter().map(move |path| format!("{mount}{path}"))).collect()
}

/// The smallest share of real-time threads that a group of version 1 has; `None` where groups have none of their own
/// (`CONFIG_RT_GROUP_SCHED` is off, or version 2).
pub(super) fn realtime_share(machine: &Machine) -> Option<Finding> {
    let group = group(machine, "cpu")?;
    let of_folder = |folder: String| {
        let runtime: i64 = machine.number(&format!("{folder}/cpu.rt_runtime_us"))?;
        let period = machine.number(&format!("{folder}/cpu.rt_period_us")).unwrap_or(DEFAULT_RT_PERIOD);
        Some((percent_of(runtime, period), folder))
    };
    let shares = folders(VERSION_1, &group).into_iter().filter_map(of_folder);
    let (percent, folder) = shares.min_by_key(|(percent, _)| percent.unwrap_or(i64::MAX))?;
    let found = percent.map_or_else(|| "unlimited".to_owned(), |percent| format!("{percent} % in {folder}"));
    let advice = format!("`echo 950000 > {folder}/cpu.rt_runtime_us`, in the groups above it first");
    Some(share("real-time share of the group", percent, found, &advice))
}

/// The quota of a group of version 2. It binds ordinary threads only: the loop's does not stand still, the recorder's may.
pub(super) fn quota(machine: &Machine) -> Option<Finding> {
    let group = group(machine, "")?;
    let limited = folders(VERSION_2, &group).into_iter().find_map(|folder| {
        let limit = machine.text(&format!("{folder}/cpu.max"))?;
        (!limit.starts_with("max")).then_some((limit, folder))
    });
    let (limit, folder) = limited?;
    let finding = Finding::good("quota of the group", format!("{limit} us in {folder}"), "none");
    Some(finding.but(Verdict::Warning, format!("the recorder may stand still: `echo max > {folder}/cpu.max`")))
}
