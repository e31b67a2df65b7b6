//! From power-on to *Operation enabled*.

use super::blocking::Blocking;
use super::error::StartError;
use super::master::{DriveNetwork, LastDefence, Stage};
use super::receive::Event;
use crate::drive::cia402::{Command, Controlword, PowerState, Statusword};
use crate::drive::identity::DriveIdentity;
use crate::drive::objects;
use crate::drive::plan::Findings;
use crate::drive::readings::{Found, Quantity, Verdict};
use crate::drive::wire::{self, DriveCommand, SyncCounter};
use crate::drive::wishes::{DriveConfiguration, Protocol, SyncPayload, Watchdog, WatchdogTest};
use crate::link::Link;
use crate::time::{Clock, Duration, Instant};
use canopen_rs::{NmtCommand, NmtState, NodeId, Value};

/// What the drives said of themselves at start, joint 1 first.
#[derive(Clone, Debug, PartialEq)]
pub struct Started<const JOINTS: usize> {
    /// What each drive says of itself.
    pub drives: [DriveIdentity; JOINTS],
    /// 6064h before power is on: counts, where the joints stand.
    pub positions: [i32; JOINTS],
    /// What was found in each drive.
    pub findings: [Findings; JOINTS],
    /// The SYNC that all drives take.
    pub sync_payload: SyncPayload,
}

impl<L: Link, const JOINTS: usize> DriveNetwork<L, JOINTS> {
    /// Sets all drives up and enables them: [`configure`](Self::configure), then [`enable`](Self::enable).
    ///
    /// # Errors
    /// [`StartError`]; call [`DriveNetwork::stop`] then, since some drives may be enabled.
    pub fn start<C: Clock>(&mut self, clock: &C) -> Result<Started<JOINTS>, StartError<L::Error>> {
        let started = self.configure(clock)?;
        self.enable(clock)?;
        Ok(started)
    }

    /// Resets and configures all drives, without power; blocks.
    ///
    /// Listening for another master, with which nothing is sent; power off, for drives that were left enabled; NMT reset
    /// communication and boot-up; each drive is read, judged by [`plan`](mod@crate::drive::plan), written where it
    /// differs, and read again.
    ///
    /// # Errors
    /// [`StartError`]; call [`DriveNetwork::stop`] then.
    pub fn configure<C: Clock>(&mut self, clock: &C) -> Result<Started<JOINTS>, StartError<L::Error>> {
        let configured = Blocking::new(self, clock).configure_all();
        configured.map_err(|error| self.cause(error))
    }

    /// Enables drives that are configured; blocks.
    ///
    /// NMT start; CiA 402 to *Switched on* and mode of operation 6061h; when all are there, to *Operation enabled*, where
    /// brakes open, and 6061h again. All torques are zero, and no SYNC is sent: the first belongs to the loop. From here on
    /// the caller owes a [`DriveNetwork::housekeeping`] at least once per master heartbeat.
    ///
    /// # Errors
    /// [`StartError`]; call [`DriveNetwork::stop`] then, since some drives may be enabled.
    pub fn enable<C: Clock>(&mut self, clock: &C) -> Result<(), StartError<L::Error>> {
        let enabled = Blocking::new(self, clock).enable();
        enabled.map_err(|error| self.cause(error))
    }

    /// 6064h of all drives after `wait`, counts; blocks.
    ///
    /// # Errors
    /// [`StartError`]; call [`DriveNetwork::stop`] then.
    pub fn positions_after<C: Clock>(
        &mut self,
        wait: Duration,
        clock: &C,
    ) -> Result<[i32; JOINTS], StartError<L::Error>> {
        let read = Blocking::new(self, clock).positions_after(wait);
        read.map_err(|error| self.cause(error))
    }

    /// A disturbance ends all waiting, and so is the cause of whatever came of that.
    fn cause(&self, error: StartError<L::Error>) -> StartError<L::Error> {
        match (error, self.disturbance) {
            (StartError::Link(error), _) => StartError::Link(error),
            (_, Some(disturbance)) => StartError::Disturbed(disturbance),
            (error, None) => error,
        }
    }
}

type Outcome<T, L> = Result<T, StartError<<L as Link>::Error>>;

impl<L: Link, C: Clock, const JOINTS: usize> Blocking<'_, L, C, JOINTS> {
    /// See [`DriveNetwork::configure`].
    fn configure_all(&mut self) -> Outcome<Started<JOINTS>, L> {
        self.begin();
        self.listen()?;
        self.command_power_off()?;
        self.boot()?;
        for node in self.nodes() {
            self.check_profile(node)?;
            self.switch_off(node)?;
        }
        let sync_payload = self.choose_sync()?;
        match self.set_up_all(sync_payload) {
            Err(error) if self.can_do_without_counter(&error) => self.set_up_all(SyncPayload::Empty),
            outcome => outcome,
        }
    }

    /// Sets all drives up for this SYNC.
    fn set_up_all(&mut self, sync_payload: SyncPayload) -> Outcome<Started<JOINTS>, L> {
        self.network.sync_counter = SyncCounter::new(sync_payload.overflow()).ok();
        let protocol = self.network.configuration.protocol(sync_payload);
        let mut positions = [0; JOINTS];
        let mut findings = core::array::from_fn(|_| Findings::new());
        // Taken by position, since `self` is borrowed while a drive is set up.
        for (joint, (position, found)) in positions.iter_mut().zip(&mut findings).enumerate() {
            let Some(drive) = self.network.configuration.drives().get(joint).cloned() else { break };
            (*position, *found) = self.set_up(&drive, &protocol)?;
            self.check_readings(&drive)?;
        }
        Ok(Started { drives: self.network.identities(), positions, findings, sync_payload })
    }

    /// See [`DriveNetwork::positions_after`].
    fn positions_after(&mut self, wait: Duration) -> Outcome<[i32; JOINTS], L> {
        self.pause(wait)?;
        self.unalarmed()?;
        let mut positions = [0; JOINTS];
        for (node, position) in self.nodes().into_iter().zip(&mut positions) {
            if let Value::Integer32(counts) = self.read(node, &objects::POSITION_ACTUAL)? {
                *position = counts;
            }
        }
        Ok(positions)
    }

    /// See [`DriveNetwork::enable`].
    fn enable(&mut self) -> Outcome<(), L> {
        self.operate()?;
        self.power_on()?;
        self.forget_feedback();
        Ok(())
    }

    /// All drives to *Operation enabled*, in the mode that was written, each step by all before the next.
    fn power_on(&mut self) -> Outcome<(), L> {
        for wanted in [PowerState::SwitchedOn, PowerState::OperationEnabled] {
            for node in self.nodes() {
                self.bring_to(node, wanted)?;
            }
            self.unalarmed()?;
            for node in self.nodes() {
                self.check_mode(node)?;
            }
            if wanted == PowerState::SwitchedOn {
                self.try_watchdogs()?;
            }
            self.unalarmed()?;
        }
        Ok(())
    }

    /// Forgets the last run.
    fn begin(&mut self) {
        self.network.disturbance = None;
        self.network.forget_readings();
        for node in &mut self.network.nodes {
            node.stage = Stage::Unknown;
            node.owed = None;
            node.sdo_owed = 0;
            node.sdo_late = 0;
            node.identity = DriveIdentity::default();
        }
    }

    /// Drives that somebody left enabled lose their power with the first frames, as far as they hear them.
    fn command_power_off(&mut self) -> Outcome<(), L> {
        for node in self.nodes() {
            self.network.command(node, &DriveCommand::default())?;
        }
        Ok(())
    }

    /// A drive may keep its power through a reset of its communication, and may not have listened to RPDO1 before it.
    fn switch_off(&mut self, node: NodeId) -> Outcome<(), L> {
        let waited = self.network.configuration.timeouts.power;
        let deadline = self.clock.now() + waited;
        loop {
            let found = self.statusword(node)?;
            if !found.state().is_some_and(PowerState::has_power) {
                return Ok(());
            }
            if self.clock.now() >= deadline {
                return Err(self.not_reached(node, PowerState::SwitchOnDisabled, found, waited));
            }
            self.command_by_sdo(node, Controlword::of(Command::DisableVoltage))?;
            self.pause(self.network.configuration.timeouts.power_poll)?;
        }
    }

    /// Resets all drives and waits for their boot-up messages.
    fn boot(&mut self) -> Outcome<(), L> {
        for node in &mut self.network.nodes {
            node.health.nmt_state = None;
            node.health.last_heartbeat_at = None;
            node.stage = Stage::Unknown;
            node.commanded_at = None;
            node.last_defence = LastDefence::None;
        }
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

    /// Reads, writes and checks everything in one drive. Returns where its joint stands, counts, and what was found.
    fn set_up(&mut self, drive: &DriveConfiguration, protocol: &Protocol) -> Outcome<(i32, Findings), L> {
        let (survey, plan) = self.configure(drive, protocol)?;
        (self.network.learned)(drive.node.raw(), &survey, &plan.findings);
        if let Some(node) = self.network.node_mut(drive.node) {
            node.identity = survey.identity();
        }
        let position = survey.number(&objects::POSITION_ACTUAL).and_then(|position| i32::try_from(position).ok());
        Ok((position.unwrap_or_default(), plan.findings))
    }

    /// Refuses a drive with a supply voltage or temperature with which a run would end.
    fn check_readings(&mut self, drive: &DriveConfiguration) -> Outcome<(), L> {
        for (reading, quantity) in drive.readings.iter().zip(Quantity::ALL) {
            let Some(reading) = reading else { continue };
            let value = reading.value(self.read_at(drive.node, reading.object, reading.data_type)?);
            let value = value.unwrap_or(f64::NAN);
            if reading.limits.verdict(value) == Verdict::Stop {
                let found = Found { quantity, value, allowed: reading.limits.stop() };
                return Err(StartError::Reading { node: drive.node.raw(), found });
            }
        }
        Ok(())
    }

    /// Refuses what is no drive, before anything else is asked of it.
    fn check_profile(&mut self, node: NodeId) -> Outcome<(), L> {
        if let Value::Unsigned32(device_type) = self.read(node, &objects::DEVICE_TYPE)? {
            let [low, high, ..] = device_type.to_le_bytes();
            let profile = u16::from_le_bytes([low, high]);
            if profile != objects::DEVICE_PROFILE_CIA402 {
                return Err(StartError::NotADrive { node: node.raw(), profile });
            }
        }
        Ok(())
    }

    /// Waits until the drive shows the mode that was written.
    fn check_mode(&mut self, node: NodeId) -> Outcome<(), L> {
        let drives = self.network.configuration.drives();
        let operation = drives.iter().find(|drive| drive.node == node).map(|drive| drive.operation);
        let expected = Value::Integer8(operation.unwrap_or_default().mode());
        let object = &objects::MODE_OF_OPERATION_DISPLAY;
        let deadline = self.clock.now() + self.network.configuration.timeouts.nmt;
        loop {
            let found = self.read(node, object)?;
            if found == expected {
                return Ok(());
            }
            if self.clock.now() >= deadline {
                return Err(StartError::Mismatch { node: node.raw(), object: object.address(), expected, found });
            }
            self.pause(self.network.configuration.timeouts.power_poll)?;
        }
    }

    /// Lets the commands of each drive that watches them fail to come, once, and sees it react. Brakes are closed.
    fn try_watchdogs(&mut self) -> Outcome<(), L> {
        for joint in 0..JOINTS {
            let Some(drive) = self.network.configuration.drives().get(joint) else { break };
            let node = drive.node;
            if let Watchdog::RpdoTimeout { milliseconds, test: WatchdogTest::AtStart } = drive.watchdog {
                self.try_watchdog(node, Duration::from_millis(milliseconds.into()))?;
                self.bring_to(node, PowerState::SwitchedOn)?;
                // The emergency of this fault was asked for.
                if let Some(node) = self.network.node_mut(node) {
                    node.alarm = None;
                }
            }
        }
        Ok(())
    }

    fn try_watchdog(&mut self, node: NodeId, timeout: Duration) -> Outcome<(), L> {
        /// A drive may look at its timers as seldom as this.
        const MARGIN: Duration = Duration::from_millis(100);
        let waited = timeout * 2 + MARGIN;
        let deadline = self.clock.now() + waited;
        if let Some(node) = self.network.node_mut(node) {
            node.commanded_at = None;
        }
        loop {
            if self.statusword(node)?.state() != Some(PowerState::SwitchedOn) {
                return Ok(());
            }
            if self.clock.now() >= deadline {
                return Err(StartError::WatchdogSilent { node: node.raw(), waited });
            }
            self.pause(self.network.configuration.timeouts.power_poll)?;
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
                if !self.obeys_pdos(node) {
                    self.command_by_sdo(node, last)?;
                }
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
            node.has_followed = false;
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
