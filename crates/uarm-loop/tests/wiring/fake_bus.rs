//! Three drives that answer SYNC on a bus in virtual time, each step of which takes a time that a test can add up.

use std::cell::Cell;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::rc::Rc;

use uarm_loop::uarm_io::drive::cia402::{PowerState, Statusword};
use uarm_loop::uarm_io::drive::network::{DriveConfiguration, NetworkConfiguration};
use uarm_loop::uarm_io::drive::wire::{Channel, DriveCommand, DriveFeedback, heartbeat_frame};
use uarm_loop::uarm_io::drive::{DriveNetwork, NmtState, NodeId};
use uarm_loop::uarm_io::frame::Frame;
use uarm_loop::uarm_io::link::{Link, Received};
use uarm_loop::uarm_io::time::{Clock, Duration, Instant};
use uarm_loop::uarm_io::torque::RatedTorque;

/// From the deadline to the wake-up.
pub const OVERSLEEP: Duration = Duration::from_micros(70);
/// What sending one frame takes.
pub const SENDING: Duration = Duration::from_micros(20);
/// From the hand-over of SYNC to the last drive's feedback.
pub const FEEDBACK: Duration = Duration::from_micros(400);
/// How often each drive sends its heartbeat.
const HEARTBEAT: Duration = Duration::from_millis(50);

/// Virtual time, shared between bus and loop, that wakes up late.
#[derive(Clone, Debug, Default)]
pub struct LateClock {
    now: Rc<Cell<Instant>>,
    /// How much later than usual the next wake-up comes.
    delay: Rc<Cell<Duration>>,
}

impl LateClock {
    /// Lets the next wake-up come `by` later than the others.
    pub fn delay_next(&self, by: Duration) {
        self.delay.set(by);
    }

    fn pass(&self, time: Duration) -> Instant {
        self.now.set(self.now.get() + time);
        self.now.get()
    }
}

impl Clock for LateClock {
    fn now(&self) -> Instant {
        self.now.get()
    }
    fn sleep_until(&mut self, deadline: Instant) {
        self.now.set(self.now.get().max(deadline + OVERSLEEP + self.delay.take()));
    }
}

/// The drives of joints 1 to 3, on nodes 1 to 3.
#[derive(Debug)]
pub struct FakeBus {
    clock: LateClock,
    queue: VecDeque<Received>,
    next_heartbeat: Instant,
    /// The counts that the drives report.
    pub counts: [i32; 3],
    /// From when on the drive of joint 3 sends no heartbeat.
    pub silent_from: Instant,
    /// The state in the heartbeats of joint 2's drive.
    pub state_of_joint_2: NmtState,
    /// How many SYNCs were sent.
    pub syncs: usize,
    /// The torques that were sent, per mille, a row for each cycle.
    pub torques: Vec<[i16; 3]>,
}

/// A master of three such drives.
pub fn network(clock: &LateClock) -> DriveNetwork<FakeBus, 3> {
    let rated_torque = RatedTorque::from_millinewton_metres(200).unwrap();
    let drives = [1, 2, 3].map(|node| DriveConfiguration::new(NodeId::new(node).unwrap(), 36_000, rated_torque));
    let bus = FakeBus {
        clock: clock.clone(),
        queue: VecDeque::new(),
        next_heartbeat: Instant::default(),
        counts: [0; 3],
        silent_from: Instant::from_nanoseconds(u64::MAX),
        state_of_joint_2: NmtState::Operational,
        syncs: 0,
        torques: Vec::new(),
    };
    DriveNetwork::new(bus, NetworkConfiguration::new(drives, Duration::from_millis(3)).unwrap())
}

impl FakeBus {
    fn send_heartbeats(&mut self) {
        let now = self.clock.now();
        while self.next_heartbeat <= now {
            let at = self.next_heartbeat;
            let states = [NmtState::Operational, self.state_of_joint_2, NmtState::Operational];
            for (node, state) in (1..).zip(states) {
                if node < 3 || at < self.silent_from {
                    let frame = heartbeat_frame(NodeId::new(node).unwrap(), state);
                    self.queue.push_back(Received { frame, at });
                }
            }
            self.next_heartbeat = at + HEARTBEAT;
        }
    }
}

impl Link for FakeBus {
    type Error = Infallible;

    fn send(&mut self, frame: &Frame) -> Result<Instant, Infallible> {
        let now = self.clock.pass(SENDING);
        match Channel::of(frame.id()) {
            Some(Channel::Sync) => {
                self.syncs += 1;
                let statusword = Statusword::of(PowerState::OperationEnabled);
                for (node, position) in (1_u8..).zip(self.counts) {
                    let frame = DriveFeedback { statusword, position }.frame(NodeId::new(node).unwrap());
                    // 300, 350 and 400 microseconds after SYNC.
                    let at = now + FEEDBACK - Duration::from_micros(50) * u32::from(3 - node);
                    self.queue.push_back(Received { frame, at });
                }
            }
            Some(Channel::Rpdo1(node)) => {
                if node.raw() == 1 {
                    self.torques.push([0; 3]);
                }
                let torque = DriveCommand::decode(frame.data()).unwrap().target_torque;
                self.torques.last_mut().unwrap()[usize::from(node.raw()) - 1] = torque;
            }
            _ => {}
        }
        Ok(now)
    }

    fn receive(&mut self, deadline: Instant) -> Result<Option<Received>, Infallible> {
        self.send_heartbeats();
        let now = self.clock.now();
        match self.queue.front().copied() {
            Some(received) if received.at <= now.max(deadline) => {
                self.queue.pop_front();
                self.clock.now.set(now.max(received.at));
                Ok(Some(received))
            }
            _ => {
                self.clock.now.set(now.max(deadline));
                Ok(None)
            }
        }
    }
}
