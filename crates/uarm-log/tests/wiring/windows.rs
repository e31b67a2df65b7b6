//! A long run in windows: each cycle once, with its own record and the keyframes behind it, and no more than some thousand at a time.

use uarm_log::ordered::{InOrder, LoggedKeyframe};
use uarm_log::replay::source::{Behind, Source};
use uarm_log::replay::windows::Windows;
use uarm_log::uarm_loop::record::CycleRecord;
use uarm_log::uarm_loop::recording::FrameRecord;
use uarm_log::uarm_loop::timing::CycleInstants;
use uarm_log::uarm_loop::uarm_io::embedded_can::StandardId;
use uarm_log::uarm_loop::uarm_io::frame::Frame;
use uarm_log::uarm_loop::uarm_io::link::FrameDirection;
use uarm_log::uarm_loop::uarm_io::time::Instant;

use crate::support::{robot, run, settings, sync};

const CYCLES: u64 = 10_000;

/// What there was in a window.
#[derive(Debug, PartialEq, Eq)]
struct Window {
    syncs: Vec<Instant>,
    records: Vec<u64>,
    keyframes: Vec<Option<u64>>,
    behind: Behind,
}

impl Window {
    fn of(source: &Source<'_, 3, 2>) -> Self {
        Self {
            syncs: source.bus.iter().map(|cycle| cycle.sync_at).collect(),
            records: source.records.iter().map(|record| record.tick).collect(),
            keyframes: source.keyframes.iter().map(|(after, _)| *after).collect(),
            behind: source.behind,
        }
    }
}

/// SYNC of a tick, numbered from 1 to 240.
fn sync_frame(tick: u64) -> FrameRecord {
    let number = u8::try_from(tick % 240 + 1).unwrap();
    FrameRecord {
        sequence: u32::try_from(tick).unwrap(),
        direction: FrameDirection::Sent,
        frame: Frame::new(StandardId::new(0x080).unwrap(), &[number]).unwrap(),
        at: sync(tick),
    }
}

fn record(tick: u64) -> CycleRecord<3, 2> {
    let instants = CycleInstants { sync_sent: sync(tick), ..CycleInstants::default() };
    CycleRecord { tick, instants, ..CycleRecord::default() }
}

/// The windows of a log in which the first cycles have `records`, and each `keyframe_step`th one of them has a keyframe, if that is given.
fn log_windows(records: u64, keyframe_step: Option<u64>) -> Vec<Window> {
    let (robot, settings, state) = (robot(), settings(), run(0).keyframes[0].1);
    let (mut windows, mut found) = (Windows::new(&robot, &settings, None), Vec::new());
    let mut each = |source: &Source<'_, 3, 2>| {
        found.push(Window::of(source));
        Ok::<(), ()>(())
    };
    for tick in 0..CYCLES {
        windows.take(InOrder::Frame(&sync_frame(tick)), &mut each).unwrap();
        if tick >= records {
            continue;
        }
        windows.take(InOrder::Cycle(&record(tick)), &mut each).unwrap();
        if keyframe_step.is_some_and(|step| tick % step == 0) {
            let keyframe: LoggedKeyframe<3, 2> = (Some(tick), state);
            windows.take(InOrder::Keyframe(&keyframe), &mut each).unwrap();
        }
    }
    windows.finish(&mut each).unwrap();
    found
}

fn lengths(windows: &[Window]) -> Vec<usize> {
    let all: Vec<_> = windows.iter().flat_map(|window| window.syncs.iter().copied()).collect();
    assert_eq!(all, (0..CYCLES).map(sync).collect::<Vec<_>>(), "each cycle once, in order");
    let (last, earlier) = windows.split_last().unwrap();
    assert!(earlier.iter().all(|window| window.behind == Behind::More));
    assert_eq!(last.behind, Behind::Nothing);
    windows.iter().map(|window| window.syncs.len()).collect()
}

/// The 4096th cycle is not complete as long as no later one was recorded.
#[test]
fn a_log_comes_in_windows_of_four_thousand_cycles_with_their_records() {
    let windows = log_windows(CYCLES, Some(333));
    assert_eq!(lengths(&windows), [4095, 4095, 1810]);
    let records: Vec<_> = windows.iter().map(|window| (window.records[0], window.records.len())).collect();
    assert_eq!(records, [(0, 4096), (4095, 4096), (8190, 1810)], "what was replayed is forgotten");
    let keyframes: Vec<_> = windows.iter().map(|window| (window.keyframes[0], window.keyframes.len())).collect();
    // 13 of 333 cycles are 3996 + 333: the last keyframe that was given stays, since that there are any is told by it.
    assert_eq!(keyframes, [(Some(0), 13), (Some(3_996), 13), (Some(7_992), 7)]);
}

#[test]
fn a_keyframe_behind_a_window_belongs_to_the_next() {
    let windows = log_windows(CYCLES, Some(1));
    let keyframes: Vec<_> = windows.iter().map(|window| window.keyframes[0]).collect();
    assert_eq!(keyframes, [Some(0), Some(4_095), Some(8_190)]);
}

/// Without keyframes a replay cannot go on behind a gap, and needs all that follows.
#[test]
fn a_log_without_keyframes_is_one_window() {
    assert_eq!(lengths(&log_windows(CYCLES, None)), [10_000]);
}

/// Of a cycle behind the newest record it is not known whether it was recorded.
#[test]
fn a_window_has_two_thousand_cycles_at_least() {
    assert_eq!(lengths(&log_windows(2_049, Some(1))), [2_048, 7_952]);
    assert_eq!(lengths(&log_windows(2_048, Some(1))), [10_000]);
}

/// How the end of the run is judged depends on what was near it: half a window is kept.
#[test]
fn the_bus_alone_comes_in_half_windows() {
    let (robot, settings) = (robot(), settings());
    let (mut windows, mut found) = (Windows::<3, 2>::of_bus(&robot, &settings, 240), Vec::new());
    let mut each = |source: &Source<'_, 3, 2>| {
        found.push(Window::of(source));
        Ok::<(), ()>(())
    };
    for tick in 0..CYCLES {
        windows.take(InOrder::Frame(&sync_frame(tick)), &mut each).unwrap();
    }
    windows.finish(&mut each).unwrap();
    assert_eq!(lengths(&found), [2_048, 2_048, 2_048, 3_856]);
}
