//! Time as the laws are told it.

use uarm_loop::period::Period;
use uarm_loop::task_clock::{PeriodSource, TaskClock};
use uarm_loop::uarm_io::time::{Duration, Instant};

use crate::fake_path::tick;

/// 2⁻⁸ s, so that sums are exact.
fn period() -> Period {
    Period::new(Duration::from_nanos(3_906_250)).unwrap()
}

fn at(nanoseconds: u64) -> Instant {
    Instant::from_nanoseconds(nanoseconds)
}

#[test]
fn the_measured_clock_adds_what_passed_between_syncs_and_expects_one_period_more() {
    let mut clock = TaskClock::new(PeriodSource::Measured, -0.5);
    assert_eq!(clock.next(period()), -0.496_093_75, "before the first cycle: one period after the start");
    assert_eq!(clock.advance(&tick(0, 0), at(1_000), period()), (-0.5, 0.0));
    assert_eq!(clock.next(period()), -0.496_093_75);
    // 1.5 periods later.
    assert_eq!(clock.advance(&tick(1, 1), at(5_860_375), period()), (-0.494_140_625, 0.005_859_375));
    assert_eq!(clock.next(period()), -0.490_234_375);
    // Half a period later.
    assert_eq!(clock.advance(&tick(2, 1), at(7_813_500), period()), (-0.492_187_5, 0.001_953_125));
    assert_eq!(clock.next(period()), -0.488_281_25);
}

#[test]
fn the_scheduled_clock_counts_ticks_from_the_start() {
    let mut clock = TaskClock::new(PeriodSource::Scheduled, -0.5);
    assert_eq!(clock.advance(&tick(0, 0), at(1_000), period()), (-0.5, 0.0));
    assert_eq!(clock.next(period()), -0.496_093_75);
    assert_eq!(clock.advance(&tick(4, 4), at(9_999), period()), (-0.484_375, 0.015_625));
    assert_eq!(clock.next(period()), -0.480_468_75);
}
