//! ODrive axes instead of CiA 402 drives, in virtual time: the paper's task, what no SYNC costs, no allocation, every exit.

mod support;

use std::cell::RefCell;
use std::collections::VecDeque;
use std::path::Path;
use std::rc::Rc;
use std::time::Duration;

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use hinf_control::{AdaptationGuard, Disturbance, Law};
use uarm::dimensions::{ACTIVE, CycleRecord, JOINTS, Progress};
use uarm::drives::{ToDrives, run_on};
use uarm::robot::Robot;
use uarm::robot::overrides::Overrides;
use uarm::simulated_plant::{PlantChoice, SimulatedPlant};
use uarm::simulated_robot::{SimulatedRobot, simulated};
use uarm_io::drive::RobotDrives;
use uarm_io::drive::odrive::wire::{AxisNode, AxisState, EncoderEstimates, Message};
use uarm_io::drive::odrive::{OdriveNetwork, Positions};
use uarm_io::drive::wire::Channel;
use uarm_io::frame::Frame;
use uarm_io::link::{Link, Received};
use uarm_io::time::{Clock, Instant};
use uarm_loop::control_loop::{ControlLoop, LoopEnd};
use uarm_loop::fault_code::FaultCode;
use uarm_loop::record::NoRecorder;
use uarm_loop::robot::Protocol;
use uarm_loop::run::{Observer, signal_path};
use uarm_loop::schedule::{OverrunPolicy, Schedule};
use uarm_loop::settings::Settings;
use uarm_loop::stop_request::StopRequest;
use uarm_loop::timing::TimingRecorder;
use uarm_sim::{InProcessError, InProcessLink, Pacing, VirtualClock};

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

const ODRIVE: &str = include_str!("../robots/uarm-odrive.toml");

fn odrive(change: (&str, &str)) -> Robot {
    assert!(ODRIVE.contains(change.0));
    Robot::parse(Path::new("test.toml"), &ODRIVE.replacen(change.0, change.1, 1), &Overrides::default()).unwrap()
}

type Simulated = InProcessLink<SimulatedRobot<SimulatedPlant>, VirtualClock>;

fn link(robot: &Robot, clock: &VirtualClock) -> Simulated {
    let plant = SimulatedPlant::new(robot, PlantChoice::Uarm, Disturbance::None).unwrap();
    InProcessLink::new(simulated(robot, plant, Pacing::WallClock).unwrap(), clock.clone())
}

/// L2 of the paper's task over `link`.
fn l2(robot: &Robot, link: impl Link<Error = InProcessError>, clock: &mut VirtualClock) -> f64 {
    let settings = Settings::paper(Law::Nonlinear);
    let mut controller = robot.controller(settings.law, AdaptationGuard::None).unwrap();
    let (progress, stop) = (Progress::default(), StopRequest::default());
    let observer = Observer { progress: &progress, stop: &stop };
    let ended =
        run_on(&robot.description, &settings, controller.as_mut(), ToDrives::over(link), clock, NoRecorder, observer)
            .unwrap();
    assert_eq!(ended.end.unwrap(), LoopEnd::Completed);
    assert!(ended.stop.all_off());
    ended.outcome.indices.l2
}

#[test]
fn the_task_on_odrive_axes_is_the_task_on_canopen_drives() {
    let task = |robot: &Robot| {
        let mut clock = VirtualClock::default();
        l2(robot, link(robot, &clock), &mut clock)
    };
    let (canopen, odrive) = (task(&Robot::load(None).unwrap()), task(&odrive(("", ""))));
    // The same counts at the same instants; only the torques differ, by the last bits of an f32.
    assert!((odrive / canopen - 1.0).abs() < 1e-5, "{odrive} and {canopen}");
}

/// A bus of 1 Mbit/s between the loop and the robot: one frame at a time, in the order in which they are handed over, each as
/// long as it is at worst. Arbitration between two that wait is left out.
struct TimedBus {
    robot: Simulated,
    clock: VirtualClock,
    free_at: Instant,
    to_robot: VecDeque<(Frame, Instant)>,
    to_loop: VecDeque<Received>,
    ages: Rc<RefCell<Ages>>,
}

/// When positions were latched, and how old they were when a torque left.
#[derive(Default)]
struct Ages {
    /// Joint 2 has a torque: not at the start and at the end, where there is no cycle.
    in_motion: bool,
    latched: [Option<Instant>; JOINTS],
    delivered: VecDeque<(usize, Instant, Instant)>,
    at_use: Vec<Duration>,
    spread: Vec<Duration>,
}

fn frame_time(frame: &Frame) -> Duration {
    Duration::from_micros(uarm_io::bus_time::worst_case_frame_bits(frame.data().len()).into())
}

/// The joint whose position a frame carries, or whose torque.
fn joint(frame: &Frame) -> (Option<usize>, Option<usize>) {
    let number = |node: u8| usize::from(node).checked_sub(1);
    match Message::of(frame.id()) {
        Some((Message::EncoderEstimates, axis)) if frame.data().len() == 8 => return (number(axis.raw()), None),
        Some((Message::SetInputTorque, axis)) if frame.data().len() == 4 => return (None, number(axis.raw())),
        _ => {}
    }
    match Channel::of(frame.id()) {
        Some(Channel::Tpdo1(node)) => (number(node.raw()), None),
        Some(Channel::Rpdo1(node)) => (None, number(node.raw())),
        _ => (None, None),
    }
}

impl TimedBus {
    fn new(robot: &Robot, clock: &VirtualClock) -> (Self, Rc<RefCell<Ages>>) {
        let ages = Rc::new(RefCell::new(Ages::default()));
        let mut robot = link(robot, clock);
        // The robot was on long before: what it said when its supply came is over.
        while robot.receive(Instant::default()).unwrap().is_some() {}
        let bus = Self {
            robot,
            clock: clock.clone(),
            free_at: Instant::default(),
            to_robot: VecDeque::new(),
            to_loop: VecDeque::new(),
            ages: Rc::clone(&ages),
        };
        (bus, ages)
    }

    /// When a frame that is ready at `ready` has passed.
    fn occupy(&mut self, frame: &Frame, ready: Instant) -> Instant {
        self.free_at = self.free_at.max(ready) + frame_time(frame);
        self.free_at
    }

    /// Takes in what the robot has sent by now.
    fn collect(&mut self) -> Result<(), InProcessError> {
        while let Some(received) = self.robot.receive(Instant::default())? {
            self.deliver(&received);
        }
        Ok(())
    }

    /// Puts a frame of the robot on the bus.
    fn deliver(&mut self, received: &Received) {
        let at = self.occupy(&received.frame, received.at);
        if let (Some(joint), _) = joint(&received.frame) {
            self.ages.borrow_mut().delivered.push_back((joint, received.at, at));
        }
        self.to_loop.push_back(Received { frame: received.frame, at });
    }
}

impl Ages {
    fn torque_leaves(&mut self, now: Instant) {
        while let Some((joint, latched, _)) = self.delivered.front().copied().filter(|(_, _, at)| *at <= now) {
            self.latched[joint] = Some(latched);
            self.delivered.pop_front();
        }
        if let ([Some(first), Some(second), Some(third)], true) = (self.latched, self.in_motion) {
            let (oldest, newest) = (first.min(second).min(third), first.max(second).max(third));
            self.at_use.push(now.since(oldest));
            self.spread.push(newest.since(oldest));
        }
    }
}

impl Link for TimedBus {
    type Error = InProcessError;

    fn send(&mut self, frame: &Frame) -> Result<Instant, InProcessError> {
        let now = self.clock.now();
        self.collect()?;
        match joint(frame).1 {
            Some(0) => self.ages.borrow_mut().torque_leaves(now),
            // Both protocols have the torque, or its upper half, in these bytes.
            Some(1) => self.ages.borrow_mut().in_motion = frame.data()[2..4] != [0, 0],
            _ => {}
        }
        let at = self.occupy(frame, now);
        self.to_robot.push_back((*frame, at));
        Ok(now)
    }

    fn receive(&mut self, deadline: Instant) -> Result<Option<Received>, InProcessError> {
        loop {
            let now = self.clock.now();
            while let Some((frame, _)) = self.to_robot.pop_front_if(|(_, at)| *at <= now) {
                self.robot.send(&frame)?;
            }
            self.collect()?;
            if let Some(received) = self.to_loop.pop_front_if(|received| received.at <= now) {
                return Ok(Some(received));
            }
            if now >= deadline {
                return Ok(None);
            }
            let outgoing = self.to_robot.front().map(|(_, at)| *at);
            let incoming = self.to_loop.front().map(|received| received.at);
            let wake = [outgoing, incoming].into_iter().flatten().fold(deadline, Instant::min);
            // The robot's own messages on the way there.
            if let Some(received) = self.robot.receive(wake)? {
                self.deliver(&received);
            }
        }
    }
}

/// Prints what stands in docs/odrive.md, section "No SYNC".
#[test]
fn what_no_sync_costs() {
    let canopen = Robot::load(None).unwrap();
    let rate = |milliseconds| odrive(("encoder_msg_rate_ms = 0", milliseconds));
    let cases = [
        ("CANopen, SYNC", canopen),
        ("ODrive, on request", rate("encoder_msg_rate_ms = 0")),
        ("ODrive, every 1 ms", rate("encoder_msg_rate_ms = 1")),
        ("ODrive, every 3 ms", rate("encoder_msg_rate_ms = 3")),
    ];
    println!(
        "| positions | age when the torque leaves, mean | max | between joints, mean | max | L2 |\n|---|---|---|---|---|---|"
    );
    let measured = cases.map(|(name, robot)| {
        let mut clock = VirtualClock::default();
        let (bus, ages) = TimedBus::new(&robot, &clock);
        let l2 = l2(&robot, bus, &mut clock);
        let ages = ages.borrow();
        let micro = |duration: Duration| duration.as_secs_f64() * 1e6;
        let mean = |of: &[Duration]| of.iter().copied().map(micro).sum::<f64>() / of.len() as f64;
        let most = |of: &[Duration]| of.iter().copied().map(micro).fold(0.0, f64::max);
        let [age, oldest, apart, furthest] =
            [mean(&ages.at_use), most(&ages.at_use), mean(&ages.spread), most(&ages.spread)];
        println!("| {name} | {age:.0} µs | {oldest:.0} µs | {apart:.0} µs | {furthest:.0} µs | {l2:.5} |");
        (age, oldest, furthest, l2)
    });
    let [sync, asked, fast, slow] = measured;
    assert_eq!(sync.2, 0.0, "one SYNC, one instant");
    assert!(asked.1 < 1_000.0 && asked.2 > 100.0, "answers follow one another: {asked:?}");
    assert!(fast.1 < 2_000.0 && slow.1 > 2_000.0 && slow.1 < 4_000.0, "{fast:?} {slow:?}");
    for (_, _, _, l2) in [asked, fast, slow] {
        assert!((l2 / sync.3 - 1.0).abs() < 0.05, "{measured:?}");
    }
}

#[test]
fn the_cycle_allocates_nothing() {
    let robot = odrive(("", ""));
    let mut clock = VirtualClock::default();
    let configuration = robot.description.odrive_configuration(Positions::OnRequest).unwrap();
    let mut drives: OdriveNetwork<_, JOINTS> = OdriveNetwork::new(link(&robot, &clock), configuration);
    let settings = Settings::paper(Law::Nonlinear);
    let mut controller = robot.controller(settings.law, AdaptationGuard::None).unwrap();
    let (progress, stop) = (uarm_loop::progress::Progress::<ACTIVE>::default(), StopRequest::default());
    let mut control_loop = ControlLoop {
        feedback_timeout: robot.description.feedback_timeout,
        path: signal_path(&robot.description, &settings, controller.as_mut()).unwrap(),
        timing: TimingRecorder::new(robot.description.period.duration()),
        progress: &progress,
        stop: &stop,
    };
    drives.start(&clock).unwrap();
    let first = clock.now() + Duration::from_millis(3);
    let mut schedule = Schedule::new(first, robot.description.period, OverrunPolicy::Skip);
    let mut supervisor = support::running_supervisor();
    let end =
        assert_no_alloc(|| control_loop.run(&mut drives, &mut clock, &mut schedule, &mut NoRecorder, &mut supervisor));
    assert_eq!(end.unwrap(), LoopEnd::Completed);
    assert!(drives.stop(&clock).all_off());
}

/// A link that notes each state that is asked for, and ends the run at the 400th torque.
struct Witness<'a> {
    link: Simulated,
    torques: usize,
    states: &'a RefCell<Vec<(u8, AxisState)>>,
    last_torques: &'a RefCell<[f32; JOINTS]>,
    at_400: &'a dyn Fn(),
}

impl Link for Witness<'_> {
    type Error = InProcessError;

    fn send(&mut self, frame: &Frame) -> Result<Instant, InProcessError> {
        match Message::of(frame.id()) {
            Some((Message::SetAxisState, axis)) => {
                let state = uarm_io::drive::odrive::wire::decode_state(frame.data()).unwrap();
                self.states.borrow_mut().push((axis.raw(), state));
            }
            Some((Message::SetInputTorque, axis)) => {
                let torque = uarm_io::drive::odrive::wire::decode_torque(frame.data()).unwrap();
                self.last_torques.borrow_mut()[usize::from(axis.raw()) - 1] = torque;
                self.torques += 1;
                if self.torques == 3 * 400 {
                    (self.at_400)();
                }
            }
            _ => {}
        }
        self.link.send(frame)
    }

    fn receive(&mut self, deadline: Instant) -> Result<Option<Received>, InProcessError> {
        self.link.receive(deadline)
    }
}

/// Joint 2 behind a gear: ten turns of a motor with a tenth of the torque are the joint's one.
#[test]
fn a_geared_axis_does_the_task_as_a_direct_one() {
    const DIRECT: &str = "node = 2\nencoder = { counts_per_revolution = 33739, counter_bits = 32, direction = \"positive\", \
                          zero_counts = 0 }\ndrive = { rated_torque_nm = 0.2, writes = [] }";
    const GEARED: &str = "node = 2\ngear_ratio = [10, 1]\nencoder = { counts_per_revolution = 8192, counter_bits = 32, \
                          direction = \"positive\", zero_counts = 0 }\ndrive = { rated_torque_nm = 0.02, writes = [] }";
    let index = |robot: &Robot| {
        let mut clock = VirtualClock::default();
        let link = link(robot, &clock);
        l2(robot, link, &mut clock)
    };
    let (direct, geared) = (index(&odrive(("", ""))), index(&odrive((DIRECT, GEARED))));
    // The finer counts of the geared encoder are all that differs.
    assert!((geared / direct - 1.0).abs() < 0.02, "{geared} and {direct}");
    let axes = odrive((DIRECT, GEARED)).description.odrive_configuration(Positions::OnRequest).unwrap().axes;
    assert_eq!(axes.map(|axis| axis.counts_per_turn.ratio()), [(33_739, 1), (8_192, 1), (33_739, 1)]);
}

fn end_of(stop: &StopRequest, at_400: &dyn Fn()) {
    let robot = odrive(("", ""));
    assert!(matches!(robot.description.bus.protocol, Protocol::Odrive(Positions::OnRequest)));
    let mut clock = VirtualClock::default();
    let (states, last_torques) = (RefCell::default(), RefCell::default());
    let link = Witness { link: link(&robot, &clock), torques: 0, states: &states, last_torques: &last_torques, at_400 };
    let settings = Settings::paper(Law::Nonlinear);
    let mut controller = robot.controller(settings.law, AdaptationGuard::None).unwrap();
    let progress = Progress::default();
    let observer = Observer { progress: &progress, stop };
    let ended = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
        run_on(
            &robot.description,
            &settings,
            controller.as_mut(),
            ToDrives::over(link),
            &mut clock,
            NoRecorder,
            observer,
        )
        .map(|_| ())
    }));
    let _ = ended;
    let states = states.into_inner();
    assert_eq!(states[states.len() - 3..], [1, 2, 3].map(|node| (node, AxisState::IDLE)), "the last word is IDLE");
    assert_eq!(last_torques.into_inner(), [0.0; JOINTS], "and torque 0");
}

#[test]
fn a_signal_and_a_panic_end_idle_with_torque_zero() {
    let stop = StopRequest::default();
    end_of(&stop, &|| stop.make());
    end_of(&StopRequest::default(), &|| panic!("a bug in the loop"));
}

/// A link on which the position of joint 2 is falsified from [`FALSE_FROM`] on: turns in, turns out.
struct Falsified<F> {
    link: Simulated,
    positions: usize,
    falsify: F,
}

impl<F: FnMut(f32) -> f32> Link for Falsified<F> {
    type Error = InProcessError;

    fn send(&mut self, frame: &Frame) -> Result<Instant, InProcessError> {
        self.link.send(frame)
    }

    fn receive(&mut self, deadline: Instant) -> Result<Option<Received>, InProcessError> {
        let Some(received) = self.link.receive(deadline)? else { return Ok(None) };
        if joint(&received.frame).0 != Some(1) {
            return Ok(Some(received));
        }
        self.positions += 1;
        if self.positions < FALSE_FROM {
            return Ok(Some(received));
        }
        let bytes = received.frame.data();
        let position = f32::from_le_bytes(bytes[..4].try_into().unwrap());
        let estimates = EncoderEstimates { position: (self.falsify)(position), velocity: 0.0 };
        Ok(Some(Received { frame: estimates.frame(AxisNode::new(2).unwrap()), ..received }))
    }
}

/// Requests of a position: at half time of the task, where joint 2 is fastest.
const FALSE_FROM: usize = 500;

/// Turns that an axis would have sent to turns that it sends.
type Falsify<'a> = &'a mut dyn FnMut(f32) -> f32;

#[test]
fn an_encoder_that_jumps_reverses_or_is_no_number_ends_the_run_in_time() {
    let end_with = |falsify: Falsify<'_>| {
        let robot = odrive(("", ""));
        let mut clock = VirtualClock::default();
        let link = Falsified { link: link(&robot, &clock), positions: 0, falsify };
        let settings = Settings::paper(Law::Nonlinear);
        let mut controller = robot.controller(settings.law, AdaptationGuard::None).unwrap();
        let (progress, stop) = (Progress::default(), StopRequest::default());
        let observer = Observer { progress: &progress, stop: &stop };
        let ways = ToDrives::over(link);
        let recorder = Vec::<CycleRecord>::new();
        let ended =
            run_on(&robot.description, &settings, controller.as_mut(), ways, &mut clock, recorder, observer).unwrap();
        assert!(ended.stop.all_off());
        (ended.end.unwrap_err().code, ended.recorder.len())
    };
    let mut first = None;
    let faults: [(&str, Falsify<'_>, usize); 3] = [
        ("jumps", &mut |turns| turns + 0.15, 2),
        ("reverses", &mut |turns| 2.0 * *first.get_or_insert(turns) - turns, 10),
        ("no number", &mut |_| f32::NAN, 2),
    ];
    for (name, falsify, bound) in faults {
        let (code, cycles) = end_with(falsify);
        assert_eq!(code, FaultCode::EncoderImplausible, "{name}");
        // A few of the positions were asked for before the first cycle.
        assert!((FALSE_FROM - 10..FALSE_FROM + bound).contains(&cycles), "{name}: {cycles}");
    }
}
