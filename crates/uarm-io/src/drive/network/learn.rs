//! Reading a drive before it is written to, and writing what the plan says.

use super::blocking::Blocking;
use super::error::StartError;
use super::master::LastDefence;
use crate::drive::objects;
use crate::drive::plan::{self, Plan};
use crate::drive::sdo::{DriveObjects, SdoError};
use crate::drive::survey::{ObjectSource, Survey};
use crate::drive::wire;
use crate::drive::wishes::{
    AbortOption, DriveConfiguration, Protocol, ReadBack, Setting, SyncCounterChoice, SyncPayload, Watchdog,
};
use crate::link::Link;
use crate::time::Clock;
use canopen_rs::{NodeId, Value};

impl<L: Link, C: Clock, const JOINTS: usize> Blocking<'_, L, C, JOINTS> {
    fn objects_of(&mut self, node: NodeId) -> DriveObjects<'_, Self> {
        self.address(node);
        let patience = self.patience();
        DriveObjects::new(self, patience, node)
    }

    /// What is to be known of a drive.
    fn survey(&mut self, drive: &DriveConfiguration) -> Result<Survey, SdoError<L::Error>> {
        let mut objects = self.objects_of(drive.node);
        plan::survey_of(&mut objects, drive)
    }

    /// The SYNC that all drives take.
    pub(super) fn choose_sync(&mut self) -> Result<SyncPayload, SdoError<L::Error>> {
        let mut all_can_count = true;
        for node in self.nodes() {
            all_can_count &= self.objects_of(node).ask(&objects::SYNC_COUNTER_OVERFLOW)?.answer.is_there();
        }
        Ok(self.network.configuration.sync_counter.payload(all_can_count))
    }

    /// True if a drive did not take the SYNC's counter, which it tells only when it is written to, and the robot file leaves the
    /// choice to the drives.
    pub(super) fn can_do_without_counter(&self, error: &StartError<L::Error>) -> bool {
        let object = match error {
            StartError::Refused { finding, .. } => finding.object,
            StartError::Sdo(SdoError::Abort { object, .. }) | StartError::ReadBack { object, .. } => *object,
            _ => return false,
        };
        let is_chosen = self.network.configuration.sync_counter == SyncCounterChoice::Auto;
        is_chosen && self.network.sync_counter.is_some() && object == objects::SYNC_COUNTER_OVERFLOW.address()
    }

    /// Reads a drive, writes what differs, and reads it again: what then is not as it should be is an error.
    pub(super) fn configure(
        &mut self,
        drive: &DriveConfiguration,
        protocol: &Protocol,
    ) -> Result<(Survey, Plan), StartError<L::Error>> {
        let node = drive.node.raw();
        let before = self.survey(drive)?;
        let planned = accepted(node, plan::plan(&before, drive, protocol))?;
        for setting in &planned.settings {
            self.set(drive.node, setting).map_err(|error| explained(error, &before, drive, protocol))?;
        }
        if planned.settings.is_empty() {
            self.note_defence(drive, &before, protocol);
            return Ok((before, planned));
        }
        // One object may have changed another, such as a scale factor.
        let after = self.survey(drive)?;
        let missing = accepted(node, plan::plan(&after, drive, protocol))?;
        self.kept(drive.node, &planned.settings, &missing.settings)?;
        self.note_defence(drive, &after, protocol);
        Ok((after, missing))
    }

    /// An error if an object that was written, or that read as wanted before, was changed by what was written after it; `missing` is
    /// what would be written now.
    fn kept(&mut self, node: NodeId, written: &[Setting], missing: &[Setting]) -> Result<(), StartError<L::Error>> {
        for Setting { address, .. } in missing {
            // The robot file may set what the protocol sets otherwise: the last one counts.
            let is_same = |setting: &&Setting| setting.address == *address;
            let last = written.iter().rev().find(is_same).or(missing.iter().rev().find(is_same));
            if let Some(last) = last
                && let Some(found) = self.differs(node, last)?
            {
                return Err(StartError::Undone { node: node.raw(), object: *address, written: last.value, found });
            }
        }
        Ok(())
    }

    /// Writes an object and reads it back.
    fn set(&mut self, node: NodeId, setting: &Setting) -> Result<(), StartError<L::Error>> {
        self.write(node, setting)?;
        match self.differs(node, setting)? {
            None => Ok(()),
            Some(found) => {
                let Setting { address: object, value: written, .. } = *setting;
                Err(StartError::ReadBack { node: node.raw(), object, written, found })
            }
        }
    }

    /// What an object reads instead of what was written to it; `None` if it is that.
    fn differs(&mut self, node: NodeId, setting: &Setting) -> Result<Option<Value>, SdoError<L::Error>> {
        if setting.read_back == ReadBack::Skipped {
            return Ok(None);
        }
        let found = self.read_at(node, setting.address, setting.value.data_type())?;
        Ok((!setting.agrees(found)).then_some(found))
    }

    /// Records what makes the drive brake by itself, from what it says after it was written.
    fn note_defence(&mut self, drive: &DriveConfiguration, survey: &Survey, protocol: &Protocol) {
        let entry = wire::consumer_heartbeat_entry(protocol.heartbeats.master_timeout_milliseconds());
        let listens = survey.number(&objects::CONSUMER_HEARTBEAT_TIME) == Some(entry.into());
        let reacts = drive.abort_option == AbortOption::Explained
            || survey.number(&objects::ABORT_CONNECTION_OPTION).is_some_and(|option| option != 0);
        let defence = match drive.watchdog {
            Watchdog::RpdoTimeout { .. } => LastDefence::RpdoTimeout,
            Watchdog::Heartbeat if listens && reacts => LastDefence::Heartbeat,
            Watchdog::Heartbeat => LastDefence::None,
        };
        if let Some(node) = self.network.node_mut(drive.node) {
            node.last_defence = defence;
        }
    }
}

/// SDO abort code: attempt to write a read-only object.
const READ_ONLY: u32 = 0x0601_0002;

/// A drive tells only when it is written to that it cannot be: what the plan says of such a drive.
fn explained<E>(
    error: StartError<E>,
    survey: &Survey,
    drive: &DriveConfiguration,
    protocol: &Protocol,
) -> StartError<E> {
    let StartError::Sdo(SdoError::Abort { node, object, code: READ_ONLY }) = error else { return error };
    let known = survey.clone().with_read_only(object);
    match plan::plan(&known, drive, protocol).refusal() {
        Some(finding) => StartError::Refused { node, finding: *finding },
        None => error,
    }
}

/// The plan, if nothing in it forbids a start.
fn accepted<E>(node: u8, plan: Plan) -> Result<Plan, StartError<E>> {
    match plan.refusal() {
        Some(finding) => Err(StartError::Refused { node, finding: *finding }),
        None => Ok(plan),
    }
}
