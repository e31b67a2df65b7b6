//! The master against scripted axes in virtual time.

use super::axis_error::AxisError;
use super::wire::{self, AxisNode, AxisState, ControllerMode, EncoderEstimates, Heartbeat, Message};
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
        }
    }

    fn feed(&mut self, now: Instant) {
        let runs = self.has_watchdog && self.state == AxisState::CLOSED_LOOP_CONTROL;
        self.watchdog_due = runs.then(|| now + WATCHDOG);
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
    };
    OdriveConfiguration { axes: [axis(1), axis(2), axis(3)], positions, times: OdriveTimes::usual() }
}

fn network(change: impl FnOnce(&mut [Axis; 3])) -> (OdriveNetwork<Bus, 3>, VirtualClock) {
    network_with(Positions::OnRequest, change)
}

fn network_with(positions: Positions, change: impl FnOnce(&mut [Axis; 3])) -> (OdriveNetwork<Bus, 3>, VirtualClock) {
    let clock = VirtualClock::default();
    let mut axes = [Axis::new(1), Axis::new(2), Axis::new(3)];
    change(&mut axes);
    let bus = Bus { clock: clock.clone(), axes, wire: Vec::new(), sent: Vec::new() };
    (OdriveNetwork::new(bus, configuration(positions)), clock)
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

#[test]
fn the_start_ends_armed_with_torque_zero_after_every_watchdog_has_proved_itself() {
    let (mut network, clock) = network(|axes| axes[1].error = 0x2000);
    let positions = network.start(&clock).unwrap();
    assert_eq!(positions, [8_192, 16_384, 24_576], "1, 2 and 3 turns of 8192 counts");
    for axis in &network.link().axes {
        assert_eq!(
            (axis.state, axis.error, axis.mode),
            (AxisState::CLOSED_LOOP_CONTROL, 0, Some(ControllerMode::TORQUE))
        );
        assert!(axis.torques.iter().all(|torque| *torque == 0.0));
    }
    let health = network.health();
    assert!(health.nodes.iter().all(|node| node.last_emergency.is_none()), "what was provoked is no emergency");
    assert_eq!(health.nodes.map(|node| node.emergencies), [0, 1, 0], "the error of before the start is one");
    let proved = network.stop(&clock).drives.map(|drive| drive.last_defence);
    assert_eq!(proved, [LastDefence::RpdoTimeout; 3], "each watchdog was seen to act");
}

#[test]
fn an_axis_that_is_not_heard_fails_the_start() {
    let (mut network, clock) = network(|axes| axes[2].mute_since = Some(Instant::default()));
    let axis = AxisNode::new(3).unwrap();
    assert_eq!(network.start(&clock), Err(OdriveStartError::NotHeard { axis, waited: Duration::from_secs(3) }));
}

#[test]
fn an_axis_without_a_watchdog_fails_the_start() {
    let (mut network, clock) = network(|axes| axes[1].has_watchdog = false);
    let error = network.start(&clock).unwrap_err();
    assert!(matches!(error, OdriveStartError::NoWatchdog { axis, .. } if axis.raw() == 2), "{error}");
    assert!(network.stop(&clock).all_off());
}

#[test]
fn an_axis_that_does_not_arm_or_keeps_its_error_fails_the_start() {
    let (mut arms_not, clock) = network(|axes| axes[1].never_arms = true);
    let error = arms_not.start(&clock).unwrap_err();
    assert!(
        matches!(error, OdriveStartError::NotReached { axis, found, .. } if axis.raw() == 2 && found.state == AxisState::IDLE),
        "{error}"
    );
    let (mut hot, clock) = network(|axes| (axes[0].error, axes[0].lasting_error) = (0x2000, 0x2000));
    let error = hot.start(&clock).unwrap_err();
    let text = std::string::ToString::to_string(&error);
    assert!(text.contains("axis 1 is in IDLE with axis error 00002000h MOTOR_OVER_TEMP"), "{text}");
}

#[test]
fn an_axis_without_answers_or_with_positions_of_its_own_fails_the_start() {
    let (mut mute, clock) = network(|axes| axes[2].answers = false);
    let error = mute.start(&clock).unwrap_err();
    assert!(matches!(error, OdriveStartError::NoPosition { axis, .. } if axis.raw() == 3), "{error}");
    let (mut talks, clock) = network(|axes| axes[0].sends_every = Some(Duration::from_millis(10)));
    let error = talks.start(&clock).unwrap_err();
    assert!(matches!(error, OdriveStartError::Unrequested { axis } if axis.raw() == 1), "{error}");
    let (mut far, clock) = network(|axes| axes[1].turns = 3_000.0);
    let error = far.start(&clock).unwrap_err();
    assert!(matches!(error, OdriveStartError::Position { axis, .. } if axis.raw() == 2), "{error}");
}

#[test]
fn a_cycle_takes_counts_and_gives_newton_metres() {
    let (mut network, mut clock) = started();
    network.link_mut().axes[1].turns = -0.5;
    assert_eq!(cycle(&mut network, &mut clock, [0, 353, -1_000]).unwrap(), [Some(8_192), Some(-4_096), Some(24_576)]);
    let last = network.link().axes.clone().map(|axis| *axis.torques.last().unwrap());
    // 353 per mille of 0.2 N·m.
    assert_eq!(last, [0.0, 0.0706, -0.2]);
    let health = network.health();
    assert_eq!(health.nodes[1].statusword, Statusword::of(PowerState::OperationEnabled));
    assert_eq!((health.nodes[1].node, health.syncs, health.nodes[1].nmt_state), (2, 1, Some(NmtState::Operational)));
}

#[test]
fn a_position_that_does_not_come_is_missing_and_a_late_one_is_not_taken_for_the_next() {
    let (mut network, mut clock) = started();
    cycle(&mut network, &mut clock, [0; 3]).unwrap();
    network.link_mut().axes[2].delay = PERIOD + Duration::from_micros(500);
    assert_eq!(cycle(&mut network, &mut clock, [0; 3]).unwrap()[2], None);
    assert_eq!(network.health().nodes[2].missed_feedbacks, 1);
    network.link_mut().axes[2].delay = Duration::from_millis(1);
    network.link_mut().axes[2].turns = 7.0;
    assert_eq!(cycle(&mut network, &mut clock, [0; 3]).unwrap()[2], Some(7 * 8_192));
    assert_eq!(network.health().nodes[2].stale_feedbacks, 1);
}

/// After an answer that was lost for good, the next one is not taken for a late one.
#[test]
fn one_answer_that_is_lost_costs_one_cycle() {
    let (mut network, mut clock) = started();
    network.link_mut().axes[2].delay = Duration::from_secs(1_000);
    assert_eq!(cycle(&mut network, &mut clock, [0; 3]).unwrap()[2], None);
    network.link_mut().axes[2].delay = Duration::from_millis(1);
    for _ in 0..3 {
        assert_eq!(cycle(&mut network, &mut clock, [0; 3]).unwrap()[2], Some(24_576));
    }
    assert_eq!(network.health().nodes[2].stale_feedbacks, 0);
}

#[test]
fn an_axis_that_disarms_ends_the_run_within_a_heartbeat() {
    let (mut network, mut clock) = started();
    cycle(&mut network, &mut clock, [0; 3]).unwrap();
    let before = clock.now();
    network.link_mut().axes[1].fail(0x2000);
    let error = until_error(&mut network, &mut clock);
    assert!(
        matches!(error, OdriveCycleError::NotArmed { axis, found } if axis.raw() == 2 && found.error == AxisError::MOTOR_OVER_TEMP),
        "{error}"
    );
    assert!(clock.now().since(before) <= HEARTBEAT + PERIOD);
    assert_eq!(network.health().nodes[1].statusword, Statusword::of(PowerState::Fault));
    let told = network.health().nodes[1].last_emergency.unwrap();
    assert_eq!((told.error_code, told.vendor_specific), (0xFF00, [0x00, 0x20, 0x00, 0x00, 1]));
    assert!(network.stop(&clock).all_off());
}

#[test]
fn a_lost_heartbeat_ends_the_run() {
    let (mut network, mut clock) = started();
    network.link_mut().axes[0].mute_since = Some(clock.now());
    // Its positions still come, since they are asked for.
    let error = until_error(&mut network, &mut clock);
    let limit = Duration::from_millis(200);
    assert!(
        matches!(error, OdriveCycleError::Lost { axis, silence, limit: told } if axis.raw() == 1 && silence > limit && told == limit),
        "{error}"
    );
}

#[test]
fn frames_of_the_wrong_length_are_counted_and_not_read() {
    let (mut network, mut clock) = started();
    let at = clock.now();
    let id = Message::Heartbeat.identifier(AxisNode::new(2).unwrap());
    let estimates = Message::EncoderEstimates.identifier(AxisNode::new(2).unwrap());
    for frame in [Frame::with(id, [0, 0, 0, 0, 1, 0, 0]), Frame::with(estimates, [0; 7])] {
        network.link_mut().wire.insert(0, Received { frame, at });
    }
    cycle(&mut network, &mut clock, [0; 3]).unwrap();
    assert_eq!(network.health().nodes[1].malformed, 2);
}

#[test]
fn a_position_of_before_the_request_is_not_taken_for_the_answer() {
    let (mut network, mut clock) = started();
    let early = EncoderEstimates { position: 99.0, velocity: 0.0 }.frame(AxisNode::new(1).unwrap());
    let at = clock.now();
    network.link_mut().wire.insert(0, Received { frame: early, at });
    assert_eq!(cycle(&mut network, &mut clock, [0; 3]).unwrap()[0], Some(8_192));
}

#[test]
fn no_torque_is_asked_for_in_a_cycle_in_which_an_axis_is_seen_disarmed() {
    let (mut network, clock) = started();
    let error = AxisError::MOTOR_OVER_TEMP;
    let heartbeat = Heartbeat { error, state: AxisState::IDLE, ..Heartbeat::default() };
    let frame = heartbeat.frame(AxisNode::new(3).unwrap());
    let at = network.sync(clock.now()).unwrap();
    network.link_mut().wire.insert(0, Received { frame, at });
    let seen = network.collect(at + PERIOD).unwrap_err();
    assert!(
        matches!(seen, OdriveCycleError::NotArmed { axis, found } if axis.raw() == 3 && found.error == error),
        "{seen}"
    );
}

#[test]
fn a_position_that_is_no_number_ends_the_run() {
    let (mut network, mut clock) = started();
    network.link_mut().axes[1].turns = f32::NAN;
    let error = cycle(&mut network, &mut clock, [0; 3]).unwrap_err();
    assert!(matches!(error, OdriveCycleError::Position { axis, .. } if axis.raw() == 2), "{error}");
}

#[test]
fn cyclic_positions_are_used_as_old_as_they_are_and_not_when_two_periods_old() {
    let every = Duration::from_millis(5);
    let (mut network, mut clock) = network_with(Positions::Cyclic { every }, |axes| {
        axes.iter_mut().for_each(|axis| axis.sends_every = Some(every))
    });
    network.start(&clock).unwrap();
    for _ in 0..50 {
        cycle(&mut network, &mut clock, [0; 3]).unwrap();
    }
    let asked = |frame: &&Frame| matches!(Message::of(frame.id()), Some((Message::EncoderEstimates, _)));
    assert_eq!(network.link().sent.iter().filter(asked).count(), 0, "nobody asks");
    let oldest = network.health().nodes[0].longest_latency;
    assert!(oldest > Duration::from_millis(3) && oldest <= every, "{oldest:?}");
    network.link_mut().axes[2].sends_every = None;
    let missing_from = (0..).find(|_| cycle(&mut network, &mut clock, [0; 3]).unwrap()[2].is_none()).unwrap();
    assert!(missing_from <= 4, "twice 5 ms are borne, not {missing_from} cycles of 3 ms");
}

#[test]
fn the_stop_ends_idle_and_an_axis_that_does_not_obey_gets_the_emergency_stop() {
    let (mut network, clock) = started();
    assert!(network.stop(&clock).all_off());
    assert!(network.link().axes.iter().all(|axis| axis.state == AxisState::IDLE && axis.torques.last() == Some(&0.0)));

    let (mut network, clock) = started();
    network.link_mut().axes[1].ignores_idle = true;
    // Without its watchdog, so that only the emergency stop can have done it.
    network.link_mut().axes[1].has_watchdog = false;
    network.send_torques([0; 3]).unwrap();
    assert!(network.stop(&clock).all_off());
    assert_eq!(network.link().axes[1].error, AxisError::ESTOP_REQUESTED.0);
    assert_eq!(network.link().axes[0].error, 0, "the others did obey");
}

#[test]
fn a_silent_axis_is_not_confirmed() {
    let (mut network, clock) = started();
    network.link_mut().axes[2].mute_since = Some(clock.now());
    let report = network.stop(&clock);
    let confirmed = report.drives.map(|drive| drive.power_off);
    assert_eq!(confirmed, [Confirmation::Confirmed, Confirmation::Confirmed, Confirmation::Unconfirmed]);
    assert!(
        report.drives.iter().all(|drive| drive.last_defence == LastDefence::RpdoTimeout),
        "seen to act at the start"
    );
}

#[test]
fn a_watchdog_is_told_of_only_after_it_was_seen_to_act() {
    let (mut network, clock) = network(|axes| axes[1].has_watchdog = false);
    assert_eq!(network.stop(&clock).drives.map(|drive| drive.last_defence), [LastDefence::None; 3], "never started");
    assert!(network.start(&clock).is_err());
    let seen = network.stop(&clock).drives.map(|drive| drive.last_defence);
    assert_eq!(seen, [LastDefence::RpdoTimeout, LastDefence::None, LastDefence::RpdoTimeout]);
}

/// A torque for axis 2 that this master did not send.
fn foreign_torque(at: Instant) -> Received {
    Received { frame: wire::torque_frame(AxisNode::new(2).unwrap(), 1.0), at }
}

#[test]
fn nothing_is_sent_on_a_bus_that_another_master_commands() {
    let (mut network, clock) = network(|_| {});
    network.link_mut().wire.push(foreign_torque(Instant::default() + Duration::from_millis(150)));
    let error = network.start(&clock).unwrap_err();
    let text = std::string::ToString::to_string(&error);
    // 2 × 32 + 14.
    assert!(
        text.starts_with("Set_Input_Torque to ODrive axis 2 (identifier 04Eh) is not from this controller"),
        "{text}"
    );
    let report = network.stop(&clock);
    assert!(report.drives.iter().all(|drive| drive.power_off == Confirmation::Withheld));
    assert_eq!(network.link().sent, [], "not even a stop");
}

#[test]
fn another_master_ends_a_start_and_a_run() {
    let (mut network, clock) = network(|_| {});
    // Behind 200 ms of listening, while the watchdogs are tried.
    network.link_mut().wire.push(foreign_torque(Instant::default() + Duration::from_millis(260)));
    let error = network.start(&clock).unwrap_err();
    assert!(
        matches!(error, OdriveStartError::AnotherMaster(foreign) if foreign.message == Message::SetInputTorque),
        "{error}"
    );
    let (mut network, mut clock) = started();
    assert!(cycle(&mut network, &mut clock, [0; 3]).is_ok());
    let request = Received { frame: wire::estimates_request(AxisNode::new(3).unwrap()), at: clock.now() };
    network.link_mut().wire.push(request);
    let error = cycle(&mut network, &mut clock, [0; 3]).unwrap_err();
    assert!(matches!(error, Error::AnotherMaster(foreign) if foreign.axis.raw() == 3), "{error}");
    assert!(network.stop(&clock).all_off(), "its own axes are stopped");
}

#[test]
fn two_axes_with_one_node_id_are_told_apart_from_one() {
    let (mut network, clock) = network(|axes| axes[1].has_twin = true);
    let error = network.start(&clock).unwrap_err();
    assert!(matches!(error, OdriveStartError::TwoAxes { axis } if axis.raw() == 2), "{error}");
    assert!(std::string::ToString::to_string(&error).contains("two axes with node id 2?"), "{error}");
    let (mut network, mut clock) = started();
    network.link_mut().axes[2].has_twin = true;
    let error = until_error(&mut network, &mut clock);
    assert!(matches!(error, Error::TwoAxes { axis } if axis.raw() == 3), "{error}");
}
