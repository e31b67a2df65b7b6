//! Replay: the recorded frames and instants through the same estimator and controller, and every signal compared with the
//! recorded one, bit for bit.
//!
//! | module | subject |
//! |---|---|
//! | [`bus_cycles`] | frames, cut at each SYNC |
//! | [`comparison`] | two records, bit for bit |
//! | [`exact`] | the run again, as it was |
//! | [`what_if`] | another law or robot on the same measurements |
//! | [`chart`] | both torques in one figure |

pub mod bus_cycles;
pub mod chart;
pub mod comparison;
pub mod exact;
pub mod what_if;

use uarm_io::time::Instant;

use crate::control_loop::keyframe::Keyframe;
use crate::control_loop::record::CycleRecord;
use crate::control_loop::schedule::{Period, Tick};
use crate::experiment::Settings;
use crate::robot::Robot;
use bus_cycles::BusCycle;

/// What is replayed.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a> {
    /// The robot of the run.
    pub robot: &'a Robot,
    /// Its settings.
    pub settings: &'a Settings,
    /// What was on the bus.
    pub bus: &'a [BusCycle],
    /// What the loop recorded, in the order of ticks; empty if only the bus was recorded.
    pub records: &'a [CycleRecord],
    /// Inner states, each with the tick that it follows, in their order; empty if only the bus was recorded.
    pub keyframes: &'a [(Option<u64>, Keyframe)],
    /// Why the run failed, if it did.
    pub fault: Option<&'a str>,
}

impl<'a> Source<'a> {
    /// The record of the cycle whose SYNC was sent at `sync_at`.
    fn record(&self, sync_at: Instant) -> Option<&'a CycleRecord> {
        let found = self.records.binary_search_by_key(&sync_at, |record| record.instants.sync_sent);
        found.ok().and_then(|index| self.records.get(index))
    }

    /// The tick of a cycle: as recorded, or from the distance of its SYNC to the previous one.
    fn tick(&self, cycle: &BusCycle, previous: Option<(u64, Instant)>) -> Tick {
        if let Some(CycleRecord { tick, elapsed_ticks, instants, .. }) = self.record(cycle.sync_at) {
            return Tick { index: *tick, elapsed: *elapsed_ticks, scheduled: instants.scheduled, woke: instants.woke };
        }
        let elapsed = previous.map_or(0, |(_, sync)| whole_periods(cycle.sync_at, sync, self.robot.period));
        let index = previous.map_or(0, |(index, _)| index) + elapsed;
        Tick { index, elapsed, scheduled: cycle.sync_at, woke: cycle.sync_at }
    }
}

/// Periods between two SYNCs, to the nearest whole one, at least one.
fn whole_periods(later: Instant, earlier: Instant, period: Period) -> u64 {
    let period = period.duration().as_nanos().max(1);
    let rounded = (later.since(earlier).as_nanos() + period / 2) / period;
    u64::try_from(rounded).unwrap_or(u64::MAX).max(1)
}
