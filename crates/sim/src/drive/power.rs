//! The drive's power stage: commands, faults, torque, and the objects that show them.

use super::dictionary::{ABORT_IS_FAULT, BRAKE_OUTPUT};
use super::state::EmulatedDrive;
use crate::outbox::Outbox;
use canopen_rs::{Address, ErrorRegister, Value};
use uarm_io::drive::cia402::{Command, Controlword, PowerState, Statusword};
use uarm_io::drive::objects as od;
use uarm_io::drive::wire;
use uarm_io::drive::{NmtCommand, NmtState};
use uarm_io::time::Instant;

/// Emergency error codes (CiA 301 table 26, CiA 402-2 table 4).
pub(super) mod error {
    /// Excess temperature of the device.
    pub const OVER_TEMPERATURE: u16 = 0x4210;
    /// Life guard or heartbeat error.
    pub const MASTER_LOST: u16 = 0x8130;
    /// PDO not processed because it is too short.
    pub const PDO_LENGTH: u16 = 0x8210;
    /// RPDO timeout.
    pub const RPDO_TIMEOUT: u16 = 0x8250;
}

/// Indices without a constant in `uarm_io`, which does not touch them.
const TORQUE_DEMAND: Address = Address::new(0x6074, 0);
const DIGITAL_OUTPUTS: Address = Address::new(0x60FE, 1);
const ERROR_BEHAVIOUR: Address = Address::new(0x1029, 1);

/// Torque as the drive counts it.
pub(super) struct Torque {
    /// Per mille of the rated torque, after the limit.
    pub(super) applied: i16,
    /// The limit cut it.
    pub(super) limited: bool,
    /// The drive follows its target.
    pub(super) obeys: bool,
}

impl EmulatedDrive {
    /// Obeys the controlword.
    pub(super) fn on_command(&mut self, now: Instant, outbox: &mut Outbox) {
        let word = Controlword::from_bits(self.unsigned16(od::CONTROLWORD.address()));
        let command = word.command(self.controlword);
        self.controlword = word;
        if command == Command::FaultReset && self.power == PowerState::Fault {
            if self.faults.over_temperature {
                return;
            }
            let cleared = self.node.clear_errors();
            self.send(&cleared, now, outbox);
            self.set(od::ERROR_CODE.address(), Value::Unsigned16(0));
        }
        self.enter(self.power.after(command));
    }

    /// 6007h says what happens to the power stage, 1029h what happens to the NMT state.
    pub(super) fn on_master_lost(&mut self, now: Instant, outbox: &mut Outbox) {
        let option = match self.node.od().read(od::ABORT_CONNECTION_OPTION.address()) {
            Ok(Value::Integer16(option)) => option,
            _ => ABORT_IS_FAULT,
        };
        let powered = !matches!(self.power, PowerState::SwitchOnDisabled | PowerState::Fault);
        if powered && option == ABORT_IS_FAULT {
            self.fault(error::MASTER_LOST, ErrorRegister::COMMUNICATION, now, outbox);
        } else {
            self.warn(error::MASTER_LOST, ErrorRegister::COMMUNICATION, now, outbox);
            match option {
                2 => self.enter(self.power.after(Command::DisableVoltage)),
                3 => self.enter(self.power.after(Command::QuickStop)),
                _ => {}
            }
        }
        let command = match self.node.od().read(ERROR_BEHAVIOUR) {
            Ok(Value::Unsigned8(0)) if self.node.state() == NmtState::Operational => NmtCommand::EnterPreOperational,
            Ok(Value::Unsigned8(2)) => NmtCommand::StopRemoteNode,
            _ => return,
        };
        let frame = wire::nmt_frame(command, self.parameters.node());
        self.node.on_frame(frame.id().as_raw(), frame.data());
        self.publish();
    }

    /// Reports an error that leaves the power stage alone.
    pub(super) fn warn(&mut self, code: u16, register: u8, now: Instant, outbox: &mut Outbox) {
        let emergency = self.node.raise_emergency(code, ErrorRegister(register), [0; 5]);
        self.send(&emergency, now, outbox);
    }

    /// Reports an error, switches off and brakes. The reaction takes no time: the brake holds at once.
    pub(super) fn fault(&mut self, code: u16, register: u8, now: Instant, outbox: &mut Outbox) {
        self.warn(code, register, now, outbox);
        self.set(od::ERROR_CODE.address(), Value::Unsigned16(code));
        self.enter(self.power.after_fault().after_fault_reaction());
    }

    pub(super) fn switch_off(&mut self) {
        self.enter(self.power.after(Command::DisableVoltage));
    }

    pub(super) fn enter(&mut self, state: PowerState) {
        if state != PowerState::OperationEnabled {
            self.set(od::TARGET_TORQUE.address(), Value::Integer16(0));
        }
        self.power = state;
        self.publish();
    }

    /// The torque in force.
    pub(super) fn torque_per_mille(&self) -> Torque {
        let mode = self.node.od().read(od::MODE_OF_OPERATION.address());
        let obeys =
            self.power == PowerState::OperationEnabled && mode == Ok(Value::Integer8(od::CYCLIC_SYNCHRONOUS_TORQUE));
        let target = match self.node.od().read(od::TARGET_TORQUE.address()) {
            Ok(Value::Integer16(target)) if obeys => target,
            _ => 0,
        };
        let limit = i16::try_from(self.unsigned16(od::MAXIMUM_TORQUE.address())).unwrap_or(i16::MAX);
        Torque { applied: target.clamp(-limit, limit), limited: target.unsigned_abs() > limit.unsigned_abs(), obeys }
    }

    /// Brings the objects that show the drive's state up to date.
    pub(super) fn publish(&mut self) {
        let torque = self.torque_per_mille();
        let flag = |bits, set| if set { bits } else { 0 };
        let remote = self.node.state() == NmtState::Operational;
        let status = Statusword::of(self.power)
            .with(Statusword::VOLTAGE_ENABLED)
            .with(flag(Statusword::REMOTE, remote))
            .with(flag(Statusword::INTERNAL_LIMIT_ACTIVE, torque.limited))
            .with(flag(Statusword::FOLLOWS_TARGET, torque.obeys));
        self.set(od::STATUSWORD.address(), Value::Unsigned16(status.bits()));
        self.set(TORQUE_DEMAND, Value::Integer16(torque.applied));
        self.set(od::TORQUE_ACTUAL.address(), Value::Integer16(torque.applied));
        let outputs = if self.power == PowerState::OperationEnabled { 0 } else { BRAKE_OUTPUT };
        self.set(DIGITAL_OUTPUTS, Value::Unsigned32(outputs));
        if let Ok(mode) = self.node.od().read(od::MODE_OF_OPERATION.address()) {
            self.set(od::MODE_OF_OPERATION_DISPLAY.address(), mode);
        }
    }
}
