//! What is heard on a CANopen bus by somebody who sends nothing.
//!
//! Frames are told by their identifiers as the predefined connection set of CiA 301 gives them. A network whose PDOs have
//! other identifiers shows them under other names, or among [`BusObservation::others`].

use std::collections::BTreeMap;

use serde::{Serialize, Serializer};
use uarm_io::drive::network::Emergency;
use uarm_io::drive::wire::{self, EmergencyMessage, MASTER_NODE};
use uarm_io::drive::{NmtCommand, NmtState};
use uarm_io::link::Received;
use uarm_io::time::{Duration, Instant};

/// PDOs of the predefined connection set that a node has each way.
pub const PDOS: usize = 4;

/// Frames of one kind: how many, and how often.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Periodic {
    /// How many came.
    pub count: u32,
    first: Instant,
    last: Instant,
}

impl Periodic {
    fn note(&mut self, at: Instant) {
        if self.count == 0 {
            self.first = at;
        }
        self.last = at;
        self.count += 1;
    }

    /// The mean time between two of them; `None` before the second.
    pub fn period(&self) -> Option<Duration> {
        let gaps = self.count.checked_sub(1).filter(|gaps| *gaps > 0)?;
        Some(self.last.since(self.first) / gaps)
    }
}

impl Serialize for Periodic {
    /// As `{ count, period_ms }`, the period null before the second frame.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Shown {
            count: u32,
            period_ms: Option<f64>,
        }
        let period_ms = self.period().map(|period| period.as_secs_f64() * 1e3);
        Shown { count: self.count, period_ms }.serialize(serializer)
    }
}

/// What was heard of one node.
#[derive(Clone, Debug, Default, Serialize)]
pub struct NodeTraffic {
    /// What its last heartbeat or boot-up said, in the standard's words.
    #[serde(serialize_with = "state_in_words")]
    pub nmt_state: Option<NmtState>,
    /// Its heartbeats.
    pub heartbeat: Periodic,
    /// Boot-up messages: how often it started anew while somebody listened.
    pub boot_ups: u32,
    /// TPDO1 to TPDO4.
    pub tpdos: [Periodic; PDOS],
    /// RPDO1 to RPDO4: somebody commands it.
    pub rpdos: [Periodic; PDOS],
    /// Its emergency messages.
    pub emergencies: u32,
    /// The last of them, in words.
    #[serde(serialize_with = "emergency_in_words")]
    pub last_emergency: Option<EmergencyMessage>,
    /// SDO requests to it: somebody reads or configures it.
    pub sdo_requests: u32,
    /// Its SDO answers.
    pub sdo_answers: u32,
}

impl NodeTraffic {
    /// True if the node itself sent something.
    pub fn is_present(&self) -> bool {
        self.heartbeat.count + self.boot_ups + self.emergencies + self.sdo_answers > 0
            || self.tpdos.iter().any(|tpdo| tpdo.count > 0)
    }
}

/// What was heard on a bus.
#[derive(Clone, Debug, Default, Serialize)]
pub struct BusObservation {
    /// All data frames.
    pub frames: u32,
    /// SYNC messages.
    pub sync: Periodic,
    /// Data bytes of the last SYNC: 1 with a counter, 0 without.
    pub sync_length: Option<usize>,
    /// NMT commands, each with the node it was for (0: all), in the order in which they were first heard.
    #[serde(serialize_with = "commands_in_words")]
    pub nmt_commands: Vec<(NmtCommand, u8)>,
    /// TIME messages.
    pub time: Periodic,
    /// LSS messages: somebody assigns node ids.
    pub lss: u32,
    /// The nodes, by node id; also such that only were spoken to.
    pub nodes: BTreeMap<u8, NodeTraffic>,
    /// Identifiers outside the predefined connection set.
    pub others: BTreeMap<u16, Periodic>,
}

impl BusObservation {
    /// Takes a frame in.
    pub fn note(&mut self, received: &Received) {
        let (frame, at) = (&received.frame, received.at);
        self.frames += 1;
        let identifier = frame.id().as_raw();
        let node = (identifier & 0x7F) as u8;
        match (identifier & 0x780, node) {
            (0x000, 0) => self.note_command(frame.data()),
            (0x080, 0) => {
                self.sync.note(at);
                self.sync_length = Some(frame.data().len());
            }
            (0x100, 0) => self.time.note(at),
            (0x780, 0x64 | 0x65) => self.lss += 1,
            (0x080 | 0x180..=0x600 | 0x700, 1..) => self.note_node(identifier & 0x780, node, received),
            _ => self.others.entry(identifier).or_default().note(at),
        }
    }

    fn note_command(&mut self, data: &[u8]) {
        if let (Ok((command, _)), [_, node]) = (wire::decode_nmt(data), data)
            && !self.nmt_commands.contains(&(command, *node))
        {
            self.nmt_commands.push((command, *node));
        }
    }

    fn note_node(&mut self, function: u16, node: u8, received: &Received) {
        let (data, at) = (received.frame.data(), received.at);
        let traffic = self.nodes.entry(node).or_default();
        match function {
            0x080 => {
                traffic.emergencies += 1;
                traffic.last_emergency = Some(wire::decode_emergency(data));
            }
            0x580 => traffic.sdo_answers += 1,
            0x600 => traffic.sdo_requests += 1,
            0x700 => {
                let state = wire::decode_heartbeat(data).ok();
                traffic.nmt_state = state.or(traffic.nmt_state);
                if state == Some(NmtState::Initialising) { traffic.boot_ups += 1 } else { traffic.heartbeat.note(at) }
            }
            // 180h, 280h, 380h, 480h are TPDOs 1 to 4; 200h, 300h, 400h, 500h the RPDOs.
            _ => {
                let number = usize::from((function - 0x180) / 0x100);
                let pdos = if function & 0x80 != 0 { &mut traffic.tpdos } else { &mut traffic.rpdos };
                if let Some(pdo) = pdos.get_mut(number) {
                    pdo.note(at);
                }
            }
        }
    }

    /// The nodes that were heard themselves, by node id; the heartbeat of a master is not one.
    pub fn present(&self) -> impl Iterator<Item = (u8, &NodeTraffic)> {
        let is_drive = |node: u8| node != MASTER_NODE;
        self.nodes
            .iter()
            .filter(move |(node, heard)| is_drive(**node) && heard.is_present())
            .map(|(n, heard)| (*n, heard))
    }

    /// Signs of a master at work, in words, worst first; empty if there is none.
    pub fn master_at_work(&self) -> Vec<String> {
        let mut signs = Vec::new();
        let nodes = |heard: &dyn Fn(&NodeTraffic) -> bool| -> Vec<String> {
            self.nodes.iter().filter(|(_, traffic)| heard(traffic)).map(|(node, _)| node.to_string()).collect()
        };
        let commanded = nodes(&|traffic| traffic.rpdos.iter().any(|rpdo| rpdo.count > 0));
        if !commanded.is_empty() {
            signs.push(format!("RPDOs to node {}", commanded.join(", ")));
        }
        if self.sync.count > 0 {
            signs.push("SYNC".to_owned());
        }
        for (command, node) in &self.nmt_commands {
            signs.push(format!("NMT {} to {}", command_name(*command), addressee(*node)));
        }
        if self.nodes.get(&MASTER_NODE).is_some_and(|traffic| traffic.heartbeat.count > 0) {
            signs.push(format!("heartbeat of node {MASTER_NODE}, as masters have it"));
        }
        let configured = nodes(&|traffic| traffic.sdo_requests > 0);
        if !configured.is_empty() {
            signs.push(format!("SDO requests to node {}", configured.join(", ")));
        }
        signs
    }
}

/// The standard's name of an NMT command.
pub const fn command_name(command: NmtCommand) -> &'static str {
    match command {
        NmtCommand::StartRemoteNode => "start remote node",
        NmtCommand::StopRemoteNode => "stop remote node",
        NmtCommand::EnterPreOperational => "enter pre-operational",
        NmtCommand::ResetNode => "reset node",
        NmtCommand::ResetCommunication => "reset communication",
    }
}

fn addressee(node: u8) -> String {
    if node == 0 { "all nodes".to_owned() } else { format!("node {node}") }
}

/// The standard's name of an NMT state.
pub const fn state_name(state: NmtState) -> &'static str {
    match state {
        NmtState::Initialising => "booted",
        NmtState::Stopped => "Stopped",
        NmtState::Operational => "Operational",
        NmtState::PreOperational => "Pre-operational",
    }
}

fn state_in_words<S: Serializer>(state: &Option<NmtState>, serializer: S) -> Result<S::Ok, S::Error> {
    state.map(state_name).serialize(serializer)
}

fn emergency_in_words<S: Serializer>(message: &Option<EmergencyMessage>, serializer: S) -> Result<S::Ok, S::Error> {
    message.map(|message| Emergency(message).to_string()).serialize(serializer)
}

fn commands_in_words<S: Serializer>(commands: &[(NmtCommand, u8)], serializer: S) -> Result<S::Ok, S::Error> {
    let words = commands.iter().map(|(command, node)| format!("{} to {}", command_name(*command), addressee(*node)));
    serializer.collect_seq(words)
}

#[cfg(test)]
mod tests {
    use super::*;
    use uarm_io::embedded_can::StandardId;
    use uarm_io::frame::Frame;

    /// A frame's identifier and data.
    type Dumped<'a> = (u16, &'a [u8]);

    /// Frames as candump shows them, a millisecond apart.
    fn observed(frames: &[Dumped<'_>]) -> BusObservation {
        let mut observation = BusObservation::default();
        for (number, (identifier, data)) in frames.iter().enumerate() {
            let frame = Frame::new(StandardId::new(*identifier).unwrap(), data).unwrap();
            let at = Instant::from_nanoseconds(number as u64 * 1_000_000);
            observation.note(&Received { frame, at });
        }
        observation
    }

    /// Identifiers of CiA 301, 7.3.5: each function at its place, node 5.
    #[test]
    fn frames_are_told_by_the_predefined_connection_set() {
        let heard = observed(&[
            (0x185, &[0; 6]),
            (0x285, &[0]),
            (0x385, &[0]),
            (0x485, &[0; 8]),
            (0x205, &[0; 4]),
            (0x305, &[0]),
            (0x405, &[0]),
            (0x505, &[0]),
            (0x085, &[0x30, 0x81, 0x11, 0, 0, 0, 0, 0]),
            (0x585, &[0; 8]),
            (0x605, &[0; 8]),
            (0x705, &[0]),
            (0x705, &[0x7F]),
            (0x100, &[0; 6]),
            (0x7E5, &[0; 8]),
            (0x6E0, &[]),
            (0x101, &[]),
        ]);
        let node = &heard.nodes[&5];
        assert!(node.tpdos.iter().chain(&node.rpdos).all(|pdo| pdo.count == 1), "{node:?}");
        assert_eq!((node.emergencies, node.sdo_answers, node.sdo_requests, node.boot_ups), (1, 1, 1, 1));
        assert_eq!(node.nmt_state, Some(NmtState::PreOperational));
        assert_eq!(node.heartbeat.count, 1, "a boot-up is no heartbeat");
        assert_eq!((heard.time.count, heard.lss), (1, 1));
        // Functions 100h and 680h belong to no node.
        assert_eq!(heard.others.keys().copied().collect::<Vec<_>>(), [0x101, 0x6E0]);
        assert_eq!(heard.present().map(|(node, _)| node).collect::<Vec<_>>(), [5]);
    }

    #[test]
    fn a_period_is_the_mean_of_what_was_heard() {
        let heard = observed(&[(0x080, &[1]), (0x181, &[0; 6]), (0x080, &[2]), (0x181, &[0; 6]), (0x080, &[3])]);
        assert_eq!(heard.sync.period(), Some(Duration::from_millis(2)));
        assert_eq!(heard.sync_length, Some(1));
        assert_eq!(observed(&[(0x080, &[])]).sync.period(), None);
    }

    #[test]
    fn drives_alone_are_no_master() {
        let drives: [Dumped<'_>; 4] = [(0x701, &[0]), (0x702, &[5]), (0x182, &[0; 6]), (0x081, &[0; 8])];
        assert_eq!(observed(&drives).master_at_work(), Vec::<String>::new());
    }

    #[test]
    fn every_sign_of_a_master_is_told() {
        let signs: [(&[Dumped<'_>], &str); 5] = [
            (&[(0x203, &[0; 4])], "RPDOs to node 3"),
            (&[(0x080, &[])], "SYNC"),
            (&[(0x000, &[0x81, 0])], "NMT reset node to all nodes"),
            (&[(0x77F, &[5])], "heartbeat of node 127, as masters have it"),
            (&[(0x602, &[0; 8])], "SDO requests to node 2"),
        ];
        for (frames, sign) in signs {
            assert_eq!(observed(frames).master_at_work(), [sign]);
        }
    }

    #[test]
    fn json_has_words_and_periods() {
        let heard = observed(&[(0x701, &[0x7F]), (0x000, &[1, 2]), (0x701, &[0x7F])]);
        let json = serde_json::to_value(&heard).unwrap();
        assert_eq!(json["nodes"]["1"]["nmt_state"], "Pre-operational");
        assert_eq!(json["nodes"]["1"]["heartbeat"], serde_json::json!({ "count": 2, "period_ms": 2.0 }));
        assert_eq!(json["nmt_commands"][0], "start remote node to node 2");
    }
}
