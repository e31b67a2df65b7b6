//! Health records as messages of `/can/health`.

use uarm_loop::uarm_io::drive::network::{Emergency, NetworkHealth, NodeHealth};
use uarm_loop::uarm_io::drive::words;
use uarm_loop::uarm_io::link::LinkHealth;
use uarm_loop::uarm_io::time::{Duration, Instant};

use crate::proto;
use uarm_loop::record::HealthRecord;

/// The message of a health record; `records_dropped` is the writer's own.
pub fn message<const J: usize>(health: &HealthRecord<J>, records_dropped: u64) -> proto::CanHealth {
    let NetworkHealth { nodes, frames_received, frames_sent, syncs, unexpected_frames } = &health.network;
    proto::CanHealth {
        frames_in: *frames_received,
        frames_out: *frames_sent,
        syncs: *syncs,
        unexpected_frames: *unexpected_frames,
        nodes: nodes.iter().map(|node| self::node(node, health.at)).collect(),
        interface: Some(interface(&health.link)),
        records_dropped,
    }
}

fn node(node: &NodeHealth, at: Instant) -> proto::NodeHealth {
    let [supply_voltage_v, temperature_c] = node.readings;
    let age = |last: Option<Instant>| last.map_or(0.0, |last| milliseconds(at.since(last)));
    proto::NodeHealth {
        node: node.node.into(),
        feedbacks: node.feedbacks,
        missed_feedbacks: node.missed_feedbacks,
        stale_feedbacks: node.stale_feedbacks,
        surplus_feedbacks: node.surplus_feedbacks,
        commands: node.commands,
        heartbeats: node.heartbeats,
        emergencies: node.emergencies,
        malformed: node.malformed,
        latency_us: milliseconds(node.latency) * 1e3,
        longest_latency_us: milliseconds(node.longest_latency) * 1e3,
        feedback_age_ms: age(node.last_feedback_at),
        longest_feedback_gap_ms: milliseconds(node.longest_feedback_gap),
        heartbeat_age_ms: age(node.last_heartbeat_at),
        longest_heartbeat_gap_ms: milliseconds(node.longest_heartbeat_gap),
        nmt_state: words::nmt_state(node.nmt_state).to_owned(),
        last_emergency: node.last_emergency.map(|message| Emergency(message).to_string()).unwrap_or_default(),
        supply_voltage_v,
        temperature_c,
        reading_warnings: node.reading_warnings,
    }
}

fn interface(link: &LinkHealth) -> proto::InterfaceHealth {
    proto::InterfaceHealth {
        frames_sent: link.frames_sent,
        frames_received: link.frames_received,
        refused: link.refused,
        queue_full: link.queue_full,
        error_frames: link.error_frames,
        controller_problems: link.controller_problems,
        bus_offs: link.bus_offs,
        restarts: link.restarts,
        transmit_errors: link.error_counters.map(|counters| counters.transmit.into()),
        receive_errors: link.error_counters.map(|counters| counters.receive.into()),
        dropped: link.dropped,
        last_problem: link.last_problem.map(|problem| problem.to_string()).unwrap_or_default(),
    }
}

fn milliseconds(duration: Duration) -> f64 {
    duration.as_secs_f64() * 1e3
}
