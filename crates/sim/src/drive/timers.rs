//! The drive's timers: its own heartbeat, and its patience with the master.

use core::time::Duration;
use uarm_io::time::Instant;

/// A repeated instant.
#[derive(Clone, Copy, Debug, Default)]
pub struct Ticker {
    period: Option<Duration>,
    due: Option<Instant>,
}

impl Ticker {
    /// Starts anew with a period in ms; 0 stops it.
    pub fn restart(&mut self, period_milliseconds: u16, now: Instant) {
        self.period = limit(period_milliseconds);
        self.due = self.period.map(|period| now + period);
    }

    /// The next tick.
    pub const fn due(&self) -> Option<Instant> {
        self.due
    }

    /// True once for each tick up to `now`.
    pub fn take_tick(&mut self, now: Instant) -> bool {
        match (self.due, self.period) {
            (Some(due), Some(period)) if due <= now => {
                self.due = Some(due + period);
                true
            }
            _ => false,
        }
    }
}

/// A deadline that each sign of life puts off. As CiA 301 wants it, it is not armed before the first one.
#[derive(Clone, Copy, Debug, Default)]
pub struct Watchdog {
    limit: Option<Duration>,
    due: Option<Instant>,
}

impl Watchdog {
    /// Starts anew with a limit in ms; 0 switches it off.
    pub fn restart(&mut self, limit_milliseconds: u16) {
        *self = Self { limit: limit(limit_milliseconds), due: None };
    }

    /// A sign of life.
    pub fn feed(&mut self, now: Instant) {
        self.due = self.limit.map(|limit| now + limit);
    }

    /// When patience ends.
    pub const fn due(&self) -> Option<Instant> {
        self.due
    }

    /// True once if patience has ended by `now`; the next sign of life arms it again.
    pub fn take_expiry(&mut self, now: Instant) -> bool {
        let expired = self.due.is_some_and(|due| due <= now);
        if expired {
            self.due = None;
        }
        expired
    }
}

fn limit(milliseconds: u16) -> Option<Duration> {
    (milliseconds > 0).then(|| Duration::from_millis(milliseconds.into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(milliseconds: u64) -> Instant {
        Instant::from_nanoseconds(milliseconds * 1_000_000)
    }

    #[test]
    fn a_ticker_keeps_its_grid() {
        let mut ticker = Ticker::default();
        ticker.restart(10, at(5));
        assert!(!ticker.take_tick(at(14)));
        assert!(ticker.take_tick(at(37)));
        assert!(ticker.take_tick(at(37)));
        assert!(ticker.take_tick(at(37)));
        assert!(!ticker.take_tick(at(37)));
        assert_eq!(ticker.due(), Some(at(45)));
        ticker.restart(0, at(40));
        assert_eq!(ticker.due(), None);
    }

    #[test]
    fn a_watchdog_waits_for_the_first_sign_of_life_and_expires_once() {
        let mut watchdog = Watchdog::default();
        watchdog.restart(100);
        assert!(!watchdog.take_expiry(at(10_000)));
        watchdog.feed(at(10_000));
        assert!(!watchdog.take_expiry(at(10_099)));
        assert!(watchdog.take_expiry(at(10_100)));
        assert!(!watchdog.take_expiry(at(20_000)));
    }
}
