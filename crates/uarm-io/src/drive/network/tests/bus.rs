//! A bus in virtual time with scripted drives: enough of a drive to test its master, no more.

use crate::drive::cia402::{Command, Controlword, PowerState, Statusword};
use crate::drive::objects::*;
use crate::drive::wire::{self, Channel, DriveCommand, DriveFeedback, EmergencyMessage};
use crate::frame::Frame;
use crate::link::{Link, LinkError, LinkErrorKind, Received};
use crate::time::{Clock, Duration, Instant};
use canopen_rs::sdo::{SdoAbortCode, SdoServer, encode_abort};
use canopen_rs::{Address, Entry, NmtCommand, NmtState, NodeId, ObjectDictionary, Value};
use embedded_can::StandardId;
use std::cell::Cell;
use std::rc::Rc;
use std::vec::Vec;

/// Virtual time, shared between bus and test.
#[derive(Clone, Debug, Default)]
pub struct VirtualClock(Rc<Cell<Instant>>);

impl Clock for VirtualClock {
    fn now(&self) -> Instant {
        self.0.get()
    }
    fn sleep_until(&mut self, deadline: Instant) {
        self.0.set(self.0.get().max(deadline));
    }
}

/// How a drive misbehaves.
#[derive(Clone, Debug, Default)]
pub struct Script {
    pub never_boots: bool,
    /// Answers no SDO for this object.
    pub mute_object: Option<Address>,
    /// Answers no SDO and nothing else after this time.
    pub dies_at: Option<Instant>,
    /// Power state beyond which it does not go.
    pub stuck_in: Option<PowerState>,
    /// Its TPDO1 comes so much later than the SYNC.
    pub feedback_delay: Duration,
    /// SYNC counters that it does not answer.
    pub ignores_syncs: Vec<u8>,
    /// Answers each SYNC twice, as two drives with one node id do.
    pub answers_twice: bool,
    /// Bits of the statusword beside those of the state.
    pub status_bits: u16,
    /// Leaves the size out of expedited answers.
    pub no_size: bool,
    /// Fault resets that it needs before it leaves *Fault*.
    pub stubborn_faults: u8,
    /// The mode that 6061h shows, whatever mode was written.
    pub shows_mode: Option<i8>,
    /// Stays silent on NMT start.
    pub ignores_nmt_start: bool,
    /// An object that has its default, 0, again when 6060h is written.
    pub mode_resets: Option<Object>,
    /// Goes to *Fault* when RPDO1 does not come within 1400h:05.
    pub faults_without_commands: bool,
}

/// Command specifier of a download that a server confirms (CiA 301).
const DOWNLOADED: u8 = 0x60;

#[derive(Debug)]
pub struct FakeDrive {
    pub node: NodeId,
    pub script: Script,
    pub dictionary: ObjectDictionary<64>,
    pub power: PowerState,
    pub nmt: NmtState,
    pub position: i32,
    pub commands: Vec<DriveCommand>,
    /// Objects that it does not have.
    pub lacks: Vec<Address>,
    /// How often its commands failed to come.
    pub timeouts: u32,
    commanded_at: Option<Instant>,
    controlword: Controlword,
    server: SdoServer,
    heartbeat_due: Instant,
}

impl FakeDrive {
    pub fn new(node: u8) -> Self {
        let mut dictionary = ObjectDictionary::new();
        for object in ALL.iter().filter(|object| !OPTIONAL.contains(object)) {
            let value = Value::decode_le(object.data_type, &[0; 8][..object.data_type.size()]).unwrap();
            dictionary.insert(object.address(), Entry::rw(value)).unwrap();
        }
        let constants = [
            (DEVICE_TYPE, Value::Unsigned32(0x0002_0192)),
            (ENCODER_INCREMENTS, Value::Unsigned32(8000)),
            (ENCODER_REVOLUTIONS, Value::Unsigned32(1)),
            (RATED_TORQUE, Value::Unsigned32(200)),
            (VENDOR_ID, Value::Unsigned32(0x55)),
            (SUPPORTED_MODES, Value::Unsigned32(CYCLIC_SYNCHRONOUS_TORQUE_BIT)),
        ];
        for (object, value) in constants {
            dictionary.insert(object.address(), Entry::constant(value)).unwrap();
        }
        dictionary.set(ABORT_CONNECTION_OPTION.address(), Value::Integer16(1)).unwrap();
        let node = NodeId::new(node).unwrap();
        for (object, channel) in [(RPDO1_IDENTIFIER, Channel::Rpdo1(node)), (TPDO1_IDENTIFIER, Channel::Tpdo1(node))] {
            let identifier = Value::Unsigned32(channel.identifier().as_raw().into());
            dictionary.set(object.address(), identifier).unwrap();
        }
        Self {
            node,
            script: Script::default(),
            dictionary,
            power: PowerState::SwitchOnDisabled,
            nmt: NmtState::PreOperational,
            position: 0,
            commands: Vec::new(),
            lacks: Vec::new(),
            timeouts: 0,
            commanded_at: None,
            controlword: Controlword::default(),
            server: SdoServer::new(node),
            heartbeat_due: Instant::from_nanoseconds(u64::MAX),
        }
    }

    fn heartbeat_period(&self) -> Option<Duration> {
        match self.dictionary.read(PRODUCER_HEARTBEAT_TIME.address()) {
            Ok(Value::Unsigned16(period)) if period > 0 => Some(Duration::from_millis(period.into())),
            _ => None,
        }
    }

    fn identifier(&self, object: &Object) -> u16 {
        match self.dictionary.read(object.address()) {
            Ok(Value::Unsigned32(identifier)) => (identifier & 0x7FF) as u16,
            _ => 0,
        }
    }

    /// Goes to *Fault* if its commands failed to come.
    fn watch_commands(&mut self, now: Instant) {
        let Ok(Value::Unsigned16(timeout @ 1..)) = self.dictionary.read(RPDO1_EVENT_TIMER.address()) else { return };
        let missed = self.commanded_at.is_some_and(|at| now.since(at) > Duration::from_millis(timeout.into()));
        if missed && self.script.faults_without_commands {
            self.commanded_at = None;
            self.timeouts += 1;
            self.power = PowerState::Fault;
        }
    }

    /// What the drive sends, and how long after `now`, in answer to a frame.
    fn on_frame(&mut self, frame: &Frame, now: Instant) -> Vec<(Duration, Frame)> {
        let at_once = |frame| std::vec![(Duration::ZERO, frame)];
        match Channel::of(frame.id()) {
            Some(Channel::NmtCommand) => self.on_nmt(frame, now),
            Some(Channel::SdoRequest(node)) if node == self.node && self.nmt != NmtState::Stopped => {
                self.on_sdo(frame).map(at_once).unwrap_or_default()
            }
            _ if frame.id().as_raw() == self.identifier(&RPDO1_IDENTIFIER) && self.nmt == NmtState::Operational => {
                self.commanded_at = Some(now);
                self.on_command(DriveCommand::decode(frame.data()).unwrap());
                Vec::new()
            }
            Some(Channel::Sync) if self.nmt == NmtState::Operational => {
                let count = wire::decode_sync(frame.data()).unwrap().unwrap_or(0);
                if self.script.ignores_syncs.contains(&count) {
                    return Vec::new();
                }
                let statusword = Statusword::of(self.power).with(self.script.status_bits);
                let feedback = DriveFeedback { statusword, position: self.position };
                let identifier = StandardId::new(self.identifier(&TPDO1_IDENTIFIER)).unwrap();
                let answer = (self.script.feedback_delay, Frame::with(identifier, feedback.encode()));
                std::iter::repeat_n(answer, if self.script.answers_twice { 2 } else { 1 }).collect()
            }
            _ => Vec::new(),
        }
    }

    fn on_nmt(&mut self, frame: &Frame, now: Instant) -> Vec<(Duration, Frame)> {
        let (command, target) = wire::decode_nmt(frame.data()).unwrap();
        if target != self.node && target != NodeId::BROADCAST {
            return Vec::new();
        }
        let state = match command {
            NmtCommand::ResetCommunication | NmtCommand::ResetNode if self.script.never_boots => return Vec::new(),
            NmtCommand::ResetCommunication | NmtCommand::ResetNode => {
                self.nmt = NmtState::PreOperational;
                let boot_time = Duration::from_millis(10 * u64::from(self.node.raw()));
                return std::vec![(boot_time, wire::heartbeat_frame(self.node, NmtState::Initialising))];
            }
            NmtCommand::StartRemoteNode if self.script.ignores_nmt_start => return Vec::new(),
            NmtCommand::StartRemoteNode => NmtState::Operational,
            NmtCommand::StopRemoteNode => NmtState::Stopped,
            NmtCommand::EnterPreOperational => NmtState::PreOperational,
        };
        self.nmt = state;
        self.heartbeat_due = now;
        Vec::new()
    }

    fn on_sdo(&mut self, frame: &Frame) -> Option<Frame> {
        let request = wire::decode_sdo(frame.data()).unwrap();
        let address = Address::new(u16::from_le_bytes([request[1], request[2]]), request[3]);
        if self.script.mute_object == Some(address) {
            return None;
        }
        if self.lacks.contains(&address) {
            let absent = encode_abort(address, SdoAbortCode::ObjectDoesNotExist);
            return Some(wire::sdo_response_frame(self.node, &absent));
        }
        let status = Value::Unsigned16(Statusword::of(self.power).bits());
        self.dictionary.set(STATUSWORD.address(), status).unwrap();
        self.dictionary.set(POSITION_ACTUAL.address(), Value::Integer32(self.position)).unwrap();
        let written = self.dictionary.read(MODE_OF_OPERATION.address()).unwrap();
        let mode = self.script.shows_mode.map_or(written, Value::Integer8);
        self.dictionary.set(MODE_OF_OPERATION_DISPLAY.address(), mode).unwrap();
        let mut answer = self.server.handle(&mut self.dictionary, &request)?;
        if address == CONTROLWORD.address() && answer[0] == DOWNLOADED {
            let controlword = Controlword::from_bits(u16::from_le_bytes([request[4], request[5]]));
            self.on_command(DriveCommand { controlword, target_torque: 0 });
        }
        if address == MODE_OF_OPERATION.address()
            && answer[0] == DOWNLOADED
            && let Some(object) = self.script.mode_resets
        {
            let zero = Value::decode_le(object.data_type, &[0; 8][..object.data_type.size()]).unwrap();
            self.dictionary.set(object.address(), zero).unwrap();
        }
        if self.script.no_size && answer[0] & 0xE3 == 0x43 {
            answer[0] = 0x42;
        }
        Some(wire::sdo_response_frame(self.node, &answer))
    }

    fn on_command(&mut self, command: DriveCommand) {
        self.commands.push(command);
        let order = command.controlword.command(self.controlword);
        let mut next = self.power.after(order);
        if self.power == PowerState::Fault && order == Command::FaultReset && self.script.stubborn_faults > 0 {
            self.script.stubborn_faults -= 1;
            next = PowerState::Fault;
        }
        self.controlword = command.controlword;
        if self.script.stuck_in != Some(self.power) {
            self.power = next;
        }
    }

    fn on_time(&mut self, now: Instant) -> Option<Frame> {
        self.watch_commands(now);
        let period = self.heartbeat_period()?;
        if self.heartbeat_due.nanoseconds() == u64::MAX {
            self.heartbeat_due = now;
        }
        (now >= self.heartbeat_due).then(|| {
            self.heartbeat_due = now + period;
            wire::heartbeat_frame(self.node, self.nmt)
        })
    }

    fn alive(&self, now: Instant) -> bool {
        self.script.dies_at.is_none_or(|end| now < end)
    }
}

/// The link to all drives.
#[derive(Debug, Default)]
pub struct FakeBus {
    pub clock: VirtualClock,
    pub drives: Vec<FakeDrive>,
    pub sent: Vec<Frame>,
    /// What somebody else sends when the master asks a node for an object, once; for 6061h when the node is enabled.
    pub meanwhile: Option<(u8, Address, Frame)>,
    /// Frames are stamped when they are read, not when they came.
    pub stamps_on_reading: bool,
    /// SDO answers with this specifier, the upper three bits of their first byte, come twice.
    pub echo: Option<u8>,
    /// The link fails from here on.
    pub down: bool,
    /// Sending fails before this.
    pub down_until: Option<Instant>,
    queue: Vec<Received>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the interface is down")]
pub struct Down;

impl LinkError for Down {
    fn kind(&self) -> LinkErrorKind {
        LinkErrorKind::Down
    }
}

impl FakeBus {
    pub fn new(nodes: &[u8]) -> Self {
        Self { drives: nodes.iter().map(|node| FakeDrive::new(*node)).collect(), ..Self::default() }
    }

    /// Puts a frame on the bus, to be received at `at`.
    pub fn inject(&mut self, at: Instant, frame: Frame) {
        let position = self.queue.partition_point(|queued| queued.at <= at);
        self.queue.insert(position, Received { frame, at });
    }

    /// What the others on the bus do when the master sends `frame`.
    fn others(&mut self, frame: &Frame) {
        let Some((node, object, answer)) = self.meanwhile else { return };
        let request = Channel::of(frame.id()) == NodeId::new(node).ok().map(Channel::SdoRequest);
        let [low, high] = object.index.to_le_bytes();
        let enabled = |drive: &FakeDrive| drive.node.raw() == node && drive.power == PowerState::OperationEnabled;
        let early = object == MODE_OF_OPERATION_DISPLAY.address() && !self.drives.iter().any(enabled);
        if request && !early && frame.data()[1..4] == [low, high, object.subindex] {
            self.meanwhile = None;
            self.deliver(&answer);
            self.inject(self.clock.now(), answer);
        }
    }

    /// Gives a frame to the drives.
    fn deliver(&mut self, frame: &Frame) {
        let now = self.clock.now();
        let alive = self.drives.iter_mut().filter(|drive| drive.alive(now));
        let answers: Vec<(Duration, Frame)> = alive.flat_map(|drive| drive.on_frame(frame, now)).collect();
        for (delay, answer) in answers {
            let is_answer = matches!(Channel::of(answer.id()), Some(Channel::SdoResponse(_)));
            let is_doubled = is_answer && answer.data().first().map(|command| command & 0xE0) == self.echo;
            for _ in 0..if is_doubled { 2 } else { 1 } {
                self.inject(now + delay, answer);
            }
        }
    }

    pub fn inject_emergency(&mut self, node: u8, code: u16) {
        let message = EmergencyMessage::new(code, canopen_rs::ErrorRegister(1), [0; 5]);
        self.inject(self.clock.now(), wire::emergency_frame(NodeId::new(node).unwrap(), &message));
    }

    fn heartbeats(&mut self) {
        let now = self.clock.now();
        let frames: Vec<Frame> =
            self.drives.iter_mut().filter(|drive| drive.alive(now)).filter_map(|drive| drive.on_time(now)).collect();
        for frame in frames {
            self.inject(now, frame);
        }
    }
}

impl Link for FakeBus {
    type Error = Down;

    fn send(&mut self, frame: &Frame) -> Result<Instant, Down> {
        if self.down || self.down_until.is_some_and(|end| self.clock.now() < end) {
            return Err(Down);
        }
        self.sent.push(*frame);
        self.others(frame);
        self.deliver(frame);
        Ok(self.clock.now())
    }

    /// Time goes on in steps of at most a millisecond, so that heartbeats come when they are due.
    fn receive(&mut self, deadline: Instant) -> Result<Option<Received>, Down> {
        if self.down {
            return Err(Down);
        }
        loop {
            self.heartbeats();
            let now = self.clock.now();
            if self.queue.first().is_some_and(|queued| queued.at <= now) {
                let received = self.queue.remove(0);
                let at = if self.stamps_on_reading { now } else { received.at };
                return Ok(Some(Received { at, ..received }));
            }
            if now >= deadline {
                return Ok(None);
            }
            let next = self.queue.first().map_or(deadline, |queued| queued.at.min(deadline));
            self.clock.sleep_until(next.min(now + Duration::from_millis(1)));
        }
    }
}

/// The command word that enables, for assertions.
pub fn enabling() -> Controlword {
    Controlword::of(Command::EnableOperation)
}
