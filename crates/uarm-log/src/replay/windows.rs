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
    cutter: BusCutter<J>,
    bus: Vec<BusCycle<J>>,
    records: Vec<CycleRecord<J, N>>,
    keyframes: Vec<LoggedKeyframe<J, N>>,
}

impl<'a, const J: usize, const N: usize> Windows<'a, J, N> {
    /// Of a run of `robot` that failed of `fault`, if it did.
    pub fn new(robot: &'a Robot<J, N>, settings: &'a Settings, fault: Option<&'a str>) -> Self {
        let cutter = BusCutter::new(robot.nodes(), SYNC_COUNTER_OVERFLOW);
        Self { robot, settings, fault, cutter, bus: Vec::new(), records: Vec::new(), keyframes: Vec::new() }
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

    /// A cycle is complete when a later one was recorded: then its own record was, too, and the keyframe behind it.
    fn give_what_is_complete<E>(&mut self, each: &mut dyn FnMut(&Source<'_, J, N>) -> Result<(), E>) -> Result<(), E> {
        let (Some(newest), false) = (self.records.last(), self.keyframes.is_empty()) else { return Ok(()) };
        let complete = self.bus.partition_point(|cycle| cycle.sync_at < newest.instants.sync_sent);
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
