//! The real-time path does not allocate: a whole experiment, cycle by cycle, with the allocator watched.

use std::time::Duration;

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use hinf_control::{Law, PerformanceIndices, TorqueLimiter, TorqueLimits};
use nalgebra::Vector2;
use sim::{Disturbance, VirtualClock};
use uarm::commands::run::PlantChoice;
use uarm::control_loop::estimation::Estimation;
use uarm::control_loop::guard::Guard;
use uarm::control_loop::progress::Progress;
use uarm::control_loop::schedule::{OverrunPolicy, Schedule};
use uarm::control_loop::task_clock::{PeriodSource, TaskClock};
use uarm::control_loop::timing::TimingRecorder;
use uarm::control_loop::torque::{DisturbanceSite, TorqueStage};
use uarm::control_loop::{ControlLoop, LoopEnd};
use uarm::controllers::{self, AdaptationGuard};
use uarm::experiment::embedded;
use uarm::recording::{self, FullQueue};
use uarm::robot::Robot;
use uarm::signals::StopRequest;
use uarm::trace::TraceWriter;
use uarm_io::drive::network::DriveNetwork;
use uarm_io::time::Clock;

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

/// Runs the loop of `law` under the watch. The queue to the writer is part of the real-time side, the writer is not.
fn run_watched(law: Law, guard: AdaptationGuard) {
    let robot = Robot::load(None).unwrap();
    let mut clock = VirtualClock::default();
    let link = embedded::link(&robot, PlantChoice::Uarm, Disturbance::Paper, clock.clone()).unwrap();
    let mut drives = DriveNetwork::new(link, robot.network_configuration().unwrap());
    let mut controller = controllers::build(law, &robot, guard).unwrap();
    let progress = Progress::default();
    let stop = StopRequest::default();
    let limits = TorqueLimits::new(Vector2::new(0.2, 0.2)).unwrap();
    let mut control_loop = ControlLoop {
        estimation: Estimation::new(robot.joints.each_ref().map(|joint| (joint.encoder, joint.estimator))),
        motion: robot.task.motion(),
        controller: &mut controller,
        torque: TorqueStage {
            limiter: TorqueLimiter::new(limits),
            scales: robot.joints.each_ref().map(|joint| joint.torque_scale),
            disturbance: Disturbance::Paper,
            site: DisturbanceSite::Plant,
        },
        guard: Guard {
            joints: robot.joints.each_ref().map(|joint| joint.limits),
            tracking_error: robot.tracking_error_limit,
            start_tolerance: robot.task.start_tolerance,
        },
        task_clock: TaskClock::new(PeriodSource::Scheduled, 0.0),
        indices: PerformanceIndices::new(),
        timing: TimingRecorder::new(robot.period.duration()),
        progress: &progress,
        stop: &stop,
    };
    let sink = TraceWriter::new(std::io::sink());
    let (mut recorder, writer) = recording::start(vec![Box::new(sink)], FullQueue::Wait).unwrap();
    drives.start(&clock).unwrap();
    let mut schedule = Schedule::new(clock.now() + Duration::from_millis(3), robot.period, OverrunPolicy::Skip);

    let end = assert_no_alloc(|| control_loop.run(&mut drives, &mut clock, &mut schedule, &mut recorder));

    assert_eq!(end.unwrap(), LoopEnd::Completed);
    assert!(writer.finish().is_empty());
    assert!(drives.stop(&clock).all_off());
    assert_eq!(control_loop.timing.summary().cycles, 1_167, "3.5 s at 3 ms");
}

#[test]
fn no_law_allocates_in_the_loop() {
    for law in Law::ALL {
        run_watched(law, AdaptationGuard::None);
    }
}

#[test]
fn no_guarded_law_allocates_in_the_loop() {
    for law in Law::ALL {
        run_watched(law, AdaptationGuard::Bounded);
    }
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
