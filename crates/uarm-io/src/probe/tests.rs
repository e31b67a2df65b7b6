//! Machines described as folders.

use super::*;
use crate::finding::Verdict;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

/// A folder laid out like a machine; removed at the end.
struct Described(PathBuf);

impl Described {
    fn new(files: &[(&str, &str)]) -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let described = Self(std::env::temp_dir().join(format!("uarm-probe-{}-{number}", std::process::id())));
        std::fs::create_dir_all(&described.0).unwrap();
        for (path, text) in files {
            let path = described.0.join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        described
    }

    fn machine(&self) -> Machine {
        Machine::in_folder(&self.0)
    }

    fn verdict(&self, name: &str) -> Option<Verdict> {
        self.machine()
            .realtime_findings()
            .into_iter()
            .find(|finding| finding.name == name)
            .map(|finding| finding.verdict)
    }

    fn can(&self, interface: Option<&str>) -> Vec<Finding> {
        let interface = interface.map(|name| name.parse().unwrap());
        self.machine().can_findings(&CanWish { interface, ..CanWish::default() })
    }
}

impl Drop for Described {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

const CLOCK: &str = "sys/devices/system/clocksource/clocksource0/current_clocksource";

#[test]
fn a_robot_pc_is_good_throughout() {
    let described = Described::new(&[
        ("proc/sys/kernel/version", "#1 SMP PREEMPT_RT Debian 6.1.94-1 (2024-06-21)\n"),
        ("proc/sys/kernel/osrelease", "6.1.0-22-rt-amd64\n"),
        ("boot/config-6.1.0-22-rt-amd64", "CONFIG_SMP=y\nCONFIG_PREEMPT_RT=y\n"),
        ("sys/kernel/realtime", "1\n"),
        ("proc/sys/kernel/sched_rt_period_us", "1000000\n"),
        ("proc/sys/kernel/sched_rt_runtime_us", "950000\n"),
        ("proc/self/status", "Name:\tuarm\nCapEff:\t0000000000000000\n"),
        (
            "proc/self/limits",
            "Limit                     Soft Limit           Hard Limit           Units     \n\
             Max locked memory         unlimited            unlimited            bytes     \n\
             Max realtime priority     98                   98                   \n",
        ),
        ("dev/cpu_dma_latency", ""),
        ("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "performance\n"),
        ("sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "performance\n"),
        ("sys/devices/system/cpu/cpufreq/policy0/x", ""),
        ("sys/devices/system/cpu/isolated", "1\n"),
        (CLOCK, "tsc\n"),
    ]);
    let findings = described.machine().realtime_findings();
    assert_eq!(findings.len(), 8);
    for finding in findings {
        assert_eq!((finding.verdict, finding.how_to_get_it.as_str()), (Verdict::Good, ""), "{finding}");
    }
}

#[test]
fn an_untouched_pc_gets_advice_on_each_point() {
    let described = Described::new(&[
        ("proc/sys/kernel/version", "#1 SMP PREEMPT_DYNAMIC Debian 6.1.94-1 (2024-06-21)\n"),
        ("proc/sys/kernel/osrelease", "6.1.0-22-amd64\n"),
        ("proc/sys/kernel/sched_rt_period_us", "1000000\n"),
        ("proc/sys/kernel/sched_rt_runtime_us", "0\n"),
        ("proc/self/status", "CapEff:\t0000000000000000\n"),
        ("proc/self/limits", "Max locked memory         8388608  8388608  bytes\nMax realtime priority     0  0\n"),
        ("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "performance\n"),
        ("sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "powersave\n"),
        ("sys/devices/system/cpu/isolated", "\n"),
        (CLOCK, "hpet\n"),
    ]);
    use Verdict::{Bad, Warning};
    let findings = described.machine().realtime_findings();
    let verdicts: Vec<_> = findings.iter().map(|finding| finding.verdict).collect();
    assert_eq!(verdicts, [Warning, Bad, Bad, Bad, Bad, Warning, Warning, Warning], "{findings:#?}");
    assert!(findings.iter().all(|finding| !finding.how_to_get_it.is_empty()));
}

/// What is bad keeps a loop from beginning, and nothing else does.
#[test]
fn obstacles_are_what_is_bad() {
    let described = Described::new(&[
        ("proc/sys/kernel/sched_rt_period_us", "1000000\n"),
        ("proc/sys/kernel/sched_rt_runtime_us", "700000\n"),
        ("proc/self/status", "CapEff:\t0000000000804000\n"),
        ("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "schedutil\n"),
        ("sys/class/net/can0/type", "280\n"),
        ("sys/class/net/can0/flags", "0x40080\n"),
        (CLOCK, "tsc\n"),
    ]);
    let names = |wish: Option<&CanWish>| {
        described.machine().obstacles(wish).into_iter().map(|finding| finding.name).collect::<Vec<_>>()
    };
    let of_machine = ["share for real-time threads", "frequency governor"];
    assert_eq!(names(None), of_machine);
    let wish = CanWish { interface: Some("can0".parse().unwrap()), ..CanWish::default() };
    assert_eq!(names(Some(&wish)), [of_machine.as_slice(), &["can0 state"]].concat());
}

#[test]
fn the_smallest_share_of_a_group_and_those_above_it_counts() {
    const NAME: &str = "real-time share of the group";
    let group = |files: &[(&str, &str)]| {
        let all = [&[("proc/self/cgroup", "5:cpu,cpuacct:/robot/loop\n0::/\n")], files].concat();
        Described::new(&all)
    };
    let runtime = |folder: &str| format!("sys/fs/cgroup/cpu,cpuacct{folder}/cpu.rt_runtime_us");
    let (inner, middle, root) = (runtime("/robot/loop"), runtime("/robot"), runtime(""));
    let good = group(&[(&inner, "950000"), (&middle, "950000"), (&root, "-1")]);
    assert_eq!(good.verdict(NAME), Some(Verdict::Good));
    let narrow = group(&[(&inner, "950000"), (&middle, "0"), (&root, "950000")]);
    assert_eq!(narrow.verdict(NAME), Some(Verdict::Bad));
    let finding = narrow.machine().obstacles(None).into_iter().find(|finding| finding.name == NAME).unwrap();
    assert_eq!(finding.found, "0 % in /sys/fs/cgroup/cpu,cpuacct/robot");
    assert_eq!(group(&[]).verdict(NAME), None, "no such limit in this kernel");
}

#[test]
fn a_quota_of_version_2_is_told_and_keeps_no_loop_from_beginning() {
    let quota = |limit: &str| {
        let files = [("proc/self/cgroup", "0::/robot\n"), ("sys/fs/cgroup/robot/cpu.max", limit)];
        Described::new(&files).verdict("quota of the group")
    };
    assert_eq!(quota("50000 100000"), Some(Verdict::Warning));
    assert_eq!(quota("max 100000"), None);
}

#[test]
fn a_single_sign_of_a_realtime_kernel_is_enough_unless_another_denies_it() {
    let kernel = |files: &[(&str, &str)]| Described::new(files).verdict("real-time kernel");
    assert_eq!(kernel(&[("sys/kernel/realtime", "1")]), Some(Verdict::Good));
    assert_eq!(kernel(&[("proc/sys/kernel/version", "#1 SMP PREEMPT_RT x")]), Some(Verdict::Good));
    assert_eq!(
        kernel(&[("sys/kernel/realtime", "1"), ("proc/sys/kernel/version", "#1 SMP PREEMPT x")]),
        Some(Verdict::Warning)
    );
    assert_eq!(kernel(&[]), Some(Verdict::Warning));
    let described = Described::new(&[("sys/kernel/debug/sched/preempt", "none voluntary (full) lazy")]);
    assert!(described.machine().realtime_findings()[0].found.contains("`full`"));
}

#[test]
fn capabilities_stand_in_for_limits() {
    let described = Described::new(&[("proc/self/status", "CapEff:\t0000000000804000\n")]);
    assert_eq!(described.verdict("real-time priority limit"), Some(Verdict::Good));
    assert_eq!(described.verdict("locked memory limit"), Some(Verdict::Good));
    let described = Described::new(&[("proc/self/status", "CapEff:\t0000000000004000\n")]);
    assert_eq!(described.verdict("real-time priority limit"), Some(Verdict::Bad));
}

#[test]
fn what_a_machine_does_not_have_is_not_asked_for() {
    let described = Described::new(&[("sys/devices/system/cpu/cpu0/online", "1")]);
    assert_eq!(described.verdict("frequency governor"), None);
    assert_eq!(described.verdict("isolated processors"), None);
    let described = Described::new(&[(CLOCK, "jiffies")]);
    assert_eq!(described.verdict("clock source"), Some(Verdict::Bad));
}

#[test]
fn interfaces_are_told_apart() {
    let described = Described::new(&[
        ("proc/sys/kernel/osrelease", "6.1.0-22-amd64\n"),
        (
            "lib/modules/6.1.0-22-amd64/modules.dep",
            "kernel/drivers/net/can/vcan.ko: kernel/drivers/net/can/dev/can-dev.ko\n",
        ),
        ("sys/class/net/lo/type", "772\n"),
        ("sys/class/net/vcan0/type", "280\n"),
        ("sys/class/net/vcan0/flags", "0xc1\n"),
        ("sys/class/net/can0/type", "280\n"),
        ("sys/class/net/can0/flags", "0x40080\n"),
        ("sys/class/net/can0/device/vendor", "0x1a07\n"),
        ("sys/class/net/can0/tx_queue_len", "10\n"),
    ]);
    let names_and_verdicts = |findings: Vec<Finding>| {
        findings.into_iter().map(|finding| (finding.name, finding.verdict)).collect::<Vec<_>>()
    };
    let expected =
        |list: &[(&str, Verdict)]| list.iter().map(|&(name, verdict)| (name.to_owned(), verdict)).collect::<Vec<_>>();
    use Verdict::{Bad, Good, Warning};
    let vcan = ("virtual CAN (vcan)", Good);
    assert_eq!(names_and_verdicts(described.can(Some("vcan0"))), expected(&[vcan, ("vcan0 state", Good)]));
    assert_eq!(
        names_and_verdicts(described.can(Some("can0"))),
        expected(&[
            vcan,
            ("can0 state", Bad),
            ("can0 bit rate", Bad),
            ("can0 restart-ms", Warning),
            ("can0 transmit queue", Good)
        ])
    );
    assert_eq!(names_and_verdicts(described.can(Some("can1"))), expected(&[vcan, ("can1", Bad)]));
    assert!(described.can(Some("lo")).last().unwrap().found.contains("not CAN"));
    let all = described.can(None);
    assert_eq!(all.len(), 1 + 4 + 1);
    assert!(all.iter().all(|finding| finding.verdict < Bad), "nobody asked for can0: {all:#?}");
    let bare = names_and_verdicts(Described::new(&[]).can(None));
    assert_eq!(bare, expected(&[("virtual CAN (vcan)", Warning), ("CAN interfaces", Warning)]));
}

#[test]
fn the_running_machine_can_be_looked_at() {
    let machine = Machine::this();
    let findings: Vec<_> =
        machine.realtime_findings().into_iter().chain(machine.can_findings(&CanWish::default())).collect();
    for name in ["real-time kernel", "real-time priority limit", "clock source", "timer resolution", "raw CAN sockets"]
    {
        assert!(findings.iter().any(|finding| finding.name == name), "{name} missing");
    }
    assert!(findings.iter().all(|finding| (finding.verdict == Verdict::Good) == finding.how_to_get_it.is_empty()));
}
