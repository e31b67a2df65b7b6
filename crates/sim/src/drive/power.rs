//! The drive's power stage: commands, faults, torque, and the objects that show them.

use super::dictionary::BRAKE_OUTPUT;
use super::faults::Faults;
use super::numbers::number_of;
use super::state::EmulatedDrive;
use crate::outbox::Outbox;
use canopen_rs::{Address, ErrorRegister};
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
    /// SYNC of an unexpected length.
    pub const SYNC_LENGTH: u16 = 0x8240;
    /// RPDO timeout.
    pub const RPDO_TIMEOUT: u16 = 0x8250;
}

/// Indices without a constant in `uarm_io`, which does not touch them.
const SUPPLY_VOLTAGE: Address = Address::new(0x6079, 0);
const TEMPERATURE: Address = Address::new(0x2010, 0);
const TORQUE_DEMAND: Address = Address::new(0x6074, 0);
const DIGITAL_OUTPUTS: Address = Address::new(0x60FE, 1);
const ERROR_BEHAVIOUR: Address = Address::new(0x1029, 1);

/// Abort connection option codes 6007h.
const ABORT_IGNORED: i128 = 0;
const ABORT_IS_FAULT: i128 = 1;
const ABORT_DISABLES: i128 = 2;
const ABORT_STOPS: i128 = 3;
/// Quick stop option codes 605Ah from here on stay in *Quick stop active*.
const FIRST_STAYING_OPTION: i128 = 5;

/// Torque as the drive counts it.
pub(super) struct Torque {
    /// Per mille of the rated torque, after the limit.
    pub(super) applied: i16,
    /// The limit cut it.
    pub(super) limited: bool,
    /// The drive follows its target.
    pub(super) obeys: bool,
}

impl<const N: usize> EmulatedDrive<N> {
    /// Obeys the controlword.
    pub(super) fn on_command(&mut self, now: Instant, outbox: &mut Outbox) {
        let word = self.number(od::CONTROLWORD.address()).and_then(|word| u16::try_from(word).ok());
        let word = Controlword::from_bits(word.unwrap_or_default());
        let before = core::mem::replace(&mut self.controlword, word);
        let command = word.command(before);
        if command == Command::FaultReset && self.power == PowerState::Fault {
            if self.faults.over_temperature {
                return;
            }
            self.clear_errors(now, outbox);
            self.set_number(od::ERROR_CODE.address(), 0);
        }
        if command == Command::QuickStop && self.power == PowerState::OperationEnabled && !self.stays_after_quick_stop()
        {
            return self.switch_off();
        }
        self.change_to(self.power.after(command));
        self.on_homing_command(before);
        self.publish();
    }

    /// 6007h says what happens to the power stage, 1029h what happens to the NMT state.
    pub(super) fn on_master_lost(&mut self, now: Instant, outbox: &mut Outbox) {
        // A drive without 6007h does nothing.
        let option = self.number(od::ABORT_CONNECTION_OPTION.address()).unwrap_or(ABORT_IGNORED);
        let powered = !matches!(self.power, PowerState::SwitchOnDisabled | PowerState::Fault);
        if powered && option == ABORT_IS_FAULT {
            self.fault(error::MASTER_LOST, ErrorRegister::COMMUNICATION, now, outbox);
        } else {
            self.warn(error::MASTER_LOST, ErrorRegister::COMMUNICATION, now, outbox);
            match option {
                ABORT_DISABLES => self.enter(self.power.after(Command::DisableVoltage)),
                ABORT_STOPS if self.stays_after_quick_stop() => self.enter(self.power.after(Command::QuickStop)),
                ABORT_STOPS => self.switch_off(),
                _ => {}
            }
        }
        let command = match self.number(ERROR_BEHAVIOUR) {
            Some(0) if self.node.state() == NmtState::Operational => NmtCommand::EnterPreOperational,
            Some(2) => NmtCommand::StopRemoteNode,
            _ => return,
        };
        let frame = wire::nmt_frame(command, self.parameters.node());
        self.node.on_frame(frame.id().as_raw(), frame.data());
        self.publish();
    }

    /// Reports an error, switches off and brakes. The reaction takes no time: the brake holds at once.
    pub(super) fn fault(&mut self, code: u16, register: u8, now: Instant, outbox: &mut Outbox) {
        self.warn(code, register, now, outbox);
        self.set_number(od::ERROR_CODE.address(), code.into());
        self.enter(self.power.after_fault().after_fault_reaction());
    }

    pub(super) fn switch_off(&mut self) {
        self.enter(self.power.after(Command::DisableVoltage));
    }

    pub(super) fn enter(&mut self, state: PowerState) {
        self.change_to(state);
        self.publish();
    }

    fn change_to(&mut self, state: PowerState) {
        if state != PowerState::OperationEnabled {
            self.set_number(od::TARGET_TORQUE.address(), 0);
        }
        self.power = state;
    }

    /// Quick stop options 5 to 8 stay in *Quick stop active*, 0 to 4 go on to *Switch on disabled* when the motor stands, which
    /// here takes no time.
    fn stays_after_quick_stop(&self) -> bool {
        self.number(od::QUICK_STOP_OPTION.address()).is_none_or(|option| option >= FIRST_STAYING_OPTION)
    }

    /// Mode 0 is no mode: a motor that is on goes off.
    pub(super) fn on_mode(&mut self) {
        let no_mode = self.number(od::MODE_OF_OPERATION.address()) == Some(0);
        if no_mode && self.power == PowerState::OperationEnabled {
            self.switch_off();
        }
    }

    /// The torque in force.
    pub(super) fn torque_per_mille(&self) -> Torque {
        let mode = self.number(od::MODE_OF_OPERATION.address());
        let obeys = self.power == PowerState::OperationEnabled
            && mode == Some(od::CYCLIC_SYNCHRONOUS_TORQUE.into())
            && !self.faults.target_ignored;
        let target = self.number(od::TARGET_TORQUE.address()).and_then(|target| i16::try_from(target).ok());
        let target = target.filter(|_| obeys).unwrap_or_default();
        let target = if self.is_homing() { self.homing.torque() } else { target };
        let limit = self.torque_limit();
        Torque { applied: target.clamp(-limit, limit), limited: target.unsigned_abs() > limit.unsigned_abs(), obeys }
    }

    /// 6072h, per mille.
    pub(super) fn torque_limit(&self) -> i16 {
        let limit = self.number(od::MAXIMUM_TORQUE.address()).unwrap_or(self.parameters.maximum_torque().into());
        i16::try_from(limit).unwrap_or(i16::MAX)
    }

    /// Lets the drive show the supply and the temperature again that it has at power-on, once `faults` have changed them.
    pub(super) fn recover_readings(&mut self, faults: &Faults) {
        for (address, was_changed) in
            [(SUPPLY_VOLTAGE, faults.supply_voltage.is_some()), (TEMPERATURE, faults.temperature.is_some())]
        {
            let at_power_on = self.objects.object(address).and_then(|object| number_of(&object.value?));
            if let (true, Some(number)) = (was_changed, at_power_on) {
                self.set_number(address, number);
            }
        }
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
            .with(flag(Statusword::FOLLOWS_TARGET, torque.obeys))
            .with(if self.is_homing() { self.homing.status() } else { 0 });
        self.set_number(od::STATUSWORD.address(), status.bits().into());
        self.set_number(TORQUE_DEMAND, torque.applied.into());
        self.set_number(od::TORQUE_ACTUAL.address(), torque.applied.into());
        if let Some(millivolts) = self.faults.supply_voltage {
            self.set_number(SUPPLY_VOLTAGE, millivolts.into());
        }
        if let Some(tenths) = self.faults.temperature {
            self.set_number(TEMPERATURE, tenths.into());
        }
        let outputs = if self.power == PowerState::OperationEnabled { 0 } else { BRAKE_OUTPUT };
        self.set_number(DIGITAL_OUTPUTS, outputs.into());
        if let Some(mode) = self.number(od::MODE_OF_OPERATION.address()) {
            self.set_number(od::MODE_OF_OPERATION_DISPLAY.address(), mode);
        }
    }
}
