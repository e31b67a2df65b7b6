//! On time and late by a nanosecond.

use std::cell::Cell;

use uarm_loop::schedule::{Allowed, Overrun, OverrunPolicy, Schedule};
use uarm_loop::uarm_io::time::{Clock, Duration, Instant};

use crate::fake_path::period;

/// A clock that a test sets, and that wakes up on time.
#[derive(Default)]
struct SetClock(Cell<u64>);

impl Clock for SetClock {
    fn now(&self) -> Instant {
        Instant::from_nanoseconds(self.0.get())
    }
    fn sleep_until(&mut self, deadline: Instant) {
        self.0.set(self.0.get().max(deadline.nanoseconds()));
    }
}

/// What comes of the second tick, due at 3 ms, if the first cycle ends at `end` nanoseconds: index, elapsed, wake-up.
fn second_tick(policy: OverrunPolicy, end: u64) -> Result<(u64, u64, u64), Overrun> {
    let mut clock = SetClock::default();
    let mut schedule = Schedule::new(Instant::default(), period(), policy);
    schedule.wait(&mut clock).unwrap();
    clock.0.set(end);
    schedule.wait(&mut clock).map(|tick| (tick.index, tick.elapsed, tick.woke.nanoseconds()))
}

#[test]
fn a_cycle_that_ends_with_its_period_is_on_time() {
    assert_eq!(second_tick(OverrunPolicy::Stop, 3_000_000), Ok((1, 1, 3_000_000)));
    let late = Duration::from_nanos(1);
    let overrun = Overrun { index: 1, late, in_a_row: 1, allowed: Allowed::None };
    assert_eq!(second_tick(OverrunPolicy::Stop, 3_000_001), Err(overrun));
}

#[test]
fn a_tick_is_skipped_when_the_next_one_is_due() {
    assert_eq!(second_tick(OverrunPolicy::Skip, 5_999_999), Ok((1, 1, 5_999_999)));
    assert_eq!(second_tick(OverrunPolicy::Skip, 6_000_000), Ok((2, 2, 6_000_000)));
    assert_eq!(second_tick(OverrunPolicy::CatchUp, 6_000_000), Ok((1, 1, 6_000_000)));
}

/// Before the first cycle nothing can be late: real time begins when it begins.
#[test]
fn the_first_tick_is_never_late() {
    let mut clock = SetClock(Cell::new(7_000_000));
    let mut schedule = Schedule::new(Instant::default(), period(), OverrunPolicy::Stop);
    let tick = schedule.wait(&mut clock).unwrap();
    assert_eq!((tick.index, tick.elapsed, tick.scheduled, tick.woke), (0, 0, Instant::default(), clock.now()));
    assert_eq!(schedule.due(2), Instant::from_nanoseconds(6_000_000));
}
