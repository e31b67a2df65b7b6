//! From the loop to a sink: the order in which a writer of real time hands over what it is given.

use std::io;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use uarm_loop::record::{CycleRecord, Recorder};
use uarm_loop::recording::{self, Entry, FullQueue, Leftovers, PeriodicRecord, Recording, RunEnd, Sink};
use uarm_loop::uarm_io::drive::wire::sync_frame;
use uarm_loop::uarm_io::link::FrameDirection;
use uarm_loop::uarm_io::time::Instant;

use crate::fake_path::{FakeLaw, path, rest};

/// What came: frames by their number, cycles and keyframes by their tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Came {
    Frame(u64),
    Cycle(u64),
    Keyframe(u64),
}

#[derive(Clone, Default)]
struct Order(Arc<Mutex<Vec<Came>>>);

impl Sink<3, 2> for Order {
    fn name(&self) -> String {
        "order".to_owned()
    }

    fn take(&mut self, entry: Entry<'_, 3, 2>) -> io::Result<()> {
        let came = match entry {
            Entry::Frame(frame) => Came::Frame(frame.sequence.into()),
            Entry::Cycle(cycle) => Came::Cycle(cycle.tick),
            Entry::Periodic(PeriodicRecord::Keyframe(keyframe, _), _) => {
                Came::Keyframe(keyframe.task_clock.previous_tick)
            }
            _ => return Ok(()),
        };
        self.0.lock().unwrap().push(came);
        Ok(())
    }
}

/// A part of a log begins at a keyframe: behind its cycle, before the next cycle's frames.
#[test]
fn a_keyframe_comes_behind_its_cycle_and_before_the_next_frame() {
    const CYCLES: u64 = 3_000;
    const KEYFRAME_CYCLES: u64 = 8;
    let order = Order::default();
    let Recording { mut loop_recorder, mut frame_recorder, writer } =
        recording::start(vec![Box::new(order.clone())], FullQueue::Keep, Duration::from_millis(3)).unwrap();
    let mut law = FakeLaw::constant(0.0, 0.0);
    let mut keyframe = path(&mut law, rest([0.0; 2], 1.0, 0.0)).freeze();
    for tick in 0..CYCLES {
        let done = Instant::from_nanoseconds(1_000 * tick + 500);
        frame_recorder.record(FrameDirection::Sent, &sync_frame(1), Instant::from_nanoseconds(1_000 * tick));
        let mut record = CycleRecord::default();
        (record.tick, record.instants.done) = (tick, done);
        loop_recorder.record(&record);
        keyframe.task_clock.previous_tick = tick;
        if tick % KEYFRAME_CYCLES == 0 {
            loop_recorder.keyframe(&keyframe, done);
            // The writer looks in between, now earlier and now later.
            std::thread::sleep(Duration::from_micros(tick / 4));
        }
    }
    let failures = writer.finish(Leftovers::of(loop_recorder, frame_recorder), RunEnd::default());
    assert_eq!(failures, Vec::<String>::new());
    let of_cycle = |tick| {
        let keyframe = (tick % KEYFRAME_CYCLES == 0).then_some(Came::Keyframe(tick));
        [Came::Frame(tick), Came::Cycle(tick)].into_iter().chain(keyframe)
    };
    let found = order.0.lock().unwrap();
    // Keyframes that found their queue full are kept, and come last, if at all.
    let kept = found.iter().rev().take_while(|came| matches!(came, Came::Keyframe(_))).count();
    let in_time = &found[..found.len() - kept];
    let is_late = |came: &Came| matches!(came, Came::Keyframe(_)) && !in_time.contains(came);
    let expected: Vec<_> = (0..CYCLES).flat_map(of_cycle).filter(|came| !is_late(came)).collect();
    let differing = in_time.iter().zip(&expected).find(|(found, expected)| found != expected);
    assert_eq!((differing, in_time.len()), (None, expected.len()));
    assert!(in_time.iter().filter(|came| matches!(came, Came::Keyframe(_))).count() > 100);
}
