//! The master against scripted axes in virtual time.

mod cycle;
mod inquiry;
mod masters;
mod start;
mod stop;

use super::axis_error::AxisError;
use super::wire::{
    self, AxisNode, AxisState, ControllerMode, EncoderEstimates, Heartbeat, Message, Supply, Temperature, Version,
};
use super::{
    OdriveAxis, OdriveConfiguration, OdriveCycleError, OdriveNetwork, OdriveStartError, OdriveTimes, Positions,
};
use crate::drive::RobotDrives;
use crate::drive::cia402::{PowerState, Statusword};
use crate::drive::network::{Confirmation, LastDefence};
use crate::encoder::CountsPerRevolution;
use crate::frame::Frame;
use crate::link::{Link, Received};
use crate::time::{Clock, Duration, Instant};
use crate::torque::RatedTorque;
use canopen_rs::NmtState;
use core::convert::Infallible;
use std::cell::Cell;
use std::rc::Rc;
use std::vec::Vec;

const HEARTBEAT: Duration = Duration::from_millis(50);
const WATCHDOG: Duration = Duration::from_millis(50);
const PERIOD: Duration = Duration::from_millis(3);

#[derive(Clone, Debug, Default)]
struct VirtualClock(Rc<Cell<Instant>>);

impl Clock for VirtualClock {
    fn now(&self) -> Instant {
        self.0.get()
    }
    fn sleep_until(&mut self, deadline: Instant) {
        self.0.set(self.0.get().max(deadline));
    }
}

const VERSION: Version = Version { protocol: 2, hardware: [4, 4, 58], firmware: [0, 6, 10], unreleased: 0 };

/// An axis as the documentation describes it, and how it misbehaves.
#[derive(Clone, Debug)]
struct Axis {
    node: AxisNode,
    state: AxisState,
    error: u32,
    mode: Option<ControllerMode>,
    turns: f32,
    torques: Vec<f32>,
    heartbeat_due: Instant,
    watchdog_due: Option<Instant>,
    /// Its position comes by itself this often.
    sends_every: Option<Duration>,
    estimate_due: Instant,
    has_watchdog: bool,
    mute_since: Option<Instant>,
    answers: bool,
    never_arms: bool,
    ignores_idle: bool,
    /// Errors that clearing does not clear.
    lasting_error: u32,
    /// So long after a request the answer comes.
    delay: Duration,
    /// Another axis with its node id answers as well.
    has_twin: bool,
    /// What it answers to Get_Version, Get_Bus_Voltage_Current and Get_Temperature, if it does.
    version: Option<Version>,
    supply: Option<f32>,
    temperatures: Option<[f32; 2]>,
}

impl Axis {
    fn new(node: u8) -> Self {
        Self {
            node: AxisNode::new(node).unwrap(),
            state: AxisState::IDLE,
            error: 0,
            mode: None,
            turns: f32::from(node),
            torques: Vec::new(),
            heartbeat_due: Instant::default() + Duration::from_millis(node.into()),
            watchdog_due: None,
            sends_every: None,
            estimate_due: Instant::default(),
            has_watchdog: true,
            mute_since: None,
            answers: true,
            never_arms: false,
            ignores_idle: false,
            lasting_error: 0,
            delay: Duration::ZERO,
            has_twin: false,
            version: Some(VERSION),
            supply: Some(24.0),
            temperatures: Some([40.0, 30.0]),
        }
    }

    fn feed(&mut self, now: Instant) {
        let runs = self.has_watchdog && self.state == AxisState::CLOSED_LOOP_CONTROL;
        self.watchdog_due = runs.then(|| now + WATCHDOG);
    }

    fn answer(&self, frame: Frame, now: Instant) -> Received {
        Received { frame, at: now + self.delay }
    }

    fn fail(&mut self, error: u32) {
        self.error |= error;
        self.state = AxisState::IDLE;
        self.watchdog_due = None;
    }

    fn hear(&mut self, message: Message, data: &[u8], now: Instant, wire: &mut Vec<Received>) {
        match message {
            Message::EncoderEstimates if data.is_empty() && self.answers => {
                let estimates = EncoderEstimates { position: self.turns, velocity: 0.0 };
                let received = Received { frame: estimates.frame(self.node), at: now + self.delay };
                wire.extend(core::iter::repeat_n(received, if self.has_twin { 2 } else { 1 }));
            }
            Message::Version => wire.extend(self.version.map(|version| self.answer(version.frame(self.node), now))),
            Message::BusVoltageCurrent => {
                let frame = |voltage| Supply { voltage, current: 1.0 }.frame(self.node);
                wire.extend(self.supply.map(|voltage| self.answer(frame(voltage), now)));
            }
            Message::Temperature => {
                let frame = |[inverter, motor]: [f32; 2]| Temperature { inverter, motor }.frame(self.node);
                wire.extend(self.temperatures.map(|found| self.answer(frame(found), now)));
            }
            Message::SetAxisState => match wire::decode_state(data).unwrap() {
                AxisState::CLOSED_LOOP_CONTROL if self.error == 0 && !self.never_arms => {
                    self.state = AxisState::CLOSED_LOOP_CONTROL;
                    self.feed(now);
                }
                AxisState::IDLE if !self.ignores_idle => {
                    self.state = AxisState::IDLE;
                    self.watchdog_due = None;
                }
                _ => {}
            },
            Message::SetControllerMode => self.mode = ControllerMode::decode(data).ok(),
            Message::SetInputTorque => {
                self.torques.push(wire::decode_torque(data).unwrap());
                self.feed(now);
            }
            Message::ClearErrors => self.error = self.lasting_error,
            Message::Estop => self.fail(AxisError::ESTOP_REQUESTED.0),
            _ => {}
        }
    }

    fn act(&mut self, now: Instant, wire: &mut Vec<Received>) {
        if self.watchdog_due.is_some_and(|due| due <= now) {
            self.fail(AxisError::WATCHDOG_TIMER_EXPIRED.0);
        }
        if self.heartbeat_due <= now {
            let heartbeat = Heartbeat { error: AxisError(self.error), state: self.state, ..Heartbeat::default() };
            wire.push(Received { frame: heartbeat.frame(self.node), at: self.heartbeat_due });
            self.heartbeat_due = self.heartbeat_due + HEARTBEAT;
        }
        if let Some(every) = self.sends_every.filter(|_| self.estimate_due <= now) {
            let estimates = EncoderEstimates { position: self.turns, velocity: 0.0 };
            wire.push(Received { frame: estimates.frame(self.node), at: self.estimate_due });
            self.estimate_due = self.estimate_due + every;
        }
    }

    fn due(&self) -> Instant {
        let estimate = self.sends_every.map(|_| self.estimate_due);
        [Some(self.heartbeat_due), self.watchdog_due, estimate].into_iter().flatten().min().unwrap()
    }
}

#[derive(Debug)]
struct Bus {
    clock: VirtualClock,
    axes: [Axis; 3],
    wire: Vec<Received>,
    sent: Vec<Frame>,
}

impl Bus {
    fn pass(&mut self, until: Instant) {
        for axis in &mut self.axes {
            while axis.due() <= until {
                let mute = axis.mute_since.is_some_and(|since| since <= axis.due());
                let before = self.wire.len();
                axis.act(axis.due(), &mut self.wire);
                if mute {
                    self.wire.truncate(before);
                }
            }
        }
        self.wire.sort_by_key(|received| received.at);
    }
}

impl Link for Bus {
    type Error = Infallible;

    fn send(&mut self, frame: &Frame) -> Result<Instant, Infallible> {
        let now = self.clock.now();
        self.pass(now);
        self.sent.push(*frame);
        let (message, node) = Message::of(frame.id()).unwrap();
        if let Some(axis) = self.axes.iter_mut().find(|axis| axis.node == node) {
            axis.hear(message, frame.data(), now, &mut self.wire);
        }
        Ok(now)
    }

    fn receive(&mut self, deadline: Instant) -> Result<Option<Received>, Infallible> {
        self.pass(self.clock.now());
        loop {
            let next = self.axes.iter().map(Axis::due).min().unwrap();
            let first = self.wire.first().map(|received| received.at);
            let now = self.clock.now();
            if first.is_some_and(|at| at <= now) {
                return Ok(Some(self.wire.remove(0)));
            }
            if now >= deadline {
                return Ok(None);
            }
            let wake = first.map_or(next, |at| at.min(next)).min(deadline);
            self.clock.sleep_until(wake);
            self.pass(wake);
        }
    }
}

fn configuration(positions: Positions) -> OdriveConfiguration<3> {
    let axis = |node| OdriveAxis {
        node: AxisNode::new(node).unwrap(),
        counts_per_turn: CountsPerRevolution::new(8_192).unwrap(),
        rated_torque: RatedTorque::from_millinewton_metres(200).unwrap(),
        product: None,
        readings: [None; 2],
    };
    OdriveConfiguration { axes: [axis(1), axis(2), axis(3)], positions, times: OdriveTimes::usual() }
}

fn network(change: impl FnOnce(&mut [Axis; 3])) -> (OdriveNetwork<Bus, 3>, VirtualClock) {
    network_with(Positions::OnRequest, change)
}

fn network_with(positions: Positions, change: impl FnOnce(&mut [Axis; 3])) -> (OdriveNetwork<Bus, 3>, VirtualClock) {
    network_of(configuration(positions), change)
}

fn network_of(
    configuration: OdriveConfiguration<3>,
    change: impl FnOnce(&mut [Axis; 3]),
) -> (OdriveNetwork<Bus, 3>, VirtualClock) {
    let clock = VirtualClock::default();
    let mut axes = [Axis::new(1), Axis::new(2), Axis::new(3)];
    change(&mut axes);
    let bus = Bus { clock: clock.clone(), axes, wire: Vec::new(), sent: Vec::new() };
    (OdriveNetwork::new(bus, configuration), clock)
}

fn started() -> (OdriveNetwork<Bus, 3>, VirtualClock) {
    let (mut network, clock) = network(|_| {});
    network.start(&clock).unwrap();
    (network, clock)
}

type Error = OdriveCycleError<Infallible>;

fn cycle(
    network: &mut OdriveNetwork<Bus, 3>,
    clock: &mut VirtualClock,
    torques: [i16; 3],
) -> Result<[Option<i32>; 3], Error> {
    let at = network.sync(clock.now())?;
    let feedback = network.collect(at + PERIOD)?;
    network.send_torques(torques)?;
    let result = network.housekeeping(clock.now());
    clock.sleep_until(at + PERIOD);
    result.map(|()| feedback.positions)
}

fn until_error(network: &mut OdriveNetwork<Bus, 3>, clock: &mut VirtualClock) -> Error {
    (0..200).find_map(|_| cycle(network, clock, [0; 3]).err()).expect("an error within 0.6 s")
}
