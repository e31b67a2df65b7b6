//! Faults that only the model sees, brought about on the real loop in virtual time: what answers them, how soon, and how far the true joint
//! went meanwhile.

use std::cell::RefCell;
use std::rc::Rc;

use hinf_control::{AdaptationGuard, Disturbance, Law};
use uarm::campaign::fault::Fault;
use uarm::campaign::injection::{Bench, Injection, Seen};
use uarm::dimensions::{CycleRecord, Progress};
use uarm::robot::Robot;
use uarm::simulated_plant::{PlantChoice, SimulatedPlant};
use uarm::simulated_robot::emulate;
use uarm_io::drive::DriveNetwork;
use uarm_io::time::Duration;
use uarm_loop::fault_code::{Coded, FaultCode};
use uarm_loop::run::{Observer, run};
use uarm_loop::settings::Settings;
use uarm_loop::stop_request::StopRequest;
use uarm_sim::{DriveFault, InProcessLink, Joint, Pacing, Plant, VirtualClock};

/// What came of a run with a fault.
#[derive(Debug)]
struct Reaction {
    /// Why it ended; nothing if the motion came to its end.
    code: Option<FaultCode>,
    /// From the fault to closed brakes.
    took: Duration,
    /// For how long the joint was sent all of its torque after the fault.
    full_torque: Duration,
    /// How far the true joint went after the fault, deg.
    travelled: f64,
}

/// Per mille: both driven joints of the paper's robot may have their rated torque.
const TORQUE_LIMIT: [u16; 3] = [1, 1000, 1000];
/// For how long brakes are watched after the run.
const AFTER_THE_RUN: Duration = Duration::from_millis(100);

/// The paper's robot with `law`, on which `fault` happens to the drive of `joint` with SYNC number `cycle`.
fn reaction(law: Law, fault: DriveFault, joint: Joint, cycle: u64) -> Reaction {
    let robot = Robot::load(None).unwrap();
    let mut clock = VirtualClock::default();
    let plant = SimulatedPlant::new(&robot, PlantChoice::Uarm, Disturbance::None).unwrap();
    let link = InProcessLink::new(emulate(&robot, plant, Pacing::WallClock).unwrap(), clock.clone());
    let seen = Seen { torque_limit: TORQUE_LIMIT, ..Seen::default() };
    let bench = Rc::new(RefCell::new(Bench { link, seen }));
    let stop = StopRequest::default();
    let nodes = robot.description.joints.each_ref().map(|joint| joint.node);
    let happens = (Fault::Drive(fault), joint, cycle);
    let injection = Injection::new(Rc::clone(&bench), clock.clone(), happens, nodes, &stop);
    let settings = Settings { guard: AdaptationGuard::Bounded, disturbance: Disturbance::None, ..Settings::paper(law) };
    let mut controller = robot.controller(settings.law, settings.guard).unwrap();
    let drives = DriveNetwork::new(injection, robot.description.network_configuration().unwrap());
    let observer = Observer { progress: &Progress::default(), stop: &stop };
    let records: Vec<CycleRecord> = Vec::new();
    let finished =
        run(&robot.description, &settings, controller.as_mut(), drives, &mut clock, records, observer).unwrap();
    let bench = &mut *bench.borrow_mut();
    bench.settle(&clock, AFTER_THE_RUN);
    let index = Joint::ALL.iter().position(|of| *of == joint).unwrap();
    // The angle before the fault is measured truly.
    let before = finished.recorder[usize::try_from(cycle).unwrap() - 1].measured_position[index];
    Reaction {
        code: finished.end.err().map(|error| error.code()),
        took: bench.seen.braked_at.unwrap().since(bench.seen.fault_at.unwrap()),
        full_torque: bench.seen.full_torque[index],
        travelled: (Plant::<3>::position(bench.link.robot().plant())[index] - before).to_degrees().abs(),
    }
}

/// The worst of all laws.
#[derive(Debug, Default)]
struct Worst {
    took: Duration,
    full_torque: Duration,
    travelled: f64,
}

/// Holds the reactions of all laws against the codes that may answer, and gives the worst.
fn worst(fault: DriveFault, joint: Joint, cycle: u64, codes: &[FaultCode]) -> Worst {
    let mut worst = Worst::default();
    for law in Law::ALL {
        let found = reaction(law, fault, joint, cycle);
        assert!(found.code.is_some_and(|code| codes.contains(&code)), "{law:?} {fault:?} {joint:?} {cycle}: {found:?}");
        worst.took = worst.took.max(found.took);
        worst.full_torque = worst.full_torque.max(found.full_torque);
        worst.travelled = worst.travelled.max(found.travelled);
    }
    println!("{fault:?} {joint:?} at cycle {cycle}: {worst:?}");
    worst
}

fn milliseconds(milliseconds: u64) -> Duration {
    Duration::from_millis(milliseconds)
}

const DRIVEN: [Joint; 2] = [Joint::TWO, Joint::THREE];
const BY_THE_MODEL: [FaultCode; 3] = [FaultCode::EncoderStuck, FaultCode::TorqueReversed, FaultCode::ModelContradicted];

/// From rest and in slow motion, below the 0.65 rad/s from which counts alone tell it. How long it takes is how long the law takes to ask for a
/// torque that friction cannot hold.
#[test]
fn a_counter_that_stands_still_is_found_before_the_joint_is_far() {
    for (joint, cycle, within) in [
        (Joint::TWO, 1, 700),
        (Joint::TWO, 100, 350),
        (Joint::TWO, 200, 50),
        (Joint::TWO, 300, 50),
        (Joint::THREE, 1, 750),
        (Joint::THREE, 100, 450),
        (Joint::THREE, 200, 110),
        (Joint::THREE, 300, 60),
        (Joint::THREE, 500, 50),
    ] {
        let worst = worst(DriveFault::EncoderStuck, joint, cycle, &BY_THE_MODEL);
        assert!(worst.took <= milliseconds(within), "{worst:?}");
        assert!(worst.full_torque <= milliseconds(50), "{worst:?}");
        assert!(worst.travelled < 8.0, "{worst:?}");
    }
}

/// A brake that does not open looks the same, and nothing moves.
#[test]
fn a_joint_that_cannot_move_is_found() {
    for joint in DRIVEN {
        let worst = worst(DriveFault::BrakeStuckEngaged, joint, 100, &BY_THE_MODEL);
        assert!(worst.full_torque <= milliseconds(250), "{worst:?}");
    }
}

/// From the start and in motion: friction hides it until the torque is larger, then power flows the wrong way.
#[test]
fn torque_of_the_wrong_sign_is_found_before_the_joint_is_far() {
    for joint in DRIVEN {
        for cycle in [1, 100, 200, 300, 500] {
            let worst = worst(DriveFault::TorqueReversed, joint, cycle, &BY_THE_MODEL);
            assert!(worst.full_torque <= milliseconds(250), "{worst:?}");
            assert!(worst.travelled < 8.0, "{worst:?}");
        }
    }
}

#[test]
fn an_encoder_that_is_reversed_at_rest_or_in_motion_is_found() {
    let mut codes = BY_THE_MODEL.to_vec();
    codes.push(FaultCode::EncoderImplausible);
    for joint in DRIVEN {
        for (cycle, within) in [(1, 550), (100, 250), (200, 60), (300, 50), (500, 50), (700, 50)] {
            let worst = worst(DriveFault::EncoderReversed, joint, cycle, &codes);
            assert!(worst.took <= milliseconds(within), "{worst:?}");
            assert!(worst.travelled < 3.0, "{worst:?}");
        }
    }
}

/// At full velocity joint 3 goes on as it was going, whatever it is sent: that its torque is missing is soon more than friction of 0.075 N m and
/// 40 % of the torque explain. Under controller 1, whose motion is the stiffest, friction stops it first, and its counter stands still.
#[test]
fn a_motor_without_torque_contradicts_the_model() {
    for law in Law::ALL.into_iter().filter(|law| *law != Law::Nonlinear) {
        let found = reaction(law, DriveFault::MotorDisconnected, Joint::THREE, 500);
        assert_eq!(found.code, Some(FaultCode::ModelContradicted), "{law:?}: {found:?}");
        assert!(found.took <= milliseconds(300) && found.full_torque <= milliseconds(50), "{law:?}: {found:?}");
    }
}

/// 20 counts in a cycle are 1.2 rad/s more than the joint does. 3 counts are a joint that turns slowly, which is why they are not found.
#[test]
fn a_counter_that_drifts_is_found_at_once() {
    for joint in DRIVEN {
        for cycle in [1, 100, 500, 900] {
            let worst = worst(DriveFault::EncoderDrift { counts: 20 }, joint, cycle, &[FaultCode::EncoderImplausible]);
            assert!(worst.took <= milliseconds(6), "{worst:?}");
            assert!(worst.travelled < 1.0, "{worst:?}");
        }
    }
}
