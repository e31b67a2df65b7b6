//! When cycles start: ticks at exact multiples of the period, and what happens when one comes too late.

use std::num::NonZeroU8;

use uarm_io::time::{Clock, Duration, Instant};

use crate::period::Period;

/// What to do when a cycle ends after the next one should have begun.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OverrunPolicy {
    /// Leave out the ticks that have passed; the laws are told the longer period.
    #[default]
    Skip,
    /// Run every tick, late ones at once, until the schedule is met again.
    CatchUp,
    /// End the run: torque zero, quick stop, brakes.
    Stop,
}

crate::choice! {
    OverrunPolicy:
    Skip = "skip", "Leave out the ticks that have passed; the laws are told the longer period";
    CatchUp = "catch-up", "Run every tick, late ones at once, until the schedule is met again";
    Stop = "stop", "End the run: torque zero, quick stop, brakes";
}

/// The start of one cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tick {
    /// Ticks since the start of the run, those left out included.
    pub index: u64,
    /// Ticks since the previous cycle: 0 on the first, 1 as a rule, more after an overrun.
    pub elapsed: u64,
    /// When the cycle was due.
    pub scheduled: Instant,
    /// When the loop woke.
    pub woke: Instant,
}

/// How many cycles in a row may be late at most, under every policy, before the run ends: the last of them ends it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OverrunsInARow(NonZeroU8);

impl OverrunsInARow {
    /// The most that can be asked for: at the longest period of 100 ms, a joint has then been a second on its own.
    pub const MOST: u8 = 10;
    const DEFAULT: Self = Self(NonZeroU8::MIN.saturating_add(2));

    /// So many late cycles in a row end a run; `None` if it is not within 1 to [`MOST`](Self::MOST).
    pub const fn new(late_cycles: u8) -> Option<Self> {
        match NonZeroU8::new(late_cycles) {
            Some(late_cycles) if late_cycles.get() <= Self::MOST => Some(Self(late_cycles)),
            _ => None,
        }
    }

    /// The number of late cycles in a row that ends a run.
    pub const fn get(self) -> u8 {
        self.0.get()
    }
}

impl Default for OverrunsInARow {
    /// Three: one late cycle is a hiccup of the machine, three are a machine that does not keep up.
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Cycles missed their deadlines, and the run has to end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cycle {index} was due {late:?} ago: {in_a_row} cycle(s) in a row missed their deadlines, {allowed}")]
pub struct Overrun {
    /// The tick that is late.
    pub index: u64,
    /// How late it is.
    pub late: Duration,
    /// Late cycles in a row, this one included.
    pub in_a_row: u8,
    /// What was allowed.
    pub allowed: Allowed,
}

/// What late cycles are allowed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Allowed {
    /// None: [`OverrunPolicy::Stop`].
    None,
    /// Fewer than so many in a row.
    FewerThan(OverrunsInARow),
}

impl std::fmt::Display for Allowed {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::None => formatter.write_str("and the overrun policy is to stop"),
            Self::FewerThan(limit) => write!(formatter, "and {} in a row end a run", limit.get()),
        }
    }
}

/// The ticks of one run.
#[derive(Clone, Copy, Debug)]
pub struct Schedule {
    origin: Instant,
    period: Period,
    policy: OverrunPolicy,
    in_a_row: OverrunsInARow,
    next: u64,
    previous: Option<u64>,
    late_in_a_row: u8,
}

impl Schedule {
    /// Ticks every `period` from `origin` on.
    pub const fn new(origin: Instant, period: Period, policy: OverrunPolicy) -> Self {
        Self { origin, period, policy, in_a_row: OverrunsInARow::DEFAULT, next: 0, previous: None, late_in_a_row: 0 }
    }

    /// The same, but so many late cycles in a row end the run.
    #[must_use]
    pub const fn with_overruns_in_a_row(self, in_a_row: OverrunsInARow) -> Self {
        Self { in_a_row, ..self }
    }

    /// The period.
    pub const fn period(&self) -> Period {
        self.period
    }

    /// When tick `index` is due.
    pub fn due(&self, index: u64) -> Instant {
        Instant::from_nanoseconds(self.origin.nanoseconds().saturating_add(self.period.nanoseconds(index)))
    }

    /// Sleeps until the next tick.
    ///
    /// # Errors
    /// [`Overrun`] if the tick has already passed and the policy is to stop, or too many in a row have.
    pub fn wait(&mut self, clock: &mut impl Clock) -> Result<Tick, Overrun> {
        let scheduled = self.due(self.next);
        let before = clock.now();
        if before > scheduled && self.previous.is_some() {
            self.count_late(before.since(scheduled))?;
            if self.policy == OverrunPolicy::Skip {
                self.next += self.whole_periods(before.since(scheduled));
            }
        } else {
            self.late_in_a_row = 0;
        }
        let scheduled = self.due(self.next);
        clock.sleep_until(scheduled);
        let tick = Tick {
            index: self.next,
            elapsed: self.previous.map_or(0, |previous| self.next - previous),
            scheduled,
            woke: clock.now(),
        };
        self.previous = Some(self.next);
        self.next += 1;
        Ok(tick)
    }

    /// Counts a cycle that is `late`.
    fn count_late(&mut self, late: Duration) -> Result<(), Overrun> {
        self.late_in_a_row = self.late_in_a_row.saturating_add(1);
        let allowed = match self.policy {
            OverrunPolicy::Stop => Allowed::None,
            OverrunPolicy::Skip | OverrunPolicy::CatchUp if self.late_in_a_row < self.in_a_row.get() => return Ok(()),
            OverrunPolicy::Skip | OverrunPolicy::CatchUp => Allowed::FewerThan(self.in_a_row),
        };
        Err(Overrun { index: self.next, late, in_a_row: self.late_in_a_row, allowed })
    }

    fn whole_periods(&self, late: Duration) -> u64 {
        u64::try_from(late.as_nanos() / self.period.duration().as_nanos().max(1)).unwrap_or(u64::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A clock that a test sets; sleeping lands `oversleep` after the deadline.
    struct TestClock {
        now: u64,
        oversleep: u64,
    }

    impl Clock for TestClock {
        fn now(&self) -> Instant {
            Instant::from_nanoseconds(self.now)
        }
        fn sleep_until(&mut self, deadline: Instant) {
            self.now = self.now.max(deadline.nanoseconds() + self.oversleep);
        }
    }

    fn schedule(policy: OverrunPolicy) -> Schedule {
        Schedule::new(Instant::from_nanoseconds(1_000), Period::new(Duration::from_millis(3)).unwrap(), policy)
    }

    #[test]
    fn ticks_are_exact_multiples_of_the_period_however_late_the_wake_ups_are() {
        let mut clock = TestClock { now: 0, oversleep: 70_000 };
        let mut schedule = schedule(OverrunPolicy::Skip);
        for index in 0..1_000 {
            let tick = schedule.wait(&mut clock).unwrap();
            assert_eq!(tick.index, index);
            assert_eq!(tick.elapsed, u64::from(index > 0));
            assert_eq!(tick.scheduled.nanoseconds(), 1_000 + index * 3_000_000);
            assert_eq!(tick.woke.since(tick.scheduled), Duration::from_micros(70));
        }
    }

    #[test]
    fn skip_leaves_out_the_passed_ticks_and_says_how_many() {
        let mut clock = TestClock { now: 0, oversleep: 0 };
        let mut schedule = schedule(OverrunPolicy::Skip);
        schedule.wait(&mut clock).unwrap();
        clock.now += 10_000_000; // the cycle took 10 ms: ticks 1 and 2 are lost, 3 (due at 9 ms) is run late
        let tick = schedule.wait(&mut clock).unwrap();
        assert_eq!((tick.index, tick.elapsed), (3, 3));
        assert_eq!(tick.woke.since(tick.scheduled), Duration::from_millis(1));
        assert_eq!(schedule.wait(&mut clock).unwrap().index, 4);
    }

    #[test]
    fn catch_up_runs_every_tick() {
        let mut clock = TestClock { now: 0, oversleep: 0 };
        let mut schedule = schedule(OverrunPolicy::CatchUp);
        schedule.wait(&mut clock).unwrap();
        clock.now += 7_000_000;
        for index in 1..=5 {
            let tick = schedule.wait(&mut clock).unwrap();
            assert_eq!((tick.index, tick.elapsed), (index, 1));
        }
        assert_eq!(clock.now, 1_000 + 15_000_000);
    }

    #[test]
    fn stop_ends_the_run_at_the_first_missed_deadline() {
        let mut clock = TestClock { now: 0, oversleep: 0 };
        let mut schedule = schedule(OverrunPolicy::Stop);
        schedule.wait(&mut clock).unwrap();
        clock.now += 3_000_001;
        let late = Duration::from_nanos(1);
        let overrun = Overrun { index: 1, late, in_a_row: 1, allowed: Allowed::None };
        assert_eq!(schedule.wait(&mut clock), Err(overrun));
    }

    /// Each cycle takes 3.5 ms of a period of 3 ms.
    #[test]
    fn three_late_cycles_in_a_row_end_the_run_under_every_policy() {
        for (policy, ended_by) in [(OverrunPolicy::Skip, 3), (OverrunPolicy::CatchUp, 3), (OverrunPolicy::Stop, 1)] {
            let mut clock = TestClock { now: 0, oversleep: 0 };
            let mut schedule = schedule(policy);
            let mut late = 0;
            let overrun = loop {
                match schedule.wait(&mut clock) {
                    Ok(_) => clock.now += 3_500_000,
                    Err(overrun) => break overrun,
                }
                late += 1;
                assert!(late < 10, "{policy:?}");
            };
            assert_eq!((late, overrun.in_a_row), (ended_by, ended_by), "{policy:?}");
        }
    }

    #[test]
    fn a_cycle_in_time_between_late_ones_forgives_them() {
        for policy in [OverrunPolicy::Skip, OverrunPolicy::CatchUp] {
            let mut clock = TestClock { now: 0, oversleep: 0 };
            let mut schedule = schedule(policy);
            for cycle in 0..30 {
                schedule.wait(&mut clock).unwrap();
                // Two cycles of 3.5 ms, then one that is so short that the next tick is met again.
                clock.now += if cycle % 3 == 2 { 0 } else { 3_500_000 };
            }
        }
    }

    #[test]
    fn the_number_in_a_row_is_bounded() {
        assert_eq!(OverrunsInARow::default().get(), 3);
        assert_eq!(OverrunsInARow::new(1).map(OverrunsInARow::get), Some(1));
        assert_eq!((OverrunsInARow::new(0), OverrunsInARow::new(11)), (None, None));
        let mut clock = TestClock { now: 0, oversleep: 0 };
        let one = OverrunsInARow::new(1).unwrap();
        let mut schedule = schedule(OverrunPolicy::Skip).with_overruns_in_a_row(one);
        schedule.wait(&mut clock).unwrap();
        clock.now += 3_100_000;
        let overrun = schedule.wait(&mut clock).unwrap_err();
        assert_eq!((overrun.in_a_row, overrun.allowed), (1, Allowed::FewerThan(one)));
        assert!(overrun.to_string().ends_with("1 cycle(s) in a row missed their deadlines, and 1 in a row end a run"));
    }
}
