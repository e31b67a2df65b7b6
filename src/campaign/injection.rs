//! A link on which a fault happens, and which watches the wire and the joints.

use std::cell::RefCell;
use std::rc::Rc;

use nalgebra::SVector;
use uarm_io::drive::NodeId;
use uarm_io::drive::wire::{
    Channel, DriveCommand, heartbeat_frame, master_heartbeat_frame, nmt_frame, plain_sync_frame,
};
use uarm_io::drive::{NmtCommand, NmtState};
use uarm_io::embedded_can::StandardId;
use uarm_io::frame::Frame;
use uarm_io::link::{Link, LinkError, LinkErrorKind, LinkHealth, Received};
use uarm_io::time::{Clock, Duration, Instant};
use uarm_loop::stop_request::StopRequest;
use uarm_sim::{Brake, EmulatedRobot, InProcessError, InProcessLink, Joint, Plant, VirtualClock};

use super::fault::{Fault, ForeignFault};
use crate::dimensions::JOINTS;
use crate::simulated_plant::SimulatedPlant;

/// The link to the simulated robot.
pub type ToRobot = InProcessLink<EmulatedRobot<SimulatedPlant>, VirtualClock>;

/// What goes wrong with the link.
#[derive(Debug, thiserror::Error)]
pub enum InjectedError {
    /// The link itself.
    #[error(transparent)]
    InProcess(#[from] InProcessError),
    /// The fault of the trial.
    #[error("the interface does not take the frame")]
    Refused,
}

impl LinkError for InjectedError {
    fn kind(&self) -> LinkErrorKind {
        match self {
            Self::InProcess(error) => error.kind(),
            Self::Refused => LinkErrorKind::QueueFull,
        }
    }
}

/// What was seen of a run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Seen {
    /// SYNCs of this controller.
    pub syncs: u64,
    /// When the fault happened.
    pub fault_at: Option<Instant>,
    /// Since when all brakes have been closed, after the fault.
    pub braked_at: Option<Instant>,
    /// The largest torque either way that each drive was sent, per mille.
    pub largest_torque: [u16; JOINTS],
    /// The largest change of it from one frame to the next, but to zero.
    pub largest_step: [u16; JOINTS],
    /// The most torque that each drive may be sent, per mille.
    pub torque_limit: [u16; JOINTS],
    /// The longest time for which each drive was sent that without a break, after the fault.
    pub full_torque: [Duration; JOINTS],
    /// Since when it has been.
    pub full_torque_since: [Option<Instant>; JOINTS],
    /// Smallest and largest true angle of each joint, rad.
    pub angles: [[f64; 2]; JOINTS],
    /// The last torque that each drive was sent, per mille.
    pub last_torque: [i16; JOINTS],
}

/// What is on the other end, shared with who judges the run.
pub struct Bench {
    /// The robot.
    pub link: ToRobot,
    /// What was seen.
    pub seen: Seen,
}

impl Bench {
    /// Looks at joints and brakes.
    fn look(&mut self, now: Instant) {
        let robot = self.link.robot();
        let position: SVector<f64, JOINTS> = robot.plant().position();
        for (range, angle) in self.seen.angles.iter_mut().zip(position.iter()) {
            *range = [range[0].min(*angle), range[1].max(*angle)];
        }
        let braked = robot.brakes().iter().all(|brake| *brake == Brake::Engaged);
        match (braked, self.seen.fault_at) {
            (true, Some(_)) => self.seen.braked_at = self.seen.braked_at.or(Some(now)),
            _ => self.seen.braked_at = None,
        }
    }

    /// Lets time pass in which nobody sends anything: the drives' watchdogs act.
    pub fn settle(&mut self, clock: &VirtualClock, duration: Duration) {
        let end = clock.now() + duration;
        while clock.now() < end {
            // What the drives say now is nobody's any more.
            let _ = self.link.receive(clock.now() + LOOK_INTERVAL);
            self.look(clock.now());
        }
    }
}

/// How often the joints are looked at while nobody sends anything.
const LOOK_INTERVAL: Duration = Duration::from_millis(1);

/// A link on which `fault` happens with SYNC number `cycle`.
pub struct Injection<'a> {
    bench: Rc<RefCell<Bench>>,
    clock: VirtualClock,
    fault: Fault,
    joint: Joint,
    node: NodeId,
    nodes: [NodeId; JOINTS],
    cycle: u64,
    stop: &'a StopRequest,
    again: Option<Received>,
}

impl<'a> Injection<'a> {
    /// A link to `bench` on which `fault` happens to the drive of `joint`, one of `nodes`.
    pub fn new(
        bench: Rc<RefCell<Bench>>,
        clock: VirtualClock,
        (fault, joint, cycle): (Fault, Joint, u64),
        nodes: [NodeId; JOINTS],
        stop: &'a StopRequest,
    ) -> Self {
        let node = *joint.of(&nodes);
        Self { bench, clock, fault, joint, node, nodes, cycle, stop, again: None }
    }

    /// What happens before the SYNC of the fault's cycle is sent.
    fn strike(&self, bench: &mut Bench) {
        let link = &mut bench.link;
        match self.fault {
            Fault::Suspended { duration } => {
                let mut clock = self.clock.clone();
                clock.sleep_until(clock.now() + duration);
            }
            Fault::StopRequest => self.stop.make(),
            Fault::Drive(fault) => link.inject(self.joint, fault),
            Fault::Foreign(foreign) => link.send_as_another(&self.foreign_frame(foreign)),
            Fault::BootUp => self.pretend(link, &heartbeat_frame(self.node, NmtState::Initialising)),
            Fault::Emergency { bytes } => {
                let content = [0x10, 0x23, 0x03, 0, 0, 0, 0, 0];
                let content = content.get(..usize::from(bytes)).unwrap_or(&content);
                if let Some(frame) = Frame::new(Channel::Emergency(self.node).identifier(), content) {
                    self.pretend(link, &frame);
                }
            }
            Fault::Nothing
            | Fault::FeedbackLost { .. }
            | Fault::FeedbackTwice
            | Fault::FeedbackShort
            | Fault::LinkRefusesOnce
            | Fault::LinkDown => {}
        }
        bench.seen.fault_at = Some(self.clock.now());
    }

    /// Puts a frame of the drive on the bus.
    fn pretend(&self, link: &mut ToRobot, frame: &Frame) {
        link.send_as_another(frame);
    }

    fn foreign_frame(&self, foreign: ForeignFault) -> Frame {
        match foreign {
            ForeignFault::Sync => plain_sync_frame(),
            ForeignFault::Heartbeat => master_heartbeat_frame(),
            ForeignFault::Torque => {
                let enabled = uarm_io::drive::cia402::Controlword::from_bits(0x000F);
                DriveCommand { controlword: enabled, target_torque: 1000 }.frame(self.node)
            }
            ForeignFault::NmtStop => {
                let all = StandardId::new(0).unwrap_or(StandardId::ZERO);
                Frame::with(all, [0x02, 0x00])
            }
            ForeignFault::NmtReset => nmt_frame(NmtCommand::ResetNode, self.node),
        }
    }

    /// Is this within the cycles of the fault?
    fn lasts(&self, syncs: u64) -> bool {
        let cycles = match self.fault {
            Fault::FeedbackLost { cycles } => cycles,
            _ => 1,
        };
        (self.cycle..self.cycle.saturating_add(cycles)).contains(&syncs.saturating_sub(1))
    }

    fn refuses(&self, frame: &Frame, seen: &Seen) -> bool {
        match self.fault {
            Fault::LinkDown => seen.fault_at.is_some(),
            Fault::LinkRefusesOnce => {
                let is_sync = Channel::of(frame.id()) == Some(Channel::Sync);
                is_sync && seen.syncs == self.cycle.saturating_add(1)
            }
            _ => false,
        }
    }

    fn watch_torque(&self, frame: &Frame, seen: &mut Seen) {
        let Some(Channel::Rpdo1(node)) = Channel::of(frame.id()) else { return };
        let Some(index) = self.nodes.iter().position(|of| *of == node) else { return };
        let Ok(command) = DriveCommand::decode(frame.data()) else { return };
        let torque = command.target_torque;
        let step = if torque == 0 { 0 } else { torque.saturating_sub(seen.last_torque[index]).unsigned_abs() };
        seen.largest_torque[index] = seen.largest_torque[index].max(torque.unsigned_abs());
        seen.largest_step[index] = seen.largest_step[index].max(step);
        seen.last_torque[index] = torque;
        // Rounding may take one per mille.
        let is_full = torque.unsigned_abs().saturating_add(1) >= seen.torque_limit[index];
        let now = self.clock.now();
        let since = seen.full_torque_since[index].unwrap_or(now);
        seen.full_torque_since[index] = (is_full && seen.fault_at.is_some()).then_some(since);
        if seen.full_torque_since[index].is_some() {
            seen.full_torque[index] = seen.full_torque[index].max(now.since(since));
        }
    }
}

impl Link for Injection<'_> {
    type Error = InjectedError;

    fn send(&mut self, frame: &Frame) -> Result<Instant, InjectedError> {
        let bench = Rc::clone(&self.bench);
        let bench = &mut *bench.borrow_mut();
        if Channel::of(frame.id()) == Some(Channel::Sync) {
            if bench.seen.syncs == self.cycle {
                self.strike(bench);
            }
            bench.seen.syncs += 1;
        }
        if self.refuses(frame, &bench.seen) {
            return Err(InjectedError::Refused);
        }
        self.watch_torque(frame, &mut bench.seen);
        let sent = bench.link.send(frame);
        bench.look(self.clock.now());
        Ok(sent?)
    }

    fn receive(&mut self, deadline: Instant) -> Result<Option<Received>, InjectedError> {
        if let Some(again) = self.again.take() {
            return Ok(Some(again));
        }
        let bench = Rc::clone(&self.bench);
        let bench = &mut *bench.borrow_mut();
        loop {
            let received = bench.link.receive(deadline)?;
            bench.look(self.clock.now());
            let Some(received) = received else { return Ok(None) };
            let is_feedback = Channel::of(received.frame.id()) == Some(Channel::Tpdo1(self.node));
            if !is_feedback || !self.lasts(bench.seen.syncs) {
                return Ok(Some(received));
            }
            match self.fault {
                Fault::FeedbackLost { .. } => {}
                Fault::FeedbackTwice => {
                    self.again = Some(received);
                    return Ok(Some(received));
                }
                Fault::FeedbackShort => {
                    let data = received.frame.data();
                    let short = data.get(..data.len().saturating_sub(1)).unwrap_or_default();
                    let frame = Frame::new(received.frame.id(), short).unwrap_or(received.frame);
                    return Ok(Some(Received { frame, ..received }));
                }
                _ => return Ok(Some(received)),
            }
        }
    }

    fn health(&self) -> LinkHealth {
        self.bench.borrow().link.health()
    }
}
