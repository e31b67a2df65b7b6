//! What is replayed.

use uarm_loop::estimation::AngleSource;
use uarm_loop::keyframe::{Keyframe, KeyframeError};
use uarm_loop::record::CycleRecord;
use uarm_loop::robot::Robot;
use uarm_loop::run::SetupError;
use uarm_loop::schedule::Tick;
use uarm_loop::settings::Settings;
use uarm_loop::uarm_io::time::{Duration, Instant};

use super::bus_cycles::{BusCycle, Continuity};

/// What follows what is on the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Behind {
    /// Nothing: it is all, or the end.
    Nothing,
    /// More, in another window.
    More,
}

/// What is replayed, or a window of it.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a, const J: usize, const N: usize> {
    /// The robot of the run.
    pub robot: &'a Robot<J, N>,
    /// Its settings.
    pub settings: &'a Settings,
    /// What was on the bus.
    pub bus: &'a [BusCycle<J>],
    /// What the loop recorded, in the order of ticks; empty if only the bus was recorded.
    pub records: &'a [CycleRecord<J, N>],
    /// Inner states, each with the tick that it follows, in their order; empty if only the bus was recorded.
    pub keyframes: &'a [(Option<u64>, Keyframe<J, N>)],
    /// Why the run failed, if it did.
    pub fault: Option<&'a str>,
    /// What follows.
    pub behind: Behind,
}

impl<'a, const J: usize, const N: usize> Source<'a, J, N> {
    /// The record of the cycle whose SYNC was sent at `sync_at`.
    pub(super) fn record(&self, sync_at: Instant) -> Option<&'a CycleRecord<J, N>> {
        let found = self.records.binary_search_by_key(&sync_at, |record| record.instants.sync_sent);
        found.ok().and_then(|index| self.records.get(index))
    }

    /// The counts that the loop took in, nothing of a drive whose angle it predicted; `None` if counts that it took in are
    /// missing from the bus.
    ///
    /// Where only the bus was recorded, a cycle with torques in which all frames are there is one that the loop went through,
    /// with the counts that came. So is the last one of a run that ended with a fault.
    pub(super) fn counts(&self, cycle: &BusCycle<J>) -> Option<[Option<i32>; J]> {
        let Some(record) = self.record(cycle.sync_at) else {
            let has_ended_the_run = self.fault.is_some() && self.is_last(cycle);
            let was_gone_through = self.records.is_empty()
                && cycle.continuity == Continuity::Whole
                && cycle.sent.iter().any(Option::is_some);
            let is_as_taken = has_ended_the_run || was_gone_through || cycle.counts.iter().all(Option::is_some);
            return is_as_taken.then_some(cycle.counts);
        };
        let mut counts = cycle.counts;
        for (count, source) in counts.iter_mut().zip(record.angle_sources) {
            match source {
                AngleSource::Missing => *count = None,
                AngleSource::Measured | AngleSource::Refused => *count = Some((*count)?),
            }
        }
        Some(counts)
    }

    /// Whether nothing on the bus follows a cycle.
    pub(super) fn is_last(&self, cycle: &BusCycle<J>) -> bool {
        self.behind == Behind::Nothing && self.bus.last().is_some_and(|last| last.sync_at == cycle.sync_at)
    }

    /// The tick of a cycle: as recorded, or from the distance of its SYNC to the `previous` one.
    pub(super) fn tick(&self, cycle: &BusCycle<J>, previous: Option<PlacedTick>) -> PlacedTick {
        let (sync_at, late) = (cycle.sync_at, 0);
        if let Some(CycleRecord { tick, elapsed_ticks, instants, .. }) = self.record(sync_at) {
            let (scheduled, woke) = (instants.scheduled, instants.woke);
            return PlacedTick { tick: Tick { index: *tick, elapsed: *elapsed_ticks, scheduled, woke }, sync_at, late };
        }
        let (index, elapsed, late) = previous.map_or((0, 0, late), |previous| {
            let distance = nanoseconds(sync_at.since(previous.sync_at));
            let (periods, late) = whole_periods(distance + previous.late, nanoseconds(self.robot.period.duration()));
            let elapsed = u64::try_from(periods).unwrap_or(u64::MAX);
            (previous.tick.index.saturating_add(elapsed), elapsed, late)
        });
        PlacedTick { tick: Tick { index, elapsed, scheduled: sync_at, woke: sync_at }, sync_at, late }
    }
}

/// A tick, and where its SYNC stands.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlacedTick {
    pub(super) tick: Tick,
    sync_at: Instant,
    /// How far behind its tick it was sent, ns, by what came before.
    late: i128,
}

/// A SYNC may come early by this part of a period: the one before, which it is measured from, was late itself.
const EARLY: i128 = 8;

/// How many ticks of `period` ns a SYNC is on, at least one, where the tick before was due `distance` ns ago, and how late it is. As in
/// the loop, a late SYNC belongs to the latest tick that was due, and the next one is in step again.
pub(super) fn whole_periods(distance: i128, period: i128) -> (i128, i128) {
    let period = period.max(1);
    let periods = ((distance + period / EARLY) / period).max(1);
    (periods, (distance - periods * period).max(0))
}

pub(super) fn nanoseconds(duration: Duration) -> i128 {
    i128::try_from(duration.as_nanos()).unwrap_or(i128::MAX)
}

/// Why a replay cannot begin, or cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The configuration of the run.
    #[error(transparent)]
    Configuration(#[from] SetupError),
    /// A keyframe that does not fit.
    #[error("keyframe at {time:.3} s: {source}")]
    Keyframe {
        /// The task time of the keyframe, s.
        time: f64,
        /// Why it does not fit.
        source: KeyframeError,
    },
    /// No keyframe is early enough.
    #[error("no keyframe before {0} s")]
    NoKeyframe(f64),
    /// A recording of the bus that has no state to begin with.
    #[error("its first SYNC has the number {0}, expected 1: without keyframes a replay begins where the run began")]
    BeginsLate(u8),
    /// There is nothing to replay.
    #[error("there is no SYNC in it: nothing to replay")]
    NoCycles,
}
