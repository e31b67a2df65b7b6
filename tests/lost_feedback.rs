//! Positions that are lost, late, doubled or no positions: the loop goes on without up to two in a row, and stops at the third.

use std::cell::RefCell;
use std::rc::Rc;

use hinf_control::{AdaptationGuard, Disturbance, Law};
use uarm::dimensions::{ACTIVE, CycleRecord, JOINTS, Progress};
use uarm::robot::Robot;
use uarm::simulated_plant::{PlantChoice, SimulatedPlant};
use uarm::simulated_robot::emulate;
use uarm_io::drive::DriveNetwork;
use uarm_io::drive::network::{CycleError, NetworkHealth, StartError};
use uarm_io::drive::wire::Channel;
use uarm_io::frame::Frame;
use uarm_io::link::{FrameDirection, Link, LinkHealth, Received};
use uarm_io::time::{Duration, Instant};
use uarm_log::replay::bus_cycles::bus_cycles;
use uarm_log::replay::exact::{ExactReplay, Start};
use uarm_log::replay::source::{Behind, Source};
use uarm_loop::control_loop::LoopEnd;
use uarm_loop::estimation::AngleSource;
use uarm_loop::fault_code::{Coded, FaultCode};
use uarm_loop::keyframe::Keyframe;
use uarm_loop::record::{HealthRecord, Recorder};
use uarm_loop::recording::FrameRecord;
use uarm_loop::run::{self, Finished, Observer};
use uarm_loop::settings::Settings;
use uarm_loop::stop_request::StopRequest;
use uarm_sim::{DriveFault, EmulatedRobot, InProcessError, InProcessLink, Joint, Pacing, VirtualClock};

type Bus = InProcessLink<EmulatedRobot<SimulatedPlant>, VirtualClock>;
type End = Finished<StartError<InProcessError>, CycleError<InProcessError>, Recorded, JOINTS, ACTIVE>;

/// Phases of the task: at rest, in acceleration, at full velocity, in the hold. Cycles of 3 ms.
const PHASES: [usize; 4] = [3, 200, 500, 1_100];

/// A link on which a fault is brought about at a SYNC, and which changes what the master hears of node 2 from then on.
struct Faulty {
    bus: Bus,
    syncs: usize,
    at: usize,
    fault: Option<DriveFault>,
    /// What becomes of an answer to SYNC of node 2.
    change: fn(Frame) -> Frame,
    changes: usize,
    /// What the master sent and heard.
    frames: Rc<RefCell<Vec<FrameRecord>>>,
}

impl Faulty {
    fn note(&self, direction: FrameDirection, frame: Frame, at: Instant) {
        let mut frames = self.frames.borrow_mut();
        let sequence = frames.len() as u32;
        frames.push(FrameRecord { sequence, direction, frame, at });
    }
}

impl Link for Faulty {
    type Error = InProcessError;

    fn send(&mut self, frame: &Frame) -> Result<Instant, InProcessError> {
        if Channel::of(frame.id()) == Some(Channel::Sync) {
            self.syncs += 1;
            if let Some(fault) = self.fault.filter(|_| self.syncs == self.at) {
                self.bus.inject(Joint::TWO, fault);
            }
        }
        let at = self.bus.send(frame)?;
        self.note(FrameDirection::Sent, *frame, at);
        Ok(at)
    }

    fn receive(&mut self, deadline: Instant) -> Result<Option<Received>, InProcessError> {
        let Some(Received { mut frame, at }) = self.bus.receive(deadline)? else { return Ok(None) };
        let is_changed = self.syncs >= self.at
            && self.changes > 0
            && matches!(Channel::of(frame.id()), Some(Channel::Tpdo1(node)) if node.raw() == 2);
        if is_changed {
            self.changes -= 1;
            frame = (self.change)(frame);
        }
        self.note(FrameDirection::Received, frame, at);
        Ok(Some(Received { frame, at }))
    }

    fn health(&self) -> LinkHealth {
        self.bus.health()
    }
}

#[derive(Default)]
struct Recorded {
    cycles: Vec<CycleRecord>,
    keyframes: Vec<(Option<u64>, Keyframe<JOINTS, ACTIVE>)>,
    frames: Rc<RefCell<Vec<FrameRecord>>>,
    health: Option<NetworkHealth<JOINTS>>,
}

impl Recorder<JOINTS, ACTIVE> for Recorded {
    fn record(&mut self, record: &CycleRecord) {
        self.cycles.push(*record);
    }
    fn keyframe(&mut self, keyframe: &Keyframe<JOINTS, ACTIVE>, _at: Instant) {
        self.keyframes.push((self.cycles.last().map(|cycle| cycle.tick), *keyframe));
    }
    fn health(&mut self, health: &HealthRecord<JOINTS>) {
        self.health = Some(health.network);
    }
}

/// A run of `law` in which `fault` comes about at SYNC number `at`, and `changes` answers of node 2 are changed from then on.
fn run(law: Law, at: usize, fault: Option<DriveFault>, changes: usize, change: fn(Frame) -> Frame) -> End {
    let robot = Robot::load(None).unwrap();
    let mut clock = VirtualClock::default();
    let plant = SimulatedPlant::new(&robot, PlantChoice::Uarm, Disturbance::Paper).unwrap();
    let bus = InProcessLink::new(emulate(&robot, plant, Pacing::WallClock).unwrap(), clock.clone());
    let recorded = Recorded::default();
    let link = Faulty { bus, syncs: 0, at, fault, change, changes, frames: Rc::clone(&recorded.frames) };
    let drives = DriveNetwork::new(link, robot.description.network_configuration().unwrap());
    let mut controller = robot.controller(law, AdaptationGuard::None).unwrap();
    let (progress, stop) = (Progress::default(), StopRequest::default());
    let observer = Observer { progress: &progress, stop: &stop };
    let settings = Settings::paper(law);
    run::run(&robot.description, &settings, controller.as_mut(), drives, &mut clock, recorded, observer).unwrap()
}

fn unchanged(frame: Frame) -> Frame {
    frame
}

fn predicted(cycles: &[CycleRecord]) -> Vec<u64> {
    cycles
        .iter()
        .filter(|cycle| cycle.angle_sources == [AngleSource::Measured, AngleSource::Missing, AngleSource::Measured])
        .map(|cycle| cycle.tick)
        .collect()
}

#[test]
fn two_lost_answers_are_borne_by_every_law_in_every_phase() {
    for law in Law::ALL {
        for at in PHASES {
            let end = run(law, at, Some(DriveFault::FeedbackLost { syncs: 2 }), 0, unchanged);
            assert_eq!(end.end.unwrap(), LoopEnd::Completed, "{law:?} at {at}");
            let first = at as u64 - 1;
            assert_eq!(predicted(&end.recorder.cycles), [first, first + 1]);
            assert_eq!(end.outcome.predicted_cycles, 2);
            assert_eq!(end.outcome.timing.skipped_ticks, 0, "a lost answer is no overrun");
            let adapts = end.recorder.cycles[0].parameter_count > 0;
            let frozen: Vec<_> =
                end.recorder.cycles.iter().filter(|cycle| cycle.flags.frozen).map(|cycle| cycle.tick).collect();
            let expected: &[u64] = if adapts { &[first + 1, first + 2] } else { &[] };
            assert_eq!(frozen, expected, "the steps that begin with a predicted angle");
        }
    }
}

#[test]
fn the_third_lost_answer_stops_within_three_periods() {
    for law in [Law::Nonlinear, Law::Adaptive, Law::ComputedTorque] {
        for at in PHASES {
            let end = run(law, at, Some(DriveFault::FeedbackLost { syncs: 3 }), 0, unchanged);
            let error = end.end.unwrap_err();
            assert_eq!(
                error.to_string(),
                "joint 2: its drive sent no position in 3 cycles in a row, expected one in 3 at least"
            );
            assert_eq!(error.code(), FaultCode::FeedbackMissing);
            // Its SYNC, and two more: the stop comes within the third period.
            assert_eq!(end.recorder.cycles.len(), at + 1);
        }
    }
}

/// 2.25 ms are waited for; 2.5 ms is too late for this SYNC, 3.5 ms comes after the next one.
#[test]
fn late_answers_are_lost_and_never_taken_for_the_next() {
    for by in [2_500, 3_500] {
        let fault = DriveFault::FeedbackLate { by: Duration::from_micros(by) };
        let end = run(Law::Adaptive, 500, Some(fault), 0, unchanged);
        let error = end.end.unwrap_err().to_string();
        assert!(error.contains("joint 2: its drive sent no position in 3 cycles"), "{by}: {error}");
    }
    let fault = DriveFault::FeedbackLate { by: Duration::from_micros(2_000) };
    let end = run(Law::Adaptive, 500, Some(fault), 0, unchanged);
    assert_eq!((end.end.unwrap(), end.outcome.predicted_cycles), (LoopEnd::Completed, 0));
}

#[test]
fn what_is_no_position_is_refused_before_it_is_decoded_and_counts_as_lost() {
    fn shortened(frame: Frame) -> Frame {
        Frame::new(frame.id(), &frame.data()[..5]).unwrap()
    }
    fn lengthened(frame: Frame) -> Frame {
        let mut data = [0; 8];
        data[..6].copy_from_slice(frame.data());
        Frame::new(frame.id(), &data).unwrap()
    }
    for change in [shortened, lengthened] {
        let end = run(Law::Nonlinear, 500, None, 2, change);
        assert_eq!((end.end.unwrap(), end.outcome.predicted_cycles), (LoopEnd::Completed, 2));
        let health = end.recorder.health.unwrap().nodes[1];
        assert_eq!((health.malformed, health.missed_feedbacks), (2, 2));
        let end = run(Law::Nonlinear, 500, None, 3, change);
        assert!(end.end.unwrap_err().to_string().contains("no position in 3 cycles"));
    }
}

#[test]
fn a_replayed_answer_stops_in_the_same_cycle() {
    for at in PHASES {
        let end = run(Law::Nonlinear, at, Some(DriveFault::FeedbackReplayed), 0, unchanged);
        assert_eq!(end.end.unwrap_err().code(), FaultCode::TwoDrivesOneNode);
        assert!(end.recorder.cycles.len() <= at, "{} {at}", end.recorder.cycles.len());
    }
}

/// Of what was recorded, and of the bus alone; the fault at the end as well.
#[test]
fn a_run_with_lost_answers_replays_bit_for_bit() {
    let robot = Robot::load(None).unwrap().description;
    let settings = Settings::paper(Law::Adaptive);
    // The keyframe of the 1002nd millisecond lies between the two.
    let cases = [
        (500, DriveFault::FeedbackLost { syncs: 2 }),
        (334, DriveFault::FeedbackLost { syncs: 2 }),
        (500, DriveFault::FeedbackLost { syncs: 3 }),
        (500, DriveFault::FeedbackLate { by: Duration::from_micros(2_500) }),
    ];
    for (at, fault) in cases {
        let end = run(Law::Adaptive, at, Some(fault), 0, unchanged);
        let cause = end.end.err().map(|error| error.to_string());
        let bus = bus_cycles(&end.recorder.frames.borrow(), robot.nodes());
        for is_recorded in [true, false] {
            let source = Source {
                robot: &robot,
                settings: &settings,
                bus: &bus,
                records: if is_recorded { &end.recorder.cycles } else { &[] },
                keyframes: if is_recorded { &end.recorder.keyframes } else { &[] },
                fault: cause.as_deref(),
                behind: Behind::Nothing,
            };
            let mut controller = Robot::load(None).unwrap().controller(Law::Adaptive, AdaptationGuard::None).unwrap();
            let replay = ExactReplay::run(&source, controller.as_mut(), Start::Beginning).unwrap();
            assert!(replay.is_equal(), "{at} {fault:?} {is_recorded}: {replay:?}");
            // The bus alone does not tell whether the loop or the recording went without.
            assert_eq!(replay.missing_positions, if is_recorded { 0 } else { 2 });
            assert_eq!(replay.has_loss(), !is_recorded);
            assert_eq!((replay.predicted_cycles, replay.cycles), (2, end.recorder.cycles.len() as u64));
            assert_eq!(replay.fault, cause);
            if is_recorded {
                let mut controller =
                    Robot::load(None).unwrap().controller(Law::Adaptive, AdaptationGuard::None).unwrap();
                let later = ExactReplay::run(&source, controller.as_mut(), Start::KeyframeBefore(1.1)).unwrap();
                assert!(later.is_equal() && !later.has_loss(), "{at} {fault:?}: {later:?}");
            }
        }
    }
}
