//! The system's monotonic clock, and its distance to the time of day.

use crate::time::{Clock, Duration, Instant};
use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec, clock_gettime};

const NANOSECONDS_PER_SECOND: u64 = 1_000_000_000;

/// Tries of [`RealtimeOffset::capture`]: enough that at least one is not interrupted between its clock readings.
const CAPTURE_TRIES: u32 = 16;

/// `CLOCK_MONOTONIC`: never set back, slewed by NTP but never stepped, zero at boot.
///
/// ```
/// use uarm_io::monotonic::MonotonicClock;
/// use uarm_io::time::{Clock, Duration};
///
/// let mut clock = MonotonicClock;
/// let deadline = clock.now() + Duration::from_micros(200);
/// clock.sleep_until(deadline);
/// assert!(clock.now() >= deadline);
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct MonotonicClock;

impl Clock for MonotonicClock {
    fn now(&self) -> Instant {
        read(ClockId::Monotonic)
    }

    /// Sleeps on an absolute deadline, so that time lost before the call does not add up. A signal that interrupts the
    /// sleep is served and the sleep resumed: the function never returns early.
    fn sleep_until(&mut self, deadline: Instant) {
        let request = timespec(deadline);
        while self.now() < deadline {
            // Interrupted (EINTR) is the only failure that a valid time on this clock can have.
            if clock_nanosleep_absolute(ClockId::Monotonic, &request).is_ok() {
                return;
            }
        }
    }
}

/// How far the time of day (`CLOCK_REALTIME`, nanoseconds since 1970-01-01 UTC) is ahead of `CLOCK_MONOTONIC`.
///
/// It is constant until the time of day is stepped (by hand, by NTP at start, by a leap second). Logs capture it once, so
/// that their time axis has no jumps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RealtimeOffset(i128);

impl RealtimeOffset {
    /// Measures the offset: the best of several tries, each a reading of the time of day between two of the monotonic clock.
    /// The error is at most half the time between those two, well below a microsecond on a PC.
    pub fn capture() -> Self {
        let (mut best, mut best_spread) = Self::capture_once();
        for _ in 1..CAPTURE_TRIES {
            let (candidate, spread) = Self::capture_once();
            if spread < best_spread {
                (best, best_spread) = (candidate, spread);
            }
        }
        best
    }

    /// One try: the offset, and the time between the two monotonic readings.
    pub(crate) fn capture_once() -> (Self, Duration) {
        let before = read(ClockId::Monotonic);
        let time_of_day = read(ClockId::Realtime);
        let after = read(ClockId::Monotonic);
        let spread = after.since(before);
        let middle = before + spread / 2;
        (Self(i128::from(time_of_day.nanoseconds()) - i128::from(middle.nanoseconds())), spread)
    }

    /// The offset in nanoseconds; negative if the time of day was never set and runs from before boot.
    pub const fn nanoseconds(self) -> i128 {
        self.0
    }

    /// Nanoseconds since 1970-01-01 UTC at an instant of the monotonic clock; saturates at the ends of `u64`.
    pub fn time_of_day(self, instant: Instant) -> u64 {
        saturate(i128::from(instant.nanoseconds()) + self.0)
    }

    /// The instant of the monotonic clock at a time of day in nanoseconds since 1970-01-01 UTC; saturates at the ends of `u64`.
    pub fn instant(self, time_of_day: u64) -> Instant {
        Instant::from_nanoseconds(saturate(i128::from(time_of_day) - self.0))
    }
}

fn saturate(nanoseconds: i128) -> u64 {
    u64::try_from(nanoseconds.max(0)).unwrap_or(u64::MAX)
}

fn read(clock: ClockId) -> Instant {
    let time = clock_gettime(clock);
    // Both clocks are never negative in practice: one starts at boot, the other cannot be set before 1970.
    let seconds = u64::try_from(time.tv_sec).unwrap_or(0);
    let nanoseconds = u64::try_from(time.tv_nsec).unwrap_or(0);
    Instant::from_nanoseconds(seconds.saturating_mul(NANOSECONDS_PER_SECOND).saturating_add(nanoseconds))
}

/// An instant or a span as the kernel takes it.
fn timespec(instant: Instant) -> Timespec {
    let seconds = instant.nanoseconds() / NANOSECONDS_PER_SECOND;
    let nanoseconds = instant.nanoseconds() % NANOSECONDS_PER_SECOND;
    // u64 nanoseconds are at most 584 years: both fit everywhere but in a 32-bit time_t, where a far deadline saturates.
    Timespec { tv_sec: seconds.try_into().unwrap_or(i32::MAX.into()), tv_nsec: nanoseconds.try_into().unwrap_or(0) }
}

/// A time-out as `ppoll` takes it.
pub(crate) fn timeout(duration: Duration) -> Timespec {
    timespec(Instant::default() + duration)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sleep_ends_at_the_deadline_and_not_before() {
        let mut clock = MonotonicClock;
        for microseconds in [0, 1, 50, 1_500] {
            let deadline = clock.now() + Duration::from_micros(microseconds);
            clock.sleep_until(deadline);
            assert!(clock.now() >= deadline);
        }
    }

    /// proc(5): the seconds since boot, those of a suspended machine included, which this clock leaves out. The time of day, which anybody
    /// with the right can set, is decades ahead.
    #[test]
    fn the_clock_is_the_time_since_boot_and_not_the_time_of_day() {
        let before = MonotonicClock.now();
        let uptime = std::fs::read_to_string("/proc/uptime").unwrap();
        let uptime: f64 = uptime.split(' ').next().unwrap().parse().unwrap();
        // Its hundredths are cut off.
        assert!(before <= Instant::default() + Duration::from_secs_f64(uptime + 0.01), "{before:?} {uptime}");
        let mut clock = MonotonicClock;
        let deadline = clock.now() + Duration::from_millis(20);
        clock.sleep_until(deadline);
        assert!((Duration::ZERO..Duration::from_secs(60)).contains(&clock.now().since(deadline)));
    }

    #[test]
    fn a_deadline_in_the_past_returns_at_once() {
        // A sleep that took the deadline as relative, or as far away, would hang here.
        MonotonicClock.sleep_until(Instant::default());
    }

    #[test]
    fn timespec_splits_at_the_second() {
        let split = timespec(Instant::from_nanoseconds(3_000_000_007));
        assert_eq!((split.tv_sec, split.tv_nsec), (3, 7));
    }

    #[test]
    fn offset_maps_there_and_back() {
        let offset = RealtimeOffset::capture();
        let instant = MonotonicClock.now();
        assert_eq!(offset.instant(offset.time_of_day(instant)), instant);
        let system = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap().as_nanos();
        let ours = u128::from(offset.time_of_day(MonotonicClock.now()));
        assert!(ours.abs_diff(system) < 10_000_000_000, "{ours} against {system}");
    }

    #[test]
    fn offset_saturates() {
        assert_eq!(RealtimeOffset(-5).time_of_day(Instant::from_nanoseconds(3)), 0);
        assert_eq!(RealtimeOffset(5).instant(3), Instant::from_nanoseconds(0));
        assert_eq!(RealtimeOffset(i128::MAX / 2).time_of_day(Instant::default()), u64::MAX);
    }
}
