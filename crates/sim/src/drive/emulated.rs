//! What an emulated CiA 402 drive does, without I/O: frames and instants in, frames out.

use super::dictionary::dictionary;
use super::faults::{DriveFault, Faults};
use super::parameters::DriveParameters;
use super::power::error;
use super::state::{EmulatedDrive, Reaction};
use super::timers::{Ticker, Watchdog};
use crate::outbox::Outbox;
use crate::plant::Brake;
use canopen_rs::{Address, ErrorRegister, Node, Value};
use uarm_io::drive::cia402::{Controlword, PowerState};
use uarm_io::drive::objects as od;
use uarm_io::drive::wire::Channel;
use uarm_io::drive::{NmtCommand, NmtState};
use uarm_io::frame::Frame;
use uarm_io::time::Instant;

impl EmulatedDrive {
    /// A drive without supply; [`power_on`](Self::power_on) starts it.
    pub fn new(parameters: DriveParameters) -> Self {
        let mut drive = Self {
            parameters,
            node: Node::new(parameters.node(), dictionary(&parameters)),
            power: PowerState::NotReadyToSwitchOn,
            controlword: Controlword::default(),
            heartbeat: Ticker::default(),
            master: Watchdog::default(),
            commands: Watchdog::default(),
            command_waits: false,
            faults: Faults::default(),
            report_due: false,
        };
        drive.node.configure_pdos_from_od();
        drive.publish();
        drive
    }

    /// What it is made of.
    pub const fn parameters(&self) -> &DriveParameters {
        &self.parameters
    }

    /// State of its power state machine.
    pub const fn power_state(&self) -> PowerState {
        self.power
    }

    /// State of its NMT state machine.
    pub fn nmt_state(&self) -> NmtState {
        self.node.state()
    }

    /// The value of an object, as an SDO upload would return it.
    pub fn object(&self, address: Address) -> Option<Value> {
        self.node.od().read(address).ok()
    }

    /// What its brake does to the joint.
    pub fn brake(&self) -> Brake {
        let wants_open = self.power == PowerState::OperationEnabled;
        let open = (wants_open || self.faults.brake_stuck_released) && !self.faults.brake_stuck_engaged;
        if open { Brake::Released } else { Brake::Engaged }
    }

    /// The motor's torque at the joint in the joint's positive direction, N·m: per mille of the rated torque, cut at 6072h,
    /// with the sign of the drive's mounting.
    pub fn torque(&self) -> f64 {
        if self.faults.motor_disconnected {
            return 0.0;
        }
        let rated = self.unsigned(od::RATED_TORQUE.address());
        let applied = self.parameters.direction().apply(i32::from(self.torque_per_mille().applied));
        f64::from(applied) * f64::from(rated) / PER_MILLE_OF_MILLI
    }

    /// Boots: boot-up message, then *Pre-operational* and *Switch on disabled*.
    pub fn power_on(&mut self, now: Instant, outbox: &mut Outbox) {
        let boot_up = self.node.boot();
        self.send(&boot_up, now, outbox);
        self.enter(PowerState::SwitchOnDisabled);
    }

    /// Brings a fault about.
    pub fn inject(&mut self, fault: DriveFault) {
        self.faults.add(fault);
        match fault {
            DriveFault::OverTemperature => self.report_due = true,
            DriveFault::PowerLost => self.enter(PowerState::NotReadyToSwitchOn),
            _ => {}
        }
    }

    /// Takes all injected faults away. What a drive does about it then is up to its master, and a drive that had lost its
    /// supply boots.
    pub fn repair(&mut self, now: Instant, outbox: &mut Outbox) {
        let had_no_power = self.faults.power_lost;
        let encoder_offset = self.faults.encoder_offset;
        self.faults = Faults { encoder_offset, ..Faults::default() };
        self.report_due = false;
        if had_no_power {
            self.restart(NmtCommand::ResetNode, now, outbox);
        }
    }

    /// Takes the joint's angle, rad, into 6064h.
    pub(crate) fn latch_position(&mut self, angle: f64) {
        if !self.faults.encoder_stuck {
            let counts = self.parameters.encoder().counts(angle).wrapping_add(self.faults.encoder_offset);
            self.set(od::POSITION_ACTUAL.address(), Value::Integer32(counts));
        }
    }

    /// Handles any frame but SYNC.
    pub(crate) fn on_frame(&mut self, frame: &Frame, now: Instant, outbox: &mut Outbox) -> Reaction {
        if self.faults.off_bus() {
            return Reaction::None;
        }
        match Channel::of(frame.id()) {
            Some(Channel::NmtCommand) => return self.on_nmt(frame.data(), now, outbox),
            Some(Channel::SdoRequest(node)) if node == self.parameters.node() => {
                self.on_sdo(frame.data(), now, outbox);
            }
            Some(Channel::Heartbeat(node)) => self.on_heartbeat(node.raw(), frame.data(), now),
            _ => self.on_pdo(frame, now, outbox),
        }
        Reaction::None
    }

    /// Handles SYNC, after the position was latched: first what is sent, then what was waiting to act.
    pub(crate) fn on_sync(&mut self, now: Instant, outbox: &mut Outbox) {
        if self.faults.off_bus() {
            return;
        }
        for frame in self.node.sync_tpdos() {
            self.send(&frame, now, outbox);
        }
        if core::mem::take(&mut self.command_waits) {
            self.on_command(now, outbox);
        }
    }

    /// The next instant at which the drive does something by itself.
    pub(crate) fn next_deadline(&self) -> Option<Instant> {
        if self.faults.power_lost {
            return None;
        }
        let report = self.report_due.then_some(Instant::default());
        [report, self.heartbeat.due(), self.master.due(), self.commands.due()].into_iter().flatten().min()
    }

    /// Does what is due by `now`.
    pub(crate) fn on_time(&mut self, now: Instant, outbox: &mut Outbox) {
        if self.faults.power_lost {
            return;
        }
        if core::mem::take(&mut self.report_due) {
            self.fault(error::OVER_TEMPERATURE, ErrorRegister::TEMPERATURE, now, outbox);
        }
        if self.master.take_expiry(now) {
            self.on_master_lost(now, outbox);
        }
        if self.commands.take_expiry(now) && self.power == PowerState::OperationEnabled {
            self.fault(error::RPDO_TIMEOUT, ErrorRegister::COMMUNICATION, now, outbox);
        }
        if self.heartbeat.take_tick(now) {
            let heartbeat = self.node.heartbeat();
            self.send(&heartbeat, now, outbox);
        }
    }
}

/// Per mille of mN·m in a N·m.
const PER_MILLE_OF_MILLI: f64 = 1e6;
