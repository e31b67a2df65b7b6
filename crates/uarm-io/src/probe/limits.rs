//! What the user may ask for.

use super::machine::Machine;
use crate::finding::{Finding, Verdict};
use crate::realtime::Priority;

/// Bit numbers of capabilities (`linux/capability.h`).
const CAP_IPC_LOCK: u32 = 14;
const CAP_SYS_NICE: u32 = 23;

/// The highest real-time priority allowed.
pub(super) fn realtime_priority(machine: &Machine) -> Finding {
    let wanted = format!("{} or more", Priority::LOOP);
    let finding = |found: String| Finding::good("real-time priority limit", found, wanted.as_str());
    if has_capability(machine, CAP_SYS_NICE) {
        return finding("any (CAP_SYS_NICE)".to_owned());
    }
    let limit = soft_limit(machine, "Max realtime priority");
    let enough = limit.as_deref().is_some_and(|limit| {
        limit == "unlimited" || limit.parse::<u8>().is_ok_and(|limit| limit >= Priority::LOOP.number())
    });
    let finding = finding(limit.unwrap_or_else(|| "unknown".to_owned()));
    if enough {
        finding
    } else {
        finding.but(Verdict::Bad, "put `@realtime - rtprio 98` into /etc/security/limits.conf, `usermod -aG realtime $USER`, log in again; `ulimit -r` shows it")
    }
}

/// How much memory may be locked.
pub(super) fn locked_memory(machine: &Machine) -> Finding {
    let finding = |found: String| Finding::good("locked memory limit", found, "unlimited");
    if has_capability(machine, CAP_IPC_LOCK) {
        return finding("any (CAP_IPC_LOCK)".to_owned());
    }
    let limit = soft_limit(machine, "Max locked memory");
    match limit.as_deref() {
        Some("unlimited") => finding("unlimited".to_owned()),
        other => {
            let found = other.map_or_else(|| "unknown".to_owned(), |bytes| format!("{bytes} bytes"));
            finding(found).but(Verdict::Bad, "put `@realtime - memlock unlimited` into /etc/security/limits.conf, `usermod -aG realtime $USER`, log in again; `ulimit -l` shows it")
        }
    }
}

fn soft_limit(machine: &Machine, name: &str) -> Option<String> {
    let limits = machine.text("/proc/self/limits")?;
    let values = limits.lines().find_map(|line| line.strip_prefix(name))?;
    values.split_whitespace().next().map(str::to_owned)
}

fn has_capability(machine: &Machine, bit: u32) -> bool {
    let effective = || {
        let status = machine.text("/proc/self/status")?;
        let mask = status.lines().find_map(|line| line.strip_prefix("CapEff:"))?;
        u64::from_str_radix(mask.trim(), 16).ok()
    };
    effective().is_some_and(|mask| mask >> bit & 1 == 1)
}
