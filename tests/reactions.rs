//! Faults that are injected into the real loop, in virtual time: what answers them, how soon, and that nothing answers where there is
//! no fault.

mod support;

use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use hinf_control::{AdaptationGuard, Disturbance, Law, QuinticReference};
use nalgebra::{Vector2, Vector3};
use uarm::dimensions::{ACTIVE, CycleRecord, JOINTS, Progress};
use uarm::drives::{Ended, ToDrives, run_on};
use uarm::robot::Robot;
use uarm::robot::overrides::Overrides;
use uarm::simulated_plant::{PlantChoice, SimulatedPlant};
use uarm::simulated_robot::{emulate, simulated};
use uarm_io::link::Link;
use uarm_loop::control_loop::LoopEnd;
use uarm_loop::fault_code::FaultCode;
use uarm_loop::record::{NoRecorder, Recorder};
use uarm_loop::run::Observer;
use uarm_loop::saturation::SaturationLimit;
use uarm_loop::settings::Settings;
use uarm_loop::stop_request::StopRequest;
use uarm_sim::{Brake, InProcessLink, Pacing, Plant, VirtualClock};

/// Runs `law` over `link`.
fn run<L: Link, R: Recorder<JOINTS, ACTIVE>>(
    robot: &Robot,
    settings: &Settings,
    link: L,
    mut clock: VirtualClock,
    recorder: R,
) -> Ended<R>
where
    L::Error: Send + Sync + 'static,
{
    let mut controller = robot.controller(settings.law, settings.guard).unwrap();
    let (progress, stop) = (Progress::default(), StopRequest::default());
    let observer = Observer { progress: &progress, stop: &stop };
    run_on(&robot.description, settings, controller.as_mut(), ToDrives::over(link), &mut clock, recorder, observer)
        .unwrap()
}

/// For how long a torque was cut without a break, at most, s.
#[derive(Default)]
struct Saturation {
    lasting: [f64; ACTIVE],
    longest: f64,
}

impl Recorder<JOINTS, ACTIVE> for Saturation {
    fn record(&mut self, record: &CycleRecord) {
        for (lasting, limited) in self.lasting.iter_mut().zip(record.flags.limited) {
            *lasting = if limited { *lasting + 0.003 } else { 0.0 };
            self.longest = self.longest.max(*lasting);
        }
    }
}

/// Every shipped robot, law and plant, with adaptation and disturbance as the documents have them: nothing is stopped, and no torque is
/// cut for as long as a fifth of what stops a run.
#[test]
fn nothing_answers_where_there_is_no_fault() {
    let mut longest = 0.0_f64;
    for file in ["uarm.toml", "uarm-hardware.toml", "uarm-odrive.toml"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(file);
        let robot = Robot::load_with(Some(&path), &Overrides::default()).unwrap();
        for law in Law::ALL {
            for (plant, guard) in [
                (PlantChoice::Uarm, AdaptationGuard::None),
                (PlantChoice::Ideal, AdaptationGuard::None),
                (PlantChoice::Uarm, AdaptationGuard::Bounded),
            ] {
                let clock = VirtualClock::default();
                let settings = Settings { guard, ..Settings::paper(law) };
                let plant_of_run = SimulatedPlant::new(&robot, plant, Disturbance::Paper).unwrap();
                let link =
                    InProcessLink::new(simulated(&robot, plant_of_run, Pacing::WallClock).unwrap(), clock.clone());
                let ended = run(&robot, &settings, link, clock, Saturation::default());
                let end = ended.end.unwrap_or_else(|failure| panic!("{file}, {law:?}, {plant:?}: {}", failure.cause));
                assert_eq!(end, LoopEnd::Completed);
                longest = longest.max(ended.recorder.longest);
            }
        }
    }
    let limit = SaturationLimit::default().duration().as_secs_f64();
    assert!(longest < limit / 5.0, "{longest} s");
}

/// The cycles of a run of controller 1 on the paper's robot, and the code of the fault that ended it.
fn recorded(robot: &Robot) -> (Vec<CycleRecord>, Option<FaultCode>) {
    let clock = VirtualClock::default();
    let plant = SimulatedPlant::new(robot, PlantChoice::Uarm, Disturbance::Paper).unwrap();
    let link = InProcessLink::new(emulate(robot, plant, Pacing::WallClock).unwrap(), clock.clone());
    let ended = run(robot, &Settings::paper(Law::Nonlinear), link, clock, Vec::new());
    (ended.recorder, ended.end.err().map(|failure| failure.code))
}

/// The same run twice, without a limit and with one of half a degree: the second ends in the cycle in which the first is beyond it.
#[test]
fn a_tracking_error_beyond_its_limit_ends_the_run_in_its_cycle() {
    let mut robot = Robot::load(None).unwrap();
    let limit = 0.5_f64.to_radians();
    robot.description.tracking_error_limit = f64::INFINITY;
    let (all, code) = recorded(&robot);
    assert_eq!((all.len(), code), (1_167, None), "3.5 s in periods of 3 ms");
    let is_beyond = |cycle: &CycleRecord| cycle.tracking_error().position.amax() > limit;
    let first = all.iter().position(is_beyond).unwrap();
    assert!((10..1_000).contains(&first), "{first}");
    robot.description.tracking_error_limit = limit;
    let (until, code) = recorded(&robot);
    assert_eq!((until.len(), code), (first, Some(FaultCode::TrackingError)));
}

/// Joint 2 needs more than a fortieth of its torque. 50 ms are 16 periods of 3 ms and a part of the next, whose torque is not sent any more.
#[test]
fn a_torque_that_is_cut_for_too_long_ends_the_run() {
    let mut robot = Robot::load(None).unwrap();
    robot.description.tracking_error_limit = f64::INFINITY;
    robot.description.supervision = None;
    robot.description.joints[1].torque_limit = 0.005;
    robot.description.saturation_limit = SaturationLimit::new(Duration::from_millis(50)).unwrap();
    let (cycles, code) = recorded(&robot);
    assert_eq!(code, Some(FaultCode::TorqueSaturated));
    let cut = cycles.iter().rev().take_while(|cycle| cycle.flags.limited[0]).count();
    assert_eq!(cut, 16);
    assert!(cycles.iter().all(|cycle| cycle.torque_applied[0].abs() <= 0.005));
}

/// What is known of the plant beside the loop.
#[derive(Debug)]
struct Truth<P> {
    /// Largest and smallest true angles of joint 2 and 3, rad.
    range: [[f64; 2]; ACTIVE],
    /// Largest true velocities of joints 2 and 3, rad/s.
    fastest: [f64; ACTIVE],
    plant: Option<P>,
    closing: Option<Duration>,
}

impl<P: Plant> Truth<P> {
    fn see(&mut self, plant: &P) {
        for joint in 0..ACTIVE {
            let (angle, velocity) = (plant.position()[joint + 1], plant.velocity()[joint + 1]);
            let [least, most] = &mut self.range[joint];
            (*least, *most) = (least.min(angle), most.max(angle));
            self.fastest[joint] = self.fastest[joint].max(velocity.abs());
        }
    }
}

/// A plant whose brakes take time to close, and whose truth is seen.
#[derive(Clone, Debug)]
struct SlowBrakes<P> {
    inner: P,
    brake: Duration,
    closing: Option<Duration>,
    truth: Arc<Mutex<Truth<P>>>,
}

/// How often the truth is looked at.
const LOOK: Duration = Duration::from_micros(500);

impl<P: Plant + Clone> SlowBrakes<P> {
    fn new(inner: P, brake: Duration) -> (Self, Arc<Mutex<Truth<P>>>) {
        let truth = Truth {
            range: [[f64::INFINITY, f64::NEG_INFINITY]; ACTIVE],
            fastest: [0.0; ACTIVE],
            plant: None,
            closing: None,
        };
        let truth = Arc::new(Mutex::new(truth));
        (Self { inner, brake, closing: None, truth: Arc::clone(&truth) }, truth)
    }

    /// To `until` in steps that are looked at.
    fn pass(&mut self, until: Duration, torque: &Vector3<f64>, brakes: [Brake; 3]) {
        while self.inner.time() < until {
            let next = (self.inner.time() + LOOK).min(until);
            self.inner.advance(next, torque, brakes);
            self.truth.lock().unwrap().see(&self.inner);
        }
    }
}

impl<P: Plant + Clone> Plant for SlowBrakes<P> {
    fn time(&self) -> Duration {
        self.inner.time()
    }
    fn position(&self) -> Vector3<f64> {
        self.inner.position()
    }
    fn velocity(&self) -> Vector3<f64> {
        self.inner.velocity()
    }
    fn advance(&mut self, until: Duration, torque: &Vector3<f64>, brakes: [Brake; 3]) {
        if brakes.contains(&Brake::Engaged) {
            let closing = *self.closing.get_or_insert(self.inner.time() + self.brake);
            self.pass(until.min(closing), torque, [Brake::Released; 3]);
            self.pass(until, torque, [Brake::Engaged; 3]);
        } else {
            self.closing = None;
            self.pass(until, torque, brakes);
        }
        let mut truth = self.truth.lock().unwrap();
        (truth.plant, truth.closing) = (Some(self.inner.clone()), self.closing);
    }
}

/// A task that takes `duration` seconds from `start` to `end`, deg, on a robot whose brakes close in `brake` ms.
fn swinging(start: [f64; 2], end: [f64; 2], duration: f64, brake: u32) -> Robot {
    let mut robot = Robot::load(None).unwrap();
    let at = |angles: [f64; 2]| Vector2::from(angles.map(f64::to_radians));
    let description = &mut robot.description;
    description.task.reference = QuinticReference::new(at(start), at(end), duration).unwrap().into();
    description.tracking_error_limit = f64::INFINITY;
    description.saturation_limit = SaturationLimit::new(SaturationLimit::LONGEST).unwrap();
    for joint in &mut description.joints {
        joint.brake = Duration::from_millis(brake.into());
    }
    robot
}

/// How a run ended, and the truth of it until all stood still.
fn truth_of(robot: &Robot, brake: Duration) -> (Ended<NoRecorder>, Truth<SimulatedPlant>) {
    let clock = VirtualClock::default();
    let start = robot.description.task.reference.start();
    let plant = SimulatedPlant::new(robot, PlantChoice::Ideal, Disturbance::None).unwrap();
    let plant = plant.starting_at(Vector3::new(0.0, start.x, start.y));
    let (plant, truth) = SlowBrakes::new(plant, brake);
    let link = InProcessLink::new(emulate(robot, plant, Pacing::WallClock).unwrap(), clock.clone());
    let settings = Settings { disturbance: Disturbance::None, ..Settings::paper(Law::Nonlinear) };
    let ended = run(robot, &settings, link, clock, NoRecorder);
    let mut truth = Arc::into_inner(truth).unwrap().into_inner().unwrap();
    let (mut plant, closing) = (truth.plant.take().unwrap(), truth.closing.expect("the brakes were told to close"));
    while Plant::<3>::time(&plant) < closing {
        plant.advance((Plant::<3>::time(&plant) + LOOK).min(closing), &Vector3::zeros(), [Brake::Released; 3]);
        truth.see(&plant);
    }
    (ended, truth)
}

fn code(ended: &Ended<NoRecorder>) -> Option<FaultCode> {
    ended.end.as_ref().err().map(|failure| failure.code)
}

/// The true joint, not what the loop believes of it. From slow to fast, with brakes from ideal to slow, on both sides.
#[test]
fn no_joint_passes_its_angles() {
    for duration in [3.0, 1.0, 0.7] {
        for brake in [0, 20, 50, 100] {
            for (start, end) in [([20.0, 20.0], [100.0, 60.0]), ([100.0, 60.0], [20.0, 20.0])] {
                for joint in 0..ACTIVE {
                    let mut robot = swinging(start, end, duration, brake);
                    for joint in &mut robot.description.joints {
                        joint.limits.velocity = f64::INFINITY;
                    }
                    let limit = ((start[joint] + end[joint]) / 2.0_f64).to_radians();
                    let rises = end[joint] > start[joint];
                    robot.description.joints[joint + 1].limits.position[usize::from(rises)] = limit;
                    let (ended, truth) = truth_of(&robot, Duration::from_millis(brake.into()));
                    let case = format!("{duration} s, {brake} ms, joint {}, {start:?}", joint + 2);
                    assert_eq!(code(&ended), Some(FaultCode::JointAngle), "{case}");
                    let nearest = if rises { limit - truth.range[joint][1] } else { truth.range[joint][0] - limit };
                    assert!(nearest >= 0.0, "{case}: beyond by {} deg", -nearest.to_degrees());
                    // It is no wall at a distance: 0.8 rad/s are what torque may add meanwhile. With slow brakes, what the other
                    // joints may add counts for more.
                    let most = 0.01 + (truth.fastest[joint] + 0.8) * (0.02 + f64::from(brake) * 1e-3);
                    assert!(brake > 20 || nearest < most, "{case}: stopped {} deg before", nearest.to_degrees());
                }
            }
        }
    }
}

#[test]
fn no_joint_passes_its_velocity() {
    for (limit, duration, brake) in [(80.0, 1.0, 0), (120.0, 0.8, 20), (140.0, 0.7, 50)] {
        for joint in 0..ACTIVE {
            let mut robot = swinging([20.0, 20.0], [100.0, 100.0], duration, brake);
            robot.description.joints[joint + 1].limits.velocity = f64::to_radians(limit);
            let (ended, truth) = truth_of(&robot, Duration::from_millis(brake.into()));
            assert_eq!(code(&ended), Some(FaultCode::JointVelocity), "{limit}");
            let found = truth.fastest[joint].to_degrees();
            assert!(found <= limit, "{found} deg/s of {limit}");
            assert!(found > limit / 3.0, "{found} deg/s of {limit}: stopped too early");
        }
    }
}
