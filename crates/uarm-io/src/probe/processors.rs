//! Processors: their clock, their sleep, and who else runs on them.

use super::machine::Machine;
use crate::finding::{Finding, Verdict};

const PROCESSORS: &str = "/sys/devices/system/cpu";

fn processors(machine: &Machine) -> Vec<String> {
    let is_processor = |name: &String| name.strip_prefix("cpu").is_some_and(|number| number.parse::<u32>().is_ok());
    machine.names(PROCESSORS).into_iter().filter(is_processor).collect()
}

/// The frequency governors. `None` where the machine has no frequency to govern (virtual, or a fixed clock).
pub(super) fn governor(machine: &Machine) -> Option<Finding> {
    const WANTED: &str = "performance";
    let read = |processor: String| machine.text(&format!("{PROCESSORS}/{processor}/cpufreq/scaling_governor"));
    let mut governors: Vec<_> = processors(machine).into_iter().filter_map(read).collect();
    let all = governors.len();
    governors.sort();
    governors.dedup();
    if all == 0 {
        return None;
    }
    let finding = Finding::good("frequency governor", format!("{} on {all} processors", governors.join(", ")), WANTED);
    Some(if governors == [WANTED] {
        finding
    } else {
        finding.but(Verdict::Bad, "`cpupower frequency-set -g performance` (package linux-cpupower); a clock that ramps up makes the first cycles late")
    })
}

/// Whether processors can be kept out of deep sleep.
pub(super) fn sleep_states(machine: &Machine) -> Finding {
    const DEVICE: &str = "/dev/cpu_dma_latency";
    let finding = |found: &str| Finding::good("control of sleep states", found, "may write /dev/cpu_dma_latency");
    if std::fs::OpenOptions::new().write(true).open(machine.path(DEVICE)).is_ok() {
        return finding("may write it");
    }
    if machine.exists(DEVICE) {
        let advice = "udev rule `KERNEL==\"cpu_dma_latency\", GROUP=\"realtime\", MODE=\"0660\"` in /etc/udev/rules.d/99-realtime.rules, then `udevadm trigger`; or run as root";
        finding("there, not writable").but(Verdict::Warning, advice)
    } else {
        finding("absent").but(Verdict::Warning, "in a container: pass the device in; on a bare machine: `processor.max_cstate=1` on the kernel's command line")
    }
}

/// Processors that the scheduler leaves alone. `None` on a machine with a single one.
pub(super) fn isolated(machine: &Machine) -> Option<Finding> {
    let processors = processors(machine).len();
    if processors < 2 {
        return None;
    }
    let isolated = machine.text(&format!("{PROCESSORS}/isolated")).filter(|list| !list.is_empty());
    let finding = |found: String| Finding::good("isolated processors", found, "one for the loop");
    let last = processors - 1;
    Some(match isolated {
        Some(list) => finding(list),
        None => finding(format!("none of {processors}")).but(
            Verdict::Warning,
            format!("`isolcpus={last} nohz_full={last} rcu_nocbs={last}` on the kernel's command line, then bind the loop to processor {last}; optional on a quiet machine"),
        ),
    })
}
