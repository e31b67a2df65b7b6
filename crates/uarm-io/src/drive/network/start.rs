//! From power-on to *Operation enabled*.

use super::blocking::Blocking;
use super::configuration::{DriveConfiguration, ReadBack, Setting};
use super::error::StartError;
use super::master::{DriveNetwork, Stage, new_counter};
use super::receive::Event;
use crate::drive::cia402::{Command, Controlword, PowerState, Statusword};
use crate::drive::objects::{self, Object};
use crate::drive::sdo::SdoError;
use crate::drive::wire::{self, DriveCommand};
use crate::link::Link;
use crate::time::{Clock, Duration, Instant};
use canopen_rs::{NmtCommand, NmtState, NodeId, Value};

/// What the drives said of themselves at start, joint 1 first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Started<const JOINTS: usize> {
    /// Each drive.
    pub drives: [DriveIdentity; JOINTS],
}

/// What a drive says of itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DriveIdentity {
    /// 1018h:01, if it has one.
    pub vendor: Option<u32>,
    /// 1018h:02, if it has one.
    pub product: Option<u32>,
    /// 1018h:03, if it has one.
    pub revision: Option<u32>,
    /// 1018h:04, if it has one.
    pub serial: Option<u32>,
    /// 6064h before power is on: counts, where the joint stands.
    pub position: i32,
}

impl<L: Link, const JOINTS: usize> DriveNetwork<L, JOINTS> {
    /// Resets, configures and enables all drives; blocks.
    ///
    /// NMT reset communication and boot-up; per drive: device type, the settings of its configuration, those of the
    /// protocol, each read back, then 608Fh and 6076h compared; NMT start; CiA 402 to *Switched on*, and when all are
    /// there, to *Operation enabled*, where brakes open; mode of operation 6061h. All torques are zero, and no SYNC is
    /// sent: the first belongs to the loop. From here on the caller owes a [`DriveNetwork::housekeeping`] at least once
    /// per master heartbeat.
    ///
    /// # Errors
    /// [`StartError`]; call [`DriveNetwork::stop`] then, since some drives may be enabled.
    pub fn start<C: Clock>(&mut self, clock: &C) -> Result<Started<JOINTS>, StartError<L::Error>> {
        self.sync_counter = new_counter(&self.configuration);
        Blocking::new(self, clock).start()
    }
}

type Outcome<T, L> = Result<T, StartError<<L as Link>::Error>>;

impl<L: Link, C: Clock, const JOINTS: usize> Blocking<'_, L, C, JOINTS> {
    /// See [`DriveNetwork::start`].
    pub(super) fn start(&mut self) -> Outcome<Started<JOINTS>, L> {
        self.network.drain()?;
        self.boot()?;
        let mut drives = [DriveIdentity::default(); JOINTS];
        // Taken by position, since `self` is borrowed while a drive is set up.
        for (joint, identity) in drives.iter_mut().enumerate() {
            let Some(drive) = self.network.configuration.drives().get(joint).cloned() else { break };
            *identity = self.set_up(&drive)?;
        }
        self.operate()?;
        for wanted in [PowerState::SwitchedOn, PowerState::OperationEnabled] {
            for node in self.nodes() {
                self.bring_to(node, wanted)?;
            }
            self.unalarmed()?;
        }
        for node in self.nodes() {
            let expected = Value::Integer8(objects::CYCLIC_SYNCHRONOUS_TORQUE);
            self.compare(node, &objects::MODE_OF_OPERATION_DISPLAY, expected)?;
        }
        self.unalarmed()?;
        self.forget_feedback();
        Ok(Started { drives })
    }

    /// Resets all drives and waits for their boot-up messages.
    fn boot(&mut self) -> Outcome<(), L> {
        for node in &mut self.network.nodes {
            node.health.nmt_state = None;
            node.stage = Stage::Unknown;
        }
        self.network.disturbance = None;
        for node in self.nodes() {
            self.network.send(&wire::nmt_frame(NmtCommand::ResetCommunication, node))?;
        }
        let waited = self.network.configuration.timeouts.boot;
        let deadline = self.clock.now() + waited;
        for node in self.nodes() {
            if !self.booted(node, deadline)? {
                return Err(StartError::NoBootUp { node: node.raw(), waited });
            }
        }
        Ok(())
    }

    /// Waits for the boot-up message of `node`; false if `deadline` passes first. A heartbeat does not count: it may have
    /// been under way when the drive was reset, and the boot-up message would then come after the first settings.
    fn booted(&mut self, node: NodeId, deadline: Instant) -> Outcome<bool, L> {
        if self.network.node_mut(node).is_some_and(|node| node.stage == Stage::Booted) {
            return Ok(true);
        }
        let seen =
            self.wait(deadline, |event| (*event == Event::Heartbeat(node, NmtState::Initialising)).then_some(()))?;
        Ok(seen.is_some())
    }

    /// Writes and checks everything in one drive.
    fn set_up(&mut self, drive: &DriveConfiguration) -> Outcome<DriveIdentity, L> {
        let node = drive.node;
        if let Value::Unsigned32(device_type) = self.read(node, &objects::DEVICE_TYPE)? {
            let [low, high, ..] = device_type.to_le_bytes();
            let profile = u16::from_le_bytes([low, high]);
            if profile != objects::DEVICE_PROFILE_CIA402 {
                return Err(StartError::NotADrive { node: node.raw(), profile });
            }
        }
        for setting in &drive.settings {
            self.set(node, setting)?;
        }
        for setting in self.network.configuration.protocol_settings(node) {
            self.set(node, &setting)?;
        }
        self.compare(node, &objects::ENCODER_INCREMENTS, Value::Unsigned32(drive.encoder_increments))?;
        self.compare(node, &objects::ENCODER_REVOLUTIONS, Value::Unsigned32(drive.encoder_revolutions))?;
        let rated_torque = drive.rated_torque.millinewton_metres();
        self.compare(node, &objects::RATED_TORQUE, Value::Unsigned32(rated_torque))?;
        self.identify(node)
    }

    fn set(&mut self, node: NodeId, setting: &Setting) -> Outcome<(), L> {
        self.write(node, setting)?;
        if setting.read_back == ReadBack::Skipped {
            return Ok(());
        }
        let Setting { address, value: written, .. } = *setting;
        let found = self.read_at(node, address, written.data_type())?;
        if setting.agrees(found) {
            Ok(())
        } else {
            Err(StartError::ReadBack { node: node.raw(), object: address, written, found })
        }
    }

    fn compare(&mut self, node: NodeId, object: &Object, expected: Value) -> Outcome<(), L> {
        let found = self.read(node, object)?;
        if found == expected {
            Ok(())
        } else {
            Err(StartError::Mismatch { node: node.raw(), object: object.address(), expected, found })
        }
    }

    fn identify(&mut self, node: NodeId) -> Outcome<DriveIdentity, L> {
        let position = match self.read(node, &objects::POSITION_ACTUAL)? {
            Value::Integer32(position) => position,
            _ => 0,
        };
        Ok(DriveIdentity {
            vendor: self.optional(node, &objects::VENDOR_ID)?,
            product: self.optional(node, &objects::PRODUCT_CODE)?,
            revision: self.optional(node, &objects::REVISION_NUMBER)?,
            serial: self.optional(node, &objects::SERIAL_NUMBER)?,
            position,
        })
    }

    /// A number that a drive need not have.
    fn optional(&mut self, node: NodeId, object: &Object) -> Outcome<Option<u32>, L> {
        match self.read(node, object) {
            Ok(Value::Unsigned32(value)) => Ok(Some(value)),
            Ok(_) | Err(SdoError::Abort { .. }) => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    /// NMT start of all drives.
    fn operate(&mut self) -> Outcome<(), L> {
        for node in self.nodes() {
            self.network.send(&wire::nmt_frame(NmtCommand::StartRemoteNode, node))?;
        }
        let deadline = self.clock.now() + self.network.configuration.timeouts.nmt;
        for node in self.nodes() {
            if !self.reports(node, deadline, |state| state == NmtState::Operational)? {
                return Err(StartError::NotOperational { node: node.raw(), found: self.nmt_state(node) });
            }
        }
        Ok(())
    }

    /// Brings a drive to a state of CiA 402, one command at a time, torque 0.
    fn bring_to(&mut self, node: NodeId, wanted: PowerState) -> Outcome<(), L> {
        let waited = self.network.configuration.timeouts.power;
        let deadline = self.clock.now() + waited;
        let mut last = Controlword::default();
        loop {
            let found = self.statusword(node)?;
            if found.state() == Some(wanted) {
                return Ok(());
            }
            if self.clock.now() >= deadline {
                return Err(self.not_reached(node, wanted, found, waited));
            }
            if let Some(command) = found.state().and_then(|state| towards(state, wanted)) {
                last = after(last, command);
                self.network.command(node, &DriveCommand { controlword: last, target_torque: 0 })?;
            }
            self.pause(self.network.configuration.timeouts.power_poll)?;
        }
    }

    fn not_reached(
        &self,
        node: NodeId,
        expected: PowerState,
        found: Statusword,
        waited: Duration,
    ) -> StartError<L::Error> {
        let emergency = self.network.nodes.iter().find(|other| other.id == node).and_then(|n| n.health.last_emergency);
        StartError::NotReached { node: node.raw(), expected, found, waited, emergency }
    }

    /// An error if the bus was disturbed, or for an emergency of a drive since it was addressed.
    fn unalarmed(&mut self) -> Outcome<(), L> {
        self.undisturbed().map_err(StartError::Disturbed)?;
        match self.network.take_alarm() {
            Some((node, message)) => Err(StartError::Emergency { node, message }),
            None => Ok(()),
        }
    }

    /// Feedback before the first SYNC is none.
    fn forget_feedback(&mut self) {
        for node in &mut self.network.nodes {
            node.fresh = None;
            node.missed = false;
        }
    }
}

/// The command that leads from `state` towards `wanted`, which is *Switched on* or *Operation enabled*.
fn towards(state: PowerState, wanted: PowerState) -> Option<Command> {
    match (state, wanted) {
        (PowerState::OperationEnabled, PowerState::SwitchedOn) => Some(Command::SwitchOn),
        (state, _) => state.command_towards_operation(),
    }
}

/// The controlword for `command` after `last`: a fault reset needs the bit to fall before it rises again.
fn after(last: Controlword, command: Command) -> Controlword {
    let reset = Controlword::of(Command::FaultReset);
    if command == Command::FaultReset && last == reset {
        Controlword::of(Command::DisableVoltage)
    } else {
        Controlword::of(command)
    }
}
