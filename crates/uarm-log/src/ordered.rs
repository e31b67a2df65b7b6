//! A log read in order, record by record, in memory that does not grow with its length.
//!
//! What the queue of a recording did not take stands behind what came later, and other programs may have sorted the file anew. Such
//! late records are found when the file is first gone through, and held; in the next pass they are given where they belong.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use crate::decoder::Item;
use crate::description::RunDescription;
use crate::reader::{self, Collected, ReadError, RunLog, is_gap};
use crate::regular_file;
use uarm_loop::keyframe::Keyframe;
use uarm_loop::record::CycleRecord;
use uarm_loop::recording::FrameRecord;

/// A keyframe with the tick that it follows.
pub type LoggedKeyframe<const J: usize, const N: usize> = (Option<u64>, Keyframe<J, N>);

/// A record in its place.
#[derive(Clone, Copy, Debug)]
pub enum InOrder<'a, const J: usize, const N: usize> {
    /// Of a cycle, in the order of ticks.
    Cycle(&'a CycleRecord<J, N>),
    /// A frame, in the order in which the controller sent and received them.
    Frame(&'a FrameRecord),
    /// A keyframe, in the order of cycles.
    Keyframe(&'a LoggedKeyframe<J, N>),
}

/// A log in a file that does not change.
#[derive(Clone, Debug)]
pub struct OrderedLog<const J: usize, const N: usize> {
    path: PathBuf,
    cycles: Vec<CycleRecord<J, N>>,
    frames: Vec<FrameRecord>,
    keyframes: Vec<LoggedKeyframe<J, N>>,
}

impl<const J: usize, const N: usize> OrderedLog<J, N> {
    /// The log in the file at `path`.
    pub fn new(path: &Path) -> Self {
        Self { path: path.to_owned(), cycles: Vec::new(), frames: Vec::new(), keyframes: Vec::new() }
    }

    /// What was run; reads no further than needed.
    ///
    /// # Errors
    /// [`ReadError`] if there is no description of a run in it.
    pub fn run(&self) -> Result<RunDescription, ReadError> {
        let mut collected = Collected::<J, N>::default();
        let mut run = None;
        self.each_item(&mut |item| match item {
            Item::Run(found) => {
                run = Some(*found);
                ControlFlow::Break(())
            }
            Item::Cycle(_) | Item::Frame(_) | Item::Keyframe(..) => ControlFlow::Continue(()),
            item => {
                collected.take_last_health(item);
                ControlFlow::Continue(())
            }
        })?;
        match run {
            Some(run) => Ok(run),
            None => collected.into_log(&self.path).map(|log| log.run),
        }
    }

    /// Goes through the log and gives each record in its place to a value that `start` makes. Gives that, and all else that the log
    /// tells: its cycles, frames and keyframes are left out, and of its health records all but the last. Where late records are met for
    /// the first time, the pass is made again, with another value.
    ///
    /// # Errors
    /// [`ReadError`] if it cannot be read, or there is no description of a run in it.
    pub fn pass<V>(
        &mut self,
        start: impl Fn() -> V,
        mut take: impl FnMut(&mut V, InOrder<'_, J, N>),
    ) -> Result<(V, RunLog<J, N>), ReadError> {
        loop {
            let mut value = start();
            if let Some(log) = self.one_pass(&mut |record| take(&mut value, record))? {
                return Ok((value, log));
            }
        }
    }

    /// Nothing if late records were met that were not known.
    fn one_pass(&mut self, take: &mut dyn FnMut(InOrder<'_, J, N>)) -> Result<Option<RunLog<J, N>>, ReadError> {
        let mut collected = Collected::default();
        let mut cycles = Lane::new(&self.cycles, |record: &CycleRecord<J, N>| record.tick);
        let mut frames = Lane::new(&self.frames, |frame: &FrameRecord| frame.sequence);
        let mut keyframes = Lane::new(&self.keyframes, |(after, _): &LoggedKeyframe<J, N>| *after);
        let mut gaps = 0;
        let mut previous = None;
        let mut give_cycle = |record: &CycleRecord<J, N>, take: &mut dyn FnMut(InOrder<'_, J, N>)| {
            gaps += usize::from(previous.as_ref().is_some_and(|previous| is_gap(previous, record)));
            previous = Some(*record);
            take(InOrder::Cycle(record));
        };
        self.each_item(&mut |item| {
            match item {
                Item::Cycle(record) => cycles.pass(*record, &mut |record| give_cycle(record, take)),
                Item::Frame(frame) => frames.pass(frame, &mut |frame| take(InOrder::Frame(frame))),
                Item::Keyframe(keyframe, after) => {
                    keyframes.pass((after, *keyframe), &mut |keyframe| take(InOrder::Keyframe(keyframe)));
                }
                item => collected.take_last_health(item),
            }
            ControlFlow::Continue(())
        })?;
        cycles.finish(&mut |record| give_cycle(record, take));
        frames.finish(&mut |frame| take(InOrder::Frame(frame)));
        keyframes.finish(&mut |keyframe| take(InOrder::Keyframe(keyframe)));
        let late = (cycles.met, frames.met, keyframes.met);
        let are_known = late.0.len() == self.cycles.len()
            && late.1.len() == self.frames.len()
            && late.2.len() == self.keyframes.len();
        if !are_known {
            (self.cycles, self.frames, self.keyframes) = late;
            self.cycles.sort_by_key(|record| record.tick);
            self.frames.sort_by_key(|frame| frame.sequence);
            self.keyframes.sort_by_key(|(after, _)| *after);
            return Ok(None);
        }
        let mut log = collected.into_log(&self.path)?;
        log.note_gaps(gaps);
        Ok(Some(log))
    }

    fn each_item(&self, take: &mut dyn FnMut(Item<J, N>) -> ControlFlow<()>) -> Result<(), ReadError> {
        let io_error = |source| ReadError::Io { file: self.path.clone(), source };
        let file = regular_file::open(&self.path).map_err(io_error)?;
        reader::each_item(file, take).map_err(io_error)
    }
}

/// Records of one kind on their way.
struct Lane<'a, T, K> {
    key: fn(&T) -> K,
    newest: Option<K>,
    /// Late records that are known, in their order, as far as they were not given.
    known: &'a [T],
    /// Late records that were met.
    met: Vec<T>,
}

impl<'a, T, K: Ord> Lane<'a, T, K> {
    fn new(known: &'a [T], key: fn(&T) -> K) -> Self {
        Self { key, newest: None, known, met: Vec::new() }
    }

    fn pass(&mut self, record: T, give: &mut dyn FnMut(&T)) {
        let key = (self.key)(&record);
        if self.newest.as_ref().is_some_and(|newest| *newest > key) {
            self.met.push(record);
            return;
        }
        while let Some((late, rest)) = self.known.split_first().filter(|(late, _)| (self.key)(late) < key) {
            give(late);
            self.known = rest;
        }
        self.newest = Some(key);
        give(&record);
    }

    fn finish(&mut self, give: &mut dyn FnMut(&T)) {
        for late in std::mem::take(&mut self.known) {
            give(late);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn in_order(known: &[(u32, char)], records: &[(u32, char)]) -> (String, Vec<(u32, char)>) {
        let mut given = String::new();
        let mut lane = Lane::new(known, |record: &(u32, char)| record.0);
        for record in records {
            lane.pass(*record, &mut |(_, name)| given.push(*name));
        }
        lane.finish(&mut |(_, name)| given.push(*name));
        (given, lane.met)
    }

    #[test]
    fn late_records_are_met_and_then_given_in_their_place_as_a_stable_sort_puts_them() {
        let records = [(1, 'a'), (2, 'b'), (5, 'c'), (5, 'd'), (9, 'e'), (3, 'f'), (5, 'g'), (0, 'h'), (7, 'i')];
        let (first, mut late) = in_order(&[], &records);
        assert_eq!(first, "abcde");
        late.sort_by_key(|record| record.0);
        let (given, met) = in_order(&late, &records);
        let mut sorted = records;
        sorted.sort_by_key(|record| record.0);
        assert_eq!(given, sorted.iter().map(|record| record.1).collect::<String>());
        assert_eq!(met.len(), late.len());
    }

    #[test]
    fn what_follows_all_others_is_given_at_the_end() {
        assert_eq!(in_order(&[(7, 'x')], &[(1, 'a')]), ("ax".to_owned(), Vec::new()));
    }
}
