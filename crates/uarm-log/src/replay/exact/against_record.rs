//! What a replay computed against what the run recorded.

use uarm_loop::estimation::AngleSource;
use uarm_loop::record::CycleRecord;
use uarm_loop::schedule::Tick;
use uarm_loop::signal_path::Signals;
use uarm_loop::uarm_io::drive::cia402::{PowerState, Statusword};
use uarm_loop::uarm_io::drive::network::IgnoredTargetReaction;
use uarm_loop::uarm_io::drive::wishes::Operation;

use super::{ExactRun, is_stop};
use crate::replay::bus_cycles::BusCycle;
use crate::replay::comparison::{self, Difference};
use crate::replay::source::Source;
use crate::signals::Value;

impl<const J: usize, const N: usize> ExactRun<'_, J, N> {
    pub(super) fn compare(
        &mut self,
        recorded: &CycleRecord<J, N>,
        tick: &Tick,
        cycle: &BusCycle<J>,
        signals: &Signals<J, N>,
    ) -> Vec<Difference> {
        // A drive that sent nothing in this cycle has the statusword of the one before.
        let mut statuswords = cycle.statuswords;
        for ((word, source), recorded) in statuswords.iter_mut().zip(signals.estimate.sources).zip(recorded.statuswords)
        {
            if source == AngleSource::Missing {
                *word = recorded;
            }
        }
        let mut replayed = CycleRecord::new(tick, &recorded.instants, &statuswords, signals);
        replayed.set_parameters(self.path.controller.parameters());
        // What the drives report has no part in the loop.
        replayed.torque_actual = recorded.torque_actual;
        let (compared, mut differences) = comparison::compare(recorded, &replayed);
        self.outcome.cycles += 1;
        self.outcome.signals += compared;
        differences.extend(self.compare_sent_frames(cycle, tick, signals));
        differences
    }

    /// Where only the bus was recorded, the torques on it are what there is to compare.
    pub(super) fn compare_sent(
        &mut self,
        source: &Source<'_, J, N>,
        cycle: &BusCycle<J>,
        tick: &Tick,
        signals: &Signals<J, N>,
    ) -> Vec<Difference> {
        if is_stop(source, cycle) {
            return Vec::new();
        }
        if !source.is_last(cycle) {
            let missing = cycle.sent.iter().filter(|sent| sent.is_none()).count();
            self.outcome.missing_torques += u64::try_from(missing).unwrap_or(u64::MAX);
        }
        if cycle.sent.iter().all(Option::is_none) {
            self.outcome.lost_cycles += 1;
            return Vec::new();
        }
        self.outcome.cycles += 1;
        let mut differences = self.compare_statuswords(source, cycle, tick, signals.time);
        differences.extend(self.compare_sent_frames(cycle, tick, signals));
        differences
    }

    /// A loop sends no torque to a drive that has just said that it is not in *Operation enabled*, or does not follow its target any more.
    fn compare_statuswords(
        &mut self,
        source: &Source<'_, J, N>,
        cycle: &BusCycle<J>,
        tick: &Tick,
        time: f64,
    ) -> Vec<Difference> {
        let stops = source.robot.bus.ignored_target_reaction == IgnoredTargetReaction::Stop;
        let answers = cycle.counts.iter().zip(cycle.statuswords).zip(cycle.sent).zip(&source.robot.joints);
        let mut differences = Vec::new();
        for ((((count, word), sent), joint), (followed, number)) in answers.zip(self.have_followed.iter_mut().zip(1..))
        {
            if count.is_none() || sent.is_none() {
                continue;
            }
            let word = Statusword::from_bits(word);
            let is_enabled = word.state() == Some(PowerState::OperationEnabled);
            let follows = word.contains(Statusword::FOLLOWS_TARGET);
            let ignores = stops && joint.drive.operation == Operation::CyclicTorque && *followed && !follows;
            *followed |= follows;
            let said = [(!is_enabled, "is in Operation enabled"), (is_enabled && ignores, "follows its target torque")];
            differences.extend(said.into_iter().filter(|(is_told, _)| *is_told).map(|(_, what)| Difference {
                tick: tick.index,
                time,
                signal: format!("the drive of joint {number} {what}"),
                recorded: Value::Flag(false),
                replayed: Value::Flag(true),
            }));
        }
        differences
    }

    /// Whether the torques on the bus are these, as far as they are there.
    pub(super) fn has_sent(&self, cycle: &BusCycle<J>, signals: &Signals<J, N>) -> bool {
        let mut torques = cycle.sent.iter().zip(signals.torque.sent);
        torques.all(|(recorded, replayed)| recorded.is_none_or(|recorded| recorded == replayed))
    }

    fn compare_sent_frames(&mut self, cycle: &BusCycle<J>, tick: &Tick, signals: &Signals<J, N>) -> Vec<Difference> {
        let frames = cycle.sent.iter().zip(signals.torque.sent).zip(1..);
        let mut differences = Vec::new();
        for ((recorded, replayed), joint) in frames {
            let Some(recorded) = recorded else { continue };
            self.outcome.signals += 1;
            if *recorded != replayed {
                differences.push(Difference {
                    tick: tick.index,
                    time: signals.time,
                    signal: format!("torque in the frame to joint {joint}, per mille"),
                    recorded: Value::Integer((*recorded).into()),
                    replayed: Value::Integer(replayed.into()),
                });
            }
        }
        differences
    }

    /// The inner state as well, wherever the run recorded it.
    pub(super) fn compare_keyframe(&mut self, source: &Source<'_, J, N>, tick: &Tick) -> Option<Difference> {
        let keyframes = source.keyframes;
        let index = keyframes.binary_search_by_key(&Some(tick.index), |(after, _)| *after).ok()?;
        let (_, recorded) = keyframes.get(index)?;
        self.outcome.keyframes += 1;
        let differs = self.path.freeze() != *recorded;
        self.outcome.differing_keyframes += u64::from(differs);
        // Where one state differs, all that follow do: told once.
        (differs && self.outcome.differing_keyframes == 1).then(|| Difference {
            tick: tick.index,
            time: recorded.task_clock.time,
            signal: "inner state equals the keyframe".to_owned(),
            recorded: Value::Flag(true),
            replayed: Value::Flag(false),
        })
    }
}
