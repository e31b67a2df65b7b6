//! From any state to brakes closed, as well as it can be done.

use super::blocking::{Blocking, Heed, Voice};
use super::master::{BusClaim, DriveNetwork, LastDefence};
use crate::drive::cia402::{Command, Controlword, PowerState};
use crate::drive::wire::{self, DriveCommand};
use crate::link::Link;
use crate::time::{Clock, Duration, Instant};
use canopen_rs::{NmtCommand, NmtState, NodeId};

/// How far a step of stopping got.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Confirmation {
    /// The drive reported it.
    Confirmed,
    /// It was sent; the drive did not report it in time.
    Unconfirmed,
    /// The link did not take it.
    #[default]
    NotSent,
    /// Nothing was sent on purpose: before the start another master was heard on the bus, whose drives these are.
    Withheld,
}

/// How one drive was stopped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DriveStop {
    /// The drive's node id.
    pub node: u8,
    /// Torque 0 and quick stop: the drive no longer is in *Operation enabled*.
    pub quick_stop: Confirmation,
    /// Power off, brake closed: *Switch on disabled*, or *Fault*.
    pub power_off: Confirmation,
    /// NMT Stopped.
    pub nmt_stop: Confirmation,
    /// What makes it brake by itself, if none of this arrived.
    pub last_defence: LastDefence,
}

/// How all drives were stopped, joint 1 first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StopReport<const JOINTS: usize> {
    /// Each drive.
    pub drives: [DriveStop; JOINTS],
}

impl<const JOINTS: usize> StopReport<JOINTS> {
    /// True if every drive reported that its power is off.
    pub fn all_off(&self) -> bool {
        self.drives.iter().all(|drive| drive.power_off == Confirmation::Confirmed)
    }
}

impl<L: Link, const JOINTS: usize> DriveNetwork<L, JOINTS> {
    /// Stops all drives as well as it can be done: torque 0, quick stop, power off and brakes, NMT stop; blocks.
    ///
    /// Never fails: what a drive did not confirm is told in the report. After a step that was not confirmed within
    /// [`Timeouts::stop`](super::Timeouts::stop) the master sends no more heartbeats, so that the drive's own watchdog
    /// brakes it.
    pub fn stop<C: Clock>(&mut self, clock: &C) -> StopReport<JOINTS> {
        Blocking::new(self, clock).stop()
    }
}

impl<L: Link, C: Clock, const JOINTS: usize> Blocking<'_, L, C, JOINTS> {
    /// See [`DriveNetwork::stop`]. Each step goes to all drives before any of them is waited for.
    pub(super) fn stop(&mut self) -> StopReport<JOINTS> {
        if self.network.claim == BusClaim::AnotherMasters {
            return self.withhold();
        }
        // A drive that does not answer must not hold up the others three times.
        self.sdo_attempts = 1;
        self.heed = Heed::Nothing;
        let quick_stop = self.command_all(Command::QuickStop, |state| state != PowerState::OperationEnabled);
        let power_off = self.command_all(Command::DisableVoltage, |state| {
            matches!(state, PowerState::SwitchOnDisabled | PowerState::NotReadyToSwitchOn | PowerState::Fault)
        });
        let nmt_stop = self.stop_nodes();
        let mut drives = self.network.nodes.map(|node| DriveStop {
            node: node.health.node,
            last_defence: node.last_defence,
            ..DriveStop::default()
        });
        let steps = quick_stop.into_iter().zip(power_off).zip(nmt_stop);
        for (drive, ((quick_stop, power_off), nmt_stop)) in drives.iter_mut().zip(steps) {
            *drive = DriveStop { quick_stop, power_off, nmt_stop, ..*drive };
        }
        StopReport { drives }
    }

    /// Sends `order` with torque 0 to every drive, then waits for each to be in a state that is `wanted`.
    fn command_all(&mut self, order: Command, wanted: impl Fn(PowerState) -> bool) -> [Confirmation; JOINTS] {
        let command = DriveCommand { controlword: Controlword::of(order), target_torque: 0 };
        let sent = self.nodes().map(|node| (node, self.network.command(node, &command).is_ok()));
        let deadline = self.begin_step(self.network.configuration.timeouts.stop);
        for node in self.nodes() {
            // What became of this is seen below.
            if !self.obeys_pdos(node) {
                let _ = self.command_by_sdo(node, command.controlword);
            }
        }
        let confirmations = sent.map(|(node, sent)| match sent {
            false => Confirmation::NotSent,
            true if self.comes_to(node, deadline, &wanted) => Confirmation::Confirmed,
            true => Confirmation::Unconfirmed,
        });
        self.end_step(&confirmations);
        confirmations
    }

    /// The deadline of a step; heartbeats end with it.
    fn begin_step(&mut self, time: Duration) -> Instant {
        let deadline = self.clock.now() + time;
        if self.voice != Voice::Silent {
            self.voice = Voice::HeartbeatsUntil(deadline);
        }
        deadline
    }

    /// A drive that did not obey is left to its watchdog, which the master's heartbeats would feed.
    fn end_step(&mut self, confirmations: &[Confirmation; JOINTS]) {
        if confirmations.iter().any(|confirmation| *confirmation != Confirmation::Confirmed) {
            self.voice = Voice::Silent;
        }
    }

    /// The report of a stop that sent nothing.
    fn withhold(&self) -> StopReport<JOINTS> {
        let withheld = Confirmation::Withheld;
        let drives = self.network.nodes.map(|node| DriveStop {
            node: node.health.node,
            quick_stop: withheld,
            power_off: withheld,
            nmt_stop: withheld,
            last_defence: node.last_defence,
        });
        StopReport { drives }
    }

    /// Reads the statusword of `node` until its state is `wanted`; false after silence, a failing link or `deadline`.
    pub(super) fn comes_to(&mut self, node: NodeId, deadline: Instant, wanted: &impl Fn(PowerState) -> bool) -> bool {
        loop {
            let Ok(found) = self.statusword(node) else { return false };
            if found.state().is_some_and(wanted) {
                return true;
            }
            let poll = self.network.configuration.timeouts.power_poll;
            if self.clock.now() >= deadline || self.pause(poll).is_err() {
                return false;
            }
        }
    }

    /// NMT stop of every drive, confirmed by its heartbeat.
    fn stop_nodes(&mut self) -> [Confirmation; JOINTS] {
        let sent = self.nodes().map(|node| {
            let stop = wire::nmt_frame(NmtCommand::StopRemoteNode, node);
            (node, self.network.send(&stop).is_ok())
        });
        let deadline = self.begin_step(self.network.configuration.timeouts.nmt);
        sent.map(|(node, sent)| match sent {
            false => Confirmation::NotSent,
            true => match self.reports(node, deadline, |state| state == NmtState::Stopped) {
                Ok(true) => Confirmation::Confirmed,
                _ => Confirmation::Unconfirmed,
            },
        })
    }
}
