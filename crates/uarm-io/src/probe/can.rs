//! CAN: in the kernel, and each interface.

use super::machine::Machine;
use crate::finding::{Finding, Verdict};
use crate::socketcan_link::{InterfaceName, raw_can_sockets};
use socketcan::nl::{CanInterface, CanState};
use std::io;

/// The hardware type of CAN interfaces (`ARPHRD_CAN`).
const CAN_HARDWARE: u32 = 280;
/// Bit of an interface's flags that says it is up (`IFF_UP`).
const UP: u32 = 1;
/// Room for a cycle's frames and a few more. Far longer, and torques of long ago are still sent after the bus comes back.
const QUEUE_LENGTHS: core::ops::RangeInclusive<u32> = 8..=64;

/// What the caller wants of the bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CanWish {
    /// The interface that will be used; with `None` all are looked at, and a machine without any is no fault.
    pub interface: Option<InterfaceName>,
    /// The bus's bit rate, bit/s. With `None` no advice names one: an interface at another rate than the bus's disturbs it.
    pub bit_rate: Option<u32>,
}

impl CanWish {
    /// The bit rate as a command line of `ip` has it.
    fn bit_rate_in_advice(&self) -> String {
        self.bit_rate.map_or_else(|| "RATE".to_owned(), |rate| rate.to_string())
    }

    /// What stands behind a command with [`bit_rate_in_advice`](Self::bit_rate_in_advice).
    const fn rate_explained(&self) -> &'static str {
        match self.bit_rate {
            Some(_) => "",
            None => ", RATE that of the drives",
        }
    }
}

/// An interface as found.
#[derive(Clone, Debug)]
struct Interface {
    name: String,
    kind: Kind,
    is_up: bool,
    queue_length: Option<u32>,
}

/// What stands behind an interface.
#[derive(Clone, Debug)]
enum Kind {
    /// vcan: frames stay in this machine.
    Virtual,
    /// A controller, and what its driver tells.
    Hardware(Controller),
}

#[derive(Clone, Copy, Debug, Default)]
struct Controller {
    state: Option<CanState>,
    bit_rate: Option<u32>,
    restart_ms: Option<u32>,
}

pub(super) fn findings(machine: &Machine, wish: &CanWish) -> Vec<Finding> {
    let mut findings = Vec::new();
    let demanded = if wish.interface.is_some() { Verdict::Bad } else { Verdict::Warning };
    if machine.is_running() {
        findings.push(sockets(raw_can_sockets(), demanded));
    }
    findings.push(virtual_bus(machine));
    let interfaces = interfaces(machine);
    match wish.interface {
        None if interfaces.is_empty() => findings.push(no_interface()),
        None => findings.extend(interfaces.iter().flat_map(|interface| judge(interface, wish)).map(unneeded)),
        Some(name) => match interfaces.iter().find(|interface| interface.name == name.as_str()) {
            Some(interface) => findings.extend(judge(interface, wish)),
            None => findings.push(absent(machine, name)),
        },
    }
    findings
}

/// What is bad about an interface that nobody asked for is no more than a warning.
fn unneeded(finding: Finding) -> Finding {
    Finding { verdict: finding.verdict.min(Verdict::Warning), ..finding }
}

fn sockets(answer: io::Result<()>, demanded: Verdict) -> Finding {
    let finding = |found: String| Finding::good("raw CAN sockets", found, "AF_CAN in the kernel");
    match answer {
        Ok(()) => finding("there".to_owned()),
        Err(error) => finding(format!("none: {error}")).but(
            demanded,
            "`modprobe can-raw`, or a kernel with CONFIG_CAN_RAW; `tools/can-guest` runs commands where they are",
        ),
    }
}

/// Whether a virtual bus can be made.
fn virtual_bus(machine: &Machine) -> Finding {
    let release = machine.text("/proc/sys/kernel/osrelease").unwrap_or_default();
    let lists = |file: &str| {
        machine.text(&format!("/lib/modules/{release}/{file}")).is_some_and(|text| text.contains("/vcan.ko"))
    };
    let finding = |found: &str| Finding::good("virtual CAN (vcan)", found, "loaded or loadable");
    if machine.exists("/sys/module/vcan") {
        finding("loaded")
    } else if lists("modules.builtin") {
        finding("built in")
    } else if lists("modules.dep") {
        finding("loadable")
    } else {
        finding("not in this kernel").but(Verdict::Warning, "only for trials without drives: a stock Debian kernel has it (cloud kernels do not); `tools/can-guest` boots one")
    }
}

fn no_interface() -> Finding {
    let advice = "plug in an adapter, or `ip link add vcan0 type vcan && ip link set vcan0 up`; a simulated robot in the same process needs none";
    Finding::good("CAN interfaces", "none", "one, for drives").but(Verdict::Warning, advice)
}

fn absent(machine: &Machine, name: InterfaceName) -> Finding {
    let finding = |found: &str| Finding::good(format!("{name}"), found, "a CAN interface");
    if machine.exists(&format!("/sys/class/net/{name}")) {
        finding("an interface, but not CAN")
            .but(Verdict::Bad, "`ip link show type can` and `ip link show type vcan` list those that are")
    } else {
        finding("absent").but(Verdict::Bad, format!("plug in the adapter and see `dmesg`; a virtual one: `ip link add {name} type vcan && ip link set {name} up`"))
    }
}

fn interfaces(machine: &Machine) -> Vec<Interface> {
    let folder = |name: &str, file: &str| format!("/sys/class/net/{name}/{file}");
    let is_can = |name: &String| machine.number(&folder(name, "type")) == Some(CAN_HARDWARE);
    let describe = |name: String| Interface {
        kind: if machine.exists(&folder(&name, "device")) {
            Kind::Hardware(controller(machine, &name))
        } else {
            Kind::Virtual
        },
        is_up: machine.text(&folder(&name, "flags")).is_some_and(|flags| is_up(&flags)),
        queue_length: machine.number(&folder(&name, "tx_queue_len")),
        name,
    };
    machine.names("/sys/class/net").into_iter().filter(is_can).map(describe).collect()
}

fn is_up(flags: &str) -> bool {
    flags
        .strip_prefix("0x")
        .and_then(|digits| u32::from_str_radix(digits, 16).ok())
        .is_some_and(|flags| flags & UP != 0)
}

/// What only netlink tells, of the running machine.
fn controller(machine: &Machine, name: &str) -> Controller {
    let ask = || CanInterface::open(name).and_then(|interface| interface.can_params()).ok();
    let Some(parameters) = machine.is_running().then(ask).flatten() else { return Controller::default() };
    Controller {
        state: parameters.state,
        bit_rate: parameters.bit_timing.map(|timing| timing.bitrate),
        restart_ms: parameters.restart_ms,
    }
}

fn judge(interface: &Interface, wish: &CanWish) -> Vec<Finding> {
    let mut findings = vec![state(interface, wish)];
    if let Kind::Hardware(controller) = &interface.kind {
        findings.push(bit_rate(&interface.name, controller, wish));
        findings.push(restart(&interface.name, controller));
        findings.push(queue(interface));
    }
    findings
}

fn state(interface: &Interface, wish: &CanWish) -> Finding {
    let name = &interface.name;
    let (kind, state) = match &interface.kind {
        Kind::Virtual => ("virtual", None),
        Kind::Hardware(controller) => ("hardware", controller.state),
    };
    let finding = |found: &str| Finding::good(format!("{name} state"), format!("{found} ({kind})"), "up, error-active");
    let up = match interface.kind {
        Kind::Virtual => format!("`ip link set {name} up`"),
        Kind::Hardware(_) => format!(
            "`ip link set {name} up type can bitrate {} restart-ms 100`{}",
            wish.bit_rate_in_advice(),
            wish.rate_explained()
        ),
    };
    if !interface.is_up {
        return finding("down").but(Verdict::Bad, up);
    }
    match state {
        None => finding("up"),
        Some(CanState::ErrorActive) => finding("up, error-active"),
        Some(CanState::ErrorWarning) => finding("up, error-warning").but(Verdict::Warning, "the bus is disturbed: check cable, termination (two of 120 Ω) and bit rate"),
        Some(CanState::ErrorPassive) => finding("up, error-passive").but(Verdict::Bad, "nobody acknowledges or the bus is badly disturbed: are the drives on? check cable, termination and bit rate"),
        Some(CanState::BusOff) => finding("bus-off").but(Verdict::Bad, format!("check cable, termination and bit rate, then `ip link set {name} type can restart`")),
        Some(CanState::Stopped | CanState::Sleeping) => finding("stopped").but(Verdict::Bad, up),
    }
}

fn bit_rate(name: &str, controller: &Controller, wish: &CanWish) -> Finding {
    let found = controller.bit_rate.filter(|&rate| rate > 0);
    let text = found.map_or_else(|| "not set".to_owned(), |rate| format!("{rate} bit/s"));
    let wanted = wish.bit_rate.map_or_else(|| "that of the drives".to_owned(), |rate| format!("{rate} bit/s"));
    let finding = Finding::good(format!("{name} bit rate"), text, wanted);
    let as_wanted = found.is_some() && wish.bit_rate.is_none_or(|wanted| found == Some(wanted));
    if as_wanted {
        finding
    } else {
        finding.but(
            Verdict::Bad,
            format!(
                "`ip link set {name} down && ip link set {name} up type can bitrate {}`, the same as the drives'",
                wish.bit_rate_in_advice()
            ),
        )
    }
}

/// What is wrong with the bit rate of the interface of `wish`; `None` if it is as wished, or not known.
pub(super) fn wrong_bit_rate(machine: &Machine, wish: &CanWish) -> Option<Finding> {
    let name = wish.interface?;
    conflict(&interfaces(machine).into_iter().find(|found| found.name == name.as_str())?, wish)
}

fn conflict(interface: &Interface, wish: &CanWish) -> Option<Finding> {
    let Kind::Hardware(controller) = &interface.kind else { return None };
    controller.bit_rate.filter(|&rate| rate > 0)?;
    Some(bit_rate(&interface.name, controller, wish)).filter(|finding| finding.verdict == Verdict::Bad)
}

fn restart(name: &str, controller: &Controller) -> Finding {
    let finding = |found: String| Finding::good(format!("{name} restart-ms"), found, "some 100 ms");
    match controller.restart_ms {
        Some(milliseconds) if milliseconds > 0 => finding(format!("{milliseconds} ms")),
        _ => finding("off".to_owned()).but(
            Verdict::Warning,
            format!("after a bus-off the interface stays silent until restarted by hand: `ip link set {name} type can restart-ms 100` (with the interface down)"),
        ),
    }
}

fn queue(interface: &Interface) -> Finding {
    let name = &interface.name;
    let wanted = format!("{} to {} frames", QUEUE_LENGTHS.start(), QUEUE_LENGTHS.end());
    let found = interface.queue_length.map_or_else(|| "unknown".to_owned(), |length| format!("{length} frames"));
    let finding = Finding::good(format!("{name} transmit queue"), found, wanted);
    if interface.queue_length.is_some_and(|length| QUEUE_LENGTHS.contains(&length)) {
        finding
    } else {
        finding.but(
            Verdict::Warning,
            format!("`ip link set {name} txqueuelen 16`: a cycle's frames must fit, and no old torques may pile up"),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hardware(controller: Controller, queue_length: u32) -> Interface {
        Interface {
            name: "can0".to_owned(),
            kind: Kind::Hardware(controller),
            is_up: true,
            queue_length: Some(queue_length),
        }
    }

    fn verdicts(interface: &Interface) -> Vec<Verdict> {
        let wish = CanWish { interface: None, bit_rate: Some(1_000_000) };
        judge(interface, &wish).into_iter().map(|finding| finding.verdict).collect()
    }

    const SOUND: Controller =
        Controller { state: Some(CanState::ErrorActive), bit_rate: Some(1_000_000), restart_ms: Some(100) };

    #[test]
    fn a_well_set_up_controller_is_good_throughout() {
        assert_eq!(verdicts(&hardware(SOUND, 16)), [Verdict::Good; 4]);
    }

    #[test]
    fn each_fault_of_a_controller_is_seen() {
        use Verdict::{Bad, Good, Warning};
        let with_state = |state| Controller { state: Some(state), ..SOUND };
        assert_eq!(verdicts(&hardware(with_state(CanState::ErrorWarning), 16))[0], Warning);
        assert_eq!(verdicts(&hardware(with_state(CanState::ErrorPassive), 16))[0], Bad);
        assert_eq!(verdicts(&hardware(with_state(CanState::BusOff), 16))[0], Bad);
        assert_eq!(verdicts(&hardware(Controller { bit_rate: Some(500_000), ..SOUND }, 16)), [Good, Bad, Good, Good]);
        assert_eq!(verdicts(&hardware(Controller { bit_rate: None, ..SOUND }, 16)), [Good, Bad, Good, Good]);
        assert_eq!(verdicts(&hardware(Controller { restart_ms: Some(0), ..SOUND }, 16)), [Good, Good, Warning, Good]);
        assert_eq!(verdicts(&hardware(SOUND, 1_000)), [Good, Good, Good, Warning]);
    }

    /// A rate that is not known, as of an interface that is no hardware, is no reason to stay away.
    #[test]
    fn a_wrong_bit_rate_is_told_where_it_is_known() {
        let wish = CanWish { interface: None, bit_rate: Some(1_000_000) };
        let wrong = |interface: &Interface| conflict(interface, &wish).map(|finding| finding.to_string());
        let told = wrong(&hardware(Controller { bit_rate: Some(500_000), ..SOUND }, 16)).unwrap();
        assert!(told.contains("500000 bit/s") && told.contains("1000000 bit/s"), "{told}");
        assert_eq!(wrong(&hardware(SOUND, 16)), None);
        for unknown in [None, Some(0)] {
            assert_eq!(wrong(&hardware(Controller { bit_rate: unknown, ..SOUND }, 16)), None);
        }
        let virtual_bus = Interface { kind: Kind::Virtual, ..hardware(SOUND, 16) };
        assert_eq!(wrong(&virtual_bus), None);
    }

    /// A node at a wrong bit rate destroys the frames of the others: who does not know the rate is told none.
    #[test]
    fn advice_names_the_bit_rate_that_was_asked_for_and_no_other() {
        let slow = Controller { bit_rate: Some(250_000), ..SOUND };
        let down = Interface { is_up: false, ..hardware(slow, 16) };
        let advice = |bit_rate| {
            let findings = judge(&down, &CanWish { interface: None, bit_rate });
            findings.into_iter().map(|finding| finding.how_to_get_it).collect::<Vec<_>>().join("\n")
        };
        assert!(advice(Some(500_000)).contains("up type can bitrate 500000 "), "{}", advice(Some(500_000)));
        assert!(!advice(Some(500_000)).contains("1000000"));
        assert!(advice(None).contains("bitrate RATE restart-ms 100`, RATE that of the drives"), "{}", advice(None));
        // Whatever rate is set is right where none is known.
        let up = judge(&hardware(slow, 16), &CanWish::default());
        assert!(up.iter().all(|finding| finding.verdict == Verdict::Good), "{up:?}");
    }

    #[test]
    fn missing_sockets_matter_as_much_as_they_are_needed() {
        let refused = || Err(io::Error::from_raw_os_error(libc::EAFNOSUPPORT));
        assert_eq!(sockets(refused(), Verdict::Bad).verdict, Verdict::Bad);
        assert_eq!(sockets(refused(), Verdict::Warning).verdict, Verdict::Warning);
        assert_eq!(sockets(Ok(()), Verdict::Bad).verdict, Verdict::Good);
    }
}
