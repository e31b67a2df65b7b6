//! Instants of the loop on the axis of the file: nanoseconds since 1970-01-01 UTC, without jumps.

use foxglove::messages::Timestamp;
use uarm_loop::uarm_io::monotonic::RealtimeOffset;
use uarm_loop::uarm_io::time::Instant;

/// Where virtual time begins on the axis, 2000-01-01T00:00:00Z: a simulated run gives the same file each time.
const VIRTUAL_ORIGIN_NS: i128 = 946_684_800_000_000_000;

const NANOSECONDS_PER_SECOND: u64 = 1_000_000_000;

/// How far the axis is ahead of the loop's clock; constant over a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimeAxis {
    offset_ns: i128,
}

impl TimeAxis {
    /// For a run on the monotonic clock that begins now.
    pub fn monotonic() -> Self {
        Self { offset_ns: RealtimeOffset::capture().nanoseconds() }
    }

    /// For a run in virtual time.
    pub const fn simulated() -> Self {
        Self { offset_ns: VIRTUAL_ORIGIN_NS }
    }

    /// With a known offset.
    pub const fn with_offset(offset_ns: i128) -> Self {
        Self { offset_ns }
    }

    /// How far the axis is ahead of the loop's clock, ns.
    pub const fn offset_ns(self) -> i128 {
        self.offset_ns
    }

    /// An instant on the axis; saturates at the ends of `u64`.
    pub fn at(self, instant: Instant) -> u64 {
        saturate(i128::from(instant.nanoseconds()) + self.offset_ns)
    }

    /// The instant of a point on the axis; saturates.
    pub fn instant(self, at: u64) -> Instant {
        Instant::from_nanoseconds(saturate(i128::from(at) - self.offset_ns))
    }
}

fn saturate(nanoseconds: i128) -> u64 {
    u64::try_from(nanoseconds.max(0)).unwrap_or(u64::MAX)
}

/// How far one point on the axis is behind another, s.
pub fn seconds_between(from: u64, to: u64) -> f64 {
    (i128::from(to) - i128::from(from)) as f64 / NANOSECONDS_PER_SECOND as f64
}

/// A point on the axis as Foxglove's messages have it, until 2106.
pub fn timestamp(at: u64) -> Timestamp {
    let seconds = u32::try_from(at / NANOSECONDS_PER_SECOND).unwrap_or(u32::MAX);
    let nanoseconds = u32::try_from(at % NANOSECONDS_PER_SECOND).unwrap_or(0);
    Timestamp::new(seconds, nanoseconds)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn instants_come_back_to_the_nanosecond(offset in -(1_i128 << 62)..(1_i128 << 62), at in (1_u64 << 62)..(1_u64 << 63)) {
            let axis = TimeAxis::with_offset(offset);
            let instant = Instant::from_nanoseconds(at);
            prop_assert_eq!(axis.instant(axis.at(instant)), instant);
        }
    }

    #[test]
    fn virtual_time_begins_in_the_year_2000() {
        let stamp = timestamp(TimeAxis::simulated().at(Instant::from_nanoseconds(1_500_000_000)));
        assert_eq!((stamp.sec(), stamp.nsec()), (946_684_801, 500_000_000));
    }
}
