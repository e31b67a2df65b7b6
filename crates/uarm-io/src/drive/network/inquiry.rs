//! Supply voltages and temperatures: asked for in turn by SDO, one request at a time, without waiting for its answer.

use super::error::CycleError;
use super::master::{DriveNetwork, Inquiry, Node, Request};
use crate::drive::readings::{Found, Quantity, Reading, Verdict};
use crate::drive::{sdo, wire};
use crate::link::Link;
use crate::time::Instant;
use canopen_rs::sdo::{SdoClient, SdoEvent, SdoPayload};
use canopen_rs::{NodeId, Value};
use core::time::Duration;

/// How often something is asked for: a request and its answer take 0.3 ms of a bus of 1 Mbit/s.
const INTERVAL: Duration = Duration::from_millis(50);
/// How long an answer is waited for before the next is asked.
const PATIENCE: Duration = Duration::from_millis(100);
/// Requests in a row that a drive may leave unanswered.
const MOST_UNANSWERED: u8 = 1;

impl<L: Link, const JOINTS: usize> DriveNetwork<L, JOINTS> {
    /// Asks for the next value if it is due, and judges what came.
    pub(super) fn inquire(&mut self, now: Instant) -> Result<(), CycleError<L::Error>> {
        self.judge_readings()?;
        if let Some(request) = self.inquiry.open {
            if now < request.at + PATIENCE {
                return Ok(());
            }
            self.inquiry.open = None;
            if let Some(node) = self.node_mut(request.node) {
                node.unanswered = node.unanswered.saturating_add(1);
            }
        }
        if now < self.inquiry.next_at {
            return Ok(());
        }
        let Some((node, quantity, reading)) = self.next_reading() else { return Ok(()) };
        self.inquiry.next_at = now + INTERVAL;
        let request = SdoClient::new(node).read(reading.object, reading.data_type);
        self.send(&wire::sdo_request_frame(node, &request))?;
        if let Some(node) = self.node_mut(node) {
            node.sdo_owed = node.sdo_owed.saturating_add(1);
        }
        self.inquiry.open = Some(Request { node, quantity, reading, at: now });
        Ok(())
    }

    /// The next one that is to be asked for; `None` if there is none at all.
    fn next_reading(&mut self) -> Option<(NodeId, Quantity, Reading)> {
        let total = JOINTS.saturating_mul(Quantity::ALL.len());
        for _ in 0..total {
            let at = self.inquiry.next;
            self.inquiry.next = (at.saturating_add(1)).checked_rem(total).unwrap_or_default();
            let (joint, which) = (at.checked_div(Quantity::ALL.len())?, at.checked_rem(Quantity::ALL.len())?);
            let drive = self.configuration.drives().get(joint)?;
            if let (Some(Some(reading)), Some(quantity)) = (drive.readings.get(which), Quantity::ALL.get(which)) {
                return Some((drive.node, *quantity, *reading));
            }
        }
        None
    }

    /// Takes an SDO answer if it is the one that is waited for.
    pub(super) fn take_answer(&mut self, from: NodeId, payload: &SdoPayload) {
        let Some(request) = self.inquiry.open.filter(|request| request.node == from) else { return };
        if !sdo::concerns(payload, request.reading.object) {
            return;
        }
        self.inquiry.open = None;
        let Some(node) = self.node_mut(from) else { return };
        match answered(&request, payload).and_then(|value| request.reading.value(value)) {
            Some(value) => node.take_reading(&request, value),
            // An abort takes nothing off what is owed.
            None => {
                node.sdo_owed = node.sdo_owed.saturating_sub(u8::from(payload.first() == Some(&sdo::ABORT)));
                node.unanswered = node.unanswered.saturating_add(1);
            }
        }
    }

    /// Begins anew, with nothing known.
    pub(super) fn forget_readings(&mut self) {
        self.inquiry = Inquiry::default();
        for node in &mut self.nodes {
            node.unanswered = 0;
            node.health.readings = Default::default();
        }
    }

    /// An error for the first drive with a value that ends a run, or that answers no more.
    fn judge_readings(&self) -> Result<(), CycleError<L::Error>> {
        for (node, drive) in self.nodes.iter().zip(self.configuration.drives()) {
            if node.unanswered > MOST_UNANSWERED {
                return Err(CycleError::NoReading { node: node.health.node });
            }
            for ((reading, quantity), value) in drive.readings.iter().zip(Quantity::ALL).zip(node.health.readings) {
                let (Some(reading), Some(value)) = (reading, value) else { continue };
                if reading.limits.verdict(value) == Verdict::Stop {
                    let found = Found { quantity, value, allowed: reading.limits.stop() };
                    return Err(CycleError::Reading { node: node.health.node, found });
                }
            }
        }
        Ok(())
    }
}

/// The value in an answer, if it is one.
fn answered(request: &Request, payload: &SdoPayload) -> Option<Value> {
    let payload = sdo::sized(*payload, sdo::Expected::Value(request.reading.data_type));
    let mut client = SdoClient::new(request.node);
    let _ = client.read(request.reading.object, request.reading.data_type);
    match client.on_response(&payload) {
        SdoEvent::Complete(value) => value,
        _ => None,
    }
}

impl Node {
    fn take_reading(&mut self, request: &Request, value: f64) {
        self.unanswered = 0;
        let which = Quantity::ALL.iter().position(|quantity| *quantity == request.quantity);
        if let Some(kept) = which.and_then(|which| self.health.readings.get_mut(which)) {
            *kept = Some(value);
        }
        if request.reading.limits.verdict(value) == Verdict::Warning {
            self.health.reading_warnings = self.health.reading_warnings.saturating_add(1);
        }
    }
}
