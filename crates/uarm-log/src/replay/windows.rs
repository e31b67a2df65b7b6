//! A recorded run in windows: a replay holds some thousand cycles of it at a time.

use uarm_loop::record::CycleRecord;
use uarm_loop::robot::Robot;
use uarm_loop::settings::Settings;
use uarm_loop::uarm_io::drive::wire::SYNC_COUNTER_OVERFLOW;

use super::bus_cycles::{BusCutter, BusCycle};
use super::source::{Behind, Source};
use crate::ordered::{InOrder, LoggedKeyframe};

/// Cycles in a window.
const WINDOW: usize = 4096;

/// Collects the records of a log, given in order, into windows.
#[derive(Clone, Debug)]
pub struct Windows<'a, const J: usize, const N: usize> {
    robot: &'a Robot<J, N>,
    settings: &'a Settings,
    fault: Option<&'a str>,
    recorded: Recorded,
    cutter: BusCutter<J>,
    bus: Vec<BusCycle<J>>,
    records: Vec<CycleRecord<J, N>>,
    keyframes: Vec<LoggedKeyframe<J, N>>,
}

/// What was recorded of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Recorded {
    /// Frames, cycles and keyframes.
    Log,
    /// Frames alone.
    Bus,
}

impl<'a, const J: usize, const N: usize> Windows<'a, J, N> {
    /// Of a run of `robot` that failed of `fault`, if it did.
    pub fn new(robot: &'a Robot<J, N>, settings: &'a Settings, fault: Option<&'a str>) -> Self {
        let cutter = BusCutter::new(robot.nodes(), SYNC_COUNTER_OVERFLOW);
        let (bus, records, keyframes) = (Vec::new(), Vec::new(), Vec::new());
        Self { robot, settings, fault, recorded: Recorded::Log, cutter, bus, records, keyframes }
    }

    /// Of a run of which only frames were recorded, whose SYNC counter begins again behind `largest`.
    pub fn of_bus(robot: &'a Robot<J, N>, settings: &'a Settings, largest: u8) -> Self {
        let cutter = BusCutter::new(robot.nodes(), largest);
        Self { recorded: Recorded::Bus, cutter, ..Self::new(robot, settings, None) }
    }

    /// Takes the next record, and gives the next window to `each` once it is there.
    ///
    /// # Errors
    /// That of `each`.
    pub fn take<E>(
        &mut self,
        record: InOrder<'_, J, N>,
        each: &mut dyn FnMut(&Source<'_, J, N>) -> Result<(), E>,
    ) -> Result<(), E> {
        match record {
            InOrder::Cycle(record) => self.records.push(*record),
            InOrder::Keyframe(keyframe) => self.keyframes.push(*keyframe),
            InOrder::Frame(frame) => {
                self.bus.extend(self.cutter.take(frame));
                if self.bus.len() >= WINDOW {
                    return self.give_what_is_complete(each);
                }
            }
        }
        Ok(())
    }

    /// How many cycles are complete: of a log those before one that was recorded, since then their own records were, too, and the
    /// keyframes behind them. Of the bus alone all but half a window: what is near the end is judged otherwise.
    fn complete(&self) -> usize {
        match (self.recorded, self.records.last()) {
            (Recorded::Bus, _) => self.bus.len().saturating_sub(WINDOW / 2),
            (Recorded::Log, Some(newest)) if !self.keyframes.is_empty() => {
                self.bus.partition_point(|cycle| cycle.sync_at < newest.instants.sync_sent)
            }
            (Recorded::Log, _) => 0,
        }
    }

    fn give_what_is_complete<E>(&mut self, each: &mut dyn FnMut(&Source<'_, J, N>) -> Result<(), E>) -> Result<(), E> {
        let complete = self.complete();
        if complete < WINDOW / 2 {
            return Ok(());
        }
        let rest = self.bus.split_off(complete);
        each(&self.source(Behind::More))?;
        if let Some(last) = self.bus.last() {
            // The newest stays: that there are records is told by it.
            let done = self.records.partition_point(|record| record.instants.sync_sent <= last.sync_at);
            let tick = done.checked_sub(1).and_then(|index| self.records.get(index)).map(|record| record.tick);
            self.records.drain(..done);
            let done = self.keyframes.partition_point(|(after, _)| *after <= tick);
            // One stays as well: that there are keyframes is told by it.
            self.keyframes.drain(..done.min(self.keyframes.len().saturating_sub(1)));
        }
        self.bus = rest;
        Ok(())
    }

    /// Gives what is left.
    ///
    /// # Errors
    /// That of `each`.
    pub fn finish<E>(mut self, each: &mut dyn FnMut(&Source<'_, J, N>) -> Result<(), E>) -> Result<(), E> {
        self.bus.extend(self.cutter.clone().finish());
        each(&self.source(Behind::Nothing))
    }

    fn source(&self, behind: Behind) -> Source<'_, J, N> {
        Source {
            robot: self.robot,
            settings: self.settings,
            bus: &self.bus,
            records: &self.records,
            keyframes: &self.keyframes,
            fault: self.fault,
            behind,
        }
    }
}
