//! The run again, as it was.

mod against_record;

use serde::Serialize;
use uarm_loop::estimation::{AngleError, AngleSource, Estimate, EstimationError};
use uarm_loop::hinf_control::Controller;
use uarm_loop::keyframe::Keyframe;
use uarm_loop::robot::Robot;
use uarm_loop::run::signal_path;
use uarm_loop::schedule::Tick;
use uarm_loop::settings::Settings;
use uarm_loop::signal_path::{SignalFault, SignalPath, Signals};
use uarm_loop::supervisor::Authority;

use super::bus_cycles::{BusCycle, Continuity};
use super::comparison::Difference;
use super::source::{Behind, PlacedTick, ReplayError, Source};
use crate::ordered::LoggedKeyframe;

/// Differences that are kept; all are counted.
const MOST_DIFFERENCES: usize = 10;

/// Where a replay begins.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Start {
    /// With the first cycle.
    #[default]
    Beginning,
    /// With the last keyframe before this task time, s.
    KeyframeBefore(f64),
}

/// What came of a replay.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ExactReplay {
    /// Task time at which it began, s.
    pub from: f64,
    /// Cycles that were replayed.
    pub cycles: u64,
    /// Cycles of them in which the angle of some joint was predicted, since its drive sent none that could be believed.
    pub predicted_cycles: u64,
    /// Signals that were compared.
    pub signals: u64,
    /// Keyframes that were reached and compared.
    pub keyframes: u64,
    /// Keyframes of them whose inner state differs; the first is one of the differences.
    pub differing_keyframes: u64,
    /// Of a run of which only the bus was recorded: task time from which the torques faded since somebody asked for the end, s.
    pub faded_from: Option<f64>,
    /// Cycles in which something differs.
    pub differing_cycles: u64,
    /// The first differences, at most ten.
    pub differences: Vec<Difference>,
    /// Cycles that could not be replayed, since something in them or before them is missing.
    pub lost_cycles: u64,
    /// Torques that are missing in cycles of which only the bus was recorded.
    pub missing_torques: u64,
    /// Cycles of which only the bus was recorded, without a position: whether the loop had it is not known.
    pub missing_positions: u64,
    /// Of a run of which only the bus was recorded: the recording ends before the last torque of a cycle, and without a stop of the drives.
    pub ends_within_a_cycle: bool,
    /// How often the replay went on from a keyframe behind a gap.
    pub resumed: u64,
    /// The fault that the signal path gave in the last cycle, as the live one did.
    pub fault: Option<String>,
    /// Whether the recorded fault is that one; nothing if the run had none or one of the bus, or if a recording of the bus alone ends
    /// there.
    pub fault_reproduced: Option<bool>,
}

impl ExactReplay {
    /// Whether anything was compared.
    pub fn has_compared(&self) -> bool {
        self.signals > 0 || self.fault_reproduced.is_some()
    }

    /// Whether parts of the run were not compared.
    pub fn has_loss(&self) -> bool {
        self.lost_cycles > 0 || self.missing_torques > 0 || self.missing_positions > 0 || self.ends_within_a_cycle
    }

    /// Whether all that was compared is equal.
    pub fn is_equal(&self) -> bool {
        self.differing_cycles == 0 && self.differing_keyframes == 0 && self.fault_reproduced != Some(false)
    }

    /// Replays `source` with `controller`, which must be the run's, in its initial state.
    ///
    /// # Errors
    /// [`ReplayError`] if it cannot begin.
    pub fn run<const J: usize, const N: usize>(
        source: &Source<'_, J, N>,
        controller: &mut dyn Controller<f64, N>,
        start: Start,
    ) -> Result<Self, ReplayError> {
        let begin = match start {
            Start::Beginning => Begin::Beginning,
            Start::KeyframeBefore(time) => {
                let found = source.keyframes.iter().rfind(|keyframe| is_before(keyframe, time));
                Begin::At(*found.ok_or(ReplayError::NoKeyframe(time))?)
            }
        };
        let mut replay = ExactRun::new(source.robot, source.settings, controller, begin)?;
        replay.window(source)?;
        replay.finish()
    }

    fn note(&mut self, differences: Vec<Difference>) {
        self.differing_cycles += u64::from(!differences.is_empty());
        let room = MOST_DIFFERENCES.saturating_sub(self.differences.len());
        self.differences.extend(differences.into_iter().take(room));
    }
}

/// Whether the path's state is that of the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Position {
    /// It follows the cycle of this tick; nothing before the first.
    After(Option<u64>),
    /// Something is missing since.
    Lost,
    /// The run has ended with a fault.
    Ended,
}

/// The state that a replay begins with.
#[derive(Clone, Copy, Debug)]
#[allow(clippy::large_enum_variant, reason = "there is one of these")]
pub enum Begin<const J: usize, const N: usize> {
    /// That before the first cycle.
    Beginning,
    /// This keyframe.
    At(LoggedKeyframe<J, N>),
}

/// Whether a replay from before a task `time`, s, can begin with a keyframe.
pub fn is_before<const J: usize, const N: usize>((after, keyframe): &LoggedKeyframe<J, N>, time: f64) -> bool {
    after.is_none() || keyframe.task_clock.time < time
}

/// A replay that is given a run window by window.
pub struct ExactRun<'a, const J: usize, const N: usize> {
    path: SignalPath<'a, J, N>,
    begin: Option<Begin<J, N>>,
    position: Position,
    /// The previous cycle on the bus.
    previous: Option<PlacedTick>,
    /// Cycles that count as lost since the last one that the loop went through: behind the end of the run they are none.
    unanswered: u64,
    /// Whether the drives were stopped in some cycle.
    is_stopped: bool,
    /// Which drives have said that they follow their target.
    have_followed: [bool; J],
    outcome: ExactReplay,
}

/// Whether an answer is missing of which this is made.
fn lacks_an_answer<const J: usize>(estimate: &Estimate<J>) -> bool {
    estimate.sources.contains(&AngleSource::Missing)
}

/// Whether what follows the last SYNC is the stop that ended the run, with torque 0.
fn is_stop<const J: usize, const N: usize>(source: &Source<'_, J, N>, cycle: &BusCycle<J>) -> bool {
    source.is_last(cycle) && cycle.sent.iter().all(|sent| sent.unwrap_or(0) == 0)
}

impl<'a, const J: usize, const N: usize> ExactRun<'a, J, N> {
    /// A replay of a run of `robot` with `controller`, which must be the run's, in its initial state.
    ///
    /// # Errors
    /// [`ReplayError`] if it cannot begin.
    pub fn new(
        robot: &Robot<J, N>,
        settings: &Settings,
        controller: &'a mut dyn Controller<f64, N>,
        begin: Begin<J, N>,
    ) -> Result<Self, ReplayError> {
        Ok(Self {
            path: signal_path(robot, settings, controller)?,
            begin: Some(begin),
            position: Position::Lost,
            previous: None,
            unanswered: 0,
            is_stopped: false,
            have_followed: [false; J],
            outcome: ExactReplay::default(),
        })
    }

    /// Replays the next cycles. The first window of a run that was recorded with keyframes has the first of them; each window has the
    /// records and keyframes of its cycles.
    ///
    /// # Errors
    /// [`ReplayError`] if it cannot begin or go on.
    pub fn window(&mut self, source: &Source<'_, J, N>) -> Result<(), ReplayError> {
        if source.bus.is_empty() {
            return Ok(());
        }
        if let Some(begin) = self.begin.take() {
            // A run of an earlier version was not held against the model.
            if source.records.first().is_some_and(|record| record.unexplained.is_none()) {
                self.path.supervision = None;
            }
            self.begin(source, begin)?;
        }
        // Behind the last cycle that the loop went through, the run had ended.
        let last_answered = match source.behind {
            Behind::Nothing => source.bus.iter().rposition(|cycle| source.counts(cycle).is_some()),
            Behind::More => source.bus.len().checked_sub(1),
        };
        if last_answered.is_none() {
            self.outcome.lost_cycles -= std::mem::take(&mut self.unanswered);
        }
        for (index, cycle) in source.bus.iter().enumerate() {
            if Some(index) > last_answered {
                break;
            }
            self.cycle(source, cycle)?;
        }
        self.is_stopped |= source.bus.iter().any(|cycle| cycle.stopped);
        if let (Behind::Nothing, true, Some(last)) = (source.behind, source.records.is_empty(), source.bus.last()) {
            self.outcome.ends_within_a_cycle = !self.is_stopped && last.all_sent().is_none();
        }
        Ok(())
    }

    /// What came of it.
    ///
    /// # Errors
    /// [`ReplayError::NoCycles`] if there was none.
    pub fn finish(self) -> Result<ExactReplay, ReplayError> {
        if self.begin.is_some() { Err(ReplayError::NoCycles) } else { Ok(self.outcome) }
    }

    fn begin(&mut self, source: &Source<'_, J, N>, begin: Begin<J, N>) -> Result<(), ReplayError> {
        match begin {
            // Of a run that was not recorded with keyframes, the first state is that of the configuration.
            Begin::Beginning if source.keyframes.is_empty() => {
                let counter = source.bus.first().and_then(|cycle| cycle.counter);
                if let Some(counter) = counter.filter(|first| *first > 1) {
                    return Err(ReplayError::BeginsLate(counter));
                }
                self.position = Position::After(None);
                return Ok(());
            }
            // A log that lost its beginning is taken up at its first keyframe.
            Begin::Beginning => {
                let first_tick = source.records.first().map(|first| first.tick);
                let is_first =
                    |after: Option<u64>| after.is_none_or(|after| first_tick.is_some_and(|tick| after < tick));
                if let Some((after, keyframe)) = source.keyframes.iter().find(|(after, _)| is_first(*after)) {
                    self.thaw(*after, keyframe)?;
                }
            }
            Begin::At((after, keyframe)) => self.thaw(after, &keyframe)?,
        }
        self.outcome.from = self.path.task_clock.freeze().time;
        Ok(())
    }

    fn thaw(&mut self, after: Option<u64>, keyframe: &Keyframe<J, N>) -> Result<(), ReplayError> {
        self.path.thaw(keyframe).map_err(|source| ReplayError::Keyframe { time: keyframe.task_clock.time, source })?;
        self.position = Position::After(after);
        Ok(())
    }

    fn cycle(&mut self, source: &Source<'_, J, N>, cycle: &BusCycle<J>) -> Result<(), ReplayError> {
        let placed = source.tick(cycle, self.previous);
        self.previous = Some(placed);
        let tick = placed.tick;
        match self.position {
            // Cycles before the beginning.
            Position::After(Some(after)) if tick.index <= after => return Ok(()),
            Position::After(after) => {
                let expected = after.map_or(0, |after| after.saturating_add(tick.elapsed));
                if tick.index != expected || cycle.continuity == Continuity::Broken {
                    self.position = Position::Lost;
                }
            }
            Position::Lost | Position::Ended => {}
        }
        let counts = source.counts(cycle);
        match (self.position, counts) {
            (Position::After(_), Some(counts)) => {
                self.unanswered = 0;
                self.step(source, cycle, &tick, counts);
            }
            // The live loop took in a count that is missing here.
            (Position::After(_) | Position::Lost, None) | (Position::Lost, _) => {
                self.position = Position::Lost;
                self.outcome.lost_cycles += 1;
                self.unanswered = if counts.is_none() { self.unanswered + 1 } else { 0 };
                self.resume(source, tick.index)?;
            }
            (Position::Ended, _) => {}
        }
        Ok(())
    }

    /// Goes on behind a gap, if there is a keyframe of this cycle.
    fn resume(&mut self, source: &Source<'_, J, N>, tick: u64) -> Result<(), ReplayError> {
        if let Some((after, keyframe)) = source.keyframes.iter().find(|(after, _)| *after == Some(tick)) {
            self.thaw(*after, keyframe)?;
            self.outcome.resumed += 1;
        }
        Ok(())
    }

    fn step(&mut self, source: &Source<'_, J, N>, cycle: &BusCycle<J>, tick: &Tick, counts: [Option<i32>; J]) {
        let recorded = source.record(cycle.sync_at);
        if recorded.is_none() && !source.records.is_empty() && source.is_last(cycle) && source.fault.is_none() {
            // A killed process: the cycle may not have been completed.
            self.position = Position::Ended;
            return;
        }
        match self.signals(source, cycle, tick, &counts) {
            Ok(signals) => {
                let lacks_an_answer = recorded.is_none() && lacks_an_answer(&signals.estimate);
                if lacks_an_answer && !self.has_sent(cycle, &signals) {
                    // The loop had the answer that is missing in the file.
                    self.position = Position::Lost;
                    self.outcome.lost_cycles += 1;
                    return;
                }
                self.position = Position::After(Some(tick.index));
                self.outcome.predicted_cycles += u64::from(signals.estimate.is_predicted());
                self.outcome.missing_positions += u64::from(lacks_an_answer);
                let mut differences = match recorded {
                    Some(recorded) => self.compare(recorded, tick, cycle, &signals),
                    None => self.compare_sent(source, cycle, tick, &signals),
                };
                differences.extend(self.compare_keyframe(source, tick));
                self.outcome.note(differences);
            }
            // The loop went on: it had the answer that is missing in the file.
            Err(SignalFault::Estimation(EstimationError {
                source: AngleError::NoneYet | AngleError::Missing { .. },
                ..
            })) if recorded.is_none() && cycle.sent.iter().any(Option::is_some) => {
                self.position = Position::Lost;
                self.outcome.lost_cycles += 1;
            }
            Err(fault) => {
                self.position = Position::Ended;
                let fault = fault.to_string();
                self.outcome.fault_reproduced = match source.fault {
                    Some(cause) => Some(cause.contains(&fault)),
                    // Where only the bus was recorded, nothing tells of a fault but that nothing comes after it.
                    None if source.records.is_empty() && source.is_last(cycle) => None,
                    None => Some(false),
                };
                self.outcome.fault = Some(fault);
            }
        }
    }

    /// The signals of a cycle. Where only the bus was recorded, nothing says that somebody asked for the end, but that the torques from
    /// there on are those of the ramp, and not those of a run that goes on.
    fn signals(
        &mut self,
        source: &Source<'_, J, N>,
        cycle: &BusCycle<J>,
        tick: &Tick,
        counts: &[Option<i32>; J],
    ) -> Result<Signals<J, N>, SignalFault> {
        let period = source.robot.period;
        if let Some(record) = source.record(cycle.sync_at) {
            return self.path.step(tick, cycle.sync_at, counts, period, record.authority);
        }
        let ramp = self.path.torque.fade.ramp().duration() + 2 * period.duration();
        let may_fade = source.records.is_empty()
            && source.behind == Behind::Nothing
            && source.bus.last().is_some_and(|last| last.sync_at.since(cycle.sync_at) <= ramp);
        let has_begun = self.outcome.faded_from.is_some();
        let fades = has_begun
            || may_fade
                && !self.would_send(source, cycle, Authority::Full)
                && self.would_send(source, cycle, Authority::Fading);
        let authority = if fades { Authority::Fading } else { Authority::Full };
        let signals = self.path.step(tick, cycle.sync_at, counts, period, authority)?;
        if fades && !has_begun {
            self.outcome.faded_from = Some(signals.time);
        }
        Ok(signals)
    }

    /// Whether the torques from a cycle to the end of the recording are those of a path that goes on from here with this `authority`. A
    /// single cycle does not tell: the ramp's first torques may be rounded to those without it.
    fn would_send(&mut self, source: &Source<'_, J, N>, cycle: &BusCycle<J>, authority: Authority) -> bool {
        // A keyframe has no ramp in it.
        let (before, fade) = (self.path.freeze(), self.path.torque.fade);
        let mut placed = self.previous;
        let mut is_all_sent = true;
        for next in source.bus.iter().skip_while(|earlier| earlier.sync_at < cycle.sync_at) {
            let tick = match placed {
                Some(first) if next.sync_at == cycle.sync_at => first.tick,
                before => placed.insert(source.tick(next, before)).tick,
            };
            let Some(counts) = source.counts(next) else { break };
            let Ok(signals) = self.path.step(&tick, next.sync_at, &counts, source.robot.period, authority) else {
                break;
            };
            is_all_sent = self.has_sent(next, &signals) || is_stop(source, next);
            if !is_all_sent {
                break;
            }
        }
        // It can be put back: it was before.
        let _ = self.path.thaw(&before);
        self.path.torque.fade = fade;
        is_all_sent
    }
}
