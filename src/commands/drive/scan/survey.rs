//! Listening, then asking.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use anyhow::Context;
use serde::Serialize;
use uarm_io::canopen_rs::sdo::encode_upload_request;
use uarm_io::drive::NodeId;
use uarm_io::drive::objects::DEVICE_TYPE;
use uarm_io::drive::sdo::{Bystander, Patience, SdoError};
use uarm_io::drive::wire::{self, MASTER_NODE};
use uarm_io::link::{Link, LinkError, LinkErrorKind, LinkHealth};
use uarm_io::time::{Clock, Instant};
use uarm_loop::stop_request::StopRequest;

use super::identity::Identity;
use crate::bus_observation::BusObservation;

/// How long a node may take to answer one request.
const PATIENCE: Patience = Patience { timeout: Duration::from_millis(200), attempts: 2 };
/// Time from one probe to the next: no more than a few per cent of a bus of 125 kbit/s or faster.
const PROBE_SPACING: Duration = Duration::from_millis(10);
/// How often a listening scan looks whether it shall end.
const LISTENING_SLICE: Duration = Duration::from_millis(100);

/// When nodes are asked for their identities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Asking {
    /// Never: nothing is sent.
    Never,
    /// Unless a master is at work or the interface reports errors.
    UnlessDisturbing,
    /// In any case.
    Always,
}

/// What a scan found.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Scan {
    /// How long it listened, s.
    pub listened_s: f64,
    /// What it heard before it asked.
    pub heard: BusObservation,
    /// Signs of a master at work.
    pub master: Vec<String>,
    /// Error frames of the interface.
    pub error_frames: u64,
    /// How often the interface went bus-off.
    pub bus_offs: u64,
    /// The last trouble of the interface, in words.
    pub problem: Option<String>,
    /// Why nodes were not asked; absent if they were.
    pub not_asked: Option<String>,
    /// Who answered, by node id.
    pub identities: BTreeMap<u8, Identity>,
}

impl Scan {
    /// Listens for `listening`, then asks, as `asking` says. A stop request ends the listening early, and then nobody is
    /// asked.
    ///
    /// # Errors
    /// If the link fails, other than by errors on the wire.
    pub fn make<L: Link, C: Clock>(
        link: &mut L,
        clock: &C,
        listening: Duration,
        asking: Asking,
        stop: &StopRequest,
    ) -> anyhow::Result<Self>
    where
        L::Error: Send + Sync + 'static,
    {
        let mut scan = Self::default();
        let begin = clock.now();
        listen(link, clock, begin + listening, stop, &mut scan.heard)?;
        scan.listened_s = clock.now().since(begin).as_secs_f64();
        scan.master = scan.heard.master_at_work();
        scan.note_health(&link.health());
        scan.not_asked = scan.reason_not_to_ask(asking, stop.is_made());
        if scan.not_asked.is_none() {
            scan.ask(link, clock)?;
            scan.note_health(&link.health());
        }
        Ok(scan)
    }

    /// The nodes that were heard or answered, by node id.
    pub fn nodes(&self) -> BTreeSet<u8> {
        self.heard.present().map(|(node, _)| node).chain(self.identities.keys().copied()).collect()
    }

    fn note_health(&mut self, health: &LinkHealth) {
        self.error_frames = health.error_frames;
        self.bus_offs = health.bus_offs;
        self.problem = health.last_problem.map(|problem| problem.to_string()).or_else(|| self.problem.take());
    }

    fn reason_not_to_ask(&self, asking: Asking, stopped: bool) -> Option<String> {
        match asking {
            Asking::Never => Some("asked to listen only".to_owned()),
            _ if stopped => Some("interrupted".to_owned()),
            Asking::Always => None,
            Asking::UnlessDisturbing if !self.master.is_empty() => {
                Some("a master is at work, and a drive answers one SDO client at a time".to_owned())
            }
            Asking::UnlessDisturbing if self.error_frames > 0 => {
                Some("the interface reports errors: is this the bus's bit rate?".to_owned())
            }
            Asking::UnlessDisturbing => None,
        }
    }

    /// Probes every node id, then asks those who answered or were heard.
    fn ask<L: Link, C: Clock>(&mut self, link: &mut L, clock: &C) -> anyhow::Result<()>
    where
        L::Error: Send + Sync + 'static,
    {
        let mut answers = BusObservation::default();
        let mut bus = Bystander::new(link, clock, PATIENCE, |received| answers.note(received));
        for node in (1..MASTER_NODE).filter_map(|node| NodeId::new(node).ok()) {
            let probe = wire::sdo_request_frame(node, &encode_upload_request(DEVICE_TYPE.address()));
            match bus.send(&probe) {
                Err(error) if error.kind() == LinkErrorKind::QueueFull => {
                    self.problem = Some("frames stay in the interface's queue: nobody acknowledges them".to_owned());
                    return Ok(());
                }
                sent => sent.with_context(|| format!("asking node {}", node.raw()))?,
            }
            bus.listen(PROBE_SPACING)?;
        }
        bus.listen(PATIENCE.timeout)?;
        let found: BTreeSet<u8> = answers.present().map(|(node, _)| node).chain(self.nodes()).collect();
        let mut bus = Bystander::new(link, clock, PATIENCE, |_| {});
        for node in found.into_iter().filter_map(|node| NodeId::new(node).ok()) {
            match Identity::ask(&mut bus, node) {
                Ok(identity) => {
                    self.identities.insert(node.raw(), identity);
                }
                // It was heard, but has no SDO server, or its NMT state is Stopped.
                Err(SdoError::Timeout { .. }) => {}
                Err(error) => return Err(error.into()),
            }
        }
        Ok(())
    }
}

/// Notes frames until `deadline` or a stop request.
fn listen<L: Link, C: Clock>(
    link: &mut L,
    clock: &C,
    deadline: Instant,
    stop: &StopRequest,
    heard: &mut BusObservation,
) -> Result<(), L::Error> {
    while clock.now() < deadline && !stop.is_made() {
        if let Some(received) = link.receive(deadline.min(clock.now() + LISTENING_SLICE))? {
            heard.note(&received);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
