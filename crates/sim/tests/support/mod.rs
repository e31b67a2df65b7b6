//! A small master for tests: frames in, frames out, nothing decided.
#![allow(dead_code, reason = "each test binary uses a part of it")]

use canopen_rs::sdo::{SdoClient, SdoEvent};
use dem_model::ThreeLinkDem;
use std::time::Duration;
use uarm_io::drive::cia402::{Command, Controlword, Statusword};
use uarm_io::drive::wire::{self, Channel, DriveCommand, DriveFeedback};
use uarm_io::drive::{Address, NmtCommand, NodeId, Value, objects};
use uarm_io::encoder::Direction;
use uarm_io::frame::Frame;
use uarm_io::link::Link;
use uarm_io::time::{Clock, Instant};
use uarm_sim::{
    DemPlant, DriveDescription, DriveParameters, EmulatedRobot, EncoderDescription, InProcessLink, Pacing, Plant,
    VirtualClock,
};

/// The paper's period.
pub const PERIOD: Duration = Duration::from_millis(3);
/// 6076h of all drives, mN·m.
pub const RATED_TORQUE: u32 = 200;
/// How long a drive bears the master's silence in these tests, ms.
pub const PATIENCE: u16 = 100;

/// The drives of the tests: nodes 1 to 3, the fitted encoder.
pub fn drives() -> [DriveParameters; 3] {
    drives_mounted([Direction::Positive; 3])
}

/// The same drives, each mounted in a direction of its own.
pub fn drives_mounted(directions: [Direction; 3]) -> [DriveParameters; 3] {
    let [first, second, third] = directions;
    [(1, first), (2, second), (3, third)].map(|(node, direction)| {
        DriveParameters::new(DriveDescription {
            node,
            rated_torque: RATED_TORQUE,
            rated_current: 1_500,
            maximum_torque: 1_000,
            direction,
            encoder: EncoderDescription { counts_per_revolution: 33_739, counter_bits: 32, zero_offset: 0 },
        })
        .unwrap()
    })
}

/// The drives on the ideal plant.
pub fn robot(pacing: Pacing) -> EmulatedRobot<DemPlant> {
    EmulatedRobot::new(DemPlant::new(ThreeLinkDem::table_2()), drives(), pacing).unwrap()
}

/// The pacing of most tests.
pub fn lockstep() -> Pacing {
    Pacing::Lockstep { period: PERIOD }
}

/// A node that exists.
pub fn node(id: u8) -> NodeId {
    NodeId::new(id).unwrap()
}

/// A link, its clock, and what a master does with them by hand.
pub struct Master<L> {
    pub link: L,
    pub clock: VirtualClock,
    counter: u8,
}

impl Master<InProcessLink<EmulatedRobot<DemPlant>, VirtualClock>> {
    /// A robot that has just been switched on; its boot-up messages are read.
    pub fn with_robot(pacing: Pacing) -> Self {
        let clock = VirtualClock::new();
        let mut master = Self::on(InProcessLink::new(robot(pacing), clock.clone()), clock);
        master.received();
        master
    }

    pub fn position(&self) -> nalgebra::Vector3<f64> {
        self.link.robot().plant().position()
    }
}

impl<L: Link> Master<L> {
    pub fn on(link: L, clock: VirtualClock) -> Self {
        Self { link, clock, counter: 0 }
    }

    pub fn send(&mut self, frame: Frame) {
        self.link.send(&frame).unwrap();
    }

    /// All frames that have come, without waiting.
    pub fn received(&mut self) -> Vec<Frame> {
        let now = self.clock.now();
        core::iter::from_fn(|| self.link.receive(now).unwrap()).map(|received| received.frame).collect()
    }

    /// Lets time pass, reading nothing.
    pub fn wait(&mut self, time: Duration) {
        let until = self.clock.now() + time;
        self.clock.sleep_until(until);
    }

    /// Frames and their instants that come within `time`.
    pub fn listen(&mut self, time: Duration) -> Vec<(Frame, Instant)> {
        let until = self.clock.now() + time;
        core::iter::from_fn(|| self.link.receive(until).unwrap()).map(|got| (got.frame, got.at)).collect()
    }

    pub fn nmt(&mut self, command: NmtCommand) {
        self.send(wire::nmt_frame(command, NodeId::BROADCAST));
    }

    pub fn heartbeat(&mut self) {
        self.send(wire::master_heartbeat_frame());
    }

    fn transact(&mut self, id: u8, client: &mut SdoClient, first: [u8; 8]) -> Result<Option<Value>, u32> {
        let mut request = first;
        loop {
            self.send(wire::sdo_request_frame(node(id), &request));
            let answers = self.received();
            let answer = answers.iter().find(|frame| Channel::of(frame.id()) == Some(Channel::SdoResponse(node(id))));
            match client.on_response(&wire::decode_sdo(answer.expect("an answer").data()).unwrap()) {
                SdoEvent::Send(next) => request = next,
                SdoEvent::Complete(value) => return Ok(value),
                SdoEvent::Aborted(code) => return Err(code),
            }
        }
    }

    pub fn write(&mut self, id: u8, index: u16, subindex: u8, value: Value) -> Result<(), u32> {
        let mut client = SdoClient::new(node(id));
        let first = client.write(Address::new(index, subindex), value);
        self.transact(id, &mut client, first).map(|_| ())
    }

    pub fn read(&mut self, id: u8, index: u16, subindex: u8, kind: uarm_io::drive::DataType) -> Result<Value, u32> {
        let mut client = SdoClient::new(node(id));
        let first = client.read(Address::new(index, subindex), kind);
        self.transact(id, &mut client, first).map(Option::unwrap)
    }

    pub fn command(&mut self, id: u8, command: Command, target_torque: i16) {
        let command = DriveCommand { controlword: Controlword::of(command), target_torque };
        self.send(command.frame(node(id)));
    }

    /// SYNC; returns what each drive that answered fed back.
    pub fn sync(&mut self) -> Vec<(u8, Statusword, i32)> {
        self.counter = self.counter % wire::SYNC_COUNTER_OVERFLOW + 1;
        self.send(wire::sync_frame(self.counter));
        let feedback = self.received().into_iter().filter_map(|frame| match Channel::of(frame.id()) {
            Some(Channel::Tpdo1(node)) => {
                let feedback = DriveFeedback::decode(frame.data()).unwrap();
                Some((node.raw(), feedback.statusword, feedback.position))
            }
            _ => None,
        });
        feedback.collect()
    }

    /// Torque mode and heartbeat watch on all drives.
    pub fn configure(&mut self) {
        for id in 1..=3 {
            self.write(id, 0x6060, 0, Value::Integer8(objects::CYCLIC_SYNCHRONOUS_TORQUE)).unwrap();
            self.write(id, 0x1019, 0, Value::Unsigned8(wire::SYNC_COUNTER_OVERFLOW)).unwrap();
            self.write(id, 0x1016, 1, Value::Unsigned32(wire::consumer_heartbeat_entry(PATIENCE))).unwrap();
        }
        self.heartbeat();
    }

    /// Up to *Operation enabled*, brakes open.
    pub fn enable(&mut self) {
        self.configure();
        self.nmt(NmtCommand::StartRemoteNode);
        for command in [Command::Shutdown, Command::SwitchOn, Command::EnableOperation] {
            for id in 1..=3 {
                self.command(id, command, 0);
            }
        }
    }

    /// One period: SYNC, torques of joints 2 and 3, heartbeat.
    pub fn cycle(&mut self, torque: [i16; 2]) -> Vec<(u8, Statusword, i32)> {
        let feedback = self.sync();
        self.command(1, Command::EnableOperation, 0);
        self.command(2, Command::EnableOperation, torque[0]);
        self.command(3, Command::EnableOperation, torque[1]);
        self.heartbeat();
        self.wait(PERIOD);
        feedback
    }
}
