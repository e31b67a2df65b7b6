//! How the drive answers the services of CANopen: NMT, SDO, heartbeat, RPDO.

use super::dictionary::{OBJECTS, dictionary};
use super::power::error;
use super::sdo_rules;
use super::state::{EmulatedDrive, RPDO1_EVENT_TIMER, Reaction};
use super::timers::{Ticker, Watchdog};
use crate::outbox::Outbox;
use canopen_rs::{Address, ErrorRegister, Node, Value, pdo};
use uarm_io::drive::cia402::{Controlword, PowerState};
use uarm_io::drive::objects as od;
use uarm_io::drive::wire::{self, Channel};
use uarm_io::drive::{NmtCommand, NmtState};
use uarm_io::frame::Frame;
use uarm_io::time::Instant;

/// Application objects begin here; a reset of the communication leaves them alone.
const FIRST_APPLICATION_INDEX: u16 = 0x2000;

impl EmulatedDrive {
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
            after if before == NmtState::Operational && after != NmtState::Operational => self.switch_off(),
            _ => {}
        }
        self.publish();
        Reaction::None
    }

    /// Boots anew; a reset of the communication alone keeps the application's objects, and a fault.
    pub(super) fn restart(&mut self, command: NmtCommand, now: Instant, outbox: &mut Outbox) {
        let mut fresh = dictionary(&self.parameters);
        let keeps_application = command == NmtCommand::ResetCommunication;
        if keeps_application {
            for object in OBJECTS.iter().filter(|object| object.address.index >= FIRST_APPLICATION_INDEX) {
                if let Ok(value) = self.node.od().read(object.address) {
                    let _ = fresh.set(object.address, value);
                }
            }
        }
        let state = match self.power {
            PowerState::Fault if keeps_application => PowerState::Fault,
            _ => PowerState::SwitchOnDisabled,
        };
        self.node = Node::new(self.parameters.node(), fresh);
        self.node.configure_pdos_from_od();
        self.controlword = Controlword::default();
        self.heartbeat = Ticker::default();
        self.master = Watchdog::default();
        self.commands = Watchdog::default();
        self.command_waits = false;
        self.report_due = self.faults.over_temperature && state != PowerState::Fault;
        let boot_up = self.node.boot();
        self.send(&boot_up, now, outbox);
        self.enter(state);
    }

    pub(super) fn on_sdo(&mut self, data: &[u8], now: Instant, outbox: &mut Outbox) {
        let Ok(request) = wire::decode_sdo(data) else { return };
        let node = self.parameters.node();
        if !matches!(self.node.state(), NmtState::PreOperational | NmtState::Operational) {
            return;
        }
        if let Some(abort) = sdo_rules::abort(self.node.od(), &request) {
            self.push(wire::sdo_response_frame(node, &abort), now, outbox);
            return;
        }
        if let Some(response) = self.node.on_frame(Channel::SdoRequest(node).identifier().as_raw(), &request) {
            self.send(&response, now, outbox);
        }
        if let Some(written) = self.node.take_written_object() {
            self.on_written(written, now, outbox);
        }
    }

    /// Acts on what the master wrote by SDO.
    pub(super) fn on_written(&mut self, written: Address, now: Instant, outbox: &mut Outbox) {
        match written.index {
            0x1016 => {
                let entry = self.unsigned(od::CONSUMER_HEARTBEAT_TIME.address());
                self.master.restart(wire::decode_consumer_heartbeat_entry(entry).1);
            }
            0x1017 => {
                let period = self.unsigned16(od::PRODUCER_HEARTBEAT_TIME.address());
                self.heartbeat.restart(period, now);
            }
            0x1400 if written == RPDO1_EVENT_TIMER => self.commands.restart(self.unsigned16(RPDO1_EVENT_TIMER)),
            0x1400..=0x1BFF => self.node.configure_pdos_from_od(),
            0x6040 => self.on_command(now, outbox),
            _ => {}
        }
        self.publish();
    }

    pub(super) fn on_heartbeat(&mut self, node: u8, data: &[u8], now: Instant) {
        let (listened_to, _) =
            wire::decode_consumer_heartbeat_entry(self.unsigned(od::CONSUMER_HEARTBEAT_TIME.address()));
        let alive = matches!(wire::decode_heartbeat(data), Ok(state) if state != NmtState::Initialising);
        if alive && node == listened_to {
            self.master.feed(now);
        }
    }

    pub(super) fn on_pdo(&mut self, frame: &Frame, now: Instant, outbox: &mut Outbox) {
        let identifier = self.unsigned(od::RPDO1_IDENTIFIER.address());
        let ours = pdo::pdo_is_valid(identifier) && pdo::pdo_can_id(identifier) == frame.id().as_raw();
        if !ours || self.node.state() != NmtState::Operational {
            return;
        }
        if frame.data().len() < self.rpdo_length() {
            self.warn(error::PDO_LENGTH, ErrorRegister::COMMUNICATION, now, outbox);
            return;
        }
        self.node.on_frame(frame.id().as_raw(), frame.data());
        self.commands.feed(now);
        let kind = self.node.od().read(od::RPDO1_TRANSMISSION_TYPE.address());
        if matches!(kind, Ok(Value::Unsigned8(0..=240))) {
            self.command_waits = true;
        } else {
            self.on_command(now, outbox);
        }
    }

    /// Bytes that RPDO1 carries.
    pub(super) fn rpdo_length(&self) -> usize {
        let Ok(Value::Unsigned8(count)) = self.node.od().read(od::RPDO1_MAPPED_OBJECTS.address()) else { return 0 };
        let bits = |subindex| self.unsigned(Address::new(od::RPDO1_MAPPED_OBJECTS.index, subindex)).to_le_bytes()[0];
        (1..=count).map(|subindex| usize::from(bits(subindex))).sum::<usize>() / 8
    }
}
