//! When cycles start: ticks at exact multiples of the period, and what happens when one comes too late.

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

/// A tick came after its successor was due, and the policy is [`OverrunPolicy::Stop`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "cycle {index} was due {late:?} ago: the cycle before it missed its deadline, and the overrun policy is to stop"
)]
pub struct Overrun {
    /// The tick that is late.
    pub index: u64,
    /// How late it is.
    pub late: Duration,
}

/// The ticks of one run.
#[derive(Clone, Copy, Debug)]
pub struct Schedule {
    origin: Instant,
    period: Period,
    policy: OverrunPolicy,
    next: u64,
    previous: Option<u64>,
}

impl Schedule {
    /// Ticks every `period` from `origin` on.
    pub const fn new(origin: Instant, period: Period, policy: OverrunPolicy) -> Self {
        Self { origin, period, policy, next: 0, previous: None }
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
    /// [`Overrun`] if the tick has already passed and the policy is to stop.
    pub fn wait(&mut self, clock: &mut impl Clock) -> Result<Tick, Overrun> {
        let scheduled = self.due(self.next);
        let before = clock.now();
        if before > scheduled && self.previous.is_some() {
            match self.policy {
                OverrunPolicy::Stop => return Err(Overrun { index: self.next, late: before.since(scheduled) }),
                OverrunPolicy::Skip => self.next += self.whole_periods(before.since(scheduled)),
                OverrunPolicy::CatchUp => {}
            }
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
        clock.now += 10_000_000;
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
        assert_eq!(schedule.wait(&mut clock), Err(Overrun { index: 1, late: Duration::from_nanos(1) }));
    }
}
