//! The real-time path does not allocate: a whole experiment, cycle by cycle, with the allocator watched.

mod support;

use std::io::{self, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use hinf_control::AdaptationGuard;
use hinf_control::Disturbance;
use hinf_control::Law;
use uarm::dimensions::Progress;
use uarm::dimensions::{ACTIVE, JOINTS};
use uarm::robot::Robot;
use uarm::simulated_plant::PlantChoice;
use uarm::simulated_plant::SimulatedPlant;
use uarm::simulated_robot::emulate;
use uarm_io::drive::network::DriveNetwork;
use uarm_io::link::ObservedLink;
use uarm_io::time::Clock;
use uarm_loop::control_loop::{ControlLoop, LoopEnd};
use uarm_loop::recording::{self, Entry, FullQueue, Leftovers, Recording, RunEnd, Sink};
use uarm_loop::run::signal_path;
use uarm_loop::schedule::{OverrunPolicy, Schedule};
use uarm_loop::settings::Settings;
use uarm_loop::stop_request::StopRequest;
use uarm_loop::timing::TimingRecorder;
use uarm_sim::{InProcessLink, Pacing, VirtualClock};

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

/// Throws away what a log writer makes of a run, and counts it.
#[derive(Clone, Default)]
struct Nowhere(Arc<AtomicUsize>);

impl Write for Nowhere {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.fetch_add(bytes.len(), Ordering::Relaxed);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A sink that the disk has stopped taking anything from.
struct Stalled;

impl Sink<JOINTS, ACTIVE> for Stalled {
    fn name(&self) -> String {
        "stalled".to_owned()
    }

    fn take(&mut self, _entry: Entry<'_, JOINTS, ACTIVE>) -> io::Result<()> {
        loop {
            std::thread::park();
        }
    }
}

/// Runs the loop of `law` under the watch, with everything recorded into `recording`. The queues to the writer are part of
/// the real-time side, the writer is not.
fn run_watched(law: Law, guard: AdaptationGuard, recording: &mut Recording<JOINTS, ACTIVE>) {
    let robot = Robot::load(None).unwrap();
    let mut clock = VirtualClock::default();
    let plant = SimulatedPlant::new(&robot, PlantChoice::Uarm, Disturbance::Paper).unwrap();
    let link = InProcessLink::new(emulate(&robot, plant, Pacing::WallClock).unwrap(), clock.clone());
    let Recording { loop_recorder, frame_recorder, .. } = recording;
    let link = ObservedLink::new(link, |direction, frame: &_, at| frame_recorder.record(direction, frame, at));
    let mut drives = DriveNetwork::new(link, robot.description.network_configuration().unwrap());
    let mut controller = robot.controller(law, guard).unwrap();
    let progress = Progress::default();
    let stop = StopRequest::default();
    let settings = settings(law, guard);
    let mut control_loop = ControlLoop {
        path: signal_path(&robot.description, &settings, controller.as_mut()).unwrap(),
        feedback_timeout: robot.description.feedback_timeout,
        timing: TimingRecorder::new(robot.description.period.duration()),
        progress: &progress,
        stop: &stop,
    };
    drives.start(&clock).unwrap();
    let mut schedule =
        Schedule::new(clock.now() + Duration::from_millis(3), robot.description.period, OverrunPolicy::Skip);

    let mut supervisor = support::running_supervisor();
    let end =
        assert_no_alloc(|| control_loop.run(&mut drives, &mut clock, &mut schedule, loop_recorder, &mut supervisor));

    assert_eq!(end.unwrap(), LoopEnd::Completed);
    assert!(drives.stop(&clock).all_off());
    assert_eq!(control_loop.timing.summary().cycles, 1_167, "3.5 s at 3 ms");
}

fn settings(law: Law, guard: AdaptationGuard) -> Settings {
    Settings { guard, ..Settings::paper(law) }
}

/// The period of the built-in robot.
const PERIOD: std::time::Duration = std::time::Duration::from_millis(3);

/// Runs a law with a log, and checks that there is something in it.
fn run_with_log(law: Law, guard: AdaptationGuard) {
    let written = Nowhere::default();
    let log = support::log_writer(written.clone(), &settings(law, guard), &[]);
    let mut recording = recording::start(vec![Box::new(log)], FullQueue::Wait, PERIOD).unwrap();
    run_watched(law, guard, &mut recording);
    let Recording { loop_recorder, frame_recorder, writer } = recording;
    let failures = writer.finish(Leftovers::of(loop_recorder, frame_recorder), RunEnd::default());
    assert!(failures.is_empty(), "{failures:?}");
    assert!(written.0.load(Ordering::Relaxed) > 100_000, "the log was written");
}

#[test]
fn no_law_allocates_in_the_loop() {
    for law in Law::ALL {
        run_with_log(law, AdaptationGuard::None);
    }
}

#[test]
fn no_guarded_law_allocates_in_the_loop() {
    for law in Law::ALL {
        run_with_log(law, AdaptationGuard::Bounded);
    }
}

/// The disk stands still from the first record on: queues and rings fill up and the oldest are overwritten, and nothing of
/// that waits or allocates.
#[test]
fn a_stalled_writer_costs_the_loop_neither_an_allocation_nor_a_wait() {
    let mut recording = recording::start(vec![Box::new(Stalled)], FullQueue::Keep, PERIOD).unwrap();
    for _ in 0..8 {
        run_watched(Law::Fuzzy, AdaptationGuard::Bounded, &mut recording);
    }
    assert!(recording.writer.dropped() > 0, "8 runs of 1167 cycles do not fit 4000 + 2000");
}

/// The watch itself: it must be able to see an allocation.
#[test]
fn the_watch_sees_an_allocation() {
    if std::env::var_os("UARM_TEST_ALLOCATE").is_some() {
        assert_no_alloc(|| drop(std::hint::black_box(vec![0_u8; 64])));
        return;
    }
    let status = std::process::Command::new(std::env::current_exe().unwrap())
        .args(["the_watch_sees_an_allocation", "--exact", "--test-threads", "1"])
        .env("UARM_TEST_ALLOCATE", "1")
        .output()
        .unwrap()
        .status;
    assert!(!status.success(), "an allocation under the watch ends the process");
}
