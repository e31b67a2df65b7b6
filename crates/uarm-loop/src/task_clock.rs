//! What time and period the estimators and laws are told.

use uarm_io::time::Instant;

use crate::period::Period;
use crate::schedule::Tick;

/// Where the period that estimators and laws are told comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PeriodSource {
    /// Scheduled ticks elapsed, exact multiples of the period: the same bits in every lockstep run.
    #[default]
    Scheduled,
    /// From SYNC to SYNC as measured, as in the paper.
    Measured,
}

crate::choice! {
    PeriodSource:
    Scheduled = "scheduled", "Scheduled ticks elapsed, exact multiples of the period: the same bits in every lockstep run";
    Measured = "measured", "From SYNC to SYNC as measured, as in the paper";
}

/// Task time: the start of the motion at the first cycle.
#[derive(Clone, Copy, Debug)]
pub struct TaskClock {
    source: PeriodSource,
    start: f64,
    state: TaskClockState,
}

/// What a task clock remembers of the previous cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TaskClockState {
    /// Its task time, s.
    pub time: f64,
    /// The instant of its SYNC; nothing before the first cycle.
    pub previous_sync: Option<Instant>,
    /// The index of its tick.
    pub previous_tick: u64,
}

impl TaskClock {
    /// A task clock that begins at `start`, s.
    pub const fn new(source: PeriodSource, start: f64) -> Self {
        Self { source, start, state: TaskClockState { time: start, previous_sync: None, previous_tick: 0 } }
    }

    /// Goes on to this cycle. Returns its task time and the period since the previous one, zero in the first cycle, both
    /// in seconds.
    pub fn advance(&mut self, tick: &Tick, sync_sent: Instant, nominal: Period) -> (f64, f64) {
        let period = match (self.state.previous_sync, self.source) {
            (None, _) => 0.0,
            (Some(_), PeriodSource::Scheduled) => nominal.seconds(tick.elapsed),
            (Some(previous), PeriodSource::Measured) => sync_sent.since(previous).as_secs_f64(),
        };
        self.state.time = match self.source {
            PeriodSource::Scheduled => self.start + nominal.seconds(tick.index),
            PeriodSource::Measured => self.state.time + period,
        };
        self.state.previous_sync = Some(sync_sent);
        self.state.previous_tick = tick.index;
        (self.state.time, period)
    }

    /// Seconds since the SYNC of the previous cycle; nothing before the second.
    pub fn since_sync(&self, sync_sent: Instant) -> Option<f64> {
        Some(sync_sent.since(self.state.previous_sync?).as_secs_f64())
    }

    /// Begins anew at `start`, s.
    pub const fn restart(&mut self, start: f64) {
        *self = Self::new(self.source, start);
    }

    /// The whole inner state.
    pub const fn freeze(&self) -> TaskClockState {
        self.state
    }

    /// Goes on from a frozen state.
    pub const fn thaw(&mut self, state: TaskClockState) {
        self.state = state;
    }

    /// The task time of the next cycle if it comes in time, s.
    pub fn next(&self, nominal: Period) -> f64 {
        match self.source {
            PeriodSource::Scheduled => self.start + nominal.seconds(self.state.previous_tick.saturating_add(1)),
            PeriodSource::Measured => self.state.time + nominal.seconds(1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use uarm_io::time::Duration;

    fn tick(index: u64, elapsed: u64) -> Tick {
        Tick { index, elapsed, scheduled: Instant::default(), woke: Instant::default() }
    }

    #[test]
    fn scheduled_periods_are_exact_multiples_and_tell_of_skipped_ticks() {
        let nominal = Period::new(Duration::from_millis(3)).unwrap();
        let mut clock = TaskClock::new(PeriodSource::Scheduled, 0.0);
        let at = |microseconds: u64| Instant::from_nanoseconds(microseconds * 1_000);
        assert_eq!(clock.advance(&tick(0, 0), at(17), nominal), (0.0, 0.0));
        assert_eq!(clock.advance(&tick(1, 1), at(3_100), nominal), (0.003, 0.003));
        assert_eq!(clock.advance(&tick(4, 3), at(12_001), nominal), (0.012, 0.009));
        assert_eq!(clock.next(nominal), 0.015);
    }

    #[test]
    fn measured_periods_follow_sync() {
        let nominal = Period::new(Duration::from_millis(3)).unwrap();
        let mut clock = TaskClock::new(PeriodSource::Measured, 0.0);
        let at = |microseconds: u64| Instant::from_nanoseconds(microseconds * 1_000);
        assert_eq!(clock.advance(&tick(0, 0), at(17), nominal), (0.0, 0.0));
        let (time, period) = clock.advance(&tick(1, 1), at(3_100), nominal);
        assert_eq!((time, period), (0.003_083, 0.003_083));
    }
}
