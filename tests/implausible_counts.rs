//! Counts that a joint cannot have: refused at once, the run ends at the second; and no count of a run without a fault is refused.

use hinf_control::{AdaptationGuard, Disturbance, Law};
use uarm::dimensions::{ACTIVE, CycleRecord, JOINTS, Progress};
use uarm::robot::Robot;
use uarm::simulated_plant::{PlantChoice, SimulatedPlant};
use uarm::simulated_robot::emulate;
use uarm_io::drive::DriveNetwork;
use uarm_io::drive::network::{CycleError, StartError};
use uarm_io::drive::wire::Channel;
use uarm_io::frame::Frame;
use uarm_io::link::{Link, LinkHealth, Received};
use uarm_io::time::Instant;
use uarm_loop::fault_code::{Coded, FaultCode};
use uarm_loop::run::{self, Finished, Observer};
use uarm_loop::settings::Settings;
use uarm_loop::stop_request::StopRequest;
use uarm_sim::{DriveFault, EmulatedRobot, InProcessError, InProcessLink, Joint, Pacing, VirtualClock};

type Bus = InProcessLink<EmulatedRobot<SimulatedPlant>, VirtualClock>;
type End = Finished<StartError<InProcessError>, CycleError<InProcessError>, Vec<CycleRecord>, JOINTS, ACTIVE>;

/// Brings a fault about at SYNC number `at`.
struct Faulty {
    bus: Bus,
    syncs: usize,
    at: usize,
    faults: Vec<(Joint, DriveFault)>,
}

impl Link for Faulty {
    type Error = InProcessError;

    fn send(&mut self, frame: &Frame) -> Result<Instant, InProcessError> {
        if Channel::of(frame.id()) == Some(Channel::Sync) {
            self.syncs += 1;
            if self.syncs == self.at {
                self.faults.iter().for_each(|(joint, fault)| self.bus.inject(*joint, *fault));
            }
        }
        self.bus.send(frame)
    }

    fn receive(&mut self, deadline: Instant) -> Result<Option<Received>, InProcessError> {
        self.bus.receive(deadline)
    }

    fn health(&self) -> LinkHealth {
        self.bus.health()
    }
}

fn run_on(
    robot: &Robot,
    plant: PlantChoice,
    disturbance: Disturbance,
    law: Law,
    at: usize,
    fault: Option<DriveFault>,
) -> End {
    let mut clock = VirtualClock::default();
    let plant = SimulatedPlant::new(robot, plant, disturbance).unwrap();
    let bus = InProcessLink::new(emulate(robot, plant, Pacing::WallClock).unwrap(), clock.clone());
    let faults = fault.map(|fault| (Joint::TWO, fault)).into_iter().collect();
    let link = Faulty { bus, syncs: 0, at, faults };
    let drives = DriveNetwork::new(link, robot.description.network_configuration().unwrap());
    let mut controller = robot.controller(law, AdaptationGuard::None).unwrap();
    let (progress, stop) = (Progress::default(), StopRequest::default());
    let observer = Observer { progress: &progress, stop: &stop };
    let settings = Settings::paper(law);
    run::run(&robot.description, &settings, controller.as_mut(), drives, &mut clock, Vec::new(), observer).unwrap()
}

fn run(law: Law, at: usize, fault: DriveFault) -> End {
    run_on(&Robot::load(None).unwrap(), PlantChoice::Uarm, Disturbance::Paper, law, at, Some(fault))
}

/// Cycles of 3 ms: on the way up, at full velocity, on the way down.
const IN_MOTION: [usize; 3] = [300, 500, 700];

#[test]
fn what_is_off_in_motion_ends_the_run_in_two_cycles() {
    let faults = [
        DriveFault::EncoderJump { counts: 95 },
        DriveFault::EncoderJump { counts: -5_000 },
        DriveFault::EncoderGlitch { counts: 48 },
        DriveFault::EncoderDrift { counts: 20 },
    ];
    for law in Law::ALL {
        for (at, fault) in IN_MOTION.into_iter().flat_map(|at| faults.map(|fault| (at, fault))) {
            let end = run(law, at, fault);
            let error = end.end.unwrap_err();
            assert_eq!(error.code(), FaultCode::EncoderImplausible, "{law:?} {at} {fault:?}: {error}");
            assert!(error.to_string().starts_with("joint 2:"), "{error}");
            // The cycle of the fault is predicted, the one after it has no torque.
            assert_eq!(end.recorder.len(), at, "{law:?} {fault:?}");
        }
    }
}

/// At full velocity a counter that goes the other way is no better than one that jumps: within 30 ms.
#[test]
fn a_reversed_encoder_at_full_velocity_ends_the_run_in_time() {
    for law in Law::ALL {
        let end = run(law, 500, DriveFault::EncoderReversed);
        let error = end.end.unwrap_err();
        assert_eq!(error.code(), FaultCode::EncoderImplausible, "{law:?}: {error}");
        assert!(end.recorder.len() <= 500 + 10, "{law:?}: {}", end.recorder.len());
    }
}

#[test]
fn a_single_glitch_is_borne() {
    // A counter that jumps and jumps back at the next SYNC.
    let robot = Robot::load(None).unwrap();
    let mut clock = VirtualClock::default();
    let plant = SimulatedPlant::new(&robot, PlantChoice::Uarm, Disturbance::Paper).unwrap();
    let bus = InProcessLink::new(emulate(&robot, plant, Pacing::WallClock).unwrap(), clock.clone());
    struct Once(Faulty);
    impl Link for Once {
        type Error = InProcessError;
        fn send(&mut self, frame: &Frame) -> Result<Instant, InProcessError> {
            if Channel::of(frame.id()) == Some(Channel::Sync) && self.0.syncs == self.0.at {
                self.0.bus.inject(Joint::TWO, DriveFault::EncoderJump { counts: -95 });
            }
            self.0.send(frame)
        }
        fn receive(&mut self, deadline: Instant) -> Result<Option<Received>, InProcessError> {
            self.0.receive(deadline)
        }
    }
    let faults = vec![(Joint::TWO, DriveFault::EncoderJump { counts: 95 })];
    let link = Once(Faulty { bus, syncs: 0, at: 500, faults });
    let drives = DriveNetwork::new(link, robot.description.network_configuration().unwrap());
    let mut controller = robot.controller(Law::Nonlinear, AdaptationGuard::None).unwrap();
    let (progress, stop) = (Progress::default(), StopRequest::default());
    let observer = Observer { progress: &progress, stop: &stop };
    let settings = Settings::paper(Law::Nonlinear);
    let end = run::run(
        &robot.description,
        &settings,
        controller.as_mut(),
        drives,
        &mut clock,
        Vec::<CycleRecord>::new(),
        observer,
    )
    .unwrap();
    assert_eq!(end.outcome.predicted_cycles, 1);
    end.end.unwrap();
    let change =
        |at: usize| i32::from(end.recorder[at].torque_sent[1]) - i32::from(end.recorder[at - 1].torque_sent[1]);
    let largest = (495..505).map(change).map(i32::abs).max().unwrap();
    assert!(largest < 60, "{largest} per mille; the glitch gave 714 when it was believed");
}

#[test]
fn no_count_is_refused_without_a_fault() {
    for file in ["robots/uarm.toml", "robots/uarm-hardware.toml"] {
        let robot = Robot::load(Some(std::path::Path::new(file))).unwrap();
        for law in Law::ALL {
            for plant in [PlantChoice::Uarm, PlantChoice::Ideal, PlantChoice::Space] {
                for disturbance in [Disturbance::Paper, Disturbance::None] {
                    let end = run_on(&robot, plant, disturbance, law, 0, None);
                    assert_eq!(end.outcome.predicted_cycles, 0, "{file} {law:?} {plant:?} {disturbance:?}");
                    end.end.unwrap();
                }
            }
        }
    }
}
