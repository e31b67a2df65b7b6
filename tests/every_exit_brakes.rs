//! However a run ends, it ends with torque 0, quick stop, power off and NMT stop on the wire, and every brake closed.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use hinf_control::{
    AdaptationGuard, Command, Controller, Disturbance, FrozenState, Law, LimitedJoints, Measurement, Reference,
    ThawError,
};
use uarm::dimensions::CycleRecord;
use uarm::dimensions::Progress;
use uarm::dimensions::{ACTIVE, JOINTS};
use uarm::robot::Robot;
use uarm::simulated_plant::PlantChoice;
use uarm::simulated_plant::SimulatedPlant;
use uarm::simulated_robot::emulate;
use uarm_io::drive::DriveNetwork;
use uarm_io::drive::network::{CycleError, StartError};
use uarm_io::drive::wire::Channel;
use uarm_io::frame::Frame;
use uarm_io::link::{Link, ObservedLink, Received};
use uarm_io::time::Instant;
use uarm_loop::control_loop::LoopEnd;
use uarm_loop::fault_code::{Coded, FaultCode};
use uarm_loop::record::{NoRecorder, Recorder};
use uarm_loop::run::{self, Observer};
use uarm_loop::settings::Settings;
use uarm_loop::stop_request::StopRequest;
use uarm_sim::{Brake, DriveFault, EmulatedRobot, InProcessError, InProcessLink, Joint, Pacing, VirtualClock};

type Finished<R = NoRecorder, E = InProcessError> = run::Finished<StartError<E>, CycleError<E>, R, JOINTS, ACTIVE>;

/// SYNCs before something happens: well inside the motion.
const IN_MOTION: usize = 400;

/// What a test sees of the other end of the link.
#[derive(Default)]
struct Seen {
    sent: Vec<Frame>,
    syncs: usize,
    brakes: Option<[Brake; 3]>,
}

/// A link that lets something happen in the midst of the motion, and shows what is sent.
struct Witness<F> {
    link: InProcessLink<EmulatedRobot<SimulatedPlant>, VirtualClock>,
    seen: Arc<Mutex<Seen>>,
    in_motion: F,
}

impl<F: FnMut(&mut InProcessLink<EmulatedRobot<SimulatedPlant>, VirtualClock>)> Link for Witness<F> {
    type Error = InProcessError;

    fn send(&mut self, frame: &Frame) -> Result<Instant, InProcessError> {
        let mut seen = self.seen.lock().unwrap();
        seen.sent.push(*frame);
        if Channel::of(frame.id()) == Some(Channel::Sync) {
            seen.syncs += 1;
            if seen.syncs == IN_MOTION {
                (self.in_motion)(&mut self.link);
            }
        }
        let sent = self.link.send(frame);
        seen.brakes = Some(self.link.robot().brakes());
        sent
    }

    fn receive(&mut self, deadline: Instant) -> Result<Option<Received>, InProcessError> {
        let received = self.link.receive(deadline);
        self.seen.lock().unwrap().brakes = Some(self.link.robot().brakes());
        received
    }
}

fn settings() -> Settings {
    Settings::paper(Law::Nonlinear)
}

/// A link to the simulated robot.
fn link(
    robot: &Robot,
    disturbance: Disturbance,
    clock: &VirtualClock,
) -> InProcessLink<EmulatedRobot<SimulatedPlant>, VirtualClock> {
    let plant = SimulatedPlant::new(robot, PlantChoice::Uarm, disturbance).unwrap();
    InProcessLink::new(emulate(robot, plant, Pacing::WallClock).unwrap(), clock.clone())
}

/// Runs an experiment over `link`.
fn run_on<L: Link, R: Recorder<JOINTS, ACTIVE>>(
    robot: &Robot,
    settings: &Settings,
    link: L,
    clock: &mut VirtualClock,
    recorder: R,
    stop: &StopRequest,
) -> Finished<R, L::Error>
where
    L::Error: 'static,
{
    let mut controller = robot.controller(settings.law, AdaptationGuard::None).unwrap();
    run_law(controller.as_mut(), robot, settings, link, clock, recorder, stop)
}

/// The same under any law.
fn run_law<L: Link, R: Recorder<JOINTS, ACTIVE>>(
    controller: &mut dyn Controller<f64, ACTIVE>,
    robot: &Robot,
    settings: &Settings,
    link: L,
    clock: &mut VirtualClock,
    recorder: R,
    stop: &StopRequest,
) -> Finished<R, L::Error>
where
    L::Error: 'static,
{
    let drives = DriveNetwork::new(link, robot.description.network_configuration().unwrap());
    let observer = Observer { progress: &Progress::default(), stop };
    run::run(&robot.description, settings, controller, drives, clock, recorder, observer).unwrap()
}

/// Runs an experiment in which `in_motion` happens.
fn run<R: Recorder<JOINTS, ACTIVE>>(
    robot: &Robot,
    recorder: R,
    stop: &StopRequest,
    in_motion: impl FnMut(&mut InProcessLink<EmulatedRobot<SimulatedPlant>, VirtualClock>),
) -> (std::thread::Result<Finished<R>>, Seen) {
    let mut clock = VirtualClock::default();
    let link = link(robot, Disturbance::Paper, &clock);
    let seen = Arc::new(Mutex::new(Seen::default()));
    let witness = Witness { link, seen: Arc::clone(&seen), in_motion };
    let finished = catch_unwind(AssertUnwindSafe(|| run_on(robot, &settings(), witness, &mut clock, recorder, stop)));
    let seen = Arc::into_inner(seen).unwrap().into_inner().unwrap();
    (finished, seen)
}

/// What must be on the wire and at the joints in the end.
fn assert_braked(seen: &Seen) {
    assert!(seen.syncs >= IN_MOTION, "the robot was in motion");
    assert_eq!(seen.brakes, Some([Brake::Engaged; 3]), "every brake is closed");
    let after = seen.sent.iter().rposition(|frame| Channel::of(frame.id()) == Some(Channel::Sync)).unwrap();
    let last_words = &seen.sent[after..];
    for node in 1..=3_u8 {
        let commands: Vec<_> = last_words
            .iter()
            .filter(|frame| matches!(Channel::of(frame.id()), Some(Channel::Rpdo1(of)) if of.raw() == node))
            .map(|frame| frame.data().to_vec())
            .collect();
        // Controlword: bit 1 (enable voltage) set and bit 2 (quick stop, low active) clear; then bit 1 clear.
        let quick_stop = commands.iter().position(|data| data[0] & 0b110 == 0b010).expect("a quick stop");
        let power_off = commands.iter().position(|data| data[0] & 0b010 == 0).expect("power off");
        assert!(quick_stop < power_off, "node {node}: quick stop comes first");
        assert!(commands[quick_stop..].iter().all(|data| data[2..4] == [0, 0]), "node {node}: torque 0");
    }
    let nmt: Vec<_> = last_words.iter().filter(|frame| Channel::of(frame.id()) == Some(Channel::NmtCommand)).collect();
    assert!(nmt.iter().any(|frame| frame.data()[0] == 0x02), "NMT stop: {nmt:?}");
}

fn failed_with(finished: std::thread::Result<Finished>, parts: &[&str]) {
    let error = finished.unwrap().end.unwrap_err().to_string();
    for part in parts {
        assert!(error.contains(part), "{part:?} in {error:?}");
    }
}

#[test]
fn at_the_end_of_the_motion() {
    let robot = Robot::load(None).unwrap();
    let (finished, seen) = run(&robot, NoRecorder, &StopRequest::default(), |_| {});
    let finished = finished.unwrap();
    assert_eq!(finished.end.unwrap(), LoopEnd::Completed);
    assert!(finished.stop.all_off(), "{:?}", finished.stop);
    assert_braked(&seen);
}

/// What each joint's drive was sent as target torque, per mille, from the first cycle after so many SYNCs on.
fn torques_after(seen: &Seen, syncs: usize) -> Vec<[i16; 3]> {
    let mut cycles = Vec::new();
    for frame in &seen.sent {
        match Channel::of(frame.id()) {
            Some(Channel::Sync) => cycles.push([0; 3]),
            Some(Channel::Rpdo1(node)) => {
                let torque = i16::from_le_bytes([frame.data()[2], frame.data()[3]]);
                if let Some(cycle) = cycles.last_mut() {
                    // The stop after the last cycle sends torque 0 again.
                    cycle[usize::from(node.raw()) - 1] = torque;
                }
            }
            _ => {}
        }
    }
    cycles.split_off(syncs)
}

/// 50 ms are 16 2/3 periods: in the seventeenth cycle after the request nothing is left.
#[test]
fn when_somebody_asks_for_it_the_torques_fade_first() {
    let robot = Robot::load(None).unwrap();
    let stop = StopRequest::default();
    let (finished, seen) = run(&robot, NoRecorder, &stop, |_| stop.make());
    assert_eq!(finished.unwrap().end.unwrap(), LoopEnd::Interrupted);
    assert_braked(&seen);
    let torques = torques_after(&seen, IN_MOTION - 1);
    let before = torques[0].map(f64::from);
    assert!(before[1].abs() > 50.0, "{before:?}");
    assert_eq!(torques.len(), 1 + 17, "{torques:?}");
    for (cycle, torque) in torques.iter().enumerate().skip(1) {
        let left = (1.0 - 3.0 * f64::from(u32::try_from(cycle).unwrap()) / 50.0).max(0.0);
        for joint in 0..3 {
            assert!(f64::from(torque[joint]).abs() <= before[joint].abs() * left + 0.5 * (1.0 + left), "{torques:?}");
        }
    }
    assert!(torques[9][1].abs() > 10, "it is a ramp: {torques:?}");
    assert_eq!(torques[17], [0; 3]);
}

#[test]
fn when_somebody_asks_twice_the_rest_of_the_ramp_is_skipped() {
    /// Asks again in the third cycle of the ramp.
    struct Impatient(usize, StopRequest);
    impl Recorder<JOINTS, ACTIVE> for Impatient {
        fn record(&mut self, _record: &CycleRecord) {
            self.0 += 1;
            if self.0 == IN_MOTION + 3 {
                self.1.make();
            }
        }
    }
    let robot = Robot::load(None).unwrap();
    let stop = StopRequest::default();
    let (finished, seen) = run(&robot, Impatient(0, stop.clone()), &stop, |_| stop.make());
    assert_eq!(finished.unwrap().end.unwrap(), LoopEnd::Interrupted);
    assert_braked(&seen);
    assert_eq!(seen.syncs, IN_MOTION + 3);
}

#[test]
fn who_asks_before_the_brakes_open_keeps_them_closed() {
    let robot = Robot::load(None).unwrap();
    let stop = StopRequest::default();
    stop.make();
    let (finished, seen) = run(&robot, NoRecorder, &stop, |_| {});
    let finished = finished.unwrap();
    assert_eq!((finished.end.unwrap(), finished.outcome.last_time), (LoopEnd::Interrupted, None));
    let enables =
        |frame: &&Frame| matches!(Channel::of(frame.id()), Some(Channel::Rpdo1(_))) && frame.data()[0] & 0b1000 != 0;
    assert_eq!((seen.syncs, seen.sent.iter().find(enables)), (0, None), "no drive was told to enable operation");
}

#[test]
fn when_the_loop_panics() {
    struct Panics(usize);
    impl Recorder<JOINTS, ACTIVE> for Panics {
        fn record(&mut self, _record: &CycleRecord) {
            self.0 += 1;
            assert!(self.0 < IN_MOTION, "a bug in the loop");
        }
    }
    let robot = Robot::load(None).unwrap();
    let (finished, seen) = run(&robot, Panics(0), &StopRequest::default(), |_| {});
    assert!(finished.is_err(), "the panic goes on after the brakes have closed");
    assert_braked(&seen);
}

/// What of a law's numbers is none.
#[derive(Clone, Copy, Debug)]
enum Spoiled {
    Torque,
    ControlInput,
    Parameter,
    /// The law says itself that it met one, and asks for no torque.
    Told,
}

/// Controller 1 with one number that is NaN from its cycle [`IN_MOTION`] on.
struct Spoiling<'a> {
    law: &'a mut dyn Controller<f64, ACTIVE>,
    spoiled: Spoiled,
    cycles: usize,
    parameters: [f64; 2],
}

impl Controller<f64, ACTIVE> for Spoiling<'_> {
    fn update(&mut self, measurement: &Measurement<f64>, reference: &Reference<f64>, period: f64) -> Command<f64> {
        let mut command = self.law.update(measurement, reference, period);
        self.cycles += 1;
        if self.cycles >= IN_MOTION {
            match self.spoiled {
                Spoiled::Torque => command.torque.y = f64::NAN,
                Spoiled::ControlInput => command.control_input.x = f64::NAN,
                Spoiled::Parameter => self.parameters[1] = f64::NAN,
                Spoiled::Told => command = Command::fallback(command.adaptation),
            }
        }
        command
    }
    fn limited(&mut self, joints: LimitedJoints) {
        self.law.limited(joints);
    }
    fn parameters(&self) -> &[f64] {
        &self.parameters
    }
    fn reset(&mut self) {
        self.law.reset();
    }
    fn freeze(&self) -> FrozenState<f64> {
        self.law.freeze()
    }
    fn thaw(&mut self, state: &FrozenState<f64>) -> Result<(), ThawError> {
        self.law.thaw(state)
    }
}

/// In the cycle in which it is: no torque is made of it.
#[test]
fn when_a_number_of_the_law_is_none() {
    for (spoiled, words) in [
        (Spoiled::Torque, "joint 3: the torque that the law asks for is NaN, expected a finite number"),
        (Spoiled::ControlInput, "joint 2: the control input is NaN, expected a finite number"),
        (Spoiled::Parameter, "adapted parameter 2 is NaN, expected a finite number"),
        (Spoiled::Told, "a number within the control law is not finite"),
    ] {
        let robot = Robot::load(None).unwrap();
        let mut law = robot.controller(Law::Nonlinear, AdaptationGuard::None).unwrap();
        let mut law = Spoiling { law: law.as_mut(), spoiled, cycles: 0, parameters: [1.0, 2.0] };
        let mut clock = VirtualClock::default();
        let seen = Arc::new(Mutex::new(Seen::default()));
        let link = link(&robot, Disturbance::Paper, &clock);
        let witness = Witness { link, seen: Arc::clone(&seen), in_motion: |_: &mut _| {} };
        let stop = StopRequest::default();
        let finished = run_law(&mut law, &robot, &settings(), witness, &mut clock, Vec::new(), &stop);
        let error = finished.end.unwrap_err();
        assert_eq!((error.code(), error.to_string().as_str()), (FaultCode::NotFinite, words));
        assert_eq!(finished.recorder.len(), IN_MOTION - 1, "{words}");
        let seen = seen.lock().unwrap();
        assert_braked(&seen);
        assert_eq!(torques_after(&seen, IN_MOTION - 1), [[0; 3]], "{words}");
    }
}

#[test]
fn when_a_drive_reports_a_fault() {
    let robot = Robot::load(None).unwrap();
    let (finished, seen) = run(&robot, NoRecorder, &StopRequest::default(), |link| {
        link.inject(Joint::TWO, DriveFault::OverTemperature);
    });
    failed_with(finished, &["node 2"]);
    assert_braked(&seen);
}

/// In the cycle in which it says so.
#[test]
fn when_a_drive_ignores_its_target() {
    let robot = Robot::load(None).unwrap();
    let (finished, seen) = run(&robot, NoRecorder, &StopRequest::default(), |link| {
        link.inject(Joint::THREE, DriveFault::TargetIgnored);
    });
    failed_with(finished, &["node 3 ignores its target torque"]);
    assert_braked(&seen);
    assert_eq!(seen.syncs, IN_MOTION);
}

#[test]
fn when_a_joint_turns_before_the_brakes_open_they_stay_closed() {
    let robot = Robot::load(None).unwrap();
    let mut clock = VirtualClock::default();
    let mut link = link(&robot, Disturbance::None, &clock);
    link.inject(Joint::TWO, DriveFault::EncoderDrift { counts: 20 });
    let enabled = AtomicBool::new(false);
    let link = ObservedLink::new(link, |_, frame: &Frame, _| {
        if matches!(Channel::of(frame.id()), Some(Channel::Rpdo1(_))) && frame.data()[0] & 0b1000 != 0 {
            enabled.store(true, Ordering::Relaxed);
        }
    });
    let finished = run_on(&robot, &settings(), link, &mut clock, NoRecorder, &StopRequest::default());
    let error = finished.end.unwrap_err();
    assert_eq!(error.code(), FaultCode::JointTurning, "{error}");
    assert!(error.to_string().starts_with("joint 2 turned"), "{error}");
    assert!(!enabled.load(Ordering::Relaxed));
}

#[test]
fn when_a_drive_loses_its_supply() {
    let robot = Robot::load(None).unwrap();
    let (finished, seen) = run(&robot, NoRecorder, &StopRequest::default(), |link| {
        link.inject(Joint::THREE, DriveFault::PowerLost);
    });
    failed_with(finished, &["joint 3", "no position"]);
    assert_braked(&seen);
}

#[test]
fn when_an_encoder_jumps() {
    let robot = Robot::load(None).unwrap();
    let (finished, seen) = run(&robot, NoRecorder, &StopRequest::default(), |link| {
        link.inject(Joint::TWO, DriveFault::EncoderJump { counts: 5_000 });
    });
    failed_with(finished, &["joint 2", "counts"]);
    assert_braked(&seen);
}

#[test]
fn when_a_joint_leaves_its_limits() {
    let mut robot = Robot::load(None).unwrap();
    robot.description.joints[1].limits.position[1] = 25.0_f64.to_radians();
    let (finished, seen) = run(&robot, NoRecorder, &StopRequest::default(), |_| {});
    failed_with(finished, &["joint 2", "angle", "25.00 deg"]);
    assert_eq!(seen.brakes, Some([Brake::Engaged; 3]));
}

#[test]
fn when_the_joints_do_not_stand_at_the_start_nothing_moves() {
    let mut robot = Robot::load(None).unwrap();
    // The encoder is mounted five degrees off from what the controller believes.
    robot.description.joints[2].encoder.zero += 469;
    let plant = Robot::load(None).unwrap();
    let mut clock = VirtualClock::default();
    let enabled = AtomicBool::new(false);
    let on_plant = ObservedLink::new(link(&plant, Disturbance::None, &clock), |_, frame: &Frame, _| {
        // The controlword's bit 3 is *enable operation*, with which brakes open.
        if matches!(Channel::of(frame.id()), Some(Channel::Rpdo1(_))) && frame.data()[0] & 0b1000 != 0 {
            enabled.store(true, Ordering::Relaxed);
        }
    });
    let stop = StopRequest::default();
    let finished = run_on(&robot, &settings(), on_plant, &mut clock, NoRecorder, &stop);
    let error = finished.end.unwrap_err().to_string();
    assert!(error.contains("joint 3") && error.contains("distance from the start"), "{error}");
    assert_eq!(finished.outcome.peak_torque, [0.0; 2]);
    assert!(!enabled.load(Ordering::Relaxed), "the brakes stay closed");

    // With an approach the same robot goes there first, and then does its task.
    let mut clock = VirtualClock::default();
    let on_plant = link(&plant, Disturbance::None, &clock);
    let settings = Settings { approach: Some(Duration::from_secs(5)), ..settings() };
    let finished = run_on(&robot, &settings, on_plant, &mut clock, Vec::new(), &stop);
    assert_eq!(finished.end.unwrap(), LoopEnd::Completed);
    assert_eq!(finished.recorder.first().unwrap().time, -5.0);
    // The tilted table has set the base swinging meanwhile, which controller 1 with an eliminated base feels.
    assert!(finished.outcome.final_error.iter().all(|error| error.abs() < 0.05), "{:?}", finished.outcome);
}
