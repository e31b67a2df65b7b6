//! What recording costs: per cycle on the loop's side, which must stay below a microsecond, and on the writer's.

#[path = "../tests/support/mod.rs"]
mod support;

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use embedded_can::StandardId;
use hinf_control::AdaptationGuard;
use hinf_control::Law;
use uarm::commands::figures::experiments::simulate_paper;
use uarm::dimensions::CycleRecord;
use uarm::dimensions::{ACTIVE, JOINTS};
use uarm::robot::Robot;
use uarm::simulated_plant::PlantChoice;
use uarm_io::frame::Frame;
use uarm_io::link::FrameDirection;
use uarm_io::time::Instant as LoopInstant;
use uarm_loop::keyframe::Keyframe;
use uarm_loop::record::Recorder;
use uarm_loop::recording::{self, Entry, FrameRecord, FullQueue, Leftovers, Recording, RunEnd, Sink};
use uarm_loop::run::signal_path;
use uarm_loop::settings::Settings;

/// Frames of a usual cycle: SYNC, three answers, three commands, and a heartbeat now and then.
const FRAMES: [u16; 8] = [0x080, 0x181, 0x182, 0x183, 0x201, 0x202, 0x203, 0x701];
/// The period of the built-in robot.
const PERIOD: Duration = Duration::from_millis(3);
/// Cycles between two pauses in which the writer empties the queue: a quarter of it, so that it never fills up.
const BURST: u64 = 1024;
/// As many cycles as a keyframe and ten health records are for, at 3 ms.
const CYCLES_PER_KEYFRAME: u64 = 333;

fn settings(law: Law) -> Settings {
    Settings { guard: AdaptationGuard::Bounded, ..Settings::paper(law) }
}

fn frames() -> [Frame; 8] {
    FRAMES.map(|id| Frame::with(StandardId::new(id).expect("an 11-bit identifier"), [0x37, 0x12, 1, 2, 3, 4]))
}

/// A cycle's record of the law with the most parameters, and a keyframe.
fn samples() -> (CycleRecord, Keyframe<JOINTS, ACTIVE>) {
    let robot = Robot::load(None).expect("the built-in robot");
    let experiment = simulate_paper(&robot, PlantChoice::Uarm, Law::FuzzyModel).expect("a run");
    let settings = settings(Law::FuzzyModel);
    let mut controller = robot.controller(settings.law, settings.guard).expect("the built-in robot's law");
    let path = signal_path(&robot.description, &settings, controller.as_mut()).expect("the built-in robot");
    (experiment.records[500], path.freeze())
}

/// The whole of what one cycle costs the loop: a record, its frames, and its share of keyframes.
fn loop_side(criterion: &mut Criterion) {
    let (record, keyframe) = samples();
    let frames = frames();
    let Recording { mut loop_recorder, mut frame_recorder, writer } =
        recording::start::<JOINTS, ACTIVE>(Vec::new(), FullQueue::Keep, PERIOD).expect("a thread");
    criterion.bench_function("recording: loop side, one cycle of 8 frames", |bencher| {
        bencher.iter_custom(|cycles| {
            let mut spent = Duration::ZERO;
            for cycle in 0..cycles {
                if cycle % BURST == 0 {
                    std::thread::sleep(Duration::from_millis(5)); // the writer rests 2 ms at a time
                }
                let at = LoopInstant::from_nanoseconds(cycle);
                let start = Instant::now();
                for frame in &frames {
                    frame_recorder.record(FrameDirection::Received, black_box(frame), at);
                }
                loop_recorder.record(black_box(&record));
                if cycle % CYCLES_PER_KEYFRAME == 0 {
                    loop_recorder.keyframe(black_box(&keyframe), at);
                }
                spent += start.elapsed();
            }
            spent
        });
    });
    assert_eq!(writer.dropped(), 0, "the queue never filled up: the usual path was measured");
    writer.finish(Leftovers::of(loop_recorder, frame_recorder), RunEnd::default());
}

/// Freezing the whole inner state, once a second.
fn freeze(criterion: &mut Criterion) {
    let robot = Robot::load(None).expect("the built-in robot");
    let settings = settings(Law::FuzzyModel);
    let mut controller = robot.controller(settings.law, settings.guard).expect("the built-in robot's law");
    let path = signal_path(&robot.description, &settings, controller.as_mut()).expect("the built-in robot");
    criterion.bench_function("recording: freeze the inner state", |bencher| bencher.iter(|| path.freeze()));
}

/// Messages, MCAP and zstd of one cycle, on the writer's thread.
fn writer_side(criterion: &mut Criterion) {
    let (record, _) = samples();
    let frames = frames();
    let mut log = support::log_writer(std::io::sink(), &settings(Law::FuzzyModel), &[]);
    let mut tick = 0_u64;
    criterion.bench_function("recording: writer side, one cycle of 8 frames", |bencher| {
        bencher.iter(|| {
            tick += 1;
            let at = LoopInstant::from_nanoseconds(3_000_000 * tick);
            for (frame, sequence) in frames.iter().zip(0..) {
                let frame = FrameRecord { sequence, direction: FrameDirection::Received, frame: *frame, at };
                log.take(Entry::<JOINTS, ACTIVE>::Frame(&frame)).expect("a sink");
            }
            let mut record = record;
            record.tick = tick;
            record.instants.scheduled = at;
            record.instants.done = at;
            log.take(Entry::Cycle(black_box(&record))).expect("a sink");
        });
    });
}

criterion_group!(benches, loop_side, freeze, writer_side);
criterion_main!(benches);
