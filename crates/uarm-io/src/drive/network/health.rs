//! What the master has seen of its drives, for a recorder.

use crate::drive::cia402::Statusword;
use crate::drive::readings::QUANTITIES;
use crate::time::Instant;
use canopen_rs::{EmergencyMessage, NmtState};
use core::time::Duration;

/// Counters and ages of one drive, since the network was built.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NodeHealth {
    /// The drive's node id.
    pub node: u8,
    /// TPDO1 frames that came in time for the SYNC before them.
    pub feedbacks: u64,
    /// Cycles whose deadline passed without one.
    pub missed_feedbacks: u64,
    /// TPDO1 frames that came after their deadline, or too soon to belong to the last SYNC.
    pub stale_feedbacks: u64,
    /// TPDO1 frames beyond the first in one cycle: one of them was late, or somebody else sends SYNCs.
    pub surplus_feedbacks: u64,
    /// RPDO1 frames sent.
    pub commands: u64,
    /// Heartbeats received, boot-up messages included.
    pub heartbeats: u64,
    /// Emergency messages received.
    pub emergencies: u64,
    /// Frames on one of its channels with a payload that does not belong there.
    pub malformed: u64,
    /// From SYNC to the last feedback.
    pub latency: Duration,
    /// The longest of them.
    pub longest_latency: Duration,
    /// When the last feedback came.
    pub last_feedback_at: Option<Instant>,
    /// The longest time between two feedbacks.
    pub longest_feedback_gap: Duration,
    /// When the last heartbeat came.
    pub last_heartbeat_at: Option<Instant>,
    /// The longest time between two heartbeats.
    pub longest_heartbeat_gap: Duration,
    /// The last statusword.
    pub statusword: Statusword,
    /// The torque actual value 6077h, per mille of the rated torque, of a drive that sends it: the answer to the last SYNC, or to
    /// the one before while that is on its way.
    pub torque: Option<i16>,
    /// The state in the last heartbeat.
    pub nmt_state: Option<NmtState>,
    /// The last emergency message that was no error reset.
    pub last_emergency: Option<EmergencyMessage>,
    /// What it was asked for last, by [`Quantity`](crate::drive::readings::Quantity): V and deg C.
    pub readings: [Option<f64>; QUANTITIES],
    /// How many of those were beyond what is worth a warning.
    pub reading_warnings: u64,
}

/// The whole network's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NetworkHealth<const JOINTS: usize> {
    /// Each drive, joint 1 first.
    pub nodes: [NodeHealth; JOINTS],
    /// Frames of all kinds received.
    pub frames_received: u64,
    /// Frames of all kinds sent.
    pub frames_sent: u64,
    /// SYNCs sent.
    pub syncs: u64,
    /// Frames that no drive of ours should send.
    pub unexpected_frames: u64,
}

/// Records that something came at `at`, and the gap before it.
pub(super) fn arrived(last: &mut Option<Instant>, longest_gap: &mut Duration, at: Instant) {
    if let Some(previous) = last.replace(at) {
        *longest_gap = (*longest_gap).max(at.since(previous));
    }
}
