//! Which instants make which latency.

use uarm_loop::timing::{CycleInstants, LatencySummary, TimingRecorder, Verdict};
use uarm_loop::uarm_io::time::{Duration, Instant};

/// A cycle due at 1 s that takes these many microseconds from step to step.
fn cycle(wake: u64, sync: u64, counts: u64, torque: u64, done: u64) -> CycleInstants {
    let mut now = Instant::from_nanoseconds(1_000_000_000);
    let scheduled = now;
    let mut after = |microseconds| {
        now = now + Duration::from_micros(microseconds);
        now
    };
    CycleInstants {
        scheduled,
        woke: after(wake),
        sync_sent: after(sync),
        counts_in: after(counts),
        torque_out: after(torque),
        done: after(done),
    }
}

#[test]
fn every_latency_has_its_own_beginning_and_end() {
    let instants = cycle(1, 20, 300, 4_000, 50_000);
    assert_eq!(instants.wake_up(), Duration::from_micros(1));
    assert_eq!(instants.feedback_latency(), Duration::from_micros(300), "from SYNC");
    assert_eq!(instants.total(), Duration::from_micros(4_321), "until the torques are out");
}

#[test]
fn the_summary_keeps_the_three_apart() {
    let mut timing = TimingRecorder::new(Duration::from_millis(3));
    timing.record(&cycle(1, 20, 300, 1_000, 90_000), 0);
    timing.record(&cycle(3, 20, 500, 1_000, 90_000), 1);
    let summary = timing.summary();
    let span = |latency: LatencySummary| (latency.minimum_ns, latency.maximum_ns);
    assert_eq!(span(summary.wake_up), (1_000, 3_000));
    assert_eq!(span(summary.feedback_latency), (300_000, 500_000));
    assert_eq!(span(summary.total), (1_321_000, 1_523_000));
    assert_eq!((summary.period_ns, summary.cycles), (3_000_000, 2));
    assert!((summary.total.mean_ns - 1_422_000.0).abs() < 1_422.0, "three digits: {}", summary.total.mean_ns);
}

#[test]
fn a_deadline_is_missed_beyond_the_period_and_not_at_it() {
    let mut timing = TimingRecorder::new(Duration::from_millis(3));
    timing.record(&cycle(0, 0, 0, 3_000, 500), 1);
    assert_eq!((timing.summary().missed_deadlines, timing.summary().verdict()), (0, Verdict::Tight));
    timing.record(&cycle(0, 0, 0, 3_001, 0), 1);
    assert_eq!((timing.summary().missed_deadlines, timing.summary().verdict()), (1, Verdict::Missed));
}

#[test]
fn half_of_the_period_must_stay_free() {
    for (total, verdict) in [(1_500, Verdict::Good), (1_501, Verdict::Tight)] {
        let mut timing = TimingRecorder::new(Duration::from_millis(3));
        timing.record(&cycle(0, 0, 0, total, 0), 1);
        assert_eq!(timing.summary().verdict(), verdict);
    }
}

#[test]
fn skipped_ticks_are_missed_too_and_advice_says_so() {
    let mut timing = TimingRecorder::new(Duration::from_millis(3));
    timing.record(&cycle(0, 0, 0, 1, 0), 4);
    let summary = timing.summary();
    assert_eq!((summary.missed_deadlines, summary.skipped_ticks, summary.verdict()), (0, 3, Verdict::Missed));
}

/// 989 of 1000 are at 100 µs, ten at 200 µs and one at 300 µs.
#[test]
fn quantiles_are_those_of_the_cycles() {
    let mut timing = TimingRecorder::new(Duration::from_millis(3));
    for index in 0..1_000 {
        let latency = match index {
            0..989 => 100,
            989..999 => 200,
            _ => 300,
        };
        timing.record(&cycle(latency, 0, 0, 0, 0), 1);
    }
    let LatencySummary { p99_ns, p999_ns, maximum_ns, .. } = timing.summary().wake_up;
    assert!(p99_ns.abs_diff(200_000) <= 200, "{p99_ns}");
    assert!(p999_ns.abs_diff(200_000) <= 200, "{p999_ns}");
    assert_eq!(maximum_ns, 300_000);
}
