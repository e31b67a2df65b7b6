//! Bus and drives in words, line by line.

use uarm_log::proto::{CanHealth, InterfaceHealth, NodeHealth};

/// Health of bus and drives as lines of text.
pub fn lines(health: &CanHealth) -> Vec<String> {
    let CanHealth { frames_in, frames_out, syncs, unexpected_frames, nodes, interface, records_dropped } = health;
    let mut lines = vec![format!(
        "frames {frames_in} in, {frames_out} out; {syncs} SYNC; {unexpected_frames} unexpected; {records_dropped} records \
         dropped"
    )];
    lines.extend(interface.as_ref().filter(|interface| is_there(interface)).map(interface_line));
    lines.push(format!(
        "{:<4} {:<15} {:>8} {:>7} {:>6} {:>10} {:>20} {:>20}",
        "node", "NMT state", "feedback", "missed", "stale", "emergency", "feedback age, gap", "heartbeat (ms)"
    ));
    lines.extend(nodes.iter().map(node_line));
    let told = nodes.iter().filter(|node| !node.last_emergency.is_empty());
    lines.extend(told.map(|node| format!("node {}: last emergency {}", node.node, node.last_emergency)));
    lines.extend(nodes.iter().filter_map(reading_line));
    lines
}

/// Supply voltage and temperature of a drive that is asked for them.
fn reading_line(node: &NodeHealth) -> Option<String> {
    let voltage = node.supply_voltage_v.map(|voltage| format!(" supply {voltage:.1} V"));
    let temperature = node.temperature_c.map(|temperature| format!(" {temperature:.1} deg C"));
    let values: Vec<String> = voltage.into_iter().chain(temperature).collect();
    let warned = match node.reading_warnings {
        0 => String::new(),
        times => format!("; WARNING: {times} times beyond what the robot file warns of"),
    };
    (!values.is_empty()).then(|| format!("node {}:{}{warned}", node.node, values.join(",")))
}

/// A simulated robot has no interface; its counters all stay at zero.
fn is_there(interface: &InterfaceHealth) -> bool {
    *interface != InterfaceHealth::default()
}

fn interface_line(interface: &InterfaceHealth) -> String {
    let InterfaceHealth { error_frames, bus_offs, restarts, queue_full, refused, .. } = interface;
    let counter = |counter: Option<u32>| counter.map_or_else(|| "?".to_owned(), |counter| counter.to_string());
    let mut line = format!(
        "interface: {error_frames} error frames, {bus_offs} times bus-off, {restarts} restarts, queue full {queue_full} \
         times, dropped {}, refused {refused}, error counters {} {}",
        counter(interface.dropped),
        counter(interface.transmit_errors),
        counter(interface.receive_errors)
    );
    if !interface.last_problem.is_empty() {
        line.push_str(&format!("; last: {}", interface.last_problem));
    }
    line
}

fn node_line(node: &NodeHealth) -> String {
    let ages = |age: f64, gap: f64| format!("{age:.1}, {gap:.1}");
    format!(
        "{:<4} {:<15} {:>8} {:>7} {:>6} {:>10} {:>20} {:>20}",
        node.node,
        node.nmt_state,
        node.feedbacks,
        node.missed_feedbacks,
        node.stale_feedbacks + node.surplus_feedbacks + node.malformed,
        node.emergencies,
        ages(node.feedback_age_ms, node.longest_feedback_gap_ms),
        ages(node.heartbeat_age_ms, node.longest_heartbeat_gap_ms)
    )
}
