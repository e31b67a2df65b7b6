//! Kernel, its clocks and timers.

use super::machine::Machine;
use crate::finding::{Finding, Verdict};

/// Whether the kernel is `PREEMPT_RT`, by every sign there is: none of them is on all kernels.
pub(super) fn realtime_kernel(machine: &Machine) -> Finding {
    let version = machine.text("/proc/sys/kernel/version").unwrap_or_default();
    let release = machine.text("/proc/sys/kernel/osrelease").unwrap_or_default();
    let configuration = machine.text(&format!("/boot/config-{release}"));
    let signs = [
        ("/sys/kernel/realtime", machine.text("/sys/kernel/realtime").map(|text| text == "1")),
        ("uname -v", (!version.is_empty()).then(|| version.split_whitespace().any(|word| word == "PREEMPT_RT"))),
        ("/boot/config", configuration.map(|text| text.lines().any(|line| line == "CONFIG_PREEMPT_RT=y"))),
    ];
    let told = signs.map(|(sign, answer)| match answer {
        Some(true) => format!("{sign}: yes"),
        Some(false) => format!("{sign}: no"),
        None => format!("{sign}: silent"),
    });
    let found = format!("{}{release} ({})", preemption(machine, &version), told.join(", "));
    let finding = Finding::good("real-time kernel", found, "PREEMPT_RT, by every sign that speaks");
    let answers: Vec<bool> = signs.iter().filter_map(|(_, answer)| *answer).collect();
    if answers.contains(&true) && !answers.contains(&false) {
        return finding;
    }
    let advice = if answers.contains(&true) {
        "the signs disagree: check that the kernel that runs is the one whose files are installed (`uname -a`), and reboot into it"
    } else {
        "Debian: `apt install linux-image-rt-amd64` and reboot; Ubuntu: `pro enable realtime-kernel`. \
         An ordinary kernel can keep 3 ms on a quiet machine, but nothing bounds its worst case"
    };
    finding.but(Verdict::Warning, advice)
}

/// The preemption model in words, with a trailing blank: from the scheduler's own file where one may read it.
fn preemption(machine: &Machine, version: &str) -> String {
    let chosen = machine.text("/sys/kernel/debug/sched/preempt").and_then(|models| {
        let (_, rest) = models.split_once('(')?;
        Some(format!("preemption `{}`, ", rest.split_once(')')?.0))
    });
    let named = || version.split_whitespace().find(|word| word.starts_with("PREEMPT")).map(|word| format!("{word} "));
    chosen.or_else(named).unwrap_or_default()
}

/// The share of time that real-time threads may take: beyond it the kernel stops them for the rest of a period.
pub(super) fn realtime_share(machine: &Machine) -> Finding {
    let period: i64 = machine.number("/proc/sys/kernel/sched_rt_period_us").unwrap_or(DEFAULT_RT_PERIOD);
    match machine.number::<i64>("/proc/sys/kernel/sched_rt_runtime_us") {
        None => share("share for real-time threads", None, "no limit in this kernel".to_owned(), ""),
        Some(runtime) => {
            let percent = percent_of(runtime, period);
            let found = percent.map_or_else(|| "unlimited".to_owned(), |percent| format!("{percent} %"));
            share("share for real-time threads", percent, found, "`sysctl -w kernel.sched_rt_runtime_us=950000`")
        }
    }
}

/// The kernel's default period of the share of real-time threads, us.
pub(super) const DEFAULT_RT_PERIOD: i64 = 1_000_000;

/// What `runtime` is of `period`, per cent; nothing if it is unlimited.
pub(super) fn percent_of(runtime: i64, period: i64) -> Option<i64> {
    (runtime >= 0).then(|| runtime.saturating_mul(100).checked_div(period).unwrap_or(0))
}

/// Judges a share of real-time threads, per cent, without one if there is no limit: a thread that has used it up stands for the rest of
/// the period, a second by default, with the last torque on the motors.
pub(super) fn share(name: &str, percent: Option<i64>, found: String, advice: &str) -> Finding {
    /// The kernel's default is 95 %: the loop needs a small part of it.
    const ENOUGH_PERCENT: i64 = 90;
    let finding = Finding::good(name, found, format!("at least {ENOUGH_PERCENT} %"));
    if percent.is_none_or(|percent| percent >= ENOUGH_PERCENT) { finding } else { finding.but(Verdict::Bad, advice) }
}

/// The hardware clock behind `CLOCK_MONOTONIC`.
pub(super) fn clock_source(machine: &Machine) -> Finding {
    /// Sources that are read without a system call or a slow bus access.
    const FAST: [&str; 6] =
        ["tsc", "kvm-clock", "arch_sys_counter", "hyperv_clocksource_tsc_page", "riscv_clocksource", "timebase"];
    let source = machine.text("/sys/devices/system/clocksource/clocksource0/current_clocksource").unwrap_or_default();
    let finding = Finding::good(
        "clock source",
        if source.is_empty() { "unknown" } else { &source },
        "tsc, or another that is fast to read",
    );
    match source.as_str() {
        fast if FAST.contains(&fast) => finding,
        "jiffies" | "refined-jiffies" => {
            finding.but(Verdict::Bad, "the clock ticks in milliseconds: enable the TSC or HPET in firmware and kernel")
        }
        _ => finding.but(
            Verdict::Warning,
            "each reading of the clock is a slow system call. `dmesg | grep -i tsc` says why the TSC was refused; \
             `tsc=reliable` on the kernel's command line overrides, if the firmware keeps the TSCs together",
        ),
    }
}

/// Resolution of timers, and how far the kernel may postpone an ordinary thread's.
pub(super) fn timers(machine: &Machine) -> Option<Finding> {
    // The resolution is the running kernel's answer to a system call.
    if !machine.is_running() {
        return None;
    }
    let resolution = rustix::time::clock_getres(rustix::time::ClockId::Monotonic);
    let slack =
        rustix::thread::current_timer_slack().map_or_else(|_| "unknown".to_owned(), |slack| format!("{slack} ns"));
    let found = format!("{} ns (slack of an ordinary thread {slack}; none under SCHED_FIFO)", resolution.tv_nsec);
    let finding = Finding::good("timer resolution", found, "1 ns (high-resolution timers)");
    Some(if resolution.tv_sec == 0 && resolution.tv_nsec == 1 {
        finding
    } else {
        finding.but(Verdict::Bad, "boot without `highres=off`, with a kernel built with CONFIG_HIGH_RES_TIMERS=y")
    })
}
