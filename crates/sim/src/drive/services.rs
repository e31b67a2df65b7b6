//! How the drive answers the services of CANopen: NMT, heartbeat, SYNC; what it does about objects that were written.

use super::homing_state::Homing;
use super::memory::Errors;
use super::power::error;
use super::state::{EmulatedDrive, RPDO1_EVENT_TIMER, Reaction};
use super::timers::{Ticker, Watchdog};
use crate::outbox::Outbox;
use canopen_rs::{Address, ErrorRegister, Node};
use uarm_io::drive::cia402::{Controlword, PowerState};
use uarm_io::drive::objects as od;
use uarm_io::drive::wire::{self, Channel};
use uarm_io::drive::{NmtCommand, NmtState};
use uarm_io::time::Instant;

/// Application objects begin here; a reset of the communication leaves them alone.
const FIRST_APPLICATION_INDEX: u16 = 0x2000;

impl<const N: usize> EmulatedDrive<N> {
    pub(super) fn on_nmt(&mut self, data: &[u8], now: Instant, outbox: &mut Outbox) -> Reaction {
        let before = self.node.state();
        self.node.on_frame(Channel::NmtCommand.identifier().as_raw(), data);
        match self.node.state() {
            NmtState::Initialising => {
                let command = wire::decode_nmt(data).map_or(NmtCommand::ResetNode, |(command, _)| command);
                self.restart(command, now, outbox);
                return Reaction::Reset;
            }
            // Without PDOs nobody could command the torque any more.
            after if before == NmtState::Operational && after != NmtState::Operational => {
                self.waiting = Default::default();
                self.switch_off();
            }
            _ => {}
        }
        self.publish();
        if before != NmtState::Operational && self.node.state() == NmtState::Operational {
            self.send_first_events(now, outbox);
        }
        Reaction::None
    }

    /// Boots anew; a reset of the communication alone keeps the application's objects, and a fault.
    pub(super) fn restart(&mut self, command: NmtCommand, now: Instant, outbox: &mut Outbox) {
        let mut fresh = self.objects.at_power_on();
        let keeps_application = command == NmtCommand::ResetCommunication;
        if keeps_application {
            let application = |address: &Address| address.index >= FIRST_APPLICATION_INDEX;
            for address in self.objects.objects().iter().map(|object| object.address).filter(application) {
                if let Some(entry) = self.node.od().entry(address) {
                    let _ = fresh.set(address, entry.value);
                }
            }
        } else {
            self.begin_to_count();
        }
        let state = match self.power {
            PowerState::Fault if keeps_application => PowerState::Fault,
            _ => PowerState::SwitchOnDisabled,
        };
        self.node = Node::new(self.parameters.node(), fresh);
        self.configure_pdos();
        self.controlword = Controlword::default();
        self.heartbeat = Ticker::default();
        self.master = Watchdog::default();
        self.commands = Watchdog::default();
        self.waiting = Default::default();
        self.download = None;
        self.errors = Errors::default();
        self.sync_is_wrong = false;
        if !keeps_application {
            self.homing = Homing::default();
        }
        self.report_due = self.faults.over_temperature && state != PowerState::Fault;
        self.power = state;
        self.begin_to_boot(now, outbox);
    }

    /// Boots at once, or after its boot time; until then it is deaf and dumb.
    pub(super) fn begin_to_boot(&mut self, now: Instant, outbox: &mut Outbox) {
        let boot_time = self.parameters.power_up().boot_time;
        if boot_time.is_zero() {
            self.finish_boot(now, outbox);
        } else {
            self.boots_at = Some(now + boot_time);
        }
    }

    /// Boot-up message, *Pre-operational*, and what it has to report.
    pub(super) fn finish_boot(&mut self, now: Instant, outbox: &mut Outbox) {
        self.boots_at = None;
        self.watch_master();
        self.watch_commands();
        self.restart_heartbeat(now);
        let boot_up = self.node.boot();
        self.send(&boot_up, now, outbox);
        let state = if self.power == PowerState::Fault { PowerState::Fault } else { PowerState::SwitchOnDisabled };
        self.enter(state);
        let power_up = self.parameters.power_up();
        if let Some(code) = power_up.emergency {
            self.warn(code, ErrorRegister::GENERIC, now, outbox);
        }
        if let Some(code) = power_up.fault.filter(|_| !core::mem::replace(&mut self.had_first_fault, true)) {
            self.fault(code, ErrorRegister::GENERIC, now, outbox);
        }
    }

    /// A SYNC whose length is not that of 1019h is reported once, and not answered (CiA 301, 7.2.5.3).
    pub(super) fn accepts_sync(&mut self, data: &[u8], now: Instant, outbox: &mut Outbox) -> bool {
        let is_right = data.len() == usize::from(self.wants_counter());
        let listens = matches!(self.node.state(), NmtState::PreOperational | NmtState::Operational);
        if !is_right && listens && !self.sync_is_wrong {
            self.warn(error::SYNC_LENGTH, ErrorRegister::COMMUNICATION, now, outbox);
        }
        self.sync_is_wrong = !is_right && listens;
        is_right
    }

    /// Acts on what the master wrote by SDO.
    pub(super) fn on_written(&mut self, written: Address, now: Instant, outbox: &mut Outbox) {
        match written.index {
            0x1003 => self.clear_error_history(),
            0x1016 => self.watch_master(),
            0x1017 => self.restart_heartbeat(now),
            0x1400 if written == RPDO1_EVENT_TIMER => self.watch_commands(),
            0x1400..=0x1BFF => self.configure_pdos(),
            0x6040 => self.on_command(now, outbox),
            0x6060 => self.on_mode(),
            _ => {}
        }
        self.publish();
    }

    pub(super) fn on_heartbeat(&mut self, node: u8, data: &[u8], now: Instant) {
        let (listened_to, _) = wire::decode_consumer_heartbeat_entry(self.consumer_entry());
        let alive = matches!(wire::decode_heartbeat(data), Ok(state) if state != NmtState::Initialising);
        if alive && node == listened_to {
            self.master.feed(now);
        }
    }

    fn consumer_entry(&self) -> u32 {
        let entry = self.number(od::CONSUMER_HEARTBEAT_TIME.address());
        entry.and_then(|entry| u32::try_from(entry).ok()).unwrap_or_default()
    }

    /// Watches the master as 1016h:01 says.
    fn watch_master(&mut self) {
        self.master.restart(wire::decode_consumer_heartbeat_entry(self.consumer_entry()).1);
    }

    /// Sends heartbeats as 1017h says.
    fn restart_heartbeat(&mut self, now: Instant) {
        let period = self.number(od::PRODUCER_HEARTBEAT_TIME.address()).and_then(|time| u16::try_from(time).ok());
        self.heartbeat.restart(period.unwrap_or_default(), now);
    }

    /// Watches RPDO1 as 1400h:05 says.
    fn watch_commands(&mut self) {
        let time = self.number(RPDO1_EVENT_TIMER).and_then(|time| u16::try_from(time).ok());
        self.commands.restart(time.unwrap_or_default());
    }
}
