//! A scan as a person reads it.

use std::fmt::Write;
use std::time::Duration;

use uarm_io::drive::network::Emergency;
use uarm_io::drive::objects::CYCLIC_SYNCHRONOUS_TORQUE_BIT;

use super::identity::Identity;
use super::survey::Scan;
use crate::bus_observation::{NodeTraffic, Periodic, state_name};

/// The whole report.
pub fn scan(interface: &str, scan: &Scan) -> String {
    let mut text = String::new();
    let heard = &scan.heard;
    line(&mut text, format_args!("{interface}: listened for {:.1} s, heard {} frames", scan.listened_s, heard.frames));
    if heard.sync.count > 0 {
        let counter = if heard.sync_length == Some(0) { "without counter" } else { "with counter" };
        line(&mut text, format_args!("  SYNC {}, {counter}", often(&heard.sync)));
    }
    if !scan.master.is_empty() {
        line(&mut text, format_args!("  A MASTER IS AT WORK: {}", scan.master.join("; ")));
    }
    if scan.error_frames > 0 || scan.bus_offs > 0 {
        line(&mut text, format_args!("  {} error frames, {} times bus-off", scan.error_frames, scan.bus_offs));
    }
    if let Some(problem) = &scan.problem {
        line(&mut text, format_args!("  trouble on the wire: {problem}"));
    }
    if heard.lss > 0 {
        line(&mut text, format_args!("  LSS messages: somebody assigns node ids"));
    }
    for (identifier, frames) in &heard.others {
        line(
            &mut text,
            format_args!("  {identifier:03X}h, no identifier of the predefined connection set: {}", often(frames)),
        );
    }
    let silent = NodeTraffic::default();
    for node in scan.nodes() {
        let traffic = heard.nodes.get(&node).unwrap_or(&silent);
        self::node(&mut text, node, traffic, scan.identities.get(&node), scan.not_asked.is_none());
    }
    if scan.nodes().is_empty() {
        line(
            &mut text,
            format_args!(
                "no node found: are the drives on, on this bus, with this bit rate? A drive that a master has stopped may be silent: `uarm drive check --node N` wakes it"
            ),
        );
    }
    if let Some(reason) = &scan.not_asked {
        line(&mut text, format_args!("nobody was asked for an identity: {reason}"));
    }
    text
}

/// Writing to a `String` cannot fail.
fn line(text: &mut String, arguments: std::fmt::Arguments<'_>) {
    let _ = text.write_fmt(arguments);
    text.push('\n');
}

fn node(text: &mut String, node: u8, traffic: &NodeTraffic, identity: Option<&Identity>, asked: bool) {
    let state = traffic.nmt_state.map_or("no heartbeat", state_name);
    line(text, format_args!("node {node}: {state}"));
    match identity {
        Some(identity) => self::identity(text, identity),
        None if asked => line(text, format_args!("  does not answer SDO requests (its NMT state may be Stopped)")),
        None => {}
    }
    let cyclic: Vec<_> = cyclic_traffic(traffic).collect();
    if !cyclic.is_empty() {
        line(text, format_args!("  {}", cyclic.join("; ")));
    }
    if traffic.boot_ups > 0 {
        line(text, format_args!("  booted {} times while listened to", traffic.boot_ups));
    }
    if let Some(message) = traffic.last_emergency {
        line(text, format_args!("  {} emergencies, the last: {}", traffic.emergencies, Emergency(message)));
    }
}

fn cyclic_traffic(traffic: &NodeTraffic) -> impl Iterator<Item = String> {
    let heartbeat = ("heartbeat".to_owned(), traffic.heartbeat);
    let numbered = |name: &'static str, pdos: [Periodic; 4]| {
        (1..).zip(pdos).map(move |(number, pdo): (u8, _)| (format!("{name}{number}"), pdo))
    };
    let all = [heartbeat].into_iter().chain(numbered("TPDO", traffic.tpdos)).chain(numbered("RPDO", traffic.rpdos));
    all.filter(|(_, frames)| frames.count > 0).map(|(name, frames)| format!("{name} {}", often(&frames)))
}

fn identity(text: &mut String, identity: &Identity) {
    let profile = identity.device_type.map(|device_type| device_type & 0xFFFF);
    let kind = match (profile, identity.supported_modes) {
        (Some(402), Some(modes)) if modes & CYCLIC_SYNCHRONOUS_TORQUE_BIT != 0 => {
            "drive (CiA 402) with cyclic synchronous torque".to_owned()
        }
        (Some(402), Some(_)) => "drive (CiA 402) WITHOUT cyclic synchronous torque".to_owned(),
        (Some(402), None) => "drive (CiA 402); 6502h, its modes, cannot be read".to_owned(),
        (Some(profile), _) => format!("device profile {profile}, no drive"),
        (None, _) => "1000h, its device type, cannot be read".to_owned(),
    };
    let name = identity.name.as_deref().map_or_else(String::new, |name| format!("\"{name}\", "));
    line(text, format_args!("  {name}{kind}"));
    let hexadecimal = |number: Option<u32>| number.map_or_else(|| "-".to_owned(), |number| format!("{number:08X}h"));
    let serial = identity.serial.map_or_else(|| "-".to_owned(), |serial| serial.to_string());
    line(
        text,
        format_args!(
            "  vendor {}, product {}, revision {}, serial {serial}",
            hexadecimal(identity.vendor),
            hexadecimal(identity.product),
            hexadecimal(identity.revision)
        ),
    );
    if let Some(state) = &identity.power_state {
        let errors = identity.error_register.map_or_else(String::new, |bits| format!("; error register {bits:02X}h"));
        line(text, format_args!("  power stage: {state}{errors}"));
    }
}

/// How often frames came.
fn often(frames: &Periodic) -> String {
    match frames.period() {
        Some(period) => format!("every {}", milliseconds(period)),
        None => "once".to_owned(),
    }
}

fn milliseconds(duration: Duration) -> String {
    format!("{:.2} ms", duration.as_secs_f64() * 1e3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bus_observation::BusObservation;
    use uarm_io::embedded_can::StandardId;
    use uarm_io::frame::Frame;
    use uarm_io::link::Received;
    use uarm_io::time::Instant;

    #[test]
    fn a_node_is_described_in_its_own_words() {
        let mut heard = BusObservation::default();
        for (at, identifier, data) in
            [(0, 0x705_u16, [0x7F].as_slice()), (50, 0x705, &[0x7F]), (60, 0x085, &[0x30, 0x81, 0x11, 0, 0, 0, 0, 0])]
        {
            let frame = Frame::new(StandardId::new(identifier).unwrap(), data).unwrap();
            heard.note(&Received { frame, at: Instant::from_nanoseconds(at * 1_000_000) });
        }
        let identity = Identity {
            device_type: Some(0x0002_0192),
            vendor: Some(0x9A),
            serial: Some(77),
            name: Some("Gold".to_owned()),
            supported_modes: Some(0x3ED),
            power_state: Some("Fault".to_owned()),
            error_register: Some(0x11),
            ..Identity::default()
        };
        let found = Scan { heard, identities: [(5, identity)].into(), ..Scan::default() };
        let text = scan("can0", &found);
        for part in [
            "node 5: Pre-operational",
            "\"Gold\", drive (CiA 402) with cyclic synchronous torque",
            "vendor 0000009Ah, product -, revision -, serial 77",
            "power stage: Fault; error register 11h",
            "heartbeat every 50.00 ms",
            "1 emergencies, the last: life guard or heartbeat error (8130h",
        ] {
            assert!(text.contains(part), "{part}: {text}");
        }
        assert!(!text.contains("MASTER") && !text.contains("no node found"), "{text}");
    }

    #[test]
    fn an_empty_bus_says_where_to_look() {
        let text = scan("can0", &Scan { not_asked: Some("asked to listen only".to_owned()), ..Scan::default() });
        assert!(text.contains("no node found: are the drives on"), "{text}");
        assert!(text.contains("nobody was asked for an identity: asked to listen only"), "{text}");
    }
}
