//! What an emulated CiA 402 drive does, without I/O: frames and instants in, frames out.

use super::dictionary::CAPACITY;
use super::faults::{DriveFault, Faults};
use super::homing_state::{Homing, Sight};
use super::memory::Errors;
use super::objects::{DictionaryError, DriveDictionary};
use super::parameters::{CounterAtPowerUp, DriveParameters};
use super::power::error;
use super::state::{Counter, EmulatedDrive, Reaction};
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
    /// A drive with its own dictionary and without supply; [`power_on`](Self::power_on) starts it.
    pub fn new(parameters: DriveParameters) -> Self {
        const { assert!(CAPACITY == super::dictionary::OBJECTS.len(), "its own objects fit") };
        Self::holding(parameters, DriveDictionary::own(&parameters))
    }
}

impl<const N: usize> EmulatedDrive<N> {
    /// A drive with these objects, which behave as its own do where it knows them.
    ///
    /// # Errors
    /// [`DictionaryError::TooManyObjects`] if there are more than `N`.
    pub fn with_dictionary(parameters: DriveParameters, objects: DriveDictionary) -> Result<Self, DictionaryError> {
        let found = objects.objects().len();
        if found > N {
            return Err(DictionaryError::TooManyObjects { found, most: N });
        }
        Ok(Self::holding(parameters, objects))
    }

    fn holding(parameters: DriveParameters, objects: DriveDictionary) -> Self {
        let mut drive = Self {
            parameters,
            node: Node::new(parameters.node(), objects.at_power_on()),
            objects,
            rpdos: Default::default(),
            power: PowerState::NotReadyToSwitchOn,
            torque: 0.0,
            controlword: Controlword::default(),
            heartbeat: Ticker::default(),
            master: Watchdog::default(),
            commands: Watchdog::default(),
            waiting: Default::default(),
            download: None,
            errors: Errors::default(),
            sent: Default::default(),
            sync_is_wrong: false,
            boots_at: None,
            had_first_fault: false,
            faults: Faults::default(),
            counter: Counter::Since(0),
            report_due: false,
            late: None,
            sight: Sight::default(),
            homing: Homing::default(),
        };
        drive.configure_pdos();
        drive.publish();
        drive.update_torque();
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
    pub const fn torque(&self) -> f64 {
        self.torque
    }

    /// Looks its torque up: whatever comes from outside ends with this.
    fn update_torque(&mut self) {
        self.torque = self.torque_at_joint();
    }

    fn torque_at_joint(&self) -> f64 {
        if self.faults.motor_disconnected {
            return 0.0;
        }
        let rated = self.number(od::RATED_TORQUE.address()).and_then(|rated| u32::try_from(rated).ok());
        let rated = rated.unwrap_or(self.parameters.rated_torque());
        let applied = self.parameters.direction().apply(i32::from(self.torque_per_mille().applied));
        let sign = if self.faults.torque_reversed { -1.0 } else { 1.0 };
        sign * f64::from(applied) * f64::from(rated) / self.parameters.torque_divisor()
            * self.parameters.transmission().torque_factor()
    }

    /// Boots: boot-up message, then *Pre-operational* and *Switch on disabled*.
    pub fn power_on(&mut self, now: Instant, outbox: &mut Outbox) {
        self.power = PowerState::SwitchOnDisabled;
        self.begin_to_count();
        self.begin_to_boot(now, outbox);
        self.update_torque();
    }

    /// Forgets where the joint is, if the encoder is one that does.
    pub(super) fn begin_to_count(&mut self) {
        if self.parameters.power_up().counter == CounterAtPowerUp::Zero {
            self.counter = Counter::Beginning;
        }
    }

    /// Brings a fault about.
    pub fn inject(&mut self, fault: DriveFault) {
        self.faults.add(fault);
        match fault {
            DriveFault::OverTemperature => self.report_due = true,
            DriveFault::TargetIgnored | DriveFault::SupplyVoltage { .. } | DriveFault::Temperature { .. } => {
                self.publish()
            }
            DriveFault::PowerLost => {
                self.boots_at = None;
                self.enter(PowerState::NotReadyToSwitchOn);
            }
            _ => {}
        }
        self.update_torque();
    }

    /// Takes all injected faults away. What a drive does about it then is up to its master, and a drive that had lost its
    /// supply boots.
    pub fn repair(&mut self, now: Instant, outbox: &mut Outbox) {
        let had_no_power = self.faults.power_lost;
        let encoder_offset = self.faults.encoder_offset;
        let repaired = core::mem::replace(&mut self.faults, Faults { encoder_offset, ..Faults::default() });
        self.recover_readings(&repaired);
        self.report_due = false;
        self.late = None;
        if had_no_power {
            self.restart(NmtCommand::ResetNode, now, outbox);
        }
        self.update_torque();
    }

    /// Takes the joint's angle, rad, into 6064h.
    pub(crate) fn latch_position(&mut self, angle: f64) {
        if !self.faults.encoder_stuck {
            let motor = angle * self.parameters.transmission().ratio().factor();
            let counts = self.faults.counted(self.parameters.encoder().counts(motor));
            let origin = match self.counter {
                Counter::Beginning => counts,
                Counter::Since(origin) => origin,
            };
            self.counter = Counter::Since(origin);
            let shown = self.parameters.encoder().wrapped(counts.wrapping_sub(origin));
            self.set_number(od::POSITION_ACTUAL.address(), shown.into());
            self.look_around(angle, counts);
        }
    }

    /// Lets the counter show zero where it shows `counts` without an origin.
    pub(super) fn count_from(&mut self, counts: i32) {
        self.counter = Counter::Since(counts);
        let shown = self.parameters.encoder().wrapped(self.sight.counts.wrapping_sub(counts));
        self.set_number(od::POSITION_ACTUAL.address(), shown.into());
    }

    /// Handles any frame but SYNC.
    pub(crate) fn on_frame(&mut self, frame: &Frame, now: Instant, outbox: &mut Outbox) -> Reaction {
        if self.faults.off_bus() || self.boots_at.is_some() {
            return Reaction::None;
        }
        let mut reaction = Reaction::None;
        match Channel::of(frame.id()) {
            Some(Channel::NmtCommand) => reaction = self.on_nmt(frame.data(), now, outbox),
            Some(Channel::SdoRequest(node)) if node == self.parameters.node() => {
                self.on_sdo(frame.data(), now, outbox);
            }
            Some(Channel::Heartbeat(node)) => {
                self.on_heartbeat(node.raw(), frame.data(), now);
                return Reaction::None;
            }
            _ => match self.rpdo_of(frame) {
                Some(number) => self.on_pdo(number, frame, now, outbox),
                None => return Reaction::None,
            },
        }
        self.update_torque();
        reaction
    }

    /// Handles SYNC, after the position was latched: first what is sent, then what was waiting to act.
    pub(crate) fn on_sync(&mut self, data: &[u8], now: Instant, outbox: &mut Outbox) {
        if self.faults.off_bus() || self.boots_at.is_some() || !self.accepts_sync(data, now, outbox) {
            return;
        }
        self.home(now);
        self.publish();
        self.send_tpdos(now, outbox);
        for frame in core::mem::take(&mut self.waiting).into_iter().flatten() {
            self.take_pdo(&frame, now, outbox);
        }
        self.update_torque();
    }

    /// The next instant at which the drive does something by itself.
    pub(crate) fn next_deadline(&self) -> Option<Instant> {
        if self.faults.power_lost {
            return None;
        }
        if self.boots_at.is_some() {
            return self.boots_at;
        }
        let report = self.report_due.then_some(Instant::default());
        let late = self.late.map(|(_, due)| due);
        [report, late, self.heartbeat.due(), self.master.due(), self.commands.due()].into_iter().flatten().min()
    }

    /// Does what is due by `now`.
    pub(crate) fn on_time(&mut self, now: Instant, outbox: &mut Outbox) {
        self.do_what_is_due(now, outbox);
        self.update_torque();
    }

    fn do_what_is_due(&mut self, now: Instant, outbox: &mut Outbox) {
        if self.faults.power_lost {
            return;
        }
        if let Some(boots_at) = self.boots_at {
            if boots_at <= now {
                self.finish_boot(now, outbox);
            }
            return;
        }
        if core::mem::take(&mut self.report_due) {
            self.fault(error::OVER_TEMPERATURE, ErrorRegister::TEMPERATURE, now, outbox);
        }
        if let Some((frame, _)) = self.late.take_if(|(_, due)| *due <= now) {
            self.push(frame, now, outbox);
        }
        if self.master.take_expiry(now) {
            self.on_master_lost(now, outbox);
        }
        if self.commands.take_expiry(now) && self.power.has_power() {
            self.fault(error::RPDO_TIMEOUT, ErrorRegister::COMMUNICATION, now, outbox);
        }
        if self.heartbeat.take_tick(now) {
            let heartbeat = self.node.heartbeat();
            self.send(&heartbeat, now, outbox);
        }
    }
}
