//! A path put back into the middle of a run goes on with the same bits.

use uarm_loop::hinf_control::{QuinticReference, TorqueLimiter, TorqueLimits};
use uarm_loop::nalgebra::Vector2;
use uarm_loop::record::CycleRecord;
use uarm_loop::signal_path::SignalPath;
use uarm_loop::supervisor::Authority;
use uarm_loop::task_clock::{PeriodSource, TaskClock};
use uarm_loop::timing::CycleInstants;
use uarm_loop::uarm_io::time::Instant;

use crate::fake_path::{FakeLaw, path, period, rest, tick};

const CYCLES: u64 = 60;
const FROZEN_AFTER: u64 = 25;

fn law() -> FakeLaw {
    FakeLaw { gain: 0.02, ..FakeLaw::constant(0.01, -0.02) }
}

/// A path whose every part remembers something: the torque's rate is limited, and time is measured.
fn fresh(law: &mut FakeLaw) -> SignalPath<'_, 3, 2> {
    let mut path = path(law, rest([0.2, -0.1], 1.0, 0.0));
    let limits = TorqueLimits::new(Vector2::new(0.1, 0.2)).unwrap();
    path.torque.limiter = TorqueLimiter::new(limits.with_rate(Vector2::new(0.4, 0.3)).unwrap());
    path.task_clock = TaskClock::new(PeriodSource::Measured, 0.0);
    path
}

/// One cycle; a tick is skipped at 40, SYNC is late by 0 to 0.4 ms, joints turn unevenly.
fn step(path: &mut SignalPath<'_, 3, 2>, cycle: u64) -> CycleRecord<3, 2> {
    let (index, elapsed) = match cycle {
        0 => (0, 0),
        1..40 => (cycle, 1),
        40 => (41, 2),
        _ => (cycle + 1, 1),
    };
    let sync_sent = Instant::from_nanoseconds(index * 3_000_000 + cycle * cycle % 5 * 100_000);
    let k = i32::try_from(cycle).unwrap();
    let counts = [k * k % 7, 10 * k + k * k % 3, -12 * k];
    let signals = path.step(&tick(index, elapsed), sync_sent, &counts.map(Some), period(), Authority::Full).unwrap();
    CycleRecord::new(&tick(index, elapsed), &CycleInstants::default(), &[0; 3], &signals)
}

#[test]
fn a_thawed_path_goes_on_bit_for_bit() {
    let mut live_law = law();
    let mut live = fresh(&mut live_law);
    let approach = QuinticReference::new(Vector2::new(0.0, 0.1), Vector2::new(0.2, -0.1), 0.125).unwrap();
    live.motion = live.motion.after(approach);
    live.task_clock = TaskClock::new(PeriodSource::Measured, -0.125);
    for cycle in 0..FROZEN_AFTER {
        step(&mut live, cycle);
    }
    let keyframe = live.freeze();
    assert_eq!(keyframe.task_clock.previous_tick, FROZEN_AFTER - 1);

    let mut thawed_law = law();
    let mut thawed = fresh(&mut thawed_law);
    thawed.thaw(&keyframe).unwrap();
    assert_eq!(thawed.freeze(), keyframe, "what is put back is what was taken out");
    let mut limited = 0;
    for cycle in FROZEN_AFTER..CYCLES {
        let (live, thawed) = (step(&mut live, cycle), step(&mut thawed, cycle));
        assert_eq!(format!("{live:?}"), format!("{thawed:?}"), "cycle {cycle}");
        limited += u32::from(live.flags.limited.contains(&true));
    }
    assert!(limited > 0, "the limiter's memory mattered");
}

#[test]
fn the_measured_half_alone_leaves_the_law_as_it_is() {
    let mut live_law = law();
    let mut live = fresh(&mut live_law);
    for cycle in 0..FROZEN_AFTER {
        step(&mut live, cycle);
    }
    let keyframe = live.freeze();
    let mut other_law = FakeLaw { sum: Vector2::new(3.0, 4.0), ..law() };
    let mut other = fresh(&mut other_law);
    other.thaw_measured(&keyframe).unwrap();
    let frozen = other.freeze();
    assert_eq!(frozen.controller.values(), [3.0, 4.0]);
    assert_eq!((frozen.joints, frozen.torque_applied), (keyframe.joints, keyframe.torque_applied));
    assert_eq!((frozen.task_clock, frozen.approach), (keyframe.task_clock, None));
}

/// A clock that counts ticks takes its origin from the approach.
#[test]
fn the_scheduled_clock_of_a_thawed_path_begins_with_the_approach() {
    let mut live_law = law();
    let mut live = path(&mut live_law, rest([0.0; 2], 1.0, 0.0));
    let approach = QuinticReference::new(Vector2::new(0.5, 0.0), Vector2::zeros(), 0.5).unwrap();
    live.motion = live.motion.after(approach);
    live.task_clock.restart(-0.5);
    step(&mut live, 0);
    let keyframe = live.freeze();
    let mut thawed_law = law();
    let mut thawed = path(&mut thawed_law, rest([0.0; 2], 1.0, 0.0));
    thawed.thaw(&keyframe).unwrap();
    assert_eq!(step(&mut thawed, 1).time, -0.497);
}
