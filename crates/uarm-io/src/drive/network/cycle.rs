//! What happens in each cycle: SYNC out, feedback in, torques out, supervision.

use super::configuration::{EmergencyReaction, IgnoredTargetReaction};
use super::error::CycleError;
use super::master::{DriveNetwork, NO_DEADLINE, Node};
use crate::drive::cia402::{Command, Controlword, PowerState, Statusword};
use crate::drive::wire::{self, DriveCommand, EmergencyMessage, SyncCounter};
use crate::drive::wishes::Operation;
use crate::link::Link;
use crate::time::{Duration, Instant};
use canopen_rs::NmtState;

/// What the drives reported for one SYNC, joint 1 first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Feedback<const JOINTS: usize> {
    /// When the SYNC was handed to the link: the instant that the positions belong to.
    pub sync_at: Instant,
    /// Feedback latency: from there to the last drive's feedback.
    pub latency: Duration,
    /// 6064h, counts; nothing of a drive whose feedback did not come by the deadline, or was no feedback.
    pub positions: [Option<i32>; JOINTS],
    /// 6041h; of a drive whose feedback is missing, the last one that came.
    pub statuswords: [Statusword; JOINTS],
}

/// Answers that may be under way from one drive: one for this SYNC, and late ones for the two before it. More are not
/// remembered, so that a drive that missed some SYNCs cannot lend its answers to a second one with its node id for long.
const MOST_ANSWERS_OWED: u8 = 3;

impl<L: Link, const JOINTS: usize> DriveNetwork<L, JOINTS> {
    /// Sends the SYNC, after taking in what is left of earlier cycles, so that late feedback cannot pass for that of
    /// this SYNC. Returns when it was handed to the link.
    ///
    /// # Errors
    /// [`CycleError::Link`], [`CycleError::Disturbed`].
    pub fn sync(&mut self) -> Result<Instant, CycleError<L::Error>> {
        self.drain()?;
        self.undisturbed().map_err(CycleError::Disturbed)?;
        self.deadline = NO_DEADLINE;
        for node in &mut self.nodes {
            node.fresh = None;
            node.missed = false;
            if !core::mem::take(&mut node.torque_is_fresh) {
                node.health.torque = None;
            }
            node.owed = Some(node.owed.map_or(1, |owed| owed.saturating_add(1).min(MOST_ANSWERS_OWED)));
        }
        let frame = match self.sync_counter.as_mut().and_then(SyncCounter::advance) {
            Some(count) => wire::sync_frame(count),
            None => wire::plain_sync_frame(),
        };
        self.sync_at = self.send(&frame)?;
        self.traffic.syncs += 1;
        Ok(self.sync_at)
    }

    /// Takes in the drives' feedback, until all of it is here or `deadline` passes, and supervises the drives. What comes later
    /// is counted as stale, in this cycle and the next.
    ///
    /// A drive whose feedback for the SYNC before is still under way may answer twice: both answers are waited for, and the
    /// later one is taken.
    ///
    /// # Errors
    /// The first of: [`CycleError::Link`]; [`CycleError::Disturbed`]; an emergency, if the configuration says so; a drive that is not in
    /// *Operation enabled*; a drive that ignores its target torque.
    pub fn collect(&mut self, deadline: Instant) -> Result<Feedback<JOINTS>, CycleError<L::Error>> {
        self.deadline = deadline;
        while self.disturbance.is_none() && self.nodes.iter().any(Node::is_awaited) {
            match self.link.receive(deadline)? {
                Some(received) => {
                    self.absorb(&received);
                    // A bus full of other traffic must not hold the loop beyond its deadline.
                    if received.at > deadline {
                        break;
                    }
                }
                None => break,
            }
        }
        self.undisturbed().map_err(CycleError::Disturbed)?;
        self.alarms()?;
        self.enabled()?;
        self.following()?;
        Ok(self.feedback())
    }

    /// Sends the torques, per mille of each drive's rated torque, joint 1 first. Returns when the last was handed to
    /// the link. A drive whose frame was not taken does not keep the others from theirs.
    ///
    /// # Errors
    /// [`CycleError::Link`] with the first failure.
    pub fn send_torques(&mut self, per_mille: [i16; JOINTS]) -> Result<Instant, CycleError<L::Error>> {
        let controlword = Controlword::of(Command::EnableOperation);
        self.send_commands(per_mille.map(|target_torque| DriveCommand { controlword, target_torque }))
    }

    /// Sends controlwords without torque, joint 1 first, to drives in another mode than cyclic synchronous torque; otherwise as
    /// [`send_torques`](Self::send_torques).
    ///
    /// # Errors
    /// [`CycleError::Link`] with the first failure.
    pub fn send_controlwords(&mut self, words: [Controlword; JOINTS]) -> Result<Instant, CycleError<L::Error>> {
        self.send_commands(words.map(|controlword| DriveCommand { controlword, target_torque: 0 }))
    }

    fn send_commands(&mut self, commands: [DriveCommand; JOINTS]) -> Result<Instant, CycleError<L::Error>> {
        let ids = self.nodes.map(|node| node.id);
        let mut outcome = Ok(self.sync_at);
        for (id, command) in ids.into_iter().zip(commands) {
            let sent = self.command(id, &command);
            outcome = match (outcome, sent) {
                (Ok(_), sent) => sent,
                (failed, _) => failed,
            };
        }
        Ok(outcome?)
    }

    /// The torque actual values 6077h, per mille of each drive's rated torque, joint 1 first: those for the last SYNC, or for the
    /// one before while they are on their way. `None` for a drive that sends none.
    pub fn torque_actual(&self) -> [Option<i16>; JOINTS] {
        self.nodes.map(|node| node.health.torque)
    }

    /// What is not bound to the SYNC, once a cycle: takes in waiting frames, sends the master's heartbeat if it is due,
    /// supervises heartbeats, NMT states and emergencies, and asks for supply voltages and temperatures.
    ///
    /// # Errors
    /// [`CycleError::Link`], [`CycleError::Disturbed`], [`CycleError::Emergency`], [`CycleError::NotOperational`],
    /// [`CycleError::Lost`], [`CycleError::Reading`], [`CycleError::NoReading`].
    pub fn housekeeping(&mut self, now: Instant) -> Result<(), CycleError<L::Error>> {
        self.produce_heartbeat(now)?;
        self.drain()?;
        self.undisturbed().map_err(CycleError::Disturbed)?;
        self.alarms()?;
        let limit = self.configuration.heartbeats.drive_timeout();
        for Node { health, .. } in &self.nodes {
            if let Some(found) = health.nmt_state.filter(|state| *state != NmtState::Operational) {
                return Err(CycleError::NotOperational { node: health.node, found });
            }
            let silence = now.since(health.last_heartbeat_at.unwrap_or_default());
            if silence > limit {
                return Err(CycleError::Lost { node: health.node, silence, limit });
            }
        }
        self.inquire(now)
    }

    /// The first emergency that was not reported yet.
    fn alarms(&mut self) -> Result<(), CycleError<L::Error>> {
        match self.take_alarm() {
            Some((node, message)) => Err(CycleError::Emergency { node, message }),
            None => Ok(()),
        }
    }

    /// The first emergency that was not reported yet and has to be, and the node id of the drive that sent it.
    pub(super) fn take_alarm(&mut self) -> Option<(u8, EmergencyMessage)> {
        if self.configuration.emergency_reaction == EmergencyReaction::Record {
            return None;
        }
        self.nodes.iter_mut().find_map(|node| Some((node.health.node, node.alarm.take()?)))
    }

    /// An error for the first drive whose feedback says that it is not in *Operation enabled*.
    fn enabled(&self) -> Result<(), CycleError<L::Error>> {
        for Node { fresh, health, .. } in &self.nodes {
            if let Some(found) = fresh.map(|feedback| feedback.statusword)
                && found.state() != Some(PowerState::OperationEnabled)
            {
                return Err(CycleError::NotEnabled { node: health.node, found, emergency: health.last_emergency });
            }
        }
        Ok(())
    }

    /// An error for the first drive that followed its target torque in this run and says now that it does not.
    fn following(&mut self) -> Result<(), CycleError<L::Error>> {
        if self.configuration.ignored_target_reaction == IgnoredTargetReaction::Record {
            return Ok(());
        }
        let drives = self.configuration.drives().iter();
        for (Node { fresh, health, has_followed, .. }, drive) in self.nodes.iter_mut().zip(drives) {
            // The bit means something else in other modes.
            if drive.operation != Operation::CyclicTorque {
                continue;
            }
            let Some(found) = fresh.map(|feedback| feedback.statusword) else { continue };
            let follows = found.contains(Statusword::FOLLOWS_TARGET);
            if *has_followed && !follows {
                return Err(CycleError::TargetIgnored { node: health.node, found });
            }
            *has_followed |= follows;
        }
        Ok(())
    }

    /// The feedback of the drives; counts what is missing.
    fn feedback(&mut self) -> Feedback<JOINTS> {
        for node in &mut self.nodes {
            node.missed = node.fresh.is_none();
            node.late = node.missed;
            node.health.missed_feedbacks += u64::from(node.missed);
        }
        let fresh = self.nodes.iter().filter(|node| node.fresh.is_some());
        Feedback {
            sync_at: self.sync_at,
            latency: fresh.map(|node| node.health.latency).max().unwrap_or_default(),
            positions: self.nodes.map(|node| node.fresh.map(|feedback| feedback.position)),
            statuswords: self.nodes.map(|node| node.health.statusword),
        }
    }
}
